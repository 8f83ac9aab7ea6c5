"""RTL along the own track, in lockstep: ordered by a ground station, judged by the truth."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import common as mavlink

from companion.cli.rig import LockstepRig
from companion.core.geodesy import LocalFrame
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.measure import between, read_truth
from sitl.scenarios.rig import Conditions

MISSION = 0x04040000
AUTO, SMART_RTL = 10, 12  # of Rover
OUT = ((22.0, 0.0), (22.0, 22.0))


@pytest.mark.parametrize(("vessel", "most_m"), [("aboat", 8.0), pytest.param("revolt", 2.5, marks=pytest.mark.sweep)])
def test_back_round_the_headland(tmp_path: Path, vessel: str, most_m: float) -> None:
    """Out round a corner by a mission, back by NAV_RETURN_TO_LAUNCH. `most_m`: largest distance from the way out."""
    conditions = Conditions(vessel, seed=41, wind="2", current="0.1", gnss="rtk", parameters={"RTL_TRACK": 1.0})
    gcs = GroundStation(LockstepRig(conditions, tmp_path))
    out_and_back(gcs, tmp_path, MISSION, most_m, turn_back=lambda: gcs.command(mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH))


def test_back_by_smart_rtl_of_a_ground_station(tmp_path: Path) -> None:
    """Rover's mode 12 asks for the own track by itself: RTL_TRACK is 0."""
    conditions = Conditions("otter", seed=42, wind="2", current="0.1", gnss="rtk")
    gcs = GroundStation(LockstepRig(conditions, tmp_path, link="memory:scenario?dialect=ardupilot"))
    out_and_back(gcs, tmp_path, AUTO, 5.0, turn_back=lambda: gcs.set_mode(SMART_RTL), home_first=True)


def out_and_back(
    gcs: GroundStation,
    folder: Path,
    mission: int,
    most_m: float,
    turn_back: Callable[[], None],
    home_first: bool = False,
) -> None:
    """`mission`: number of its mode. `home_first`: item 0 of a mission is home, on this link."""
    home = gcs.rig.config.home
    frame = LocalFrame(home.lat_deg, home.lon_deg)
    points = ((0.0, 0.0), *OUT) if home_first else OUT
    gcs.ready()
    gcs.upload([Item(mavlink.MAV_CMD_NAV_WAYPOINT, *frame.to_geodetic(*point)) for point in points])
    gcs.set_mode(mission)
    gcs.arm()
    began_s = gcs.rig.now_s
    gcs.wait("the end of the mission", lambda: len(points) - 1 in gcs.reached, 300.0)
    turned_s = gcs.rig.now_s
    turn_back()
    gcs.wait("home", lambda: "RTL: at home, holding" in gcs.texts, 400.0)
    gcs.rig.close()
    truth = read_truth(folder)
    out = [(row["north_m"], row["east_m"]) for row in between(truth, began_s, turned_s)]
    back = [(row["north_m"], row["east_m"]) for row in between(truth, turned_s)]
    off_m = [min(math.dist(place, point) for point in out[::5]) for place in back[::5]]
    assert max(off_m) < most_m, f"{max(off_m):.1f} m off the way out; the short cut is 16 m off"
    assert math.dist(back[-1], out[0]) < 3.0
