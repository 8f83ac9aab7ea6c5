"""A curve through waypoints: linear, PCHIP, modified Akima or cubic spline, measured by arc length (ÅBOAT thesis 3.2, mended).

North and east are interpolated separately over the chord length between waypoints, so a route may turn back on itself. scipy computes the
coefficients once (imported only then); from there on the curve is evaluated in plain floats. PCHIP is shape-preserving: it never leaves
the span of two neighbouring waypoints in north or in east.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import IntEnum
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

_SAME_POINT_M = 1.0e-6
_PIECES = 16  # arc-length pieces a segment
_GAUSS = ((-0.9061798459386640, 0.2369268850561891), (-0.5384693101056831, 0.4786286704993665), (0.0, 0.5688888888888889))  # 5 points, half of them
_NODES = tuple((0.5 * (1.0 + sign * x), 0.5 * w) for x, w in _GAUSS for sign in ((1.0, -1.0) if x else (1.0,)))
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)

Cubic = tuple[float, float, float, float]  # coefficients, highest power first


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
    """Piecewise cubic curve, addressed by arc length from its begin. Made by `build_path`; never changes.

    `waypoint_s_m` holds the arc length at each point given, doubled points included.
    """

    def __init__(self, knots: Sequence[float], north: Sequence[Cubic], east: Sequence[Cubic], owner: Sequence[int]) -> None:
        """`knots`: the parameter at each distinct waypoint; `north`, `east`: one cubic a segment in (parameter − knot); `owner`: which
        distinct waypoint each given point is."""
        self._knots = list(knots)
        self._north, self._east = list(north), list(east)
        self._parameter = [self._knots[0]]
        self._s = [0.0]
        at_knot = [0.0]
        for i in range(len(self._north)):
            begin, width = self._knots[i], self._knots[i + 1] - self._knots[i]
            pieces = 1 if self._is_straight(i) else _PIECES
            for k in range(pieces):
                low, high = begin + width * k / pieces, begin + width * (k + 1) / pieces
                self._s.append(self._s[-1] + self._length(i, low, high))
                self._parameter.append(high)
            self._parameter[-1] = self._knots[i + 1]
            at_knot.append(self._s[-1])
        self.length_m = self._s[-1]
        self.waypoint_s_m: tuple[float, ...] = tuple(at_knot[i] for i in owner)

    def at(self, s_m: float) -> PathPoint:
        """The point at that arc length; beyond the ends, the end."""
        return self._point(self._parameter_at(s_m))

    def position(self, s_m: float) -> tuple[float, float]:
        """(north_m, east_m) at that arc length."""
        t = self._parameter_at(s_m)
        i, x = self._segment(t)
        a, b, c, d = self._north[i]
        e, f, g, h = self._east[i]
        return ((a * x + b) * x + c) * x + d, ((e * x + f) * x + g) * x + h

    def project(self, north_m: float, east_m: float, near_s_m: float, window_m: float) -> float:
        """Arc length of the point nearest to (north_m, east_m) on the branch around `near_s_m`, at most `window_m` from it.

        Walks downhill from `near_s_m`, so another branch that passes nearer by is never taken.
        """
        low, high = max(0.0, near_s_m - window_m), min(self.length_m, near_s_m + window_m)
        s = min(high, max(low, near_s_m))
        step = max(0.02 * window_m, 1.0e-3)

        def distance(at_s: float) -> float:
            n, e = self.position(at_s)
            return (n - north_m) ** 2 + (e - east_m) ** 2

        here = distance(s)
        for sign in (1.0, -1.0):
            while low < s or sign > 0.0:
                ahead = min(high, max(low, s + sign * step))
                there = distance(ahead)
                if ahead == s or there >= here:
                    break
                s, here = ahead, there
        return self._refine(distance, max(low, s - step), min(high, s + step))

    @staticmethod
    def _refine(distance: Callable[[float], float], low: float, high: float) -> float:
        """Golden-section search of a minimum between `low` and `high`."""
        a, b = high - _GOLDEN * (high - low), low + _GOLDEN * (high - low)
        fa, fb = distance(a), distance(b)
        while high - low > 1.0e-7:
            if fa < fb:
                high, b, fb = b, a, fa
                a = high - _GOLDEN * (high - low)
                fa = distance(a)
            else:
                low, a, fa = a, b, fb
                b = low + _GOLDEN * (high - low)
                fb = distance(b)
        return 0.5 * (low + high)

    def samples(self, spacing_m: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(north_m, east_m) along the whole path, evenly enough spaced, at most `spacing_m` apart, both ends included."""
        count = max(2, math.ceil(self.length_m / spacing_m) + 1)
        t = np.interp(np.linspace(0.0, self.length_m, count), self._s, self._parameter)
        segment = np.clip(np.searchsorted(self._knots, t, side="right") - 1, 0, len(self._north) - 1)
        x = t - np.asarray(self._knots)[segment]
        north, east = np.asarray(self._north)[segment].T, np.asarray(self._east)[segment].T
        return ((north[0] * x + north[1]) * x + north[2]) * x + north[3], ((east[0] * x + east[1]) * x + east[2]) * x + east[3]

    def _segment(self, t: float) -> tuple[int, float]:
        i = min(len(self._north) - 1, max(0, bisect_right(self._knots, t) - 1))
        return i, t - self._knots[i]

    def _is_straight(self, i: int) -> bool:
        return self._north[i][:2] == (0.0, 0.0) and self._east[i][:2] == (0.0, 0.0)

    def _speed(self, i: int, x: float) -> float:
        a, b, c, _ = self._north[i]
        e, f, g, _ = self._east[i]
        return math.hypot((3.0 * a * x + 2.0 * b) * x + c, (3.0 * e * x + 2.0 * f) * x + g)

    def _length(self, i: int, low: float, high: float) -> float:
        """Arc length between two parameters of segment `i`, by Gauss–Legendre."""
        begin, width = low - self._knots[i], high - low
        return width * sum(w * self._speed(i, begin + node * width) for node, w in _NODES)

    def _parameter_at(self, s_m: float) -> float:
        s_m = min(self.length_m, max(0.0, s_m))
        k = min(len(self._s) - 2, max(0, bisect_right(self._s, s_m) - 1))
        low, high = self._parameter[k], self._parameter[k + 1]
        span = self._s[k + 1] - self._s[k]
        if span <= 0.0:
            return low
        i, _ = self._segment(0.5 * (low + high))
        wanted = s_m - self._s[k]
        t = low + (high - low) * wanted / span
        if self._is_straight(i):
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

    def _point(self, t: float) -> PathPoint:
        i, x = self._segment(t)
        a, b, c, d = self._north[i]
        e, f, g, h = self._east[i]
        north, east = ((a * x + b) * x + c) * x + d, ((e * x + f) * x + g) * x + h
        dn, de = (3.0 * a * x + 2.0 * b) * x + c, (3.0 * e * x + 2.0 * f) * x + g
        ddn, dde = 6.0 * a * x + 2.0 * b, 6.0 * e * x + 2.0 * f
        speed = math.hypot(dn, de)
        if speed > 1.0e-6:
            return PathPoint(north, east, math.atan2(de, dn), (dn * dde - de * ddn) / speed**3)
        width = self._knots[i + 1] - self._knots[i]  # the curve stands still here, at a sharp corner: its course is where it comes from or goes to
        if x > 0.5 * width:
            ddn, dde = -ddn, -dde
        return PathPoint(north, east, math.atan2(dde, ddn), 0.0)


