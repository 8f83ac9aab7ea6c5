"""The leader's track against circles and lines of which everything is known."""

from __future__ import annotations

import math

import pytest

from companion.following.track import LeaderTrack
from tests.unit.following.leaders import DT_S, Lead, leader_at

PI = math.pi


def sailed(
    track: LeaderTrack, lead: Lead, duration_s: float, speed_mps: float, turn_radps: float = 0.0, now_s: float = 0.0
) -> float:
    for _ in range(round(duration_s / DT_S)):
        now_s += DT_S
        track.update(lead.step(speed_mps, turn_radps), now_s)
    return now_s


def begun(course_rad: float = 0.0) -> tuple[LeaderTrack, Lead]:
    track, lead = LeaderTrack(), Lead(0.0, 0.0, course_rad)
    track.start(leader_at(course_rad=course_rad), 40.0, course_rad, 0.0)
    return track, lead


def test_arc_length_and_curvature_of_a_circle() -> None:
    track, lead = begun()
    lead.speed_mps, lead.turn_radps = 8.0, 0.2
    sailed(track, lead, 20.0, 8.0, 0.2)
    assert track.end_s_m == pytest.approx(40.0 + 160.0, rel=2e-3)
    radius = 8.0 / 0.2
    for back_m in (10.0, 20.0, 60.0):
        point = track.at(track.end_s_m - back_m)
        assert math.hypot(point.north_m, point.east_m - radius) == pytest.approx(radius, abs=0.3)
        assert point.curvature_1pm == pytest.approx(1.0 / radius, rel=0.05)
        assert math.remainder(point.course_rad - (lead.course_rad - back_m / radius), 2 * PI) == pytest.approx(
            0.0, abs=0.03
        )


def test_projection_gives_offset_and_arc_length() -> None:
    track, lead = begun(0.5)
    sailed(track, lead, 30.0, 8.0)
    on = track.at(track.end_s_m - 20.0)
    north_m, east_m = on.north_m - 3.0 * math.sin(0.5), on.east_m + 3.0 * math.cos(0.5)
    assert track.project(north_m, east_m, None) == pytest.approx(track.end_s_m - 20.0, abs=0.05)
    assert track.project(north_m, east_m, track.end_s_m - 25.0, 12.0) == pytest.approx(track.end_s_m - 20.0, abs=0.05)


def test_no_crumbs_pile_up_at_a_leader_at_rest() -> None:
    track, lead = begun()
    now_s = sailed(track, lead, 20.0, 4.0)
    now_s = sailed(track, lead, 20.0, 0.0, now_s=now_s)
    end_s_m = track.end_s_m
    for i in range(2000):  # it swings about on a short line, as a receiver's errors do
        now_s += DT_S
        track.update(
            leader_at(lead.north_m + 0.6 * math.sin(i), lead.east_m + 0.6 * math.cos(1.7 * i), course_rad=0.0), now_s
        )
    assert track.end_s_m == pytest.approx(end_s_m, abs=1.5)
    assert track.at(track.end_s_m - 10.0).course_rad == pytest.approx(0.0, abs=0.05)


def test_a_leader_that_goes_astern_takes_its_track_back() -> None:
    track, lead = begun()
    now_s = sailed(track, lead, 30.0, 4.0)
    length_m = track.end_s_m
    now_s = sailed(track, lead, 6.0, 0.0, now_s=now_s)
    stopped_m = track.end_s_m
    now_s = sailed(track, lead, 12.0, -2.0, now_s=now_s)
    gone_m = stopped_m - track.end_s_m
    assert length_m < stopped_m and 18.0 < gone_m < 24.0
    assert track.at(track.end_s_m - 5.0).course_rad == pytest.approx(0.0, abs=0.02)
    sailed(track, lead, 10.0, 4.0, now_s=now_s)
    assert track.end_s_m > stopped_m - gone_m + 20.0, "ahead again it goes on"


def test_a_track_that_comes_back_beside_the_follower_does_not_take_it_over() -> None:
    track, lead = begun()
    now_s = sailed(track, lead, 20.0, 8.0)
    s = track.end_s_m - 20.0
    follower = track.at(s)
    lead.turn_radps = 0.4
    now_s = sailed(track, lead, PI / 0.4, 8.0, 0.4, now_s)  # half a circle of 20 m radius
    lead.turn_radps = 0.0
    sailed(track, lead, 6.0, 8.0, 0.0, now_s)
    assert track.project(follower.north_m, follower.east_m + 25.0, s, 12.0) == pytest.approx(s, abs=0.5)
    assert track.project(follower.north_m, follower.east_m + 25.0, None) > s + 50.0, "though the way back is nearer"


def test_few_fixes_make_a_smooth_track() -> None:
    """At one fix a second a bend is a cubic through them, not a polygon."""
    track, lead = begun()
    lead.speed_mps, lead.turn_radps = 8.0, 0.2
    radius = 8.0 / 0.2
    now_s = 0.0
    for i in range(200):
        now_s += DT_S
        leader = lead.step(8.0, 0.2)
        if i % 10 == 0:
            track.update(leader, now_s)
    for back_m in (15.0, 19.0, 23.0, 27.0):
        point = track.at(track.end_s_m - back_m)
        assert math.hypot(point.north_m, point.east_m - radius) == pytest.approx(radius, abs=0.15)


def test_what_is_far_astern_is_forgotten() -> None:
    track, lead = begun()
    sailed(track, lead, 120.0, 8.0)
    s = track.end_s_m - 20.0
    place = track.at(s)
    track.trim(s)
    assert s - 60.0 < track.begin_s_m < s - 30.0
    assert track.at(s) == place, "arc length stays what it was"


def test_a_leader_that_jumps_to_another_country_costs_no_more_than_the_longest_track(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    laid = [0]

    def counted(angle_rad: float) -> float:
        laid[0] += 1
        return math.remainder(angle_rad, 2 * PI)

    monkeypatch.setattr("companion.following.track.wrap_pi", counted)
    track, lead = begun()
    now_s = sailed(track, lead, 10.0, 8.0)
    laid[0] = 0
    there = leader_at(1e6, 3e5)
    track.update(there, now_s + 1.0)
    assert laid[0] < 2100, "crumbs"
    end = track.at(track.end_s_m)
    assert (end.north_m, end.east_m) == pytest.approx((there.north_m, there.east_m))
