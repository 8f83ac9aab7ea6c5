"""How a hull feels the wakes of other boats: slopes of the surface at bow and stern, with the hull's lag."""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.core.frames import ned_to_body
from sitl.hull import Hull
from sitl.wake import Wake

ARM_SHARE = 0.25  # share of the length, ahead and astern, at which half of the weight is carried
_EVERY_S = 0.05
_TAU_S = 0.15  # time in which the hull follows a wake's slope

Slopes = tuple[float, float, float, float]
_CALM: Slopes = (0.0, 0.0, 0.0, 0.0)


class WakeFeel:
    """In: the hull's place; out: `felt`, slopes ahead and across in body axes, at bow and stern. Remembers the lag."""

    __slots__ = ("_arm_m", "_due_s", "_slopes", "_wakes", "felt")

    def __init__(self, wakes: Sequence[Wake], length_m: float) -> None:
        self._wakes, self._arm_m = tuple(wakes), ARM_SHARE * length_m
        self._slopes = self.felt = _CALM
        self._due_s = 0.0

    def update(self, hull: Hull, t_s: float, dt_s: float) -> None:
        """Feel the wakes at `t_s`, `dt_s` after the last time."""
        if not self._wakes:
            return
        if t_s >= self._due_s:
            self._due_s = t_s + _EVERY_S
            c, s = math.cos(hull.yaw_rad), math.sin(hull.yaw_rad)
            slopes: list[float] = []
            for x_m in (self._arm_m, -self._arm_m):
                north_m, east_m = hull.north_m + c * x_m, hull.east_m + s * x_m
                felt = [wake.slope(north_m, east_m) for wake in self._wakes if wake.reaches(north_m, east_m)]
                slopes += ned_to_body(sum(north for north, _ in felt), sum(east for _, east in felt), hull.yaw_rad)
            self._slopes = slopes[0], slopes[1], slopes[2], slopes[3]
        share = dt_s / (dt_s + _TAU_S)
        a, b, d, e = (old + share * (new - old) for old, new in zip(self.felt, self._slopes, strict=True))
        self.felt = a, b, d, e
