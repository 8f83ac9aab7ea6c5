"""A curve through waypoints: linear, PCHIP, modified Akima or cubic spline, addressed by arc length (ÅBOAT thesis 3.2,
corrected).

North and east are interpolated separately over the chord length between waypoints, so a route may turn back on itself.
numpy computes the coefficients once; after that the curve is evaluated in plain floats.
PCHIP is shape-preserving: it never leaves the span of two neighbouring waypoints in north or in east. A cubic spline
strays from no leg by more than the leg's length: where it would, both ends of the leg have PCHIP's slopes instead.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from companion.guidance.path_slopes import cubics, makima_slopes, pchip_slopes, spline_slopes

if TYPE_CHECKING:
    from numpy.typing import NDArray

_SAME_POINT_M = 1.0e-6
_PIECES = 6  # arc-length pieces for each segment
_GAUSS = (
    (-0.9061798459386640, 0.2369268850561891),
    (-0.5384693101056831, 0.4786286704993665),
    (0.0, 0.5688888888888889),
)  # 5 points: one half of the symmetric rule
_NODES = tuple((0.5 * (1.0 + sign * x), 0.5 * w) for x, w in _GAUSS for sign in ((1.0, -1.0) if x else (1.0,)))
_STEPS = 60  # most Newton steps of a projection
_PLACED_M = 1.0e-3  # how exactly many places are found by their arc length
_CLOSE_M = 1.0e-9
_STILL = 1.0e-4  # share of a segment by which a projection steps off a point where the curve's derivative vanishes
_SHARES = np.linspace(0.0, 1.0, 17)[:, None]  # of a segment, where its distance from the chord is looked at

Floats: TypeAlias = "NDArray[np.float64]"


class PathKind(IntEnum):
    """The numbers are those of the parameter PATH_KIND."""

    LINEAR = 0
    PCHIP = 1
    MAKIMA = 2
    CUBIC = 3


@dataclass(frozen=True, slots=True)
class PathPoint:
    """A point on a path: its course and its curvature, positive where the path bends to starboard."""

    north_m: float
    east_m: float
    course_rad: float
    curvature_1pm: float


class Path:
    """Piecewise cubic curve, addressed by arc length from its beginning. `build_path` makes it; it never changes.

    `length_m`: its length. `waypoint_s_m`: the arc length at each given point, repeated points included.
    """

    def __init__(self, knots: Floats, north: Floats, east: Floats, owner: Sequence[int]) -> None:
        """`knots`: the parameter at each distinct waypoint. `north`, `east`: (segments, 4), the coefficients of a cubic
        in (parameter − knot), highest power first. `owner`: the index of the distinct waypoint of each given point."""
        self._knots: list[float] = knots.tolist()
        self._north: list[list[float]] = north.tolist()
        self._east: list[list[float]] = east.tolist()
        at_knot = self._measure(knots, north, east)
        self.length_m = self._s[-1]
        self.waypoint_s_m: tuple[float, ...] = tuple(at_knot[i] for i in owner)

    def _measure(self, knots: Floats, north: Floats, east: Floats) -> list[float]:
        """Tabulate arc length against the parameter, piece by piece; returns the arc length at each knot."""
        width = np.diff(knots)
        straight = np.all(north[:, :2] == 0.0, axis=1) & np.all(east[:, :2] == 0.0, axis=1)
        self._straight: list[bool] = straight.tolist()
        pieces = np.where(straight, 1, _PIECES)
        segment = np.repeat(np.arange(len(width)), pieces)
        first = np.concatenate(([0], np.cumsum(pieces)[:-1]))
        number = np.arange(len(segment)) - first[segment]
        step = (width / pieces)[segment]
        length = np.zeros(len(segment))
        slopes = [np.stack((3.0 * c[:, 0], 2.0 * c[:, 1], c[:, 2]))[:, segment] for c in (north, east)]
        for node, weight in _NODES:
            x = (number + node) * step
            length += weight * np.hypot(*((a * x + b) * x + c for a, b, c in slopes))
        s = np.concatenate(([0.0], np.cumsum(length * step)))
        parameter = knots[segment] + (number + 1) * step
        parameter[first + pieces - 1] = knots[1:]
        self._s: list[float] = s.tolist()
        self._parameter: list[float] = [self._knots[0], *parameter.tolist()]
        at_knot: list[float] = s[np.concatenate(([0], first + pieces))].tolist()
        return at_knot

    def at(self, s_m: float) -> PathPoint:
        """The point at that arc length; beyond the ends, the end point."""
        return self.at_parameter(self._parameter_at(s_m))

    def position(self, s_m: float) -> tuple[float, float]:
        """(north_m, east_m) at that arc length."""
        t = self._parameter_at(s_m)
        i, x = self._segment(t)
        a, b, c, d = self._north[i]
        e, f, g, h = self._east[i]
        return ((a * x + b) * x + c) * x + d, ((e * x + f) * x + g) * x + h

    def project(self, north_m: float, east_m: float, near_s_m: float, window_m: float) -> float:
        """Arc length of the point nearest to (north_m, east_m) on the branch around `near_s_m`, at most `window_m` from
        it.

        Descends from `near_s_m` by Newton steps of a fraction of the window, so it never jumps to another branch that
        passes nearer.
        """
        low_m, high_m = max(0.0, near_s_m - window_m), min(self.length_m, near_s_m + window_m)
        k = self._piece(min(high_m, max(low_m, near_s_m)))
        span = self._s[k + 1] - self._s[k]
        share = min(1.0, max(0.0, (near_s_m - self._s[k]) / span)) if span > 0.0 else 0.0
        i, x = self._segment(self._parameter[k] + share * (self._parameter[k + 1] - self._parameter[k]))
        i, x = self._descend(i, x, north_m, east_m, window_m)
        return min(high_m, max(low_m, self._s_at(i, x)))

    def _descend(self, i: int, x: float, north_m: float, east_m: float, window_m: float) -> tuple[int, float]:
        """(segment, parameter in it) of the next local minimum of the distance."""
        longest = 0.1 * window_m
        last = len(self._north) - 1
        came = 0  # direction in which the last step crossed a knot
        for _ in range(_STEPS):
            width = self._knots[i + 1] - self._knots[i]
            step = self._newton(i, x, width, north_m, east_m, longest)
            if x == width and step >= 0.0:
                if i == last or came < 0:
                    break  # the end, or a corner to which both segments lead
                i, x, came = i + 1, 0.0, 1
            elif x == 0.0 and step <= 0.0:
                if i == 0 or came > 0:
                    break
                i, x, came = i - 1, self._knots[i] - self._knots[i - 1], -1
            else:
                before, came = x, 0
                x = min(width, max(0.0, x + step))
                if abs(x - before) < _CLOSE_M:
                    break
        return i, x

    def _newton(self, i: int, x: float, width: float, north_m: float, east_m: float, longest: float) -> float:
        """Step in the parameter towards the minimum of the squared distance, limited to `longest` metres; Gauss–Newton
        where the second derivative is too small."""
        a, b, c, d = self._north[i]
        e, f, g, h = self._east[i]
        dn, de = (3.0 * a * x + 2.0 * b) * x + c, (3.0 * e * x + 2.0 * f) * x + g
        speed = math.hypot(dn, de)
        if speed < _STILL * _STILL:  # the derivative vanishes at a corner: take it a little way off
            x = x + _STILL * width if x < 0.5 * width else x - _STILL * width
            dn, de = (3.0 * a * x + 2.0 * b) * x + c, (3.0 * e * x + 2.0 * f) * x + g
            speed = math.hypot(dn, de)
        off_n, off_e = ((a * x + b) * x + c) * x + d - north_m, ((e * x + f) * x + g) * x + h - east_m
        slope = off_n * dn + off_e * de
        bend = speed * speed + off_n * (6.0 * a * x + 2.0 * b) + off_e * (6.0 * e * x + 2.0 * f)
        most = longest / max(speed, 0.1)
        step = -slope / (bend if bend > 0.5 * speed * speed else max(speed * speed, 1.0e-12))
        return min(most, max(-most, step))

    def samples(self, spacing_m: float) -> tuple[Floats, Floats]:
        """(north_m, east_m) along the whole path, about evenly spaced, at most `spacing_m` apart, both ends
        included."""
        count = max(2, math.ceil(self.length_m / spacing_m) + 1)
        return self._positions_at(np.interp(np.linspace(0.0, self.length_m, count), self._s, self._parameter))

    def positions(self, s_m: Floats) -> tuple[Floats, Floats]:
        """(north_m, east_m) at those arc lengths, to _PLACED_M."""
        s, parameter, knots = np.asarray(self._s), np.asarray(self._parameter), np.asarray(self._knots)
        k = np.clip(np.searchsorted(s, s_m, side="right") - 1, 0, len(s) - 2)
        wanted, begin, low, high = s_m - s[k], parameter[k], parameter[k], parameter[k + 1]
        segment = np.clip(np.searchsorted(knots, 0.5 * (low + high), side="right") - 1, 0, len(self._north) - 1)
        at = begin - knots[segment]
        (a, b, c, _), (e, f, g, _) = np.asarray(self._north)[segment].T, np.asarray(self._east)[segment].T

        def speeds(x: Floats) -> Floats:
            speed: Floats = np.hypot((3.0 * a * x + 2.0 * b) * x + c, (3.0 * e * x + 2.0 * f) * x + g)
            return speed

        t = begin + (high - low) * wanted / np.maximum(s[k + 1] - s[k], 1.0e-12)
        for _ in range(_STEPS):
            width = t - begin
            excess = width * sum(w * speeds(at + node * width) for node, w in _NODES) - wanted
            if float(np.max(np.abs(excess))) < _PLACED_M:
                break
            low, high = np.where(excess > 0.0, low, t), np.where(excess > 0.0, t, high)
            newton = t - excess / np.maximum(speeds(at + width), 1.0e-12)
            t = np.where((low < newton) & (newton < high), newton, 0.5 * (low + high))
        return self._positions_at(t)

    def _positions_at(self, t: Floats) -> tuple[Floats, Floats]:
        segment = np.clip(np.searchsorted(self._knots, t, side="right") - 1, 0, len(self._north) - 1)
        x = t - np.asarray(self._knots)[segment]
        north, east = np.asarray(self._north)[segment].T, np.asarray(self._east)[segment].T
        return ((north[0] * x + north[1]) * x + north[2]) * x + north[3], (
            (east[0] * x + east[1]) * x + east[2]
        ) * x + east[3]

    def _segment(self, t: float) -> tuple[int, float]:
        i = min(len(self._north) - 1, max(0, bisect_right(self._knots, t) - 1))
        return i, t - self._knots[i]

    def _speed(self, i: int, x: float) -> float:
        a, b, c, _ = self._north[i]
        e, f, g, _ = self._east[i]
        return math.hypot((3.0 * a * x + 2.0 * b) * x + c, (3.0 * e * x + 2.0 * f) * x + g)

    def _length(self, i: int, low: float, high: float) -> float:
        """Arc length between two parameters of segment `i`, by Gauss–Legendre."""
        begin, width = low - self._knots[i], high - low
        return width * sum(w * self._speed(i, begin + node * width) for node, w in _NODES)

    def _piece(self, s_m: float) -> int:
        return min(len(self._s) - 2, max(0, bisect_right(self._s, s_m) - 1))

    def _s_at(self, i: int, x: float) -> float:
        """Arc length at a parameter of segment `i`."""
        t = self._knots[i] + x
        k = min(len(self._s) - 2, max(0, bisect_right(self._parameter, t) - 1))
        return self._s[k] + self._length(i, max(self._knots[i], self._parameter[k]), t)

    def _parameter_at(self, s_m: float) -> float:
        s_m = min(self.length_m, max(0.0, s_m))
        k = self._piece(s_m)
        low, high = self._parameter[k], self._parameter[k + 1]
        span = self._s[k + 1] - self._s[k]
        if span <= 0.0:
            return low
        i, _ = self._segment(0.5 * (low + high))
        wanted = s_m - self._s[k]
        t = low + (high - low) * wanted / span
        if self._straight[i]:
            return t
        bracket_low, bracket_high = low, high
        for _ in range(30):
            excess = self._length(i, low, t) - wanted
            if abs(excess) < 1.0e-9:
                break
            if excess > 0.0:
                bracket_high = t
            else:
                bracket_low = t
            speed = self._speed(i, t - self._knots[i])
            newton = t - excess / speed if speed > 0.0 else math.inf
            t = newton if bracket_low < newton < bracket_high else 0.5 * (bracket_low + bracket_high)
        return t

    def at_parameter(self, t: float) -> PathPoint:
        """The point at the curve's own parameter, which is 0 at its beginning and grows by the chords."""
        i, x = self._segment(t)
        a, b, c, d = self._north[i]
        e, f, g, h = self._east[i]
        north, east = ((a * x + b) * x + c) * x + d, ((e * x + f) * x + g) * x + h
        dn, de = (3.0 * a * x + 2.0 * b) * x + c, (3.0 * e * x + 2.0 * f) * x + g
        ddn, dde = 6.0 * a * x + 2.0 * b, 6.0 * e * x + 2.0 * f
        speed = math.hypot(dn, de)
        if speed > 1.0e-6:
            return PathPoint(north, east, math.atan2(de, dn), (dn * dde - de * ddn) / speed**3)
        # the derivative vanishes here, at a sharp corner: the course is that of the curve just before or after it
        width = self._knots[i + 1] - self._knots[i]
        if x > 0.5 * width:
            ddn, dde = -ddn, -dde
        return PathPoint(north, east, math.atan2(dde, ddn), 0.0)


