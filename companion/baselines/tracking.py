"""Speed and heading control of the ÅBOAT thesis (Storbacka 2021, 4.3.4, 6.2; WP_LAW 1): a PID for surge, one for yaw.

τ_x = Kp e_u + Ki ∫e_u − Kd u̇ and τ_n = Kp e_ψ + Ki ∫e_ψ − Kd r, with fixed gains (WPT_*) and no model; no sway force.
The thesis prints no gains.
"""

from __future__ import annotations

from companion.config.vessel import LimitsConfig
from companion.control.surge_yaw import SurgeYawErrors
from companion.core.actuation import Wrench
from companion.core.estimate import NavState
from companion.core.setpoint import PathSetpoint
from companion.params.store import Parameters


class ThesisTracking:
    """`start`, then `update(setpoint, nav, dt_s)` → wrench before saturation. Remembers both integrals of the errors,
    and the last speed."""

    def __init__(self, limits: LimitsConfig, parameters: Parameters) -> None:
        self._parameters = parameters
        self._errors = SurgeYawErrors(limits)
        self.start()

    def start(self) -> None:
        """Reset the integrals."""
        self._errors.start()
        self._last_mps: float | None = None

    def update(self, setpoint: PathSetpoint, nav: NavState, dt_s: float) -> Wrench:
        """Surge force and yaw moment for the speed and heading of the setpoint."""
        p = self._parameters
        errors = self._errors
        ki_surge, ki_yaw = p["WPT_KI_SURGE"], p["WPT_KI_YAW"]
        errors.update(setpoint, nav, ki_surge, ki_yaw, dt_s)
        gaining = 0.0 if self._last_mps is None else (nav.surge_mps - self._last_mps) / dt_s
        self._last_mps = nav.surge_mps
        surge = (
            p["WPT_KP_SURGE"] * errors.speed_error_mps
            + ki_surge * errors.speed_integral_m
            - p["WPT_KD_SURGE"] * gaining
        )
        yaw = (
            p["WPT_KP_YAW"] * errors.heading_error_rad
            + ki_yaw * errors.heading_integral_rads
            - p["WPT_KD_YAW"] * nav.yaw_rate_radps
        )
        return Wrench(surge, 0.0, yaw)
