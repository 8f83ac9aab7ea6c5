"""Clocks: the wall's, the wall's at a multiple of its speed, and one that only moves when told to."""

from __future__ import annotations

import select
import time
from collections.abc import Sequence

_SLIP_S = 0.5  # wall time by which a paced run may fall behind before it stops trying to catch up


class WallClock:
    """Seconds since it was made, by the machine's monotonic clock; `speed`: times as many, for a boat whose plant runs as fast."""

    def __init__(self, speed: float = 1.0) -> None:
        self._speed = speed
        self._start_s = self._released_s = time.monotonic()

    def now_s(self) -> float:
        return (time.monotonic() - self._start_s) * self._speed

    def time_unix_ns(self) -> int:
        return time.time_ns()

    def wait(self, until_s: float, filenos: Sequence[int]) -> bool:
        remaining_s = (until_s - self.now_s()) / self._speed
        if remaining_s > 0.0 and _readable(filenos, remaining_s):
            return True
        self._released_s = time.monotonic()
        return False

    def busy_s(self) -> float:
        return (time.monotonic() - self._released_s) * self._speed


class PacedClock:
    """For SITL beside real ground stations: time advances in whole ticks, `speed` times as fast as the wall where the machine can.

    A tick always spans exactly its period, so that a slow machine makes a slow boat, not a different one.
    """

    def __init__(self, speed: float, epoch_unix_ns: int) -> None:
        self._speed = speed
        self._epoch_unix_ns = epoch_unix_ns
        self._now_s = 0.0
        self._wall_s = self._released_s = time.monotonic()  # when _now_s was due, and when it was reached

    def now_s(self) -> float:
        return self._now_s

    def time_unix_ns(self) -> int:
        return self._epoch_unix_ns + round(self._now_s * 1e9)

    def wait(self, until_s: float, filenos: Sequence[int]) -> bool:
        due_s = self._wall_s + (until_s - self._now_s) / self._speed
        wall_s = time.monotonic()
        if due_s > wall_s and _readable(filenos, due_s - wall_s):
            return True
        self._now_s = until_s
        self._released_s = time.monotonic()
        self._wall_s = max(due_s, self._released_s - _SLIP_S)
        return False

    def busy_s(self) -> float:
        return (time.monotonic() - self._released_s) * self._speed


class SimulatedClock:
    """Lockstep: waiting takes no time at all."""

    def __init__(self, epoch_unix_ns: int) -> None:
        self._epoch_unix_ns = epoch_unix_ns
        self._now_s = 0.0

    def now_s(self) -> float:
        return self._now_s

    def time_unix_ns(self) -> int:
        return self._epoch_unix_ns + round(self._now_s * 1e9)

    def wait(self, until_s: float, filenos: Sequence[int]) -> bool:
        self._now_s = until_s
        return False

    def busy_s(self) -> float:
        return 0.0


def _readable(filenos: Sequence[int], timeout_s: float) -> bool:
    """Wait for a descriptor, at most `timeout_s`."""
    if not filenos:
        time.sleep(timeout_s)
        return False
    try:
        return bool(select.select(filenos, (), (), timeout_s)[0])
    except (OSError, ValueError):  # one was closed meanwhile: let its link find out
        time.sleep(min(timeout_s, 0.001))
        return True
