"""Piecewise cubic Hermite interpolation that keeps the shape of its points (PCHIP).

Source: Fritsch & Butland, A method for constructing local monotone piecewise cubic interpolants, SIAM J. Sci. Stat.
Comput. 5 (1984); the slopes at the ends as in Moler, Numerical Computing with MATLAB, section 3.6. The numbers are
scipy's to the last digit. scipy's interpolation itself would take 40 MB and, on a small board, seconds to import.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, TypeAlias

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

Floats: TypeAlias = "NDArray[np.float64]"


def slopes(knots: Floats, points: Floats) -> Floats:
    """The derivative at each point, of the shape of `points` (points, axes): 0 where the chords on both sides do not
    have the same sign, else their weighted harmonic mean. Two points have that of the line."""
    steps = (knots[1:] - knots[:-1])[:, None]
    chords = (points[1:] - points[:-1]) / steps
    if len(points) == 2:
        return np.repeat(chords, 2, axis=0)
    signs = np.sign(chords)
    bends = (signs[1:] == signs[:-1]) & (chords[1:] != 0.0) & (chords[:-1] != 0.0)
    before, after = 2.0 * steps[1:] + steps[:-1], steps[1:] + 2.0 * steps[:-1]
    with np.errstate(divide="ignore", invalid="ignore"):  # where the chords' signs differ
        inverse = (before / chords[:-1] + after / chords[1:]) / (before + after)
        inner = np.where(bends, 1.0 / inverse, 0.0)
    first, last = _end(steps[0], steps[1], chords[0], chords[1]), _end(steps[-1], steps[-2], chords[-1], chords[-2])
    return np.concatenate((first[None], inner, last[None]))


def _end(step: Floats, next_step: Floats, chord: Floats, next_chord: Floats) -> Floats:
    """The derivative at an end: that of the parabola through three points, as far as the curve keeps its shape."""
    slope = ((2.0 * step + next_step) * chord - step * next_chord) / (step + next_step)
    too_steep = (np.sign(chord) != np.sign(next_chord)) & (np.abs(slope) > 3.0 * np.abs(chord))
    limited = np.where(too_steep, 3.0 * chord, slope)
    ends: Floats = np.where(np.sign(slope) == np.sign(chord), limited, 0.0)
    return ends


def hermite(knots: Floats, points: Floats, derivatives: Floats) -> Floats:
    """Coefficients of the cubics through `points` with these derivatives, of shape (segments, axes, power); the highest
    power comes first."""
    steps = np.diff(knots)[:, None]
    chords = np.diff(points, axis=0) / steps
    excess = (derivatives[:-1] + derivatives[1:] - 2.0 * chords) / steps
    cubic, square = excess / steps, (chords - derivatives[:-1]) / steps - excess
    return np.stack((cubic, square, derivatives[:-1], points[:-1]), axis=2)
