"""What ranging sensors have seen around the boat, as circles in the local plane that are forgotten with time.

Each sector of a scan says two things: something is at its distance, and nothing is nearer. So a scan adds circles, and
takes away those that it looks through. What no scan sees any more (hidden by something nearer, behind the boat) stays
until it is too old. A circle is as wide as its sector at that distance; a finer look replaces it.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from companion.core.readings import Ranges

Floats = NDArray[np.float64]

_FINEST_M = 0.25  # least radius of a circle, and the raster in which two looks at one thing are the same
_MOST = 1500  # circles kept; the oldest go first
_PASSES = 3  # looks through a circle before it is gone
_TOLERANCE_M, _TOLERANCE_SHARE = 0.4, 0.02  # between the distance of a circle and that of a sector which sees it
_FINER = 0.7  # of a radius: a look that much finer replaces a circle
_INTO = 0.7  # of its radius, a circle lies behind the distance measured: the surface is at its near side
_NORTH, _EAST, _RADIUS, _SEEN, _PASSED, _SINCE = range(6)
_AT_M = 0.4  # from a hit, beside half its radius: circles there are the same place


class Occupancy:
    """`take(scan, place, yaw_rad)` each scan, `forget(…)` once a second, `circles` → shape (n, 3): north_m, east_m,
    radius_m. `version` grows with every change. Remembers at most 1500 circles."""

    def __init__(self) -> None:
        self._cells: Floats = np.zeros((0, 6))
        self.version = 0

    @property
    def circles(self) -> Floats:
        """The circles: north_m, east_m, radius_m. Not to be changed."""
        return self._cells[:, :3]

    @property
    def confirmed(self) -> Floats:
        """Those that a second scan has seen too: what one alone sees may be spray, a gull or noise."""
        return self._cells[self._confirmed, :3]

    def confirmed_ages_s(self, now_s: float) -> Floats:
        """For how long there has been something at the place of each of `confirmed`."""
        ages: Floats = now_s - self._cells[self._confirmed, _SINCE]
        return ages

    @property
    def _confirmed(self) -> NDArray[np.bool_]:
        seen_again: NDArray[np.bool_] = self._cells[:, _SEEN] > self._cells[:, _SINCE]
        return seen_again

    def hits(self, scan: Ranges, place: tuple[float, float], yaw_rad: float) -> Floats:
        """The circles of one scan, in the order of its sectors, shape (n, 3). `place`: of the sensor (north_m,
        east_m); `yaw_rad`: heading of the boat."""
        distances = np.asarray(scan.distances_m)
        numbers = np.nonzero(np.isfinite(distances) & (distances >= scan.least_m))[0]
        off = distances[numbers]
        bearings = _first_rad(scan, yaw_rad) + numbers * scan.step_rad
        radii = np.maximum(_FINEST_M, 0.5 * scan.step_rad * off)
        away = off + _INTO * radii
        return np.column_stack((place[0] + away * np.cos(bearings), place[1] + away * np.sin(bearings), radii))

    def take(self, scan: Ranges, place: tuple[float, float], yaw_rad: float) -> None:
        """One scan from `place` (north_m, east_m) with the boat's heading `yaw_rad`."""
        found, t_s = self.hits(scan, place, yaw_rad), scan.t_s
        since = t_s - self.ages_s(found, t_s)
        if len(self._cells):
            self._look(scan, place, yaw_rad)
            new_ones = self._new_ones(found, t_s)
            found, since = found[new_ones], since[new_ones]
        if len(found):
            count = len(found)
            new = np.column_stack((found, np.full(count, t_s), np.zeros(count), since))
            self._cells = np.concatenate((self._cells, new))[-_MOST:]
            self.version += 1

    def ages_s(self, hits: Floats, t_s: float) -> Floats:
        """For how long there has been something at the place of each hit, shape (n,); 0 where it is new."""
        cells = self._cells
        if not len(cells) or not len(hits):
            return np.zeros(len(hits))
        gap = np.hypot(hits[:, None, 0] - cells[None, :, _NORTH], hits[:, None, 1] - cells[None, :, _EAST])
        there: NDArray[np.bool_] = gap < _AT_M + 0.5 * hits[:, None, 2]
        ages: Floats = np.where(there, t_s - cells[None, :, _SINCE], 0.0).max(axis=1)
        return ages

    def _look(self, scan: Ranges, place: tuple[float, float], yaw_rad: float) -> None:
        """Count the circles that the scan looks through, and take away those with too many."""
        cells = self._cells
        north, east = cells[:, _NORTH] - place[0], cells[:, _EAST] - place[1]
        away = np.hypot(north, east)
        count = len(scan.distances_m)
        turn = np.arctan2(east, north) - _first_rad(scan, yaw_rad)
        sector = np.rint(turn / scan.step_rad).astype(int)
        full = round(math.tau / scan.step_rad)
        sector %= full
        distances = np.full(max(full, count), np.nan)
        distances[:count] = scan.distances_m
        around = np.stack([distances[(sector + step) % full] for step in (-1, 0, 1)])
        middle = around[1]
        slack = _TOLERANCE_M + _TOLERANCE_SHARE * away + cells[:, _RADIUS]
        with np.errstate(invalid="ignore"):
            seen = np.any(np.abs(around - away) <= slack, axis=0)
            beyond = np.all(np.isnan(around) | (around > away + slack), axis=0) & (middle > away + slack)
        through = beyond & (away <= scan.most_m) & (away - cells[:, _RADIUS] >= scan.least_m)
        cells[seen, _SEEN] = np.maximum(cells[seen, _SEEN], scan.t_s)
        cells[seen, _PASSED] = 0.0
        cells[through, _PASSED] += 1.0
        gone = cells[:, _PASSED] >= _PASSES
        if gone.any():
            self._cells = cells[~gone]
            self.version += 1

    def _new_ones(self, found: Floats, t_s: float) -> NDArray[np.bool_]:
        """Which circles of a scan are not there yet. Coarser ones around a new one are taken away."""
        if not len(found) or not len(self._cells):
            return np.ones(len(found), dtype=bool)
        cells = self._cells
        gap = np.hypot(found[:, None, 0] - cells[None, :, _NORTH], found[:, None, 1] - cells[None, :, _EAST])
        coarser = (gap < cells[None, :, _RADIUS]) & (found[:, None, 2] < _FINER * cells[None, :, _RADIUS])
        same = (gap < np.maximum(2.0 * _FINEST_M, 0.5 * cells[None, :, _RADIUS])) & ~coarser
        known = same.any(axis=1)
        cells[same.any(axis=0), _SEEN] = t_s
        replaced = coarser.any(axis=0)
        if replaced.any():
            self._cells = cells[~replaced]
            self.version += 1
        new: NDArray[np.bool_] = np.logical_not(known)
        return new

    def forget(self, now_s: float, after_s: float, here: tuple[float, float], reach_m: float) -> None:
        """Forget circles not seen for `after_s`, and those further than `reach_m` from `here`."""
        cells = self._cells
        if not len(cells):
            return
        away = np.hypot(cells[:, _NORTH] - here[0], cells[:, _EAST] - here[1])
        kept = (now_s - cells[:, _SEEN] <= after_s) & (away <= reach_m)
        if not kept.all():
            self._cells = cells[kept]
            self.version += 1

    def clear(self) -> None:
        """Forget everything."""
        self._cells = np.zeros((0, 6))
        self.version += 1


def _first_rad(scan: Ranges, yaw_rad: float) -> float:
    return scan.first_rad + (0.0 if scan.from_north else yaw_rad)
