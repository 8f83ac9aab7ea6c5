"""Setpoints by a plan: how they speed up from rest, and when a newer plan is taken."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import pytest

from companion.config.top_speed import top_speed_mps
from companion.config.vessel import find, load
from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.core.frames import body_to_ned
from companion.core.setpoint import Point, Progress
from companion.guidance.agility import Agility, agility_of
from companion.guidance.crab_compensation import CrabCompensation
from companion.guidance.path import PathKind
from companion.guidance.path_laying import FromBoat, LaidTrack, TrackShape
from companion.guidance.path_tracking import PathTracker
from companion.guidance.planned_motion import OnTrack, PlannedMotion
from companion.guidance.waypoint import Waypoint
from companion.params.store import Parameters
from tests.unit.estimates import AT_REST

BOAT = load(find("aboat"))
DT_S, SPEED_MPS = 0.1, 1.2
CORNER = [Waypoint(30.0, 0.0), Waypoint(30.0, 30.0)]
PROGRESS = Progress(Point(0.0, 0.0), Point(0.0, 0.0), 0.0, 0.0, 0.0)
CARRIED = replace(AT_REST, current_north_mps=0.7, current_east_mps=0.0)
STREAM = replace(AT_REST, current_north_mps=-0.4, current_east_mps=-0.4)


def aboat() -> Agility:
    agility = agility_of(BOAT)
    assert agility is not None
    return agility


def motion(parameters: Parameters | None = None, agility: Agility | None = None) -> tuple[PlannedMotion, LaidTrack]:
    parameters = parameters or Parameters(BOAT.parameters)
    planned = PlannedMotion(parameters, agility or aboat(), CrabCompensation(top_speed_mps(BOAT)))
    laid = TrackShape(PathKind.LINEAR, 1.5, 10.0, True, SPEED_MPS, None).lay(FromBoat((0.0, 0.0)), CORNER, (), True)
    planned.take(laid)
    return planned, laid


def speeds(
    planned: PlannedMotion, laid: LaidTrack, nav: NavState, s_m: float, steps: int, most_mps: float = SPEED_MPS
) -> list[float]:
    """The setpoint's speed while the boat sails by it from `s_m` on."""
    found = []
    for _ in range(steps):
        assert planned.is_planned(nav, most_mps, s_m, DT_S)
        planned.update(OnTrack(laid.track, s_m, laid.track.at(s_m), 0.0), nav, PROGRESS, DT_S)
        found.append(planned.speed_mps)
        s_m += planned.speed_mps * DT_S
    return found


def test_from_rest_the_setpoint_speeds_up_as_the_thrust_builds_up() -> None:
    """With all of its acceleration at once it ran ahead of the boat, whose loops then pushed it beyond its speed."""
    planned, laid = motion()
    found = [0.0, *speeds(planned, laid, AT_REST, 0.0, 60)]
    rises = [(b - a) / DT_S for a, b in itertools.pairwise(found)]
    assert max(b - a for a, b in itertools.pairwise([0.0, *rises])) < 0.21
    assert found[-1] == pytest.approx(SPEED_MPS, abs=0.03)


def test_speeding_up_asks_for_no_more_thrust_than_is_planned_with() -> None:
    """The thrust is that for a little later, when drag takes more of it."""
    planned, laid = motion()
    agility = aboat()
    most_n = agility.hull.drag_n(SPEED_MPS) + 0.35 * 0.2 * agility.surge_n
    s_m = 0.0
    for _ in range(40):
        assert planned.is_planned(AT_REST, SPEED_MPS, s_m, DT_S)
        setpoint = planned.update(OnTrack(laid.track, s_m, laid.track.at(s_m), 0.0), AT_REST, PROGRESS, DT_S)
        soon = setpoint.surge_mps + 0.4 * setpoint.surge_mps2
        assert agility.hull.m11_kg * setpoint.surge_mps2 + agility.hull.drag_n(soon) < most_n + 25.0
        s_m += planned.speed_mps * DT_S


def test_a_plan_for_other_weather_waits_for_the_end_of_a_bend() -> None:
    """Found in the midst of braking, it let the boat speed up again, which was then too fast for the corner."""
    planned, laid = motion()
    corner_m = laid.ends_s_m[0]
    speeds(planned, laid, CARRIED, corner_m - 12.0, 100)
    braking = speeds(planned, laid, CARRIED, corner_m - 2.5, 5)[-1]
    after = speeds(planned, laid, AT_REST, corner_m - 2.0, 10)
    assert all(b < a for a, b in itertools.pairwise([braking, *after]))
    fresh, _ = motion()
    speeds(fresh, laid, CARRIED, corner_m - 12.0, 100)
    speeds(fresh, laid, CARRIED, corner_m - 2.5, 5)
    assert after == pytest.approx(speeds(fresh, laid, CARRIED, corner_m - 2.0, 10))


