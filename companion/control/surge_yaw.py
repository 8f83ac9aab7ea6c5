"""Errors of speed and heading under way and their integrals, for laws that steer by surge and yaw alone."""

from __future__ import annotations

import math

from companion.config import LimitsConfig
from companion.core.angles import wrap_pi
from companion.core.types import NavState, Setpoint

_LARGE_ERROR_RAD = math.radians(45.0)  # a turn, not an offset to be learnt
_SHARE = 0.5  # of the limits, that an integral may ask for


class SurgeYawErrors:
    """`update` each cycle. Holds `slow_mps` and `off_rad`, how much the boat is short of the speed and the heading asked for, and their
    integrals `slow_m` and `off_rads`, bounded by half of what may be asked of the thrusters."""

    def __init__(self, limits: LimitsConfig) -> None:
        self._limits = limits
        self.start()

    def start(self) -> None:
        self.slow_mps = self.off_rad = self.slow_m = self.off_rads = 0.0

    def update(self, setpoint: Setpoint, nav: NavState, surge_gain: float, yaw_gain: float, dt_s: float) -> None:
        """`surge_gain`, `yaw_gain`: what the integrals will be multiplied by, in N/m and Nm/(rad s)."""
        self.slow_mps = setpoint.surge_mps - nav.surge_mps
        self.off_rad = 0.0 if setpoint.yaw_rad is None else wrap_pi(setpoint.yaw_rad - nav.yaw_rad)
        self.slow_m = _bounded(self.slow_m + self.slow_mps * dt_s, _SHARE * self._limits.surge_n, surge_gain)
        if abs(self.off_rad) < _LARGE_ERROR_RAD:
            self.off_rads = _bounded(self.off_rads + self.off_rad * dt_s, _SHARE * self._limits.yaw_nm, yaw_gain)


def _bounded(integral: float, limit: float, gain: float) -> float:
    bound = limit / gain if gain > 0.0 else 0.0
    return min(bound, max(-bound, integral))
