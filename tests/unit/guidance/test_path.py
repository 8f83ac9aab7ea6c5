"""Curves through waypoints, against scipy and against geometry."""

from __future__ import annotations

import itertools
import math
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.interpolate import Akima1DInterpolator, CubicSpline, PchipInterpolator

from companion.guidance.path import Path, PathKind, build_path
from companion.guidance.path_laying import CONTEXT

ROUTE = [(0.0, 0.0), (40.0, 10.0), (60.0, 50.0), (55.0, 90.0), (90.0, 100.0), (120.0, 60.0)]
SQUARE = [(0.0, 0.0), (20.0, 0.0), (20.0, 20.0), (0.0, 20.0), (0.0, 0.0)]


def chords(points: list[tuple[float, float]]) -> np.ndarray:
    return np.concatenate(([0.0], np.cumsum([math.dist(a, b) for a, b in itertools.pairwise(points)])))


@pytest.mark.parametrize(
    ("kind", "oracle"),
    [
        (PathKind.PCHIP, PchipInterpolator),
        (PathKind.CUBIC, CubicSpline),
        (PathKind.MAKIMA, lambda t, p: Akima1DInterpolator(t, p, method="makima")),
    ],
)
def test_curves_agree_with_scipy_and_are_measured_by_arc_length(kind: PathKind, oracle: object) -> None:
    assert callable(oracle)
    knots = chords(ROUTE)
    curve = oracle(knots, np.array(ROUTE))
    path = build_path(ROUTE, kind)
    speed = curve.derivative()

    def length(t: float) -> float:
        parts = [k for k in knots if k < t] + [t]
        return sum(
            quad(lambda x: float(np.hypot(*speed(x))), a, b, epsabs=1e-11)[0] for a, b in itertools.pairwise(parts)
        )

    assert path.length_m == pytest.approx(length(knots[-1]), abs=1e-6)
    for t in np.linspace(0.5, knots[-1] - 0.5, 25):
        point = path.at(length(float(t)))
        north, east = curve(t)
        dn, de = speed(t)
        assert (point.north_m, point.east_m) == pytest.approx((north, east), abs=1e-6)
        assert math.remainder(point.course_rad - math.atan2(de, dn), 2.0 * math.pi) == pytest.approx(0.0, abs=1e-6)


@pytest.mark.parametrize(
    ("kind", "oracle"),
    [
        (PathKind.PCHIP, PchipInterpolator),
        (PathKind.CUBIC, CubicSpline),
        (PathKind.MAKIMA, lambda t, p: Akima1DInterpolator(t, p, method="makima")),
    ],
)
def test_our_evaluator_equals_scipys_to_1e_9(kind: PathKind, oracle: Any) -> None:
    close = [*ROUTE[:3], (ROUTE[2][0] + 0.07, ROUTE[2][1] - 0.07), *ROUTE[3:], ROUTE[3], ROUTE[0]]
    knots = chords(close)
    curve = oracle(knots, np.array(close))
    path = build_path(close, kind)
    for t in np.linspace(0.0, knots[-1], 700):
        point = path.at_parameter(float(t))
        assert (point.north_m, point.east_m) == pytest.approx(tuple(curve(t)), abs=1e-9)


@pytest.mark.parametrize("kind", list(PathKind))
def test_projection_is_the_nearest_point_of_a_thousand(kind: PathKind) -> None:
    path = build_path(ROUTE, kind)
    dense = np.linspace(0.0, path.length_m, 20_001)
    points = np.array([path.position(float(s)) for s in dense])
    for s in np.linspace(3.0, path.length_m - 3.0, 60):
        p = path.at(float(s))
        if kind is PathKind.LINEAR and min(abs(s - corner) for corner in path.waypoint_s_m) < 3.0:
            continue  # abeam of a corner two legs are equally near
        for aside in (-1.5, 0.4, 1.5):
            n, e = p.north_m - aside * math.sin(p.course_rad), p.east_m + aside * math.cos(p.course_rad)
            near = np.abs(dense - s) < 5.0
            best = np.min(np.hypot(*(points[near] - (n, e)).T))
            found = path.position(path.project(n, e, float(s) - 1.5, 6.0))
            assert math.dist(found, (n, e)) <= best + 1e-5


@pytest.mark.parametrize("kind", list(PathKind))
def test_projection_leaves_a_point_where_the_derivative_vanishes(kind: PathKind) -> None:
    """At the corners of a square PCHIP has no slope at all."""
    path = build_path(SQUARE, kind)
    for corner in path.waypoint_s_m[1:4]:
        for ahead in (-2.0, -0.3, 0.3, 2.0):
            point = path.position(corner + ahead)
            assert math.dist(path.position(path.project(*point, corner, 6.0)), point) < 1e-4


