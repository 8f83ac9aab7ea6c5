"""Whether a boat has a fix now: a leader must report the loss of its own within a fraction of a second."""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.core.estimate import NavState
from companion.core.readings import FixType, GnssFix, Reading

_USUAL_SHARE = 0.1
_LONGEST_S = 2.0
_PATIENCE = 1.5  # intervals between fixes
_LATE_S = 0.05
_REJECTED_S = 0.5  # for which fixes may be rejected as outliers


class FixWatch:
    """Remembers the last good fix and the usual interval between fixes."""

    def __init__(self) -> None:
        self._last_s = -math.inf
        self._usual_s = 1.0

    def update(self, readings: Sequence[Reading], nav: NavState, now_s: float) -> bool:
        """Whether the estimate rests on a fix: the last one is younger than one and a half usual intervals, and the
        receiver does not report that it has none."""
        for reading in readings:
            if isinstance(reading, GnssFix) and reading.fix >= FixType.FIX_2D and reading.t_s > self._last_s:
                interval_s = min(_LONGEST_S, reading.t_s - self._last_s)
                if self._last_s > -math.inf:
                    self._usual_s += _USUAL_SHARE * (interval_s - self._usual_s)
                self._last_s = reading.t_s
        fresh = now_s - self._last_s <= _PATIENCE * self._usual_s + _LATE_S
        accepted = nav.position_age_s <= max(_REJECTED_S, _PATIENCE * self._usual_s + _LATE_S)
        return nav.position_valid and nav.fix >= FixType.FIX_2D and fresh and accepted
