"""A sea trial in the middle of a mission, sailed whole: to the place, the trial there, and on to the next waypoint."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from companion.analysis.trial_log import manoeuvres
from companion.cli.rig import LockstepRig
from companion.core.geodesy import LocalFrame
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.rig import Conditions

MISSION, USER_5 = 0x04040000, 31014


@pytest.mark.sweep
def test_the_mission_goes_on_after_the_trial(tmp_path: Path) -> None:
    rig = LockstepRig(Conditions(vessel="blueboat", seed=1, wind="3@200", current="0.1@70"), tmp_path)
    gcs = GroundStation(rig)
    home = rig.config.home
    frame = LocalFrame(home.lat_deg, home.lon_deg)
    there, after = frame.to_geodetic(30.0, 0.0), frame.to_geodetic(30.0, 40.0)
    gcs.ready()
    gcs.upload([Item(16, *there), Item(USER_5, 0.0, 0.0), Item(16, *after)])
    gcs.set_mode(MISSION)
    gcs.arm()
    gcs.wait("the trial", lambda: rig.vessel.last_tick.status.mode.value == "Trial", 300.0)
    truth = rig.world.truth
    assert math.hypot(truth.north_m - 30.0, truth.east_m) < 3.0
    gcs.wait("the mission again", lambda: rig.vessel.last_tick.status.mode.value == "Mission", 1200.0)
    assert any(text.startswith("Trial: complete") for text in gcs.texts) and "Mission item 2 reached" in gcs.texts
    gcs.wait("the end", lambda: "Mission complete" in gcs.texts, 400.0)
    truth = rig.world.truth
    assert math.hypot(truth.north_m - 30.0, truth.east_m - 40.0) < 3.0
    rig.close()
    assert manoeuvres(tmp_path)[-1].name == "positioning"
