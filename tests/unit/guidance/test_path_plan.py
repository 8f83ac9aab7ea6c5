"""Plans of speed and heading along a track, against the limits that they keep."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import pytest

from companion.config.vessel import find, load
from companion.guidance.agility import Agility, Weather, agility_of
from companion.guidance.path import PathKind, build_path
from companion.guidance.path_plan import PathPlan, PlanLimits
from companion.guidance.track import Track

SHARE, SPEED_MPS = 0.2, 1.2
CORNER = [(0.0, 0.0), (40.0, 0.0), (40.0, 40.0)]


def agility() -> Agility:
    found = agility_of(load(find("aboat")))
    assert found is not None
    return found


def planned(
    weather: Weather | None = None, stop: bool = True, points: list[tuple[float, float]] = CORNER
) -> tuple[Track, PathPlan]:
    track = Track(build_path(points, PathKind.LINEAR), points, [0.2] * 3, 10.0)
    limits = PlanLimits(agility(), SHARE, 0.5, 0.3, weather or Weather())
    return track, PathPlan(track, track.waypoint_s_m[1:], [SPEED_MPS] * 2, limits, stop)


def test_straight_legs_are_sailed_at_their_speed_and_the_corner_slowly() -> None:
    track, plan = planned()
    corner_s = track.waypoint_s_m[1]
    assert plan.speed_mps(20.0) == pytest.approx(SPEED_MPS)
    assert plan.speed_mps(corner_s + 20.0) == pytest.approx(SPEED_MPS)
    assert min(plan.speed_mps(corner_s + 0.1 * i) for i in range(-10, 11)) < 0.4
    assert plan.speed_mps(track.length_m) == 0.0


def fastest_turn_radps(track: Track, plan: PathPlan) -> float:
    """Within 4 m of the corner."""
    corner_s = track.waypoint_s_m[1]
    places = [corner_s - 4.0]
    while places[-1] < corner_s + 4.0:
        places.append(plan.ahead_m(places[-1], 0.1, SPEED_MPS))
    courses = [plan.course_rad(s) for s in places]
    return max((b - a) / 0.1 for a, b in itertools.pairwise(courses))


def test_a_sharp_corner_is_turned_no_faster_than_a_right_angle_although_the_boat_is_slower_there() -> None:
    track, plan = planned()
    sharp_track, sharp = planned(points=[(0.0, 0.0), (40.0, 0.0), (8.0, 24.0)])
    assert fastest_turn_radps(sharp_track, sharp) < fastest_turn_radps(track, plan)


def thrusts_n(track: Track, plan: PathPlan, begin_m: float, end_m: float) -> list[float]:
    """Thrust along the track, by the plan's change of speed and the drag, between two places."""
    hull, step, found = agility().hull, 0.05, []
    for i in range(round((end_m - begin_m) / step)):
        a, b = plan.speed_mps(begin_m + i * step), plan.speed_mps(begin_m + (i + 1) * step)
        found.append(hull.m11_kg * (b * b - a * a) / (2.0 * step) + hull.drag_n(0.5 * (a + b)))
    return found


def test_the_thrust_ahead_of_a_bend_and_behind_it_stays_near_that_of_the_leg() -> None:
    track, plan = planned()
    corner_s, steady = track.waypoint_s_m[1], agility().hull.drag_n(SPEED_MPS)
    most = steady + 0.2 * SHARE * agility().surge_n
    found = thrusts_n(track, plan, corner_s - 8.0, corner_s + 8.0)
    assert max(found) < most + 12.0
    assert min(found) > -20.0, "the drag brakes: no thruster reverses"


def test_the_planned_thrust_changes_no_faster_than_azimuths_turn() -> None:
    """A plan of constant braking drops the thrust within a tick: at a corner the azimuths then lie where they cannot
    turn the boat."""
    track, plan = planned()
    corner_s = track.waypoint_s_m[1]
    found = thrusts_n(track, plan, corner_s - 8.0, corner_s + 6.0)
    times = [0.05 / max(0.1, plan.speed_mps(corner_s - 8.0 + 0.05 * i)) for i in range(len(found))]
    steep = [(b - a) / dt for a, b, dt in zip(found[4::4], found[8::4], times[4::4], strict=False)]
    assert max(abs(x) for x in steep) / 4.0 < 200.0


