"""A propeller that is fouled or blocked is told by its motor's current, where the board reports it."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import common as mavlink

from companion.cli.rig import LockstepRig
from companion.config.vessel import find, load
from companion.core.geodesy import LocalFrame
from sitl.fault_matrix.stages import PX4_MODES
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.measure import read_events
from sitl.scenarios.rig import Conditions

BLUEBOAT = load(find("blueboat"))
METERED = replace(BLUEBOAT, thrusters=tuple(replace(one, full_a=20.0) for one in BLUEBOAT.thrusters))


@pytest.mark.parametrize(("fault", "text"), [("fouled", "blocked or fouled"), ("stalled", "blocked or fouled")])
def test_a_fouled_propeller_is_told_within_three_seconds(tmp_path: Path, fault: str, text: str) -> None:
    gcs = GroundStation(LockstepRig(Conditions("blueboat", known=METERED, wind="2@270", gnss="sbas"), tmp_path))
    home = METERED.home
    gcs.ready()
    gcs.upload([Item(mavlink.MAV_CMD_NAV_WAYPOINT, *LocalFrame(home.lat_deg, home.lon_deg).to_geodetic(1000.0, 0.0))])
    gcs.set_mode(PX4_MODES["Mission"])
    gcs.arm()
    gcs.sail(20.0)
    assert not any(event.name.startswith("thruster_") for event in read_events(tmp_path)), "a sound motor"
    from_s = gcs.rig.now_s
    gcs.rig.world.add_fault(f"thruster_port_{fault}", math.inf)
    gcs.sail(3.0)
    gcs.rig.close()
    told = [event for event in read_events(tmp_path) if event.name == "thruster_port"]
    assert told and told[0].text == f"Thruster port not used: {text}" and told[0].t_s - from_s <= 3.0
