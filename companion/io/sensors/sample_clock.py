"""A device's own time stamps → vessel time, free of the jitter of arrival."""

from __future__ import annotations

import math


class SampleClock:
    """Time stamps of a device and the arrival of its messages → times of validity, never after arrival less
    `latency_s`.

    In: the stamp in ticks of `tick_s`, which start again after `wrap` of them, and the time of arrival. The smallest
    delay seen counts as `latency_s`. It may grow by 2 parts in 10 000 of the time, so that crystals may differ. A jump
    of either clock by more than `jump_s` starts again. Remembers the last stamp, the device's time, and that smallest
    delay.
    """

    _DRIFT = 2e-4

    def __init__(self, latency_s: float, jump_s: float = 0.5, tick_s: float = 1e-4, wrap: int = 2**32) -> None:
        self._latency_s = latency_s
        self._jump_s = jump_s
        self._tick_s = tick_s
        self._wrap = wrap
        self._last_ticks: float | None = None
        self._device_s = 0.0
        self._offset_s = 0.0

    def time_s(self, ticks: float, arrival_s: float) -> float:
        """Vessel time of the moment of the stamp `ticks`. Stamps may come out of order."""
        first = self._last_ticks is None
        step_s = 0.0 if self._last_ticks is None else self._difference(ticks, self._last_ticks) * self._tick_s
        self._last_ticks = ticks
        self._device_s += step_s
        direct = arrival_s - self._latency_s - self._device_s
        offset = self._offset_s + self._DRIFT * max(0.0, step_s)
        self._offset_s = direct if first or abs(direct - offset) > self._jump_s else min(direct, offset)
        time_s = min(self._device_s + self._offset_s, arrival_s - self._latency_s)
        return math.floor(time_s * 1e6) / 1e6  # whole microseconds: no stamp is better, and the log keeps them small

    def _difference(self, ticks: float, before: float) -> float:
        """The shorter way round."""
        step = (ticks - before) % self._wrap
        return step - self._wrap if step > self._wrap / 2 else step
