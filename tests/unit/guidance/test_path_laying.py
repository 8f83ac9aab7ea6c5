"""Tracks that are laid beside the control thread, and taken later."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config.vessel import find, load
from companion.guidance.agility import agility_of
from companion.guidance.path_laying import FromBoat
from companion.guidance.path_tracking import PathTracker
from companion.guidance.waypoint import Waypoint
from companion.params.store import Parameters
from tests.unit.estimates import AT_REST
from tests.unit.io.mavlink.slow_storage import SlowWorker

ROUTE = [Waypoint(20.0 * n, 10.0 * (n % 2)) for n in range(1, 6)]
ONWARD = [Waypoint(20.0 * n, 10.0 * (n % 2)) for n in range(6, 9)]
DT_S = 0.1


def tracker(worker: SlowWorker | None = None, **values: float) -> PathTracker:
    parameters = Parameters()
    for name, value in {"PATH_EFFORT": 0.2, "MPC_XY_VEL_MAX": 1.6, **values}.items():
        assert parameters.set(name, value) is None
    agility = agility_of(load(find("aboat")))
    if worker is None:
        return PathTracker(parameters, True, agility=agility)
    return PathTracker(parameters, True, agility=agility, submit=worker.submit)


def sailed(guide: PathTracker, steps: int) -> list[object]:
    """The setpoints of a boat that does what is asked."""
    nav, found = AT_REST, []
    for _ in range(steps):
        s = guide.update(nav, 1.2, DT_S).setpoint
        found.append(s)
        c, n = math.cos(s.yaw_rad), math.sin(s.yaw_rad)
        north_mps, east_mps = s.surge_mps * c - s.sway_mps * n, s.surge_mps * n + s.sway_mps * c
        nav = replace(
            nav,
            north_m=nav.north_m + north_mps * DT_S, east_m=nav.east_m + east_mps * DT_S, yaw_rad=s.yaw_rad,
            surge_mps=s.surge_mps, sway_mps=s.sway_mps, north_mps=north_mps, east_mps=east_mps,
        )  # fmt: skip
    return found


@pytest.mark.parametrize("effort", [0.0, 0.2])
def test_a_track_laid_beside_is_sailed_as_one_laid_at_once(effort: float) -> None:
    at_once, beside = tracker(PATH_EFFORT=effort), tracker(PATH_EFFORT=effort)
    at_once.start(ROUTE, AT_REST)
    beside.take(beside.shape(AT_REST).lay(FromBoat((0.0, 0.0)), ROUTE, (), True), AT_REST)
    assert sailed(at_once, 400) == sailed(beside, 400)


def test_a_track_that_goes_on_begins_where_the_last_one_ends() -> None:
    guide = tracker(PATH_EFFORT=0.0)
    guide.start(ROUTE, AT_REST, stop_at_end=False, beyond=ONWARD)
    begins = guide.onward()
    assert begins is not None
    laid = guide.shape().lay(begins, ONWARD, (), True)
    sailed(guide, 1000)
    place = guide.legs[0][0]
    assert math.dist(place, (100.0, 10.0)) < 10.0
    guide.take(laid, AT_REST)
    assert math.dist(guide.legs[0][0], place) < 0.1
    assert guide.update(replace(AT_REST, north_m=place[0], east_m=place[1]), 1.2, DT_S).passed == 0


def test_a_track_that_leaves_the_present_one_is_joined_where_the_boat_is_by_then() -> None:
    guide = tracker(PATH_EFFORT=0.0)
    guide.start(ROUTE, AT_REST)
    sailed(guide, 200)
    begins = guide.from_track()
    assert begins is not None
    laid = guide.shape().lay(begins, [Waypoint(20.0, -50.0)], (), True)
    before = guide.legs[0][0]
    nav = replace(AT_REST, north_m=before[0] + 0.4, east_m=before[1] + 0.2, north_mps=1.0, surge_mps=1.0)
    for _ in range(3):
        guide.update(nav, 1.2, DT_S)
    place = guide.legs[0][0]
    assert math.dist(place, before) > 0.3
    guide.take(laid, nav)
    assert math.dist(guide.legs[0][0], place) < 0.2


@pytest.mark.parametrize("radii", [0.7, 1.0, 1.5, 2.5, 4.0])
@pytest.mark.parametrize("aside_deg", [10.0, 40.0, 80.0])
@pytest.mark.parametrize("radius_m", [1.5, 5.0, 16.0])
def test_a_track_leaves_the_present_one_where_the_boat_is(radii: float, aside_deg: float, radius_m: float) -> None:
    """Towards a near waypoint, the bend of a boat that turns widely began behind it: its place jumped by 0.7 m."""
    away_m = radii * radius_m
    guide = tracker(PATH_EFFORT=0.0, NAV_ACC_RAD=radius_m)
    guide.start([Waypoint(200.0, 0.0)], AT_REST)
    sailed(guide, 600)
    joint = guide.from_track()
    assert joint is not None
    aside_rad = math.radians(aside_deg)
    near = Waypoint(joint.here.north_m + away_m * math.cos(aside_rad), away_m * math.sin(aside_rad), radius_m=3.0)
    laid = guide.shape().lay(joint, [near, Waypoint(near.north_m - 40.0, 60.0, radius_m=3.0)], (), True)
    place = laid.track.at(laid.begin_s_m)
    assert math.dist((place.north_m, place.east_m), (joint.here.north_m, joint.here.east_m)) < 0.1
    assert abs(place.course_rad - joint.here.course_rad) < math.radians(2.0)


def test_a_plan_for_other_weather_is_made_beside_and_the_old_one_serves_until_then() -> None:
    worker = SlowWorker()
    guide = tracker(worker)
    guide.take(guide.shape(AT_REST).lay(FromBoat((0.0, 0.0)), ROUTE, (), True), AT_REST)
    assert worker.work() == 0, "the plan was laid with the track"
    calm = guide.update(AT_REST, 1.2, DT_S).setpoint
    stream = replace(AT_REST, current_north_mps=0.4, current_east_mps=0.0)
    assert calm.exact and guide.update(stream, 1.2, DT_S).setpoint.exact
    guide.update(stream, 1.2, DT_S)
    assert worker.work() == 1, "once"
    guide.update(stream, 1.2, DT_S)
    assert worker.work() == 0 and guide.update(stream, 1.2, DT_S).setpoint.exact


def test_until_its_first_plan_is_made_the_boat_sails_without() -> None:
    worker = SlowWorker()
    guide = tracker(worker)
    guide.start(ROUTE, AT_REST)
    assert not guide.update(AT_REST, 1.2, DT_S).setpoint.exact
    worker.work()
    assert guide.update(AT_REST, 1.2, DT_S).setpoint.exact


def test_a_straight_line_of_many_kilometres_needs_few_samples() -> None:
    guide = tracker(PATH_EFFORT=0.0)
    guide.start([Waypoint(40_000.0, 3000.0)], AT_REST)
    assert 100 < sum(len(leg) for leg in guide.legs) < 2_500
    setpoint = guide.update(replace(AT_REST, north_m=20.0, east_m=1.5), 1.2, DT_S).setpoint
    assert setpoint.progress.course_rad == pytest.approx(math.atan2(3.0, 40.0), abs=1e-6)
    assert abs(setpoint.progress.cross_track_error_m) < 1e-3
