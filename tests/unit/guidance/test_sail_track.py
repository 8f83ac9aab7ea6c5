"""Straight legs under sail: when a waypoint is passed, and what a setpoint says of the line."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.core.estimate import NavState
from companion.guidance.sail_track import SailTrack
from companion.guidance.waypoint import Waypoint
from companion.params.store import Parameters
from tests.unit.estimates import AT_REST


def at(north_m: float, east_m: float) -> NavState:
    return replace(AT_REST, north_m=north_m, east_m=east_m)


def track(*points: tuple[float, float]) -> SailTrack:
    found = SailTrack(Parameters({"NAV_ACC_RAD": 2.0, "MPC_XY_VEL_MAX": 2.0}))
    found.start([Waypoint(*point) for point in points], at(0.0, 0.0))
    return found


def test_it_leads_to_the_waypoint_and_tells_the_distance_from_the_line() -> None:
    progress = track((50.0, 0.0)).update(at(10.0, 8.0), 1.0, 0.1)
    setpoint = progress.setpoint
    assert setpoint.yaw_rad == pytest.approx(math.atan2(-8.0, 40.0))
    assert setpoint.progress.cross_track_error_m == pytest.approx(8.0)
    assert setpoint.progress.course_rad == 0.0
    assert setpoint.surge_mps == 1.0
    assert not progress.finished


def test_a_waypoint_is_passed_inside_its_radius_or_abeam_near_it() -> None:
    assert track((50.0, 0.0), (50.0, 50.0)).update(at(48.5, 0.0), 1.0, 0.1).passed == 1
    assert track((50.0, 0.0), (50.0, 50.0)).update(at(50.1, 2.9), 1.0, 0.1).passed == 1
    assert track((50.0, 0.0), (50.0, 50.0)).update(at(50.1, 3.5), 1.0, 0.1).passed == 0
    assert track((50.0, 0.0), (50.0, 50.0)).update(at(47.0, 0.0), 1.0, 0.1).passed == 0


def test_after_the_last_waypoint_it_asks_for_no_speed() -> None:
    progress = track((50.0, 0.0)).update(at(49.5, 0.0), 1.0, 0.1)
    assert progress.finished
    assert progress.setpoint.surge_mps == 0.0


def test_headway_is_made_along_the_line_whatever_the_tack() -> None:
    found = track((100.0, 0.0))
    ways = [found.update(at(10.0, east_m), 1.0, 0.1).way_m for east_m in (0.0, 12.0, -12.0)]
    assert ways == pytest.approx([-90.0, -90.0, -90.0])


def test_a_waypoint_s_own_speed_counts() -> None:
    found = SailTrack(Parameters())
    found.start([Waypoint(50.0, 0.0, speed_mps=0.4)], at(0.0, 0.0))
    assert found.update(at(0.0, 0.0), 1.0, 0.1).setpoint.surge_mps == 0.4


def test_its_legs_begin_at_the_boat() -> None:
    assert track((50.0, 0.0), (50.0, 50.0)).legs == [[(0.0, 0.0), (50.0, 0.0)], [(50.0, 0.0), (50.0, 50.0)]]


def test_its_legs_lead_on_from_the_boat() -> None:
    found = track((50.0, 0.0), (50.0, 50.0), (0.0, 50.0))
    found.update(at(49.0, 1.0), 1.0, 0.1)
    found.update(at(50.0, 20.0), 1.0, 0.1)
    here = (50.0, 20.0)
    assert found.legs == [[here, here], [here, (50.0, 50.0)], [(50.0, 50.0), (0.0, 50.0)]]


def test_it_needs_waypoints() -> None:
    with pytest.raises(ValueError, match="waypoints"):
        SailTrack(Parameters()).start([], at(0.0, 0.0))
    with pytest.raises(RuntimeError):
        SailTrack(Parameters()).update(at(0.0, 0.0), 1.0, 0.1)
