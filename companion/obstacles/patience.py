"""How long a boat goes round obstacles without getting nearer to its destination.

What it sees on one side it may have forgotten when it has tried the other, so it could go to and fro for ever.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from companion.fence.allowed import Place
from companion.params.store import Parameters

_NEARER_M, _ANEW_M = 1.0, 5.0
_LEAST_MPS = 0.1
_WAYS = 2.0  # times the way round, as long as it takes
# What the boat finds may make its way round longer by so much: by a share of what was left before it (at most of so
# much), and some more.
_LONGER, _LONGER_OF_M, _LONGER_M = 2.0, 150.0, 80.0


class Patience:
    """`look(way, now_s)` twice a second → whether it is over; `laid(way, speed_mps, now_s)` when a way round is laid.

    In time: it begins with the first way round, lasts WP_STUCK_T and twice the time that this way takes, and is renewed
    when less is left of the way than ever. In length: the first way round may be as long as it is. What is sailed and
    left of it since may become longer by 80 m, twice what was left before it (of at most 150 m) and what has been won.
    Remembers the least that was left, what was left last, and when it is over; from the first way round on, what was
    left before it, what has been sailed since, and the length that may become of both.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self.reset()

    def reset(self) -> None:
        """Another way altogether."""
        self._least_m = self._last_m = math.inf
        self._until_s = math.inf
        self._sailed_m, self._most_m = 0.0, math.inf

    def look(self, way: Sequence[Place], now_s: float) -> bool:
        """`way`: all that is left of it."""
        left_m = _length_m(way)
        if left_m > self._last_m + _ANEW_M:  # the mode has laid its next part
            self.reset()
        if left_m < self._last_m < math.inf:
            self._sailed_m += self._last_m - left_m
        self._last_m = left_m
        if left_m < self._least_m - _NEARER_M:
            if self._least_m < math.inf:
                self._most_m += self._least_m - left_m
            self._least_m, self._until_s = left_m, math.inf
        return now_s > self._until_s or self._sailed_m + left_m > self._most_m

    def laid(self, way: Sequence[Place], speed_mps: float, now_s: float) -> None:
        """`way`: as it is now led round."""
        before_m, self._last_m = self._last_m, _length_m(way)
        if math.isinf(self._most_m):
            longer_m = _LONGER_M + _LONGER * min(before_m, _LONGER_OF_M)
            self._sailed_m, self._most_m = 0.0, self._last_m + longer_m
        if math.isinf(self._until_s):
            way_s = self._last_m / max(_LEAST_MPS, speed_mps)
            self._until_s = now_s + self._parameters["WP_STUCK_T"] + _WAYS * way_s


def _length_m(way: Sequence[Place]) -> float:
    steps = np.diff(np.asarray(way, dtype=float).reshape(-1, 2), axis=0)
    return float(np.hypot(steps[:, 0], steps[:, 1]).sum())
