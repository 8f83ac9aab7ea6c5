"""Shape-preserving cubics: scipy's numbers, and its derivatives where a slope is given."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

from companion.guidance import pchip


def _points(rng: np.random.Generator) -> tuple[pchip.Floats, pchip.Floats]:
    """Of any size and scale, with legs along an axis and turns back."""
    count = int(rng.integers(2, 12))
    scales = rng.choice([0.0, 1.0, 10.0, 1e-3], size=(count, 2), p=[0.2, 0.4, 0.3, 0.1])
    points = np.cumsum(scales * rng.normal(size=(count, 2)), axis=0)
    knots = np.concatenate(([0.0], np.cumsum(1e-6 + np.hypot(*np.diff(points, axis=0).T))))
    return knots, points


def test_the_numbers_are_scipys_to_the_last_digit() -> None:
    rng = np.random.default_rng(0)
    for _ in range(300):
        knots, points = _points(rng)
        ours = pchip.hermite(knots, points, pchip.slopes(knots, points))
        theirs = np.ascontiguousarray(np.moveaxis(PchipInterpolator(knots, points).c, 0, 2))
        assert ours.tobytes() == theirs.tobytes()


def test_a_curve_with_given_slopes_is_scipys() -> None:
    rng = np.random.default_rng(1)
    knots, points = _points(rng)
    slopes = rng.normal(size=points.shape)
    theirs = CubicHermiteSpline(knots, points, slopes).c
    assert pchip.hermite(knots, points, slopes) == pytest.approx(np.moveaxis(theirs, 0, 2), rel=1e-12)
