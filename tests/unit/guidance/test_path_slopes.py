"""Slopes at waypoints, against scipy and against the spline's own conditions."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.interpolate import Akima1DInterpolator, CubicSpline, PchipInterpolator

from companion.guidance.path_slopes import cubics, makima_slopes, pchip_slopes, spline_slopes

ENDS = list(itertools.product((None, np.array([0.3, -0.8])), repeat=2))


def chords(points: np.ndarray) -> np.ndarray:
    return np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))))


def routes() -> list[np.ndarray]:
    """Two to thirty points: anywhere, legs of very different lengths, a survey's lanes, a way back along itself."""
    draws = np.random.default_rng(7)
    found = []
    for count in range(2, 31):
        legs = draws.normal(size=(count, 2)) * 10.0 ** draws.uniform(-1.0, 3.0, size=(count, 1))
        lanes = [(5.0 * (k // 2), 20.0 * ((k + 1) // 2 % 2)) for k in range(count)]
        found += [100.0 * draws.normal(size=(count, 2)), np.cumsum(legs, axis=0), np.array(lanes)]
    return [*found, np.array([(0.0, 0.0), (20.0, 0.0), (40.0, 0.0), (0.0, 0.0), (-10.0, 0.0)])]


def test_pchip_and_modified_akima_are_scipys_to_the_last_digit() -> None:
    for points in routes():
        knots = chords(points)
        for ours, theirs in (
            (pchip_slopes, PchipInterpolator(knots, points)),
            (makima_slopes, Akima1DInterpolator(knots, points, method="makima")),
        ):
            coefficients = cubics(knots, points, ours(knots, points))
            assert np.array_equal(coefficients, np.moveaxis(theirs.c, 0, 2))


@pytest.mark.parametrize(("begin", "end"), ENDS)
def test_a_spline_is_scipys(begin: np.ndarray | None, end: np.ndarray | None) -> None:
    for points in routes():
        knots = chords(points)
        conditions = tuple("not-a-knot" if slope is None else (1, slope) for slope in (begin, end))
        theirs = CubicSpline(knots, points, bc_type=conditions)(knots, 1)
        assert spline_slopes(knots, points, begin, end) == pytest.approx(theirs, rel=1e-9, abs=1e-9)


def test_a_spline_bends_as_much_before_a_point_as_after_it() -> None:
    for points in routes():
        knots = chords(points)
        a, b, _, _ = np.moveaxis(cubics(knots, points, spline_slopes(knots, points, None, None)), 2, 0)
        after = 6.0 * a * np.diff(knots)[:, None] + 2.0 * b
        assert after[:-1] == pytest.approx(2.0 * b[1:], rel=1e-6, abs=1e-6)
