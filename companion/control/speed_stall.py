"""What of an error of the speed ahead is an offset to learn.

A large error is an acceleration, which the law's proportional part makes: learnt, it would overshoot. Of a boat that
does not accelerate it is an offset all the same: a stream or a wind that the proportional part just balances would
hold the boat for ever.
"""

from __future__ import annotations

import math

_SEEN_S = 2.0  # time constant of the acceleration
_REACHES_S = 15.0  # a boat that would need longer to reach its speed, at its acceleration, is stalled
_STALLED_S = 3.0  # for so long, before that counts


class SpeedStall:
    """`offset_mps(…)` once a tick. Remembers a low-pass copy of the speed, and for how long the boat has stalled."""

    __slots__ = ("_slow_mps", "_stalled_s")

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Forget it, after another law was active."""
        self._slow_mps: float | None = None
        self._stalled_s = 0.0

    def offset_mps(self, error_mps: float, surge_mps: float, most_mps: float, dt_s: float) -> float:
        """The error to learn from: all of one below `most_mps`, of a larger one nothing, or that much while the boat is
        stalled."""
        before_mps = surge_mps if self._slow_mps is None else self._slow_mps
        self._slow_mps = before_mps + dt_s / (dt_s + _SEEN_S) * (surge_mps - before_mps)
        if abs(error_mps) < most_mps:
            self._stalled_s = 0.0
            return error_mps
        gained_mps2 = math.copysign(1.0, error_mps) * (surge_mps - self._slow_mps) / _SEEN_S
        stalled = gained_mps2 * _REACHES_S < abs(error_mps)
        self._stalled_s = self._stalled_s + dt_s if stalled else 0.0
        return math.copysign(most_mps, error_mps) if self._stalled_s > _STALLED_S else 0.0