TRANSECTS = [(0.0, 0.0), (5.0, 10.0), (60.0, 10.0), (60.0, 20.0), (5.0, 20.0), (-5.0, 40.0), (20.0, 60.0)]
SURVEY = [False, False, True, False, True, False, False]


@pytest.mark.parametrize("kind", list(PathKind))
def test_straight_legs_are_straight_and_the_rest_is_smooth(kind: PathKind) -> None:
    path = build_path(TRANSECTS, kind, SURVEY)
    at = path.waypoint_s_m
    for i in (2, 4):
        assert at[i] - at[i - 1] == pytest.approx(55.0)
        for s in np.linspace(at[i - 1] + 0.1, at[i] - 0.1, 20):
            assert path.position(float(s))[1] == pytest.approx(TRANSECTS[i][1], abs=1e-9)
    for station, point in zip(at, TRANSECTS, strict=True):
        assert path.position(station) == pytest.approx(point, abs=1e-6)
    if kind in (PathKind.MAKIMA, PathKind.CUBIC):
        for i in (1, 2, 3, 4):
            turn = path.at(at[i] + 1e-4).course_rad - path.at(at[i] - 1e-4).course_rad
            assert math.remainder(turn, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-2)


def test_without_straight_a_survey_leg_is_bent() -> None:
    path = build_path(TRANSECTS, PathKind.CUBIC)
    at = path.waypoint_s_m
    assert max(abs(path.position(float(s))[1] - 10.0) for s in np.linspace(at[1], at[2], 20)) > 0.5


@pytest.mark.parametrize("kind", list(PathKind))
def test_a_section_with_its_neighbours_is_the_part_of_the_whole(kind: PathKind) -> None:
    points = [(30.0 * k + 7.0 * math.sin(3.0 * k), 20.0 * math.sin(k)) for k in range(80)]
    whole = build_path(points, kind)
    section = build_path(points[40 - CONTEXT : 50 + CONTEXT], kind)
    for x in np.linspace(0.0, 1.0, 101):
        s = whole.waypoint_s_m[40] + x * (whole.waypoint_s_m[49] - whole.waypoint_s_m[40])
        t = s - whole.waypoint_s_m[40] + section.waypoint_s_m[CONTEXT]
        assert section.position(float(t)) == pytest.approx(whole.position(float(s)), abs=1e-6)


def test_pchip_stays_between_its_waypoints_and_the_spline_does_not() -> None:
    island = [(0.0, 0.0), (0.0, 50.0), (20.0, 52.0), (20.0, 100.0)]

    def highest(kind: PathKind) -> float:
        path = build_path(island, kind)
        return max(path.position(s)[0] for s in np.linspace(0.0, path.length_m, 400))

    assert highest(PathKind.PCHIP) <= 20.0 + 1e-9
    assert highest(PathKind.CUBIC) > 21.0


def test_curvature_of_a_circle() -> None:
    points = [(10.0 * math.sin(a), 10.0 - 10.0 * math.cos(a)) for a in np.linspace(0.0, 5.0, 60)]
    path = build_path(points, PathKind.CUBIC)
    assert path.length_m == pytest.approx(50.0, rel=1e-4)
    for s in (5.0, 20.0, 40.0):
        assert path.at(s).curvature_1pm == pytest.approx(0.1, rel=1e-2)
        assert path.at(s).course_rad == pytest.approx(math.remainder(s / 10.0, 2.0 * math.pi), abs=1e-3)


def test_arc_lengths_of_repeated_and_near_points() -> None:
    path = build_path([(0.0, 0.0), (10.0, 0.0), (10.0, 0.0), (10.1, 0.0), (20.0, 0.0)], PathKind.PCHIP)
    assert path.waypoint_s_m == pytest.approx((0.0, 10.0, 10.0, 10.1, 20.0))


def test_a_square_by_pchip_is_the_square() -> None:
    path = build_path(SQUARE, PathKind.PCHIP)
    assert path.length_m == pytest.approx(80.0)
    assert path.waypoint_s_m == pytest.approx((0.0, 20.0, 40.0, 60.0, 80.0))
    assert path.at(30.0).course_rad == pytest.approx(math.pi / 2.0)


@pytest.mark.parametrize("kind", list(PathKind))
def test_there_and_back_again(kind: PathKind) -> None:
    path = build_path([(0.0, 0.0), (20.0, 0.0), (0.0, 0.0), (-10.0, 0.0)], kind)
    assert path.position(path.waypoint_s_m[1]) == pytest.approx((20.0, 0.0), abs=1e-6)
    assert path.position(path.waypoint_s_m[2]) == pytest.approx((0.0, 0.0), abs=1e-6)
    assert abs(path.at(path.waypoint_s_m[1] + 5.0).course_rad) == pytest.approx(math.pi)


