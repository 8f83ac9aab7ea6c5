"""The line to sail: a path whose corners are rounded as far as the acceptance radii of its waypoints allow.

Every point is the mean of the path over a window of width w around it. A straight or gently bent path hardly changes
(by w²/24R). A corner of angle θ is cut by w/4·sin(θ/2) and becomes a bend of finite curvature, whatever the curve. Two
means in a row, a wide and a narrow one, keep the curvature continuous. The window shrinks to nothing at both ends, so
the track begins and ends where the path does.

Where a boat is to pass near the point and yet quickly, the track swings out a little before the corner and behind it,
as a driver takes a bend: from the mean m another mean m' is taken, and m + g (m − m') is sailed. At the same distance
from the corner its bend is twice as wide. At the corner the track is c w sin(θ/2) (G − g) inside of it; g is chosen for
_PASS_M of that, so a gentle corner swings little.
"""

from __future__ import annotations

import itertools
import math
from bisect import bisect_left, bisect_right
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from companion.guidance.path import Path, PathPoint
from companion.guidance.steps import Steps

_WINDOW_PER_RADIUS = 2.4
_WIDE, _NARROW = 0.8, 0.25  # widths of the two means, as shares of the window
_LARGEST_CUT = 0.6  # of a waypoint's radius
# c and G: by the swing's three means, found by laying tracks. With g = G the track passes through every corner.
_SWING_CUT, _SWING_THROUGH = 0.1165, 1.59
_PASS_M = 0.06  # inside of the corner: the boat is late rather than early
_SWING_WIDE, _SWING_NARROW, _SWING_LAST = 0.6, 0.5, 1.0  # widths of its three means
_LARGEST_SWING_CUT = 0.8
_MOST_SHRINK = 0.3  # of a window at once: on a curve the cut shrinks with its square
_SAMPLES_PER_WINDOW = 24
_FEWEST_M = 0.02
_SAME_M = 1.0e-6
_MOST_SAMPLES = 10_000  # at even steps; more would take too long
# A line so long that these steps are coarse is sampled more closely around its waypoints.
_FEWEST_PER_WINDOW, _CLOSE_WINDOWS, _STEP_GROWTH = 12, 3, 0.1

Floats = NDArray[np.float64]


