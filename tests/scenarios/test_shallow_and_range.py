"""Dangers that grow slowly, in lockstep: water that becomes shallow, and a battery that just takes the boat home."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

from pymavlink.dialects.v20 import common as mavlink

from companion.cli.rig import LockstepRig
from companion.config.devices import SensorConfig
from companion.config.vessel import VesselConfig, find, load
from companion.core.geodesy import LocalFrame
from sitl.fault_matrix.stages import PX4_MODES
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.rig import Conditions

REVOLT = load(find("revolt"))
SOUNDER = SensorConfig(name="sounder", driver="nmea0183", port="memory:sounder", rate_hz=5.0, z_m=0.2)


def under_way(folder: Path, config: VesselConfig, **parameters: float) -> GroundStation:
    """In Mission, a kilometre to the north."""
    gcs = GroundStation(LockstepRig(Conditions("revolt", known=config, wind="1.5@0", parameters=parameters), folder))
    gcs.ready()
    home = config.home
    far = LocalFrame(home.lat_deg, home.lon_deg).to_geodetic(1000.0, 0.0)
    gcs.upload([Item(mavlink.MAV_CMD_NAV_WAYPOINT, *far)])
    gcs.set_mode(PX4_MODES["Mission"])
    gcs.arm()
    return gcs


def mode(gcs: GroundStation) -> int:
    return int(gcs.last["HEARTBEAT"].custom_mode)


def heard_s(gcs: GroundStation, text: str) -> float:
    return next(t_s for t_s, heard in zip(gcs.heard_s, gcs.texts, strict=True) if heard.startswith(text))


def test_shallow_water_stops_the_boat_before_it_is_aground(tmp_path: Path) -> None:
    gcs = under_way(tmp_path, replace(REVOLT, sensors=(*REVOLT.sensors, SOUNDER)), FS_DEPTH_MIN=1.0)
    gcs.sail(12.0)
    truth = gcs.rig.world.truth
    place, speed_mps, from_s = truth.north_m, truth.surge_mps, gcs.rig.now_s
    assert speed_mps > 0.3 and not any("Shallow" in text for text in gcs.texts)
    gcs.rig.world.add_fault("shallow", math.inf)
    gcs.wait("Hold", lambda: mode(gcs) == PX4_MODES["Hold"], 4.0)
    gcs.sail(25.0)
    gcs.rig.close()
    assert heard_s(gcs, "Shallow: 0.5 m of water") - from_s < 2.5, "a second of it, a second to say it, and a reading"
    still = gcs.rig.world.truth
    assert abs(still.surge_mps) < 0.1
    assert still.north_m - place < 2.0 * speed_mps + 2.5 * REVOLT.length_m, "as gently as Hold brakes"


def test_a_boat_that_is_told_to_return_gets_home(tmp_path: Path) -> None:
    small = replace(REVOLT, sitl=replace(REVOLT.sitl, battery_wh=9.0))
    gcs = under_way(tmp_path, small, BAT_ENDURANCE=0.0)  # as measured under way
    world = gcs.rig.world
    gcs.wait("told to return", lambda: mode(gcs) == PX4_MODES["RTL"], 200.0)
    gcs.sail(1.0)
    assert any(text.startswith("Return now: ") for text in gcs.texts)
    assert world.battery.remaining > 0.5 and world.truth.north_m > 15.0, "long before the battery is critical"
    gcs.wait("home", lambda: math.hypot(world.truth.north_m, world.truth.east_m) < 3.0, 250.0)
    gcs.rig.close()
    # of the reserve of 12 % the turn and the last metres, which are not reckoned, take some: it lasts 30 s here
    assert world.battery.remaining > 0.08
