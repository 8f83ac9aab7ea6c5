"""Speed and heading under way by the ÅBOAT thesis: a PID for surge and one for yaw, sway left alone (Storbacka 2021, 4.3.4, 6.2).

τ_x = Kp e_u + Ki ∫e_u − Kd u̇ and τ_n = Kp e_ψ + Ki ∫e_ψ − Kd r with fixed gains (WPT_*) and no model; the thesis prints no gains.
"""

from __future__ import annotations

from companion.config import LimitsConfig
from companion.control.surge_yaw import SurgeYawErrors
from companion.core.types import NavState, Setpoint, Wrench
from companion.params import Parameters


class ThesisTracking:
    """`start`, then `update(setpoint, nav, dt_s)` → wrench before saturation. Remembers both integrals, as errors times time, and the
    speed of the last cycle."""

    def __init__(self, limits: LimitsConfig, parameters: Parameters) -> None:
        self._parameters = parameters
        self._errors = SurgeYawErrors(limits)
        self.start()

    def start(self) -> None:
        self._errors.start()
        self._last_mps: float | None = None

    def update(self, setpoint: Setpoint, nav: NavState, dt_s: float) -> Wrench:
        """Wrench for the speed and the heading of the setpoint."""
        p = self._parameters
        errors = self._errors
        ki_surge, ki_yaw = p["WPT_KI_SURGE"], p["WPT_KI_YAW"]
        errors.update(setpoint, nav, ki_surge, ki_yaw, dt_s)
        gaining = 0.0 if self._last_mps is None else (nav.surge_mps - self._last_mps) / dt_s
        self._last_mps = nav.surge_mps
        surge = p["WPT_KP_SURGE"] * errors.slow_mps + ki_surge * errors.slow_m - p["WPT_KD_SURGE"] * gaining
        yaw = p["WPT_KP_YAW"] * errors.off_rad + ki_yaw * errors.off_rads - p["WPT_KD_YAW"] * nav.yaw_rate_radps
        return Wrench(surge, 0.0, yaw)