def build_path(points: Sequence[tuple[float, float]], kind: PathKind, straight: Sequence[bool] = ()) -> Path:
    """The path through `points` (north_m, east_m). Repeated points count once; a single point gives a path of length 0.
    `straight[i]`: the leg to point i is a straight line whatever the kind; its neighbours join it as smoothly as their
    kind allows. Raises ValueError for no points or a non-finite one."""
    if not points or not all(math.isfinite(n) and math.isfinite(e) for n, e in points):
        raise ValueError("a path needs points, all finite")
    given = np.array(points, dtype=float).reshape(-1, 2)
    distinct, owner = _distinct(given)
    if len(distinct) == 1:
        n, e = distinct[0]
        return Path(np.zeros(2), np.array([[0.0, 0.0, 0.0, n]]), np.array([[0.0, 0.0, 0.0, e]]), owner)
    steps = np.diff(distinct, axis=0)
    knots = np.concatenate(([0.0], np.cumsum(np.hypot(steps[:, 0], steps[:, 1]))))
    lines = {owner[i] - 1 for i, line in enumerate(straight) if line and i > 0 and owner[i] > owner[i - 1]}
    if kind is PathKind.LINEAR or len(distinct) == 2:
        coefficients = _straight(knots, distinct)
    elif not lines:
        coefficients = _curves(knots, distinct, kind, None, None)
    else:
        coefficients = _mixed(knots, distinct, kind, lines)
    return Path(knots, coefficients[:, 0], coefficients[:, 1], owner)