def test_plans_for_other_weather_agree_on_a_leg_and_not_ahead_of_a_bend() -> None:
    track, plan = planned()
    _, other = planned(Weather(-0.3, 0.0, -6.0, 0.0))
    corner_s = track.waypoint_s_m[1]
    assert plan.agrees(other, 15.0) and plan.agrees(plan, corner_s)
    assert not plan.agrees(other, corner_s - 2.0)


def test_at_the_end_of_the_track_the_thrusters_brake() -> None:
    track, plan = planned()
    assert min(thrusts_n(track, plan, track.length_m - 3.0, track.length_m - 0.1)) < -15.0


def test_a_gentle_bend_is_braked_for_with_little_less_thrust_than_a_sharp_one() -> None:
    low = []
    for last in ((75.0, 20.0), (40.0, 40.0)):
        points = [(0.0, 0.0), (40.0, 0.0), last]
        track = Track(build_path(points, PathKind.LINEAR), points, [0.2] * 3, 10.0, [4.4] * 3)
        plan = PathPlan(
            track, track.waypoint_s_m[1:], [SPEED_MPS] * 2, PlanLimits(agility(), SHARE, 0.5, 0.3, Weather()), True
        )
        corner_s = track.waypoint_s_m[1]
        low.append(min(thrusts_n(track, plan, corner_s - 6.0, corner_s)))
    assert low[0] > low[1] + 50.0


def test_the_bow_turns_half_before_and_half_after_the_corner_at_the_boats_rate() -> None:
    track, plan = planned()
    corner_s = track.waypoint_s_m[1]
    assert plan.course_rad(corner_s - 5.0) == pytest.approx(0.0, abs=0.02)
    assert math.degrees(plan.course_rad(corner_s)) == pytest.approx(45.0, abs=6.0)
    assert plan.course_rad(corner_s + 5.0) == pytest.approx(math.pi / 2.0, abs=0.02)
    fastest = fastest_turn_radps(track, plan)
    most = agility().turn_radps(2.0 * SHARE, 0.0)
    assert 0.5 * most < fastest < 1.15 * most


def test_a_hull_that_way_holds_straight_turns_more_slowly_at_the_same_speed() -> None:
    stiff = replace(agility(), hull=replace(agility().hull, damping=replace(agility().hull.damping, n_ur=300.0)))
    assert stiff.turn_radps(SHARE, 1.0) < 0.5 * stiff.turn_radps(SHARE, 0.0) == 0.5 * agility().turn_radps(SHARE, 1.0)
    track = Track(build_path(CORNER, PathKind.LINEAR), CORNER, [0.2] * 3, 10.0)

    def fastest_radps(of: Agility) -> float:
        limits = PlanLimits(of, SHARE, 0.5, SPEED_MPS, Weather())  # no bend slows the boat
        plan = PathPlan(track, track.waypoint_s_m[1:], [SPEED_MPS] * 2, limits, True)
        places = [track.waypoint_s_m[1] - 8.0 + 0.1 * i for i in range(160)]
        rates = [(plan.course_rad(b) - plan.course_rad(a)) / 0.1 for a, b in itertools.pairwise(places)]
        return SPEED_MPS * max(rates)

    assert fastest_radps(stiff) < 1.15 * stiff.turn_radps(2.0 * SHARE, SPEED_MPS) < fastest_radps(agility())


