"""The way round the leader never leads into the circle; the track's arc length and projection hold for any way."""

from __future__ import annotations

import math

from hypothesis import assume, example, given, settings
from hypothesis import strategies as st

from companion.following.keep_out import EITHER, way_round
from companion.following.track import LeaderTrack
from tests.unit.following.leaders import DT_S, Lead, leader_at

RADIUS_M = 16.0
angles = st.floats(-math.pi, math.pi)
far = st.floats(RADIUS_M + 0.01, 300.0)


@given(angles, far, angles, far)
@example(math.pi, 20.0, 0.0, 20.0)
@settings(max_examples=150)
def test_the_way_round_keeps_out_and_arrives(at_rad: float, distance_m: float, goal_rad: float, goal_m: float) -> None:
    x, y = distance_m * math.cos(at_rad), distance_m * math.sin(at_rad)
    goal = goal_m * math.cos(goal_rad), goal_m * math.sin(goal_rad)
    side, sailed, step = EITHER, 0.0, 0.1
    _, expected, _ = way_round((x, y), goal, RADIUS_M, side)
    while math.dist((x, y), goal) > step:
        (dx, dy), left, side = way_round((x, y), goal, RADIUS_M, side)
        assert math.hypot(dx, dy) - 1.0 < 1e-9
        x, y, sailed = x + step * dx, y + step * dy, sailed + step
        assert math.hypot(x, y) > RADIUS_M - 0.05
        assert sailed <= expected + 2.0, "no further than it said"
        assert left <= expected - sailed + 2.0
    straight = math.dist((distance_m * math.cos(at_rad), distance_m * math.sin(at_rad)), goal)
    assert straight - 0.2 <= expected <= straight + math.pi * RADIUS_M


@given(angles, st.floats(0.5, RADIUS_M - 0.5), angles, far)
def test_out_of_the_circle_it_leads_outward(at_rad: float, distance_m: float, goal_rad: float, goal_m: float) -> None:
    x, y = distance_m * math.cos(at_rad), distance_m * math.sin(at_rad)
    goal = goal_m * math.cos(goal_rad), goal_m * math.sin(goal_rad)
    (dx, dy), _, _ = way_round((x, y), goal, RADIUS_M)
    assert math.hypot(x + 0.01 * dx, y + 0.01 * dy) >= distance_m - 1e-4


legs = st.lists(st.tuples(st.floats(1.0, 10.0), st.floats(-0.26, 0.26), st.floats(3.0, 12.0)), min_size=1, max_size=6)


@given(legs, st.floats(0.0, 60.0), st.floats(-3.0, 3.0))
@settings(max_examples=60, deadline=None)
def test_a_place_beside_the_track_is_found_again(
    ways: list[tuple[float, float, float]], back_m: float, beside_m: float
) -> None:
    track, lead = LeaderTrack(), Lead(0.0, 0.0)
    track.start(leader_at(), 80.0, 0.0, 0.0)
    now_s, length_m = 0.0, 80.0
    for duration_s, turn, speed in ways:
        for _ in range(round(duration_s / DT_S)):
            now_s += DT_S
            track.update(lead.step(speed, turn), now_s)
            length_m += abs(lead.speed_mps) * DT_S
    assert abs(track.end_s_m - length_m) < 0.02 * length_m + 0.5
    s = track.end_s_m - back_m
    place = track.at(s)
    assume(abs(place.curvature_1pm) < 0.1)
    north_m = place.north_m - beside_m * math.sin(place.course_rad)
    east_m = place.east_m + beside_m * math.cos(place.course_rad)
    assert abs(track.project(north_m, east_m, s, 8.0) - s) < 1.2