def _distinct(points: Floats) -> tuple[Floats, list[int]]:
    """The points without those that repeat the one before, and for each given point its index among them."""
    apart = np.hypot(*np.diff(points, axis=0).T) > _SAME_POINT_M
    if np.all(apart):
        return points, list(range(len(points)))
    kept = [0]
    owner = [0]
    for i in range(1, len(points)):
        if math.dist(points[i], points[kept[-1]]) > _SAME_POINT_M:
            kept.append(i)
        owner.append(len(kept) - 1)
    return points[kept], owner


def _straight(knots: Floats, points: Floats) -> Floats:
    """Coefficients of straight segments, of shape (segments, axis, power)."""
    coefficients = np.zeros((len(points) - 1, 2, 4))
    coefficients[:, :, 2] = np.diff(points, axis=0) / np.diff(knots)[:, None]
    coefficients[:, :, 3] = points[:-1]
    return coefficients


def _mixed(knots: Floats, points: Floats, kind: PathKind, lines: set[int]) -> Floats:
    """Coefficients of straight segments at the indices in `lines`, and of curves of that kind between them."""
    coefficients = _straight(knots, points)
    last = len(points) - 1
    begin = 0
    while begin < last:
        end = begin
        while end < last and end not in lines:
            end += 1
        if end > begin:
            before = coefficients[begin - 1, :, 2] if begin > 0 else None
            after = coefficients[end, :, 2] if end < last else None
            coefficients[begin:end] = _curves(knots[begin : end + 1], points[begin : end + 1], kind, before, after)
        begin = end + 1
    return coefficients


