"""Whether the boat may go stern first, so that its course is no heading."""

from __future__ import annotations

import math

from companion.core.actuation import Wrench

_AHEAD_S = 3.0  # of thrust ahead, after which a boat that has pushed astern goes ahead again


class Sternway:
    """Thrust of each tick → `possible`: the boat has pushed astern, and not ahead for some seconds since. It may still
    go ahead, as one that brakes does. Remembers since when it pushes ahead."""

    def __init__(self) -> None:
        self.possible = False
        self._ahead_since_s = math.inf

    def update(self, thrust: Wrench | None, now_s: float) -> None:
        """`thrust`: on the hull since the last call; None if unknown: nothing changes."""
        if thrust is None or thrust.surge_n == 0.0:
            self._ahead_since_s = math.inf
        elif thrust.surge_n < 0.0:
            self.possible, self._ahead_since_s = True, math.inf
        else:
            self._ahead_since_s = min(self._ahead_since_s, now_s)
            self.possible = self.possible and now_s - self._ahead_since_s < _AHEAD_S
