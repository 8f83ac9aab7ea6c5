"""The rounded track: how much it cuts, how tight it bends, and projection on it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from companion.guidance.path import PathKind, build_path
from companion.guidance.track import Track, apart, turns_rad

SQUARE = [(0.0, 0.0), (20.0, 0.0), (20.0, 20.0), (0.0, 20.0), (0.0, 0.0)]


def track_of(
    points: list[tuple[float, float]], kind: PathKind = PathKind.PCHIP, radius_m: float = 1.5, widest_m: float = 50.0
) -> Track:
    return Track(build_path(points, kind), points, [radius_m] * len(points), widest_m)


def cuts(track: Track, points: list[tuple[float, float]]) -> list[float]:
    return [
        math.dist((track.at(s).north_m, track.at(s).east_m), p) for s, p in zip(track.waypoint_s_m, points, strict=True)
    ]


@pytest.mark.parametrize("kind", [PathKind.LINEAR, PathKind.PCHIP])
@pytest.mark.parametrize("radius_m", [0.5, 1.5, 4.0])
def test_corners_are_cut_well_inside_the_radius_and_bend_in_proportion(kind: PathKind, radius_m: float) -> None:
    track = track_of(SQUARE, kind, radius_m)
    assert max(cuts(track, SQUARE)) < 0.6 * radius_m
    assert max(map(abs, track.curvature_1pm)) == pytest.approx(1.46 / radius_m, rel=0.1)
    assert (cuts(track, SQUARE)[0], cuts(track, SQUARE)[-1]) == pytest.approx((0.0, 0.0), abs=1e-9)


def test_straight_legs_stay_straight_and_gentle_bends_stay_put() -> None:
    track = track_of(SQUARE)
    for s in np.linspace(4.0, 15.0, 20):
        assert track.at(float(s)).east_m == pytest.approx(0.0, abs=1e-9)
    circle = [(30.0 * math.sin(a), 30.0 - 30.0 * math.cos(a)) for a in np.linspace(0.0, 3.0, 20)]
    bent = track_of(circle, PathKind.CUBIC)
    for s in np.linspace(10.0, 80.0, 30):
        point = bent.at(float(s))
        assert math.hypot(point.north_m, point.east_m - 30.0) == pytest.approx(30.0, abs=0.03)
        assert point.curvature_1pm == pytest.approx(1.0 / 30.0, rel=0.05)


def test_no_more_rounding_than_the_speed_needs() -> None:
    assert max(cuts(track_of(SQUARE, radius_m=5.0, widest_m=1.0), SQUARE)) < 0.2


@pytest.mark.parametrize("turn_deg", [30.0, 60.0, 90.0, 140.0])
def test_a_swing_passes_the_point_as_near_with_a_wider_bend(turn_deg: float) -> None:
    turn = math.radians(turn_deg)
    points = [(0.0, 0.0), (30.0, 0.0), (30.0 + 30.0 * math.cos(turn), 30.0 * math.sin(turn))]
    path = build_path(points, PathKind.LINEAR)
    cut, swung = Track(path, points, [0.2] * 3, 10.0), Track(path, points, [0.2] * 3, 10.0, [6.0] * 3)
    assert cuts(swung, points)[1] <= 0.16 + 1e-6
    assert max(map(abs, swung.curvature_1pm)) < 0.55 * max(map(abs, cut.curvature_1pm))


@pytest.mark.parametrize("turn_deg", [30.0, -60.0, 90.0, -135.0, 150.0])
def test_a_swing_passes_a_little_inside_of_the_point_whatever_the_corner(turn_deg: float) -> None:
    """By the same part of every corner it passed sharp ones by twice as much as gentle ones, which left the boat half
    of the 0.2 m within which it is to pass them."""
    turn = math.radians(turn_deg)
    points = [(0.0, 0.0), (30.0, 0.0), (30.0 + 30.0 * math.cos(turn), 30.0 * math.sin(turn))]
    swung = Track(build_path(points, PathKind.LINEAR), points, [0.2] * 3, 10.0, [6.0] * 3)
    assert cuts(swung, points)[1] == pytest.approx(0.06, abs=0.012)


def test_the_turns_of_a_line_with_points_that_repeat() -> None:
    line = [(0.0, 0.0), (0.0, 0.0), (10.0, 0.0), (10.0, 0.0), (10.0, 10.0), (0.0, 10.0)]
    assert turns_rad(line) == pytest.approx([0.0, 0.0, 0.5 * math.pi, 0.5 * math.pi, 0.5 * math.pi, 0.0])
    assert turns_rad([(1.0, 1.0)]) == [0.0]
    assert turns_rad([(0.0, 0.0), (10.0, 0.0), (10.0, -10.0)]) == pytest.approx([0.0, -0.5 * math.pi, 0.0])


def test_a_swing_leaves_the_leg_by_no_more_than_it_cuts_the_corner() -> None:
    points = [(0.0, 0.0), (30.0, 0.0), (55.0, 17.0)]
    swung = Track(build_path(points, PathKind.LINEAR), points, [0.2] * 3, 10.0, [6.0] * 3)
    aside = [swung.at(float(s)).east_m for s in np.linspace(0.0, 29.0, 100)]
    assert -0.2 < min(aside) < -0.05, "to the outside of the corner"
    assert max(abs(y) for y in aside[:60]) < 0.01, "not far from it"


def test_a_corner_with_a_radius_of_its_own_is_cut_beside_one_with_a_swing() -> None:
    points = [(0.0, 0.0), (30.0, 0.0), (30.0, 30.0), (60.0, 30.0)]
    path = build_path(points, PathKind.LINEAR)
    mixed = Track(path, points, [0.2, 0.2, 2.0, 0.2], 10.0, [4.0, 4.0, 0.0, 4.0])
    _, through, rounded, _ = cuts(mixed, points)
    assert through <= 0.16 and 0.5 < rounded < 1.2


def test_waypoints_close_together_are_still_passed_inside_their_radius() -> None:
    points = [(0.0, 0.0), (10.0, 0.0), (10.0, 2.0), (11.0, 2.0), (11.0, -3.0), (20.0, -3.0)]
    assert max(cuts(track_of(points, PathKind.LINEAR), points)) <= 0.6 * 1.5 + 1e-6


def test_course_and_curvature_are_those_of_its_own_positions() -> None:
    track = track_of([(0.0, 0.0), (20.0, 5.0), (25.0, 25.0), (5.0, 30.0)])
    for s in np.linspace(1.0, track.length_m - 1.0, 50):
        a, b = track.at(float(s) - 0.05), track.at(float(s) + 0.05)
        course = math.atan2(b.east_m - a.east_m, b.north_m - a.north_m)
        assert math.remainder(track.at(float(s)).course_rad - course, 2.0 * math.pi) == pytest.approx(0.0, abs=0.03)
        assert (b.course_rad - a.course_rad) / 0.1 == pytest.approx(track.at(float(s)).curvature_1pm, abs=0.05)


def test_projection_descends_and_never_jumps() -> None:
    eight = [(20.0 * math.sin(a), 10.0 * math.sin(2.0 * a)) for a in np.linspace(0.0, 2.0 * math.pi, 41)]
    track = track_of(eight)
    s = 0.0
    for wanted in np.linspace(0.0, track.length_m, 600):
        point = track.at(float(wanted))
        s = track.project(point.north_m + 0.1, point.east_m + 0.1, s, 3.0)
        assert s == pytest.approx(wanted, abs=0.3)


def test_projection_stays_on_the_way_out_of_a_path_that_doubles_back() -> None:
    track = track_of([(0.0, 0.0), (20.0, 0.0), (0.0, 0.0)])
    s = 0.0
    for n in np.linspace(0.0, 15.0, 100):
        s = track.project(float(n), 0.05, s, 6.0)
        assert s == pytest.approx(n, abs=1e-6)


def test_a_path_of_no_length() -> None:
    track = track_of([(1.0, 2.0), (1.0, 2.0)])
    assert track.length_m == 0.0
    assert track.project(5.0, 5.0, 0.0, 3.0) == 0.0
    assert (track.at(0.0).north_m, track.at(0.0).east_m) == (1.0, 2.0)


@pytest.mark.parametrize("seed", range(20))
def test_samples_that_coincide_are_left_out_one_by_one(seed: int) -> None:
    """Each kept sample is the first that is far enough from the one kept before."""
    rng = np.random.default_rng(seed)
    steps = rng.random(200) * rng.choice([1.0, 0.01, 0.0], 200, p=[0.8, 0.15, 0.05])
    length = np.concatenate(([0.0], np.cumsum(steps)))
    expected, last = [0], len(length) - 1
    for i in range(1, last + 1):
        if length[expected[-1]] + 0.3 <= length[i]:
            expected.append(i)
    expected[-1] = last
    assert apart(length, 0.3) == expected
    assert apart(np.arange(9.0), 0.3) == slice(None)


@pytest.mark.parametrize("swing_m", [0.0, 6.0])
@pytest.mark.parametrize("far_m", [5_000.0, 300_000.0])
def test_a_long_leg_leaves_the_corners_of_the_others_as_they_are(far_m: float, swing_m: float) -> None:
    """Of a route of any length the corners are rounded alike."""
    radius_m = 0.2 if swing_m else 1.5

    def laid(points: list[tuple[float, float]]) -> Track:
        swings = [swing_m] * len(points)
        return Track(build_path(points, PathKind.LINEAR), points, [radius_m] * len(points), 10.0, swings)

    onward = [*SQUARE, (far_m, 0.0), (far_m, far_m)]
    near, far = laid(SQUARE), laid(onward)
    assert cuts(far, onward)[1:4] == pytest.approx(cuts(near, SQUARE)[1:4], abs=0.02)
    assert max(map(abs, far.curvature_1pm)) == pytest.approx(max(map(abs, near.curvature_1pm)), rel=0.1)
    assert far.spacing_m < 0.3