def _curves(knots: Floats, points: Floats, kind: PathKind, before: Floats | None, after: Floats | None) -> Floats:
    """Coefficients (segments, axis, power) of the piecewise cubics. `before`, `after`: slope of the straight leg that
    the curve joins there, if any."""
    if kind is PathKind.CUBIC:
        slopes = spline_slopes(knots, points, before, after)
        if np.any(_strays(knots, points, slopes)):
            slopes = _tamed(knots, points, slopes, pchip_slopes(knots, points))
        return cubics(knots, points, slopes)
    slopes = pchip_slopes(knots, points) if kind is PathKind.PCHIP else makima_slopes(knots, points)
    for at, slope, first in ((0, before, 0), (-1, after, -2)):
        if slope is not None:
            slopes[at] = _within(slope, (points[first + 1] - points[first]) / (knots[first + 1] - knots[first]), kind)
    return cubics(knots, points, slopes)


def _strays(knots: Floats, points: Floats, slopes: Floats) -> NDArray[np.bool_]:
    """The segments that stray from their chord by more than its length."""
    width = np.diff(knots)
    chord = np.diff(points, axis=0) / width[:, None]
    first, last = _SHARES * (1.0 - _SHARES) ** 2, _SHARES**2 * (1.0 - _SHARES)
    north, east = (
        first * (slopes[:-1, axis] - chord[:, axis]) - last * (slopes[1:, axis] - chord[:, axis]) for axis in (0, 1)
    )
    straying: NDArray[np.bool_] = np.max(np.hypot(north, east), axis=0) > 1.0
    return straying


def _tamed(knots: Floats, points: Floats, slopes: Floats, tame: Floats) -> Floats:
    """The slopes, with the tame ones at both ends of every segment that would stray."""
    slopes = slopes.copy()
    for _ in range(len(knots)):
        straying = np.flatnonzero(_strays(knots, points, slopes))
        if not len(straying):
            break
        slopes[straying], slopes[straying + 1] = tame[straying], tame[straying + 1]
    return slopes


def _within(slope: Floats, chord: Floats, kind: PathKind) -> Floats:
    """The slope at an end; for PCHIP limited so that the curve stays between its points in north and in east (Fritsch
    & Carlson 1980)."""
    if kind is not PathKind.PCHIP:
        return slope
    cut: Floats = np.where(slope * chord > 0.0, np.sign(chord) * np.minimum(np.abs(slope), 3.0 * np.abs(chord)), 0.0)
    return cut