def test_it_is_taken_on_the_leg_behind() -> None:
    planned, laid = motion()
    corner_m = laid.ends_s_m[0]
    speeds(planned, laid, AT_REST, corner_m - 12.0, 100)
    speeds(planned, laid, STREAM, corner_m - 1.0, 5)
    speeds(planned, laid, STREAM, corner_m + 10.0, 50)
    found = speeds(planned, laid, STREAM, laid.ends_s_m[1] - 4.0, 40)
    fresh, _ = motion()
    speeds(fresh, laid, STREAM, corner_m + 10.0, 50)
    assert found == pytest.approx(speeds(fresh, laid, STREAM, laid.ends_s_m[1] - 4.0, 40))
    still, _ = motion()
    speeds(still, laid, AT_REST, corner_m + 10.0, 50)
    assert found != pytest.approx(speeds(still, laid, AT_REST, laid.ends_s_m[1] - 4.0, 40), abs=0.02)


def test_a_plan_for_another_speed_is_taken_at_once() -> None:
    planned, laid = motion()
    speeds(planned, laid, AT_REST, 1.0, 60, 0.6)
    assert planned.speed_mps == pytest.approx(0.6)
    speeds(planned, laid, AT_REST, 6.0, 40)
    assert planned.speed_mps == pytest.approx(SPEED_MPS, abs=0.03)


def test_poses_ahead_are_planned_for_thrusters_that_turn_and_for_the_law_that_looks_ahead() -> None:
    fixed = replace(aboat(), aims=False)
    for agility, control, count in ((aboat(), 0, 12), (aboat(), 2, 19), (fixed, 0, 0), (fixed, 2, 19)):
        parameters = Parameters(BOAT.parameters)
        assert parameters.set("PATH_CTRL", control) is None
        planned, laid = motion(parameters, agility)
        assert planned.is_planned(AT_REST, SPEED_MPS, 0.0, DT_S)
        setpoint = planned.update(OnTrack(laid.track, 0.0, laid.track.at(0.0), 0.0), AT_REST, PROGRESS, DT_S)
        assert len(setpoint.ahead) == count


def headings(off_m: float, steps: int, nav: NavState = AT_REST, kept: PlannedMotion | None = None) -> list[float]:
    """The heading asked for on the first leg, which leads north, by a boat that stays `off_m` to starboard of it."""
    planned, laid = motion() if kept is None else (kept, motion()[1])
    found = []
    for _ in range(steps):
        assert planned.is_planned(nav, SPEED_MPS, 5.0, DT_S)
        found.append(planned.update(OnTrack(laid.track, 5.0, laid.track.at(5.0), off_m), nav, PROGRESS, DT_S).yaw_rad)
    return found


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_the_bow_leans_towards_a_track_that_sideways_thrust_does_not_reach(side: float) -> None:
    """With all of its thrust against a stream ReVolt stayed 0.2 to 0.5 m beside each leg."""
    leaning = headings(side * 0.3, 400)
    assert abs(leaning[0]) < math.radians(0.5)
    assert -side * leaning[-1] > math.radians(5.0)
    assert max(abs(yaw) for yaw in headings(side * 0.09, 400)) < math.radians(0.5)


def test_a_turn_makes_it_forget_the_lean() -> None:
    planned, laid = motion()
    assert planned.is_planned(AT_REST, SPEED_MPS, 5.0, DT_S)
    headings(0.3, 400, kept=planned)
    speeds(planned, laid, AT_REST, 20.0, 200)
    assert abs(headings(0.0, 100, kept=planned)[-1]) < math.radians(1.0)


def test_a_bow_far_off_the_plan_comes_round_with_all_haste_and_one_nearly_there_does_not() -> None:
    """At rest across a stream ReVolt turned at 4 deg/s, which carried it 6 m off its first leg."""
    rate = math.radians(BOAT.parameters["PATH_YAW_RATE"])
    astray = replace(AT_REST, yaw_rad=2.0)
    planned, laid = motion()
    place = OnTrack(laid.track, 5.0, laid.track.at(5.0), 0.0)
    assert planned.is_planned(astray, SPEED_MPS, 5.0, DT_S)
    first = planned.update(place, astray, PROGRESS, DT_S)
    assert first.yaw_rad == pytest.approx(2.0 - rate * DT_S)
    assert first.yaw_rate_radps == pytest.approx(-rate)
    later = headings(0.0, 200, astray, planned)
    assert later[-1] == pytest.approx(0.0, abs=0.01)
    assert max(a - b for a, b in itertools.pairwise(later) if b < math.radians(10.0)) < 0.6 * rate * DT_S


def test_a_bow_turns_no_further_than_60_degrees_to_a_track_far_away() -> None:
    """Towards it alone, against a stream, it made no way."""
    assert headings(20.0, 400)[-1] == pytest.approx(-math.radians(60.0), abs=0.01)


