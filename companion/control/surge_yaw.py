"""Errors of speed and heading under way and their integrals, for laws that control surge and yaw alone."""

from __future__ import annotations

import math

from companion.config.vessel import LimitsConfig
from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.core.setpoint import PathSetpoint

_LARGE_ERROR_RAD = math.radians(45.0)  # a larger error is a turn, not an offset to learn
_SHARE = 0.5  # of the limits: the most that an integral may demand


class SurgeYawErrors:
    """Call `update` each cycle. `speed_error_mps`, `heading_error_rad`: setpoint minus state. `speed_integral_m`,
    `heading_integral_rads`: their integrals, limited to half of the vessel's limits."""

    def __init__(self, limits: LimitsConfig) -> None:
        self._limits = limits
        self.start()

    def start(self) -> None:
        """Set errors and integrals to zero."""
        self.speed_error_mps = self.heading_error_rad = self.speed_integral_m = self.heading_integral_rads = 0.0

    def update(self, setpoint: PathSetpoint, nav: NavState, surge_gain: float, yaw_gain: float, dt_s: float) -> None:
        """Compute the errors and integrate them. `surge_gain`, `yaw_gain`: gains of the integrals, in N/m and
        Nm/(rad s), for their limits."""
        self.speed_error_mps = setpoint.surge_mps - nav.surge_mps
        self.heading_error_rad = wrap_pi(setpoint.yaw_rad - nav.yaw_rad)
        self.speed_integral_m = _bounded(
            self.speed_integral_m + self.speed_error_mps * dt_s, _SHARE * self._limits.surge_n, surge_gain
        )
        if abs(self.heading_error_rad) < _LARGE_ERROR_RAD:
            self.heading_integral_rads = _bounded(
                self.heading_integral_rads + self.heading_error_rad * dt_s, _SHARE * self._limits.yaw_nm, yaw_gain
            )


def _bounded(integral: float, limit: float, gain: float) -> float:
    bound = limit / gain if gain > 0.0 else 0.0
    return min(bound, max(-bound, integral))
