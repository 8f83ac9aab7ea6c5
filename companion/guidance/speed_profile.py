"""Speed limit along a track, from its bends, its legs and its end, with bounded acceleration and braking."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from companion.guidance.bend_speed import BendSpeeds

_SLOWEST_SHARE = 0.25  # of the leg's speed: no bend slows the boat further, so that it can steer
_LOWEST_MPS = 0.05
_STRAIGHT_1PM = 1.0e-6
_HALVINGS = 10

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class BendLimits:
    """What bounds the speed in bends. `moment`: None where the moment of the thrusters does not bound it."""

    lateral_mps2: float
    yaw_rate_radps: float
    moment: BendSpeeds | None = None

    def speeds(self, curvature_1pm: Floats) -> Floats:
        """The highest speed at each absolute curvature above 0."""
        bend: Floats = np.minimum(np.sqrt(self.lateral_mps2 / curvature_1pm), self.yaw_rate_radps / curvature_1pm)
        return bend if self.moment is None else np.minimum(bend, self.moment.of(curvature_1pm))


class SpeedProfile:
    """Highest speed allowed at each arc length. It never changes.

    `s_m`, `curvature_1pm`: samples of the track. `leg_end_s_m`, `leg_speed_mps`: end and speed limit of each leg, in
    order. `acceleration_mps2`: limit along the track.

    v ≤ √(a_lat/κ), v ≤ r/κ, as fast as the moment can turn the hull, v² ≤ v₀² + 2a Δs in both directions.
    """

    def __init__(
        self,
        s_m: Sequence[float],
        curvature_1pm: Sequence[float],
        leg_end_s_m: Sequence[float],
        leg_speed_mps: Sequence[float],
        bends: BendLimits,
        acceleration_mps2: float,
        stop_at_end: bool,
    ) -> None:
        self._s = s_m
        s = np.asarray(s_m)
        leg = np.searchsorted(np.asarray(leg_end_s_m)[:-1], s)
        speed = _bend_speeds(np.asarray(leg_speed_mps)[leg], np.abs(np.asarray(curvature_1pm)), bends)
        if stop_at_end:
            speed[-1] = 0.0
        # of v² ∓ 2as, braking and speeding up keep to the least so far
        rise = 2.0 * acceleration_mps2 * (s - s[-1])
        square = np.minimum.accumulate((speed**2 + rise)[::-1])[::-1] - rise
        square[:-1] = np.minimum.accumulate((square - rise)[:-1]) + rise[:-1]
        self._speed: list[float] = np.sqrt(np.maximum(square, 0.0)).tolist()

    def at(self, s_m: float) -> float:
        """Highest speed at that arc length; the square is interpolated, which gives constant deceleration."""
        i = min(len(self._s) - 2, max(0, bisect_right(self._s, s_m) - 1))
        low = self._s[i]
        x = min(1.0, max(0.0, (s_m - low) / (self._s[i + 1] - low)))
        a, b = self._speed[i], self._speed[i + 1]
        return math.sqrt(a * a + x * (b * b - a * a))

    def soon(self, s_m: float, lag_s: float, last_mps: float) -> float:
        """The speed v that is allowed `lag_s` later at v: at s + T v. From `last_mps`, the speed allowed at
        s + T `last_mps` may lie beyond it; the two would alternate from tick to tick where the boat brakes."""
        asked = self.at(s_m + lag_s * last_mps)
        again = self.at(s_m + lag_s * asked)
        if (again - asked) * (asked - last_mps) >= 0.0:
            return asked
        low, high = min(last_mps, asked), max(last_mps, asked)
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            if self.at(s_m + lag_s * middle) > middle:
                low = middle
            else:
                high = middle
        return low


def _bend_speeds(speed_mps: Floats, curvature_1pm: Floats, bends: BendLimits) -> Floats:
    """The legs' speeds, lower in bends."""
    bend = bends.speeds(np.maximum(curvature_1pm, _STRAIGHT_1PM))
    slowed = np.minimum(speed_mps, np.maximum(np.maximum(bend, _SLOWEST_SHARE * speed_mps), _LOWEST_MPS))
    result: Floats = np.where(curvature_1pm < _STRAIGHT_1PM, speed_mps, slowed)
    return result