class Track:
    """Sampled line with course and curvature, addressed by its own arc length. It never changes.

    `s_m`: arc length of the samples; `course_rad`, not wrapped, and `curvature_1pm`: their course and curvature;
    `waypoint_s_m`: arc length abeam of each waypoint; `spacing_m`: about how far the samples are apart, at the
    waypoints at least.
    """

    def __init__(
        self,
        path: Path,
        waypoints: Sequence[tuple[float, float]],
        radii_m: Sequence[float],
        widest_m: float,
        swings_m: Sequence[float] = (),
    ) -> None:
        """`waypoints`: the points of `path`, (north_m, east_m); `radii_m`: how near to each the track must pass;
        `widest_m`: widest useful window; `swings_m`: of each waypoint the widest window of a swing, 0 where the corner
        is only cut; none: no swings."""
        narrow = [min(_WINDOW_PER_RADIUS * r, widest_m) for r in radii_m]
        swings = np.asarray(swings_m or [0.0] * len(narrow))
        widths = [max(w, min(swing, widest_m)) if swing > 0.0 else w for w, swing in zip(narrow, swings, strict=True)]
        allowed = np.where(swings > 0.0, _LARGEST_SWING_CUT, _LARGEST_CUT) * np.asarray(radii_m)
        spacing = max(min(narrow) / _SAMPLES_PER_WINDOW, _FEWEST_M, path.length_m / _MOST_SAMPLES)
        even = min(widths) >= _FEWEST_PER_WINDOW * spacing
        if even:
            grid, north, east = _evenly(*path.samples(0.5 * spacing), spacing)
            waypoint_s = np.asarray(path.waypoint_s_m) * (grid[-1] / path.length_m if path.length_m > 0.0 else 1.0)
        else:
            close = [max(w / _SAMPLES_PER_WINDOW, _FEWEST_M) for w in widths]
            grid, north, east, waypoint_s = _closely(path, close, spacing)
            spacing = min(close)
        swing = np.interp(grid, waypoint_s, (swings > 0.0).astype(float))
        corners = np.sin(0.5 * np.abs(turns_rad(waypoints)))
        steps = Steps(grid, float(grid[1] - grid[0]) if even else None)
        for _ in range(6):
            window = np.interp(grid, waypoint_s, widths)
            out = _around(grid, waypoint_s, _out(np.asarray(widths), corners))
            smooth_north, smooth_east = _smoothed(steps, north, east, window, swing, swing * out)
            cuts = np.hypot(
                np.interp(waypoint_s, grid, smooth_north) - [w[0] for w in waypoints],
                np.interp(waypoint_s, grid, smooth_east) - [w[1] for w in waypoints],
            )
            if np.all(cuts <= allowed + 1.0e-9):
                break
            widths = [
                w * max(_MOST_SHRINK, 0.98 * most / cut) if cut > most else w
                for w, cut, most in zip(widths, cuts, allowed, strict=True)
            ]
        self._measure(grid, smooth_north, smooth_east, waypoint_s, spacing)
        self.spacing_m = self.length_m / len(self.s_m) if even else max(close)

    def _measure(self, grid: Floats, north: Floats, east: Floats, waypoint_s: Floats, spacing: float) -> None:
        """Compute arc length, course and curvature of the smoothed samples. Samples that coincide, at the tip of a turn
        back, are left out."""
        steps = np.hypot(np.diff(north), np.diff(east))
        length = np.concatenate(([0.0], np.cumsum(steps)))
        self.waypoint_s_m: tuple[float, ...] = tuple(np.interp(waypoint_s, grid, length).tolist())
        self.length_m = float(length[-1])
        keep = apart(length, 0.3 * spacing)
        s, n, e = length[keep], north[keep], east[keep]
        if self.length_m <= 0.0:
            s = np.array([0.0, 1.0e-9])
        legs = np.unwrap(np.arctan2(np.diff(e), np.diff(n)))
        middle = 0.5 * (s[1:] + s[:-1])
        course = np.interp(s, middle, legs)
        bend = np.diff(legs) / np.diff(middle) if len(legs) > 1 else np.zeros(0)
        curvature = np.concatenate(([0.0], bend, [0.0]))
        self.s_m: list[float] = s.tolist()
        self.curvature_1pm: list[float] = curvature.tolist()
        self._north: list[float] = n.tolist()
        self._east: list[float] = e.tolist()
        self.course_rad: list[float] = course.tolist()

    def index(self, s_m: float) -> int:
        """Index of the sample at or before `s_m`, never the last."""
        return min(len(self.s_m) - 2, max(0, bisect_right(self.s_m, s_m) - 1))

    def at(self, s_m: float) -> PathPoint:
        """The point at that arc length; beyond the ends, the end point. The course is not wrapped."""
        i = self.index(s_m)
        low = self.s_m[i]
        x = min(1.0, max(0.0, (s_m - low) / (self.s_m[i + 1] - low)))
        return PathPoint(
            self._north[i] + x * (self._north[i + 1] - self._north[i]),
            self._east[i] + x * (self._east[i + 1] - self._east[i]),
            self.course_rad[i] + x * (self.course_rad[i + 1] - self.course_rad[i]),
            self.curvature_1pm[i] + x * (self.curvature_1pm[i + 1] - self.curvature_1pm[i]),
        )

    def part(self, begin_s_m: float, end_s_m: float) -> list[tuple[float, float]]:
        """(north_m, east_m) of the line between two arc lengths, both ends included."""
        first, last = bisect_right(self.s_m, begin_s_m), bisect_left(self.s_m, end_s_m)
        begin, end = self.at(begin_s_m), self.at(end_s_m)
        between = zip(self._north[first:last], self._east[first:last], strict=True)
        return [(begin.north_m, begin.east_m), *between, (end.north_m, end.east_m)]

    def project(self, north_m: float, east_m: float, near_s_m: float, window_m: float) -> float:
        """Arc length of the point nearest to (north_m, east_m), found by descending from `near_s_m`, at most `window_m`
        either way: it never jumps to another branch that passes nearer."""
        low, high = max(0.0, near_s_m - window_m), min(self.length_m, near_s_m + window_m)
        i = self.index(near_s_m)
        s = self._foot(i, north_m, east_m)
        direction = 1 if s >= self.s_m[i + 1] else -1 if s <= self.s_m[i] else 0
        while direction:
            j = i + direction
            if not 0 <= j < len(self.s_m) - 1 or not low <= s <= high:
                break
            foot = self._foot(j, north_m, east_m)
            if foot == s:  # the corner between both pieces is the nearest point
                break
            i, s = j, foot
            if self.s_m[i] < s < self.s_m[i + 1]:
                break
        return min(high, max(low, s))

    def _foot(self, i: int, north_m: float, east_m: float) -> float:
        """Arc length of the nearest point between samples i and i+1."""
        n, e = self._north[i], self._east[i]
        dn, de = self._north[i + 1] - n, self._east[i + 1] - e
        square = dn * dn + de * de
        x = ((north_m - n) * dn + (east_m - e) * de) / square if square > 0.0 else 0.0
        if x <= 0.0:
            return self.s_m[i]
        if x >= 1.0:
            return self.s_m[i + 1]
        return self.s_m[i] + x * (self.s_m[i + 1] - self.s_m[i])


