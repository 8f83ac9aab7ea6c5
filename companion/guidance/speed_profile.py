"""Speed limit along a track, from its bends, its legs and its end, with bounded acceleration and braking."""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Sequence

_SLOWEST_SHARE = 0.25  # of the leg's speed: no bend slows the boat further, so that it can steer
_LOWEST_MPS = 0.05


class SpeedProfile:
    """Highest speed allowed at each arc length. It never changes.

    `s_m`, `curvature_1pm`: samples of the track. `leg_end_s_m`, `leg_speed_mps`: end and speed limit of each leg, in
    order. `lateral_mps2`, `yaw_rate_radps`: limits in bends; `acceleration_mps2`: limit along the track.

    v ≤ √(a_lat/κ), v ≤ r/κ, v² ≤ v₀² + 2a Δs in both directions.
    """

    def __init__(
        self,
        s_m: Sequence[float],
        curvature_1pm: Sequence[float],
        leg_end_s_m: Sequence[float],
        leg_speed_mps: Sequence[float],
        lateral_mps2: float,
        yaw_rate_radps: float,
        acceleration_mps2: float,
        stop_at_end: bool,
    ) -> None:
        self._s = s_m
        speeds = []
        leg = 0
        for s, curvature in zip(s_m, curvature_1pm, strict=True):
            while leg < len(leg_end_s_m) - 1 and s > leg_end_s_m[leg]:
                leg += 1
            speeds.append(_bend_speed(leg_speed_mps[leg], abs(curvature), lateral_mps2, yaw_rate_radps))
        if stop_at_end:
            speeds[-1] = 0.0
        double = 2.0 * acceleration_mps2
        for i in range(len(speeds) - 2, -1, -1):
            speeds[i] = min(speeds[i], math.sqrt(speeds[i + 1] ** 2 + double * (s_m[i + 1] - s_m[i])))
        for i in range(1, len(speeds) - 1):
            speeds[i] = min(speeds[i], math.sqrt(speeds[i - 1] ** 2 + double * (s_m[i] - s_m[i - 1])))
        self._speed = speeds

    def at(self, s_m: float) -> float:
        """Highest speed at that arc length; the square is interpolated, which gives constant deceleration."""
        i = min(len(self._s) - 2, max(0, bisect_right(self._s, s_m) - 1))
        low = self._s[i]
        x = min(1.0, max(0.0, (s_m - low) / (self._s[i + 1] - low)))
        a, b = self._speed[i], self._speed[i + 1]
        return math.sqrt(a * a + x * (b * b - a * a))


def _bend_speed(speed_mps: float, curvature_1pm: float, lateral_mps2: float, yaw_rate_radps: float) -> float:
    if curvature_1pm < 1.0e-6:
        return speed_mps
    bend = min(math.sqrt(lateral_mps2 / curvature_1pm), yaw_rate_radps / curvature_1pm)
    return min(speed_mps, max(bend, _SLOWEST_SHARE * speed_mps, _LOWEST_MPS))
