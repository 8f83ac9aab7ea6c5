"""How noisy a receiver's positions are: how far each is from the line between the one before and the one after, with
the inertial sensor's way taken off.

What the filter has made of the positions does not come into it, so that a filter that believes them too much, and has
come loose, still learns how noisy they are. Its velocity is off by a constant, its acceleration by little: what
scatters is the receiver. Slow errors of positions do not, nor do some outliers: the median counts.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from statistics import median
from typing import NamedTuple

_MOST, _ENOUGH, _FEWEST = 40, 20, 7  # positions
_CHANCE = 3.0  # over the root of their number: by so much more than said they scatter by chance
_SIGMA = 1.4826  # of a normal distribution, over the median distance from its median
_LONGEST_S = 3.0  # between two positions: further apart, the inertial sensor's own error shows


class _Point(NamedTuple):
    t_s: float
    north_m: float
    east_m: float


class PositionNoise:
    """Call `take` for each position of one receiver and kind of fix. Remembers the last two, and the distances of the
    last ones from the line between their neighbours, over what noise of 1 m makes of them."""

    def __init__(self) -> None:
        self._run = -1
        self._before: deque[_Point] = deque(maxlen=2)
        self._north: deque[float] = deque(maxlen=_MOST)
        self._east: deque[float] = deque(maxlen=_MOST)

    def take(self, t_s: float, run: int, north_m: float, east_m: float) -> None:
        """Take a position less the way that the inertial sensor has made. `run`: that way has a meaning within it."""
        if run != self._run or (self._before and not 0.0 < t_s - self._before[-1].t_s <= _LONGEST_S):
            self._run = run
            self._before.clear()
        here = _Point(t_s, north_m, east_m)
        if len(self._before) == 2:
            first, middle = self._before
            share = (middle.t_s - first.t_s) / (t_s - first.t_s)
            noise = math.sqrt(1.0 + share * share + (1.0 - share) ** 2)
            self._north.append((middle.north_m - first.north_m - share * (north_m - first.north_m)) / noise)
            self._east.append((middle.east_m - first.east_m - share * (east_m - first.east_m)) / noise)
        self._before.append(here)

    def sigma_m(self, said_m: float, unknown_m: float) -> float:
        """One sigma of the noise on each axis: the one that is found, of all or of the newest ones, where it is larger
        than chance makes it, or else the one that is said. `unknown_m`: it may be as large as that, until there are
        enough positions to tell."""
        values = list(zip(self._north, self._east, strict=True))
        supposed_m = said_m if len(values) >= _ENOUGH else unknown_m
        if len(values) < _FEWEST:
            return supposed_m
        found_m = [_beyond_chance_m(some, supposed_m) for some in (values, values[-_FEWEST:])]
        return max(*found_m, supposed_m)


def _beyond_chance_m(values: list[tuple[float, float]], supposed_m: float) -> float:
    """The noise that these show; 0 where chance explains it."""
    north, east = zip(*values, strict=True)
    found_m = math.sqrt(0.5 * (_scatter(north) ** 2 + _scatter(east) ** 2))
    return found_m if found_m > (1.0 + _CHANCE / math.sqrt(len(values))) * supposed_m else 0.0


def _scatter(values: Sequence[float]) -> float:
    centre = median(values)
    return _SIGMA * median([abs(value - centre) for value in values])
