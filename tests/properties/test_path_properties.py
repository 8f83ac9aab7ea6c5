"""Whatever waypoints are given, there is a path through them, PCHIP does not overshoot, and the tracker comes to its
end."""

from __future__ import annotations

import itertools
import math

from hypothesis import assume, given, settings
from hypothesis import strategies as st

from companion.guidance.path import PathKind, build_path
from companion.guidance.path_tracking import PathTracker
from companion.guidance.waypoint import Waypoint
from companion.params.store import Parameters
from tests.unit.control.simple_boat import nav_state

coordinates = st.floats(-60.0, 60.0)
routes = st.lists(st.tuples(coordinates, coordinates), min_size=2, max_size=8)
DT_S = 0.2


@settings(deadline=None, derandomize=True, max_examples=60)
@given(routes, st.sampled_from(list(PathKind)))
def test_the_path_runs_through_its_waypoints_in_order(points: list[tuple[float, float]], kind: PathKind) -> None:
    path = build_path(points, kind)
    assert list(path.waypoint_s_m) == sorted(path.waypoint_s_m)
    assert path.length_m >= sum(math.dist(a, b) for a, b in itertools.pairwise(points)) - 1e-3
    for s, point in zip(path.waypoint_s_m, points, strict=True):
        assert math.dist(path.position(s), point) < 1e-4


@settings(deadline=None, derandomize=True, max_examples=60)
@given(routes, st.lists(st.booleans(), min_size=8, max_size=8))
def test_pchip_stays_within_the_span_of_neighbouring_waypoints(
    points: list[tuple[float, float]], straight: list[bool]
) -> None:
    path = build_path(points, PathKind.PCHIP, straight[: len(points)])
    stations = path.waypoint_s_m
    for (a, b), (s, e) in zip(itertools.pairwise(points), itertools.pairwise(stations), strict=True):
        for k in range(11):
            at = path.position(s + (e - s) * k / 10.0)
            for axis in (0, 1):
                assert min(a[axis], b[axis]) - 1e-5 <= at[axis] <= max(a[axis], b[axis]) + 1e-5


@settings(deadline=None, derandomize=True, max_examples=40)
@given(routes, st.sampled_from(list(PathKind)), st.tuples(st.floats(-0.25, 0.25), st.floats(-0.25, 0.25)))
def test_every_route_is_sailed_to_its_end_in_any_current(
    points: list[tuple[float, float]], kind: PathKind, current: tuple[float, float]
) -> None:
    parameters = Parameters()
    parameters.set("PATH_KIND", kind)
    parameters.set("MPC_XY_VEL_MAX", 1.5)
    tracker = PathTracker(parameters, can_sway=True)
    north = east = yaw = speed = 0.0
    tracker.start([Waypoint(n, e) for n, e in points], nav_state())
    length = tracker.update(nav_state(), 1.5, DT_S).remaining_m
    assume(length < 700.0)
    reached, passed = 0.0, 0
    for _ in range(round((length / 0.3 + 120.0) / DT_S)):
        c, s = math.cos(yaw), math.sin(yaw)
        vn, ve = speed * c + current[0], speed * s + current[1]
        progress = tracker.update(nav_state(north, east, yaw, c * vn + s * ve, -s * vn + c * ve), 1.5, DT_S)
        assert progress.s_m >= reached and progress.passed >= passed
        reached, passed = progress.s_m, progress.passed
        if progress.finished:
            break
        setpoint = progress.setpoint
        turn = math.remainder(setpoint.yaw_rad - yaw, 2.0 * math.pi)
        yaw += max(-0.2 * DT_S, min(0.2 * DT_S, turn))  # the boat turns at 11°/s at most
        wanted = max(0.3, setpoint.surge_mps - (current[0] * c + current[1] * s))
        speed += max(-0.1 * DT_S, min(0.1 * DT_S, wanted - speed))
        north += vn * DT_S
        east += ve * DT_S
    assert progress.finished and progress.passed == len(points)
