"""The ÅBOAT thesis's waypoint law: its formulas against the ellipsoid, its intermediate waypoints, and that it circles
what it misses."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.baselines.path_choice import ChosenPathTracker
from companion.baselines.waypoints import EARTH_RADIUS_M, ThesisWaypoints, bearing_rad, haversine_m
from companion.core.estimate import NavState
from companion.core.geodesy import distance_and_bearing
from companion.guidance.path_tracking import PathProgress
from companion.guidance.waypoint import Waypoint
from companion.params.store import Parameters
from tests.unit.control.simple_boat import nav_state

DT_S = 0.1
SQUARE = [Waypoint(n, e) for n, e in ((40.0, 0.0), (40.0, 40.0), (0.0, 40.0), (0.0, 0.0))]
Law = ThesisWaypoints | ChosenPathTracker


def sail(
    law: Law, seconds: float, current: tuple[float, float] = (0.0, 0.0), turn_radps: float = math.inf
) -> list[tuple[NavState, PathProgress]]:
    """A point that goes 1 m/s where it heads, turns at most so fast, and is carried along."""
    north = east = yaw = 0.0
    rows = []
    for _ in range(round(seconds / DT_S)):
        nav = nav_state(north, east, yaw, 1.0)
        progress = law.update(nav, 1.0, DT_S)
        rows.append((nav, progress))
        if progress.finished:
            break
        wanted = progress.setpoint.yaw_rad
        assert wanted is not None
        off = math.remainder(wanted - yaw, math.tau)
        yaw += max(-turn_radps * DT_S, min(turn_radps * DT_S, off))
        north += (math.cos(yaw) + current[0]) * DT_S
        east += (math.sin(yaw) + current[1]) * DT_S
    return rows


def thesis(**values: float) -> ThesisWaypoints:
    return ThesisWaypoints(Parameters({"PATH_KIND": 0, **values}))


@given(st.floats(-70.0, 70.0), st.floats(-179.0, 179.0), st.floats(-0.05, 0.05), st.floats(-0.05, 0.05))
def test_bearing_and_distance_are_those_of_the_ellipsoid_but_for_its_flattening(
    lat: float, lon: float, dlat: float, dlon: float
) -> None:
    if abs(dlat) + abs(dlon) < 1e-4:
        return
    distance_m, bearing = distance_and_bearing(lat, lon, lat + dlat, lon + dlon)
    assert haversine_m(lat, lon, lat + dlat, lon + dlon) == pytest.approx(distance_m, rel=0.007)
    assert abs(math.remainder(bearing_rad(lat, lon, lat + dlat, lon + dlon) - bearing, math.tau)) < 0.006


def test_bearing_is_counted_from_north_through_east() -> None:
    assert [math.degrees(bearing_rad(0, 0, *to)) for to in ((1, 0), (0, 1), (-1, 0), (0, -1))] == pytest.approx(
        [0.0, 90.0, 180.0, 270.0]
    )
    assert haversine_m(0.0, 0.0, 0.0, 1.0) == pytest.approx(EARTH_RADIUS_M * math.pi / 180.0)


@pytest.mark.parametrize(("density", "count"), [(5.0, 5), (1.0, 1), (20.0, 20)])
def test_a_section_has_as_many_intermediate_waypoints_as_asked_for(density: float, count: int) -> None:
    law = thesis(WPT_DENSITY=density, WPT_RADIUS=1.0)
    law.start([Waypoint(100.0, 0.0)], nav_state(yaw_rad=0.0))
    rows = sail(law, 200.0)
    aims = sorted({row.setpoint.progress.place.north_m for _, row in rows})
    assert aims == pytest.approx([100.0 * k / count for k in range(1, count + 1)])


def test_a_square_is_sailed_and_the_boat_slows_down_at_its_end() -> None:
    law = thesis()
    law.start(SQUARE, nav_state())
    rows = [progress for _, progress in sail(law, 400.0)]
    assert [progress.passed for progress in rows][-1] == 4 and rows[-1].finished
    assert rows[-1].setpoint.surge_mps == 0.0
    assert rows[-3].setpoint.surge_mps < 0.95 < max(row.setpoint.surge_mps for row in rows)


def test_a_waypoint_that_is_missed_is_circled() -> None:
    """A boat that turns in a circle of 5 m, with a waypoint of 1 m inside it, goes round for ever. The companion's own
    path tracking never does."""
    law = thesis(WPT_RADIUS=1.0)
    law.start([Waypoint(0.0, 5.0)], nav_state())
    rows = sail(law, 200.0, turn_radps=0.2)
    assert not rows[-1][1].finished
    assert rows[-1][0].yaw_rad > 2.0 * math.tau


def test_a_current_carries_it_off_the_straight_line() -> None:
    law = thesis(WPT_DENSITY=0.5)
    law.start([Waypoint(100.0, 0.0)], nav_state())
    errors = [
        progress.setpoint.progress.cross_track_error_m or 0.0 for _, progress in sail(law, 300.0, current=(0.0, 0.3))
    ]
    assert max(errors) > 5.0


def test_nothing_to_sail_is_an_error() -> None:
    with pytest.raises(ValueError, match="waypoints"):
        thesis().start([], nav_state())
    with pytest.raises(RuntimeError):
        thesis().update(nav_state(), 1.0, DT_S)


def test_the_law_changes_under_way_and_the_rest_of_the_route_is_sailed() -> None:
    parameters = Parameters({"PATH_KIND": 0, "WP_LAW": 1, "MPC_XY_VEL_MAX": 2.0})
    law = ChosenPathTracker(parameters, can_sway=False)
    law.start(SQUARE, nav_state())
    passed, ways = [], []
    north = east = yaw = 0.0
    for step in range(6000):
        if step == 600:
            parameters.set("WP_LAW", 0)
        progress = law.update(nav_state(north, east, yaw, 1.0), 1.0, DT_S)
        passed.append(progress.passed)
        ways.append(progress.way_m)
        assert law.took_over == (step == 600)
        if progress.finished:
            break
        yaw = progress.setpoint.yaw_rad or 0.0
        north += math.cos(yaw) * DT_S * progress.setpoint.surge_mps
        east += math.sin(yaw) * DT_S * progress.setpoint.surge_mps
    assert progress.finished and passed == sorted(passed) and passed[599] in (1, 2) and passed[-1] == 4
    assert max(abs(b - a) for a, b in pairwise(ways[595:605])) < 0.5, "the way made goes on counting"


def test_its_legs_lead_on_from_the_boat() -> None:
    law = thesis(WPT_DENSITY=100.0)
    law.start([Waypoint(n, 0.0) for n in (15.0, 30.0, 45.0, 60.0)], nav_state(0.0, 0.0))
    north = 0.0
    while law.update(nav_state(north, 0.0, 0.0, 1.0), 1.0, DT_S).passed < 2:
        north += 0.1
    legs = law.legs
    way = [place[0] for leg in legs for place in leg]
    assert len(legs) == 4 and way == sorted(way) and way[0] == pytest.approx(north, abs=1.0)
