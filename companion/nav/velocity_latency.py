"""How late velocities are, by the inertial sensor alone: where the boat changes its velocity, a late one lags behind.

    velocity(t) = dead reckoning(t − latency) + constant + tilt · time + error of heading · change

Dead reckoning from some seconds ago (`lanes.py`) has never heard of the velocities since. What its tilt, biases and
heading were off by when it began is taken out of each stretch; the latency is the one that leaves least. So it shows
with one antenna, too, and as soon as the boat gathers way.
"""

from __future__ import annotations

import math
from array import array
from collections.abc import Sequence
from typing import Any

import numpy as np

from companion.nav.lanes import Lane

_COLUMNS = 5  # of a sample: time, velocity, dead reckoning
_STEP_S, _STEPS = 0.1, 5  # between two latencies that are tried, and how many to each side
_LEAST_S, _FEWEST = 2.0, 6  # a shorter stretch, or one of fewer velocities, is all constant and ramp
_FORGET_S = 60.0
_ALIKE_S = 1.0  # errors of velocities are alike for that long; each is in two stretches at once, on two axes
_LEAST_MPS2S = 0.05  # of acceleration, squared and summed over time, without which there is nothing to tell
_LOOK_S = 1.0  # between two looks at a stretch that goes on

Array = np.ndarray[Any, np.dtype[np.float64]]
Pair = tuple[float, float]  # north and east


class VelocityLatency:
    """Call `take` for each velocity. Remembers the samples of the stretches that go on, and what those have come to
    that have ended: their time, and what each latency leaves of them, squared and summed over time."""

    def __init__(self) -> None:
        self.begin()

    def begin(self) -> None:
        """Forget all: the times of the velocities have changed. Dead reckoning has not, and goes on."""
        self._stretches: dict[float, array[float]] = {}
        self._time_s, self._left = 0.0, np.zeros(2 * _STEPS + 1)
        self._latency: tuple[float, float] | None = None
        self._look_s = -math.inf

    def take(self, t_s: float, velocity: Pair, lanes: Sequence[Lane], swing: Pair) -> None:
        """`velocity`: of the antenna, m/s; `swing`: of the antenna relative to the inertial sensor, by which it is
        faster than the `lanes`."""
        running = {}
        for lane in lanes:
            stretch = self._stretches.pop(lane.from_s, None)
            running[lane.from_s] = stretch = array("d") if stretch is None else stretch
            stretch.extend((t_s, *velocity, lane.velocity[0] + swing[0], lane.velocity[1] + swing[1]))
        ended = list(self._stretches.values())
        self._stretches = running
        for stretch in ended:
            self._time_s, self._left = self._with(stretch)
        if ended or t_s - self._look_s >= _LOOK_S:
            self._look_s = t_s
            oldest = next(iter(running.values()), None)
            time_s, left = (self._time_s, self._left) if oldest is None else self._with(oldest)
            self._latency = _least(time_s, left)

    def latency_s(self) -> tuple[float, float] | None:
        """Latency and one sigma of it, as of the last look; None while the boat has not changed its velocity."""
        return self._latency

    def _with(self, stretch: array[float]) -> tuple[float, Array]:
        """The sums with those of one more stretch, which counts most."""
        time_s, left = _left_of(np.frombuffer(stretch).reshape(-1, _COLUMNS))
        kept = math.exp(-time_s / (2.0 * _FORGET_S))  # stretches overlap by half
        return kept * self._time_s + time_s, kept * self._left + left


def _left_of(rows: Array) -> tuple[float, Array]:
    """Time of a stretch, and what each latency leaves of it."""
    reach_s, times, left = _STEP_S * _STEPS, rows[:, 0], np.zeros(2 * _STEPS + 1)
    used = (times >= times[0] + reach_s) & (times <= times[-1] - reach_s)
    t = times[used]
    if len(t) < _FEWEST or t[-1] - t[0] < _LEAST_S:
        return 0.0, left
    north, east = rows[used, 3], rows[used, 4]
    one, none, passed = np.ones(len(t)), np.zeros(len(t)), t - t[0]
    errors = (one, none), (none, one), (passed, none), (none, passed), (-east, north)
    basis, _ = np.linalg.qr(np.array([np.concatenate(pair) for pair in errors]).T)
    for i in range(2 * _STEPS + 1):
        then = t - _STEP_S * (i - _STEPS)
        off = np.concatenate([rows[used, j] - np.interp(then, times, rows[:, j + 2]) for j in (1, 2)])
        along = off @ basis
        left[i] = off @ off - along @ along
    time_s = float(t[-1] - t[0])
    return time_s, left * (time_s / (len(t) - 1))


def _least(time_s: float, left: Array) -> tuple[float, float] | None:
    """The latency that leaves least, by a parabola, and one sigma of it: what is left by chance could be elsewhere."""
    i = int(np.argmin(left))
    if not 0 < i < 2 * _STEPS:
        return None
    before, here, after = float(left[i - 1]), float(left[i]), float(left[i + 1])
    changes = (before - 2.0 * here + after) / (2.0 * _STEP_S * _STEP_S)
    if changes < _LEAST_MPS2S:
        return None
    beyond_s = (before - after) / (4.0 * _STEP_S * changes)
    least = max(here - changes * beyond_s * beyond_s, 0.0)
    return _STEP_S * (i - _STEPS) + beyond_s, math.sqrt(least / time_s * _ALIKE_S / changes)
