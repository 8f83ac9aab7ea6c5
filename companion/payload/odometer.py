"""The way that the boat has made, along its track."""

from __future__ import annotations

import math

CHORD_M = 0.25  # shorter movements are noise of a boat at rest, not way
_LEAP_M = 2.0  # beyond what the speed explains: the estimate was corrected, the boat did not move


class Odometer:
    """`update(north_m, east_m, speed_mps, dt_s)` → metres along the track since the start, by chords of 0.25 m.

    A boat that stays within a chord makes no way, however long; its distance from the last chord's end counts while it
    is there. Leaps of the estimate do not count. Remembers the end of the last chord and the sum up to it.
    """

    def __init__(self) -> None:
        self._end: tuple[float, float] | None = None
        self._last: tuple[float, float] | None = None
        self._sum_m = 0.0
        self.way_m = 0.0

    def update(self, north_m: float, east_m: float, speed_mps: float, dt_s: float) -> float:
        """The way so far. `speed_mps`: over ground, to tell movement from a leap."""
        place = (north_m, east_m)
        if self._end is None or self._last is None:
            self._end = self._last = place
            return self.way_m
        step_m = math.dist(self._last, place)
        if step_m > _LEAP_M + 2.0 * speed_mps * dt_s:
            self._sum_m, self._end = self.way_m, place
        chord_m = math.dist(self._end, place)
        if chord_m >= CHORD_M:
            self._sum_m += chord_m
            self._end, chord_m = place, 0.0
        self._last = place
        self.way_m = self._sum_m + chord_m
        return self.way_m

    def lose(self) -> float:
        """The position is not valid: what happens until it is does not count. The way so far."""
        self._sum_m, self._end = self.way_m, None
        return self.way_m