def test_the_velocity_asked_for_does_not_jump_where_the_course_does() -> None:
    """Behind a sharp corner the course came round by 30° within a tick while the boat had swung past it: the speed
    ahead that was asked for grew by 0.3 m/s, the one aside changed its sign."""
    planned, laid = motion()
    corner_m = laid.ends_s_m[0]
    speeds(planned, laid, AT_REST, corner_m - 12.0, 150)
    here = laid.track.at(corner_m)
    asked = []
    for tick in range(40):
        course_rad = 0.3 if tick < 5 else 0.9 if tick < 10 else 1.5
        nav = replace(AT_REST, yaw_rad=1.2 + 0.05 * tick)
        assert planned.is_planned(nav, SPEED_MPS, corner_m, DT_S)
        place = OnTrack(laid.track, corner_m, replace(here, course_rad=course_rad), 0.0)
        setpoint = planned.update(place, nav, PROGRESS, DT_S)
        asked.append(body_to_ned(setpoint.surge_mps, setpoint.sway_mps, nav.yaw_rad))
    assert max(math.dist(a, b) for a, b in itertools.pairwise(asked)) < 0.15
    assert math.atan2(asked[-1][1], asked[-1][0]) == pytest.approx(1.5, abs=0.2)


def test_on_a_leg_the_velocity_asked_for_is_the_planned_one_also_from_rest() -> None:
    """Bounded by the braking alone it came a second late from rest and behind each corner."""
    planned, laid = motion()
    s_m = 0.0
    for _ in range(100):
        assert planned.is_planned(AT_REST, SPEED_MPS, s_m, DT_S)
        setpoint = planned.update(OnTrack(laid.track, s_m, laid.track.at(s_m), 0.0), AT_REST, PROGRESS, DT_S)
        assert setpoint.surge_mps == pytest.approx(planned.speed_mps, abs=0.06)
        s_m += planned.speed_mps * DT_S
    assert planned.speed_mps > 0.9 * SPEED_MPS


@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_from_rest_in_a_stream_that_is_not_known_yet_the_bow_comes_round_at_once(side: float) -> None:
    """It waited until the boat was off its track or the current known: ReVolt was set 7 m aside, not 5."""
    revolt = load(find("revolt"))
    tracker = PathTracker(Parameters(revolt.parameters), True, top_speed_mps(revolt), agility_of(revolt))
    nav = replace(AT_REST, sway_mps=side * 0.6, east_mps=side * 0.6)
    tracker.start([Waypoint(100.0, 0.0)], nav)
    for tick in range(12):
        setpoint = tracker.update(replace(nav, east_m=side * 0.06 * tick), 0.6, DT_S).setpoint
        assert -0.15 < side * setpoint.sway_mps < 0.05, "the law knows of no stream that carries the boat"
    assert -side * setpoint.yaw_rad > math.radians(12.0)


# (north_m, east_m, radius_m, speed_mps)
PACKED = [
    (0.296, 0.278, 0.5, 0.4),
    (0.354, -0.238, 0.5, 0.4),
    (0.354, -0.238, 0.5, 0.4),
    (0.354, -0.238, 0.5, 0.4),
    (-0.467, -0.284, 8.0, 0.4),
    (0.476, 0.228, 0.5, None),
    (0.097, 0.182, None, 0.4),
]


def test_points_packed_closer_than_the_boat_are_sailed() -> None:
    """The mean of turns to and fro led the bow astern of the course there, and the boat waited for its bow for ever."""
    parameters = Parameters(BOAT.parameters)
    parameters.set("PATH_KIND", 0.0)
    tracker = PathTracker(parameters, True, 3.0, aboat())
    north_m, east_m, yaw_rad, dt_s = 0.374, -0.865, 2.872, 0.2
    nav = replace(AT_REST, north_m=north_m, east_m=east_m, yaw_rad=yaw_rad)
    tracker.start([Waypoint(*point) for point in PACKED], nav)
    for _ in range(1500):
        progress = tracker.update(nav, SPEED_MPS, dt_s)
        if progress.finished:
            break
        setpoint = progress.setpoint
        yaw_rad += min(0.08, max(-0.08, wrap_pi(setpoint.yaw_rad - yaw_rad)))
        north_mps, east_mps = body_to_ned(setpoint.surge_mps, setpoint.sway_mps, yaw_rad)
        north_m, east_m = north_m + north_mps * dt_s, east_m + east_mps * dt_s
        nav = replace(
            AT_REST,
            north_m=north_m,
            east_m=east_m,
            yaw_rad=yaw_rad,
            surge_mps=setpoint.surge_mps,
            sway_mps=setpoint.sway_mps,
            north_mps=north_mps,
            east_mps=east_mps,
        )
    assert progress.finished and progress.passed == len(PACKED)