def test_to_the_side_that_a_boat_turns_to_more_weakly_without_running_aside_it_turns_more_slowly() -> None:
    """ReVolt's bow thruster pushes 6 N to port and 14 N to starboard. Turns planned as fast to either side set it 1 m
    wide behind sharp ones to port: for the rest of the moment its stern pushed the boat aside."""
    revolt = agility_of(load(find("revolt")))
    assert revolt is not None
    assert (revolt.port_share, revolt.starboard_share) == (pytest.approx(0.53, abs=0.02), 1.0)
    assert (agility().port_share, agility().starboard_share) == (1.0, 1.0)

    def fastest_radps(side: float) -> float:
        points = [(north, side * east) for north, east in CORNER]
        track = Track(build_path(points, PathKind.LINEAR), points, [0.2] * 3, 10.0)
        plan = PathPlan(track, track.waypoint_s_m[1:], [0.6] * 2, PlanLimits(revolt, SHARE, 0.1, 0.15, Weather()), True)
        places = [track.waypoint_s_m[1] - 4.0]
        while places[-1] < track.waypoint_s_m[1] + 4.0:
            places.append(plan.ahead_m(places[-1], 0.1, plan.speed_mps(places[-1])))
        return max(side * (plan.course_rad(b) - plan.course_rad(a)) / 0.1 for a, b in itertools.pairwise(places))

    port, starboard = (revolt.turn_radps(2.0 * SHARE * side, 0.0) for side in (revolt.port_share, 1.0))
    assert fastest_radps(-1.0) < 1.15 * port < fastest_radps(1.0) < 1.15 * starboard


def test_the_moment_of_a_planned_turn_has_no_steps() -> None:
    """Windows that widened in steps asked for 33 Nm more within 0.3 s: force that is gone again before it is there."""
    track, plan = planned()
    s_m, step_s, bow = track.waypoint_s_m[1] - 12.0, 0.1, []
    while s_m < track.waypoint_s_m[1] + 12.0:
        bow.append(plan.course_rad(s_m))
        s_m = plan.ahead_m(s_m, step_s, plan.speed_mps(s_m))
    turns = [b - a for a, b in itertools.pairwise(bow)]
    moments = [agility().hull.m33_kgm2 * (b - a) / step_s**2 for a, b in itertools.pairwise(turns)]
    means = [sum(moments[i : i + 3]) / 3.0 for i in range(len(moments) - 2)]
    assert max(abs(b - a) for a, b in zip(means, means[3:], strict=False)) < 20.0


def test_the_place_ahead_is_where_the_planned_speed_leads() -> None:
    track, plan = planned()
    s, time_s = track.waypoint_s_m[1] - 6.0, 0.0
    begin = s
    while time_s < 5.0:
        s += 0.01 * plan.speed_mps(s)
        time_s += 0.01
    assert plan.ahead_m(begin, 5.0, plan.speed_mps(begin)) == pytest.approx(s, abs=0.1)
    assert plan.ahead_m(5.0, 2.0, 0.5 * SPEED_MPS) == pytest.approx(5.0 + SPEED_MPS, abs=0.02)  # a slower boat


def test_against_a_strong_stream_hardly_any_thrust_is_left_to_speed_up() -> None:
    _, calm = planned()
    _, stemming = planned(Weather(water_north_mps=-1.0))
    assert calm.reach_mps2(5.0, 1.1)[0] > 0.2
    assert stemming.reach_mps2(5.0, 1.1)[0] == agility().least_mps2


def test_a_boat_without_sideways_thrust_has_no_plan() -> None:
    assert agility_of(load(find("rescuerunner"))) is None


def test_a_long_leg_leaves_the_plan_of_the_others_as_it_is() -> None:
    near_track, near = planned()
    track, far = planned(points=[*CORNER[:2], (40.0, 60_000.0)])
    corner_s = track.waypoint_s_m[1]
    for x in (-10.0, -3.0, -1.0, 0.0, 1.0, 3.0, 10.0):
        s, near_s = corner_s + x, near_track.waypoint_s_m[1] + x
        assert far.speed_mps(s) == pytest.approx(near.speed_mps(near_s), abs=0.03)
        assert far.course_rad(s) == pytest.approx(near.course_rad(near_s), abs=0.05)
        assert far.ahead_m(s, 2.0, 0.3) - s == pytest.approx(near.ahead_m(near_s, 2.0, 0.3) - near_s, abs=0.05)


def test_a_way_that_takes_no_time_has_a_plan() -> None:
    """Its steps are so short that tables of them would not fit into memory."""
    track, plan = planned(points=[(3.0, 4.0)] * 3)
    assert track.length_m == 0.0
    assert (plan.speed_mps(0.0), plan.course_rad(0.0)) == pytest.approx((0.0, 0.0), abs=1e-3)
