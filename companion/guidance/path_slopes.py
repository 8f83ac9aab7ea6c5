"""Slopes of a curve at its waypoints, and the cubics between them: PCHIP, modified Akima, cubic spline.

Same formulas and same order of operations as in scipy.interpolate: PCHIP and modified Akima are its own to the last
digit. Loading scipy for them takes 50 MB and most of a second of a small board.

All take `knots`, the parameter at each waypoint (n,), strictly increasing, and `points` (n, axes), n at least 2.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

Floats: TypeAlias = "NDArray[np.float64]"

_UNDEFINED = 1.0e-9  # modified Akima: both weights together are that small a share of the largest


def cubics(knots: Floats, points: Floats, slopes: Floats) -> Floats:
    """Coefficients (segments, axes, 4) of the cubics in (parameter − knot) with these slopes (n, axes) at the points,
    highest power first."""
    width = np.diff(knots)[:, None]
    chord = np.diff(points, axis=0) / width
    bend = (slopes[:-1] + slopes[1:] - 2.0 * chord) / width
    return np.stack((bend / width, (chord - slopes[:-1]) / width - bend, slopes[:-1], points[:-1]), axis=2)


def pchip_slopes(knots: Floats, points: Floats) -> Floats:
    """Slopes (n, axes) that keep the curve within the span of two neighbouring points. Source: Fritsch & Butland 1984;
    at the ends Moler, *Numerical Computing with MATLAB* (2004), 3.4."""
    width = np.diff(knots)[:, None]
    chord = np.diff(points, axis=0) / width
    if len(points) == 2:
        return np.repeat(chord, 2, axis=0)
    onward = (np.sign(chord[1:]) == np.sign(chord[:-1])) & (chord[1:] != 0.0)  # elsewhere there is a peak or a level
    before, after = np.where(onward, chord[:-1], 1.0), np.where(onward, chord[1:], 1.0)
    long, short = 2.0 * width[1:] + width[:-1], width[1:] + 2.0 * width[:-1]
    slopes = np.zeros_like(points)
    slopes[1:-1] = np.where(onward, 1.0 / ((long / before + short / after) / (long + short)), 0.0)
    slopes[0] = _end_slope(width[0], width[1], chord[0], chord[1])
    slopes[-1] = _end_slope(width[-1], width[-2], chord[-1], chord[-2])
    return slopes


def _end_slope(width: Floats, next_width: Floats, chord: Floats, next_chord: Floats) -> Floats:
    """That of a parabola through three points, limited so that the curve keeps its shape."""
    slope = ((2.0 * width + next_width) * chord - width * next_chord) / (width + next_width)
    peak = np.sign(chord) != np.sign(next_chord)
    limited = np.where(peak & (np.abs(slope) > 3.0 * np.abs(chord)), 3.0 * chord, slope)
    kept: Floats = np.where(np.sign(slope) == np.sign(chord), limited, 0.0)
    return kept


def makima_slopes(knots: Floats, points: Floats) -> Floats:
    """Slopes (n, axes) of modified Akima. Source: Akima 1970; Moler & Ionita, *Makima piecewise cubic interpolation*
    (MathWorks 2019)."""
    chord = np.diff(points, axis=0) / np.diff(knots)[:, None]
    if len(points) == 2:
        return np.repeat(chord, 2, axis=0)
    m = np.empty((len(points) + 3, points.shape[1]))
    m[2:-2] = chord
    m[1] = 2.0 * m[2] - m[3]  # two chords more at each end
    m[0] = 2.0 * m[1] - m[2]
    m[-2] = 2.0 * m[-3] - m[-4]
    m[-1] = 2.0 * m[-2] - m[-3]
    weights = np.abs(np.diff(m, axis=0)) + 0.5 * np.abs(m[1:] + m[:-1])
    total = weights[2:] + weights[:-2]
    defined = total > _UNDEFINED * np.max(total)
    share = weights[:-2] / np.where(defined, total, 1.0)
    slopes: Floats = np.where(defined, m[1:-2] + share * (m[2:-1] - m[1:-2]), 0.5 * (m[3:] + m[:-3]))
    return slopes


def spline_slopes(knots: Floats, points: Floats, begin: Floats | None, end: Floats | None) -> Floats:
    """Slopes (n, axes) with which the second derivative is continuous as well. `begin`, `end`: the slope there; None:
    the first two cubics, or the last two, are one. Source: de Boor, *A Practical Guide to Splines* (2001), chapter
    IV."""
    width = np.diff(knots)[:, None]
    chord = np.diff(points, axis=0) / width
    if len(points) == 2:
        return np.stack((chord[0] if begin is None else begin, chord[0] if end is None else end))
    if len(points) == 3 and begin is None and end is None:  # both conditions are the same one: a parabola
        middle = (width[0] * chord[1] + width[1] * chord[0]) / (width[0] + width[1])
        return np.stack((2.0 * chord[0] - middle, middle, 2.0 * chord[1] - middle))
    first, first_wanted = _end_row(width[0, 0], width[1, 0], chord[0], chord[1], begin)
    last, last_wanted = _end_row(width[-1, 0], width[-2, 0], chord[-1], chord[-2], end)
    inner = 3.0 * (width[1:] * chord[:-1] + width[:-1] * chord[1:])
    return _solved(
        [*width[1:, 0].tolist(), last[1]],
        [first[0], *(2.0 * (width[:-1, 0] + width[1:, 0])).tolist(), last[0]],
        [first[1], *width[:-1, 0].tolist()],
        np.vstack((first_wanted, inner, last_wanted)),
    )


def _end_row(
    width: float, next_width: float, chord: Floats, next_chord: Floats, slope: Floats | None
) -> tuple[tuple[float, float], Floats]:
    """The equation of an end: its factors of the slopes there and beside it, and what they come to."""
    if slope is not None:
        return (1.0, 0.0), slope
    both = width + next_width
    wanted: Floats = ((width + 2.0 * both) * next_width * chord + width**2 * next_chord) / both
    return (next_width, both), wanted


def _solved(lower: list[float], diagonal: list[float], upper: list[float], wanted: Floats) -> Floats:
    """The solution (n, axes) of a tridiagonal system, whose inner rows are dominated by the diagonal: it needs no
    pivoting."""
    rows = wanted.tolist()
    for i, below in enumerate(lower):
        factor = below / diagonal[i]
        diagonal[i + 1] -= factor * upper[i]
        rows[i + 1] = [b - factor * a for a, b in zip(rows[i], rows[i + 1], strict=True)]
    rows[-1] = [b / diagonal[-1] for b in rows[-1]]
    for i in range(len(upper) - 1, -1, -1):
        rows[i] = [(b - upper[i] * a) / diagonal[i] for a, b in zip(rows[i + 1], rows[i], strict=True)]
    return np.array(rows)