def apart(length: Floats, least: float) -> list[int] | slice:
    """The samples that are at least so far from the one kept before; the first and the last always."""
    near = np.nonzero(length[:-1] + least > length[1:])[0]  # samples whose next one is too near
    if not len(near):
        return slice(None)
    last = len(length) - 1
    keep: list[int] = [0]
    while (following := int(np.searchsorted(length, length[keep[-1]] + least))) <= last:
        place = int(np.searchsorted(near, following))
        until = int(near[place]) if place < len(near) else last
        keep.extend(range(following, until + 1))
    if len(keep) == 1:
        keep.append(last)
    keep[-1] = last
    return keep


def _evenly(north: Floats, east: Floats, spacing: float) -> tuple[Floats, Floats, Floats]:
    """The line resampled at even steps of arc length: (arc length, north, east)."""
    length = np.concatenate(([0.0], np.cumsum(np.hypot(np.diff(north), np.diff(east)))))
    grid = np.linspace(0.0, length[-1], max(3, math.ceil(length[-1] / spacing) + 1))
    return grid, np.interp(grid, length, north), np.interp(grid, length, east)


def _closely(path: Path, close: Sequence[float], spacing: float) -> tuple[Floats, Floats, Floats, Floats]:
    """The line sampled at even steps, and more closely around each waypoint, at steps of `close`, which grow further
    off: (arc length, north, east, arc length of each waypoint)."""
    s = [np.linspace(0.0, path.length_m, math.ceil(path.length_m / spacing) + 1)]
    count = _CLOSE_WINDOWS * _SAMPLES_PER_WINDOW
    for at, step in zip(path.waypoint_s_m, close, strict=True):
        growing = math.ceil(math.log(max(1.0, spacing / (_STEP_GROWTH * count * step))) / _STEP_GROWTH)
        away = step * np.concatenate((np.arange(count), count * (1.0 + _STEP_GROWTH) ** np.arange(max(1, growing))))
        s += [np.clip(at - away, 0.0, path.length_m), np.clip(at + away, 0.0, path.length_m)]
    along = np.unique(np.concatenate(s))
    north, east = path.positions(along)
    apart_m = np.hypot(np.diff(north), np.diff(east))
    moved = np.concatenate(([True], apart_m > _SAME_M))
    grid = np.concatenate(([0.0], np.cumsum(apart_m)))
    return grid[moved], north[moved], east[moved], np.interp(path.waypoint_s_m, along, grid)


def turns_rad(points: Sequence[tuple[float, float]]) -> list[float]:
    """The turn at each point of a line, positive to starboard; 0 at its ends. Points that repeat the one before turn as
    that does."""
    legs = [(b[0] - a[0], b[1] - a[1]) for a, b in itertools.pairwise(points)]
    turns = [0.0] * len(points)
    before: tuple[float, float] | None = None
    for i, (north, east) in enumerate(legs):
        if north == 0.0 and east == 0.0:
            continue
        if before is not None:
            turns[i] = math.atan2(before[0] * east - before[1] * north, before[0] * north + before[1] * east)
        before = north, east
    for i in range(len(legs) - 2, 0, -1):
        if legs[i] == (0.0, 0.0):
            turns[i] = turns[i + 1]
    return turns


def _out(window: Floats, corner: Floats) -> Floats:
    """g at each waypoint. `corner`: sin(θ/2)."""
    swung: Floats = np.maximum(0.0, _SWING_THROUGH - _PASS_M / np.maximum(_SWING_CUT * window * corner, 1.0e-6))
    return swung


def _around(grid: Floats, waypoint_s: Floats, values: Floats) -> Floats:
    """The values of the waypoints, each kept over the nearest quarters of its legs."""
    quarter = 0.25 * np.diff(waypoint_s)
    begins = waypoint_s - np.concatenate(([0.0], quarter))
    ends = waypoint_s + np.concatenate((quarter, [0.0]))
    around: Floats = np.interp(grid, np.stack((begins, ends), axis=1).ravel(), np.repeat(values, 2))
    return around


def _smoothed(
    grid: Steps, north: Floats, east: Floats, window: Floats, swing: Floats, out: Floats
) -> tuple[Floats, Floats]:
    """The means of the line over the window at each sample, for a swing where `swing` is 1; `out`: g."""
    room = np.minimum(grid.places, grid.places[-1] - grid.places)
    for plain, swung in ((_WIDE, _SWING_WIDE), (_NARROW, _SWING_NARROW)):
        half = np.minimum(0.5 * (plain + (swung - plain) * swing) * window, room)
        north, east = _mean(grid, north, half), _mean(grid, east, half)
    if not np.any(swing):
        return north, east
    half = np.minimum(0.5 * _SWING_LAST * window, room)
    return north + out * (north - _mean(grid, north, half)), east + out * (east - _mean(grid, east, half))


def _mean(grid: Steps, values: Floats, half: Floats) -> Floats:
    """Exact mean of the piecewise linear `values` over [s − half, s + half]."""
    if grid.step is not None and grid.step <= 0.0:
        return values
    wide = half > 1.0e-9
    spread = np.where(wide, half, 1.0)
    return np.where(wide, grid.integral(values, grid.places - half, grid.places + half) / (2.0 * spread), values)
