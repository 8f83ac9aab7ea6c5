"""Whether a boat has a fix right now: a leader must say within a fraction of a second that it has lost its own."""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.core.types import FixType, GnssFix, NavState, Reading

_USUAL_SHARE = 0.1
_LONGEST_S = 2.0
_PATIENCE = 1.5  # intervals between fixes
_LATE_S = 0.05
_REJECTED_S = 0.5  # for which fixes may be rejected as wild while the estimate stands


class FixWatch:
    """`update(readings, nav, now_s)` → whether the estimate rests on a fix: one has come within one and a half times the usual interval, and the receiver does
    not say that it has none. Remembers the last good fix and the usual interval."""

    def __init__(self) -> None:
        self._last_s = -math.inf
        self._usual_s = 1.0

    def update(self, readings: Sequence[Reading], nav: NavState, now_s: float) -> bool:
        for reading in readings:
            if isinstance(reading, GnssFix) and reading.fix >= FixType.FIX_2D and reading.t_s > self._last_s:
                interval_s = min(_LONGEST_S, reading.t_s - self._last_s)
                if self._last_s > -math.inf:
                    self._usual_s += _USUAL_SHARE * (interval_s - self._usual_s)
                self._last_s = reading.t_s
        fresh = now_s - self._last_s <= _PATIENCE * self._usual_s + _LATE_S
        accepted = nav.position_age_s <= max(_REJECTED_S, _PATIENCE * self._usual_s + _LATE_S)
        return nav.position_valid and nav.fix >= FixType.FIX_2D and fresh and accepted