def test_projection_stays_on_its_branch_where_the_path_crosses_itself() -> None:
    eight = [(20.0 * math.sin(a), 10.0 * math.sin(2.0 * a)) for a in np.linspace(0.0, 2.0 * math.pi, 41)]
    path = build_path(eight, PathKind.PCHIP)
    s = 0.0
    for wanted in np.linspace(0.0, path.length_m, 400):
        n, e = path.position(float(wanted))
        s = path.project(n + 0.05, e - 0.05, s, 3.0)
        assert s == pytest.approx(wanted, abs=0.3)


def test_a_projection_is_the_foot_of_the_perpendicular() -> None:
    path = build_path([(0.0, 0.0), (100.0, 0.0)], PathKind.LINEAR)
    assert path.project(42.5, 3.0, 40.0, 10.0) == pytest.approx(42.5, abs=1e-5)
    assert path.project(80.0, 0.0, 40.0, 10.0) == pytest.approx(50.0, abs=1e-5), "no further than the window"
    assert path.project(-5.0, 0.0, 2.0, 10.0) == pytest.approx(0.0, abs=1e-5)


def test_one_point_gives_a_path_of_length_0_and_none_is_refused() -> None:
    path = build_path([(1.0, 2.0), (1.0, 2.0)], PathKind.PCHIP)
    assert path.length_m == 0.0
    assert path.position(3.0) == (1.0, 2.0)
    with pytest.raises(ValueError, match="points"):
        build_path([], PathKind.PCHIP)
    with pytest.raises(ValueError, match="finite"):
        build_path([(0.0, math.nan)], PathKind.PCHIP)


def test_paths_need_no_scipy() -> None:
    """It takes 50 MB, and longer to load than a tick lasts."""
    script = (
        "import sys\n"
        "from companion.guidance.path import PathKind, build_path\n"
        "points = [(0, 0), (5, 5), (9, 0), (9, 9), (0, 20)]\n"
        "[build_path(points, kind, line) for kind in PathKind for line in ((), (0, 0, 0, 1, 0))]\n"
        "assert 'scipy' not in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", script], check=True)


def test_samples_follow_the_path() -> None:
    path: Path = build_path(ROUTE, PathKind.PCHIP)
    north, east = path.samples(0.5)
    assert (north[0], east[0]) == ROUTE[0]
    assert (north[-1], east[-1]) == pytest.approx(ROUTE[-1])
    assert max(np.hypot(np.diff(north), np.diff(east))) < 0.8


@pytest.mark.parametrize("leg_m", [50.0, 20_000.0])
@pytest.mark.parametrize("kind", list(PathKind))
def test_many_places_at_once_are_those_of_their_arc_lengths(kind: PathKind, leg_m: float) -> None:
    """Of a right angle too, at which the curve's own derivative vanishes."""
    path = build_path([(0.0, 0.0), (leg_m, 0.0), (leg_m, leg_m), (2.0 * leg_m, 1.3 * leg_m)], kind)
    near = [s + x for s in path.waypoint_s_m for x in (-8.0, -0.2, 0.0, 0.2, 8.0) if 0.0 <= s + x <= path.length_m]
    north, east = path.positions(np.array(near))
    for s, n, e in zip(near, north, east, strict=True):
        assert math.dist(path.position(s), (n, e)) < 2e-3


@pytest.mark.parametrize("lead_m", [60.0, 500.0, 5000.0])
def test_a_cubic_spline_strays_from_no_leg_by_more_than_its_length(lead_m: float) -> None:
    """The approach to a survey swung out by kilometres: 500 m and legs of 20 m made a path of 5.2 km."""
    lines = [(0.0, 0.0), (0.0, 20.0), (5.0, 20.0), (5.0, 0.0), (10.0, 0.0), (10.0, 20.0), (15.0, 20.0), (15.0, 0.0)]
    points = [(-lead_m, 0.0), *lines]
    path = build_path(points, PathKind.CUBIC)
    for (a, b), (begin_m, end_m) in zip(itertools.pairwise(points), itertools.pairwise(path.waypoint_s_m), strict=True):
        line = np.linspace(a, b, 400)
        for s_m in np.linspace(begin_m, end_m, 40):
            off = np.hypot(*(line - path.position(float(s_m))).T)
            assert np.min(off) <= math.dist(a, b)
    assert path.length_m < 1.35 * chords(points)[-1]
    plain, knots = CubicSpline(chords(points), np.array(points)), chords(points)
    for t in np.linspace(knots[3], knots[-1], 50):  # the other legs are those of the spline
        point = path.at_parameter(float(t))
        assert (point.north_m, point.east_m) == pytest.approx(tuple(plain(t)), abs=1e-9)
