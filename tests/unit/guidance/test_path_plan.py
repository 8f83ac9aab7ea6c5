"""Plans of speed and heading along a track, against the limits that they keep."""

from __future__ import annotations

import itertools
import math

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


def planned(weather: Weather | None = None, stop: bool = True) -> tuple[Track, PathPlan]:
    track = Track(build_path(CORNER, PathKind.LINEAR), CORNER, [0.2] * 3, 10.0)
    limits = PlanLimits(agility(), SHARE, 0.5, 0.06, weather or Weather())
    return track, PathPlan(track, track.waypoint_s_m[1:], [SPEED_MPS] * 2, limits, stop)


def test_straight_legs_are_sailed_at_their_speed_and_the_corner_slowly() -> None:
    track, plan = planned()
    corner_s = track.waypoint_s_m[1]
    assert plan.speed_mps(20.0) == pytest.approx(SPEED_MPS)
    assert plan.speed_mps(corner_s + 20.0) == pytest.approx(SPEED_MPS)
    assert plan.speed_mps(corner_s) < 0.4
    assert plan.speed_mps(track.length_m) == 0.0


def test_speeding_up_and_braking_keep_to_the_share_of_the_thrust() -> None:
    track, plan = planned()
    most = SHARE * agility().surge_n / agility().hull.m11_kg
    for a, b in itertools.pairwise(0.25 * i for i in range(round(4.0 * track.length_m))):
        change = (plan.speed_mps(b) ** 2 - plan.speed_mps(a) ** 2) / (2.0 * (b - a))
        assert abs(change) <= most * 1.001


def test_the_bow_turns_half_before_and_half_after_the_corner_at_the_boats_rate() -> None:
    track, plan = planned()
    corner_s = track.waypoint_s_m[1]
    assert plan.at(corner_s - 5.0).course_rad == pytest.approx(0.0, abs=0.02)
    assert math.degrees(plan.at(corner_s).course_rad) == pytest.approx(45.0, abs=6.0)
    assert plan.at(corner_s + 5.0).course_rad == pytest.approx(math.pi / 2.0, abs=0.02)
    places = [corner_s - 4.0]
    while places[-1] < corner_s + 4.0:
        places.append(plan.ahead_m(places[-1], 0.1, SPEED_MPS))
    courses = [plan.at(s).course_rad for s in places]
    fastest = max((b - a) / 0.1 for a, b in itertools.pairwise(courses))
    most = agility().turn_radps(1.2 * SHARE)
    assert 0.5 * most < fastest < 1.15 * most


def test_the_place_ahead_is_where_the_planned_speed_leads() -> None:
    track, plan = planned()
    s, time_s = track.waypoint_s_m[1] - 6.0, 0.0
    begin = s
    while time_s < 5.0:
        s += 0.01 * plan.speed_mps(s)
        time_s += 0.01
    assert plan.ahead_m(begin, 5.0, plan.speed_mps(begin)) == pytest.approx(s, abs=0.1)
    assert plan.ahead_m(5.0, 2.0, 0.5 * SPEED_MPS) == pytest.approx(5.0 + SPEED_MPS, abs=0.02)  # a slower boat


def test_against_a_strong_stream_less_thrust_is_left_to_speed_up() -> None:
    _, calm = planned()
    _, stemming = planned(Weather(water_north_mps=-0.8))
    assert stemming.at(5.0).speeding_up_mps2 < 0.6 * calm.at(5.0).speeding_up_mps2


def test_a_boat_without_sideways_thrust_has_no_plan() -> None:
    assert agility_of(load(find("rescuerunner"))) is None