def build_path(points: Sequence[tuple[float, float]], kind: PathKind) -> Path:
    """The path through `points` (north_m, east_m). Doubled points count once; a single one is a path of no length. Raises ValueError for
    no points or a non-finite one."""
    if not points or not all(math.isfinite(n) and math.isfinite(e) for n, e in points):
        raise ValueError("a path needs points, all finite")
    distinct: list[tuple[float, float]] = []
    owner: list[int] = []
    for point in points:
        if not distinct or math.dist(point, distinct[-1]) > _SAME_POINT_M:
            distinct.append((float(point[0]), float(point[1])))
        owner.append(len(distinct) - 1)
    if len(distinct) == 1:
        n, e = distinct[0]
        return Path((0.0, 0.0), ((0.0, 0.0, 0.0, n),), ((0.0, 0.0, 0.0, e),), owner)
    knots = [0.0]
    for a, b in pairwise(distinct):
        knots.append(knots[-1] + math.dist(a, b))
    if kind is PathKind.LINEAR or len(distinct) == 2:
        north, east = (_straight(knots, [p[axis] for p in distinct]) for axis in (0, 1))
    else:
        north, east = _curves(knots, distinct, kind)
    return Path(knots, north, east, owner)


def _straight(knots: Sequence[float], values: Sequence[float]) -> list[Cubic]:
    return [(0.0, 0.0, (values[i + 1] - values[i]) / (knots[i + 1] - knots[i]), values[i]) for i in range(len(values) - 1)]


def _curves(knots: list[float], points: list[tuple[float, float]], kind: PathKind) -> tuple[list[Cubic], list[Cubic]]:
    """Coefficients of the piecewise cubics for north and east, by scipy."""
    from scipy.interpolate import Akima1DInterpolator, CubicSpline, PchipInterpolator

    if kind is PathKind.PCHIP:
        coefficients = PchipInterpolator(knots, points).c
    elif kind is PathKind.MAKIMA:
        coefficients = Akima1DInterpolator(knots, points, method="makima").c
    else:
        coefficients = CubicSpline(knots, points).c
    north, east = (
        [(float(a), float(b), float(c), float(d)) for a, b, c, d in coefficients[:, :, axis].T.tolist()] for axis in (0, 1)
    )
    return north, east
