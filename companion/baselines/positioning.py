"""The positioning law of the ReVolt thesis (4.1…4.17; DP_LAW 1): PID with fixed gains and feed-forward, at 5 Hz.

τ = τ_FF − Kp e − Ki ∫e dt − Kd (ν − ν_d), e = Rᵀ(η − η_d) in body axes, gains per metre and per radian (DPT_*). It has
no anti-windup. τ is saturated as the thesis prints it, where the vessel's `[thesis_model]` says so.
"""

from __future__ import annotations

from companion.config.vessel import VesselConfig
from companion.control.dynamic_positioning import finite, pose_errors
from companion.control.feedforward import feedforward
from companion.core.actuation import ZERO_WRENCH, Wrench
from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.core.frames import ned_to_body
from companion.core.setpoint import PoseSetpoint
from companion.params.store import Parameters

PERIOD_S = 0.2
_AXES = ("SURGE", "SWAY", "YAW")


class ThesisPositioning:
    """`start` with the integral of the law before, then `update(setpoint, nav, dt_s)` → wrench, within the thesis's own
    saturation.

    Remembers the integral and the last wrench, which it holds for PERIOD_S. The integral is a wrench in body axes: it
    turns with the boat, as in the thesis.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._config = config
        self._parameters = parameters
        self.start(0.0, 0.0, 0.0)

    def start(self, surge_n: float, sway_n: float, yaw_nm: float) -> None:
        """Begin with this wrench as the integral."""
        self._integral = (surge_n, sway_n, yaw_nm)
        self._held = ZERO_WRENCH
        self._since_s = PERIOD_S

    def update(self, setpoint: PoseSetpoint, nav: NavState, dt_s: float) -> Wrench:
        """Wrench for the pose and velocity of the reference; a new one every PERIOD_S."""
        self._since_s += dt_s
        if self._since_s < PERIOD_S - 1.0e-6:
            return self._held
        step_s, self._since_s = min(self._since_s, 2.0 * PERIOD_S), 0.0
        self._held = self._saturated(self._sample(setpoint, nav, step_s))
        return self._held

    def _saturated(self, wrench: Wrench) -> Wrench:
        model = self._config.thesis_model
        if model is None or model.saturation is None or not finite(wrench):
            return wrench
        x, y, n = model.saturation
        return Wrench(min(x, max(-x, wrench.surge_n)), min(y, max(-y, wrench.sway_n)), min(n, max(-n, wrench.yaw_nm)))

    def _sample(self, setpoint: PoseSetpoint, nav: NavState, dt_s: float) -> Wrench:
        parameters = self._parameters
        kp, ki, kd = (tuple(parameters[f"DPT_K{term}_{axis}"] for axis in _AXES) for term in "PID")
        turn = wrap_pi(nav.yaw_rad - setpoint.yaw_rad)
        u, v = ned_to_body(setpoint.surge_mps, setpoint.sway_mps, turn)
        ex, ey, eyaw = pose_errors(setpoint, nav)
        ix, iy, iyaw = self._integral
        self._integral = ix, iy, iyaw = (ix - ki[0] * ex * dt_s, iy - ki[1] * ey * dt_s, iyaw - ki[2] * eyaw * dt_s)
        forward = feedforward(int(parameters["DP_FF_KIND"]), self._config, setpoint, turn)
        return Wrench(
            forward.surge_n - kp[0] * ex + ix - kd[0] * (nav.surge_mps - u),
            forward.sway_n - kp[1] * ey + iy - kd[1] * (nav.sway_mps - v),
            forward.yaw_nm - kp[2] * eyaw + iyaw - kd[2] * (nav.yaw_rate_radps - setpoint.yaw_rate_radps),
        )
