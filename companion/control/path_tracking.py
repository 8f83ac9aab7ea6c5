"""Under way along a path: speed by surge, heading by yaw, and gentle help from sway where the boat has it."""

from __future__ import annotations

from companion.config import VesselConfig
from companion.control.bias import BiasForce
from companion.control.heading import YawLoop
from companion.control.model import coriolis, damping
from companion.core.frames import ned_to_body
from companion.core.types import NavState, Setpoint, Wrench
from companion.params import Parameters

_INTEGRAL_SHARE = 0.25
_SWAY_SHARE = 0.5  # bandwidth of sway as a share of that of surge
_SWAY_LIMIT_SHARE = 0.75  # of the vessel's limit: what sway may ask for while the thrusters have speed and heading to serve
_YAW_RESERVE = 0.4  # share of the yaw limit below whose remainder sway gives way
_LARGE_ERROR_MPS = 0.3  # of speed: being brought up to speed, not an offset to be learnt
_LARGE_ERROR_SHARE = 0.25  # of the cruise speed, where that is more


class PathTracking:
    """Setpoints of kind PATH. Remembers nothing itself; the integral of speed and heading is the `bias` given.

    τ_x = m11 u̇_d + D(u_d) + m11 ω (u_d − u) + bias; τ_y damps the sideways drift towards the setpoint's and carries the boat round bends
    (m11 u r); yaw by `YawLoop`.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters, yaw: YawLoop) -> None:
        self._hull = config.hull
        self._limits = config.limits
        self._parameters = parameters
        self._yaw = yaw

    def update(self, setpoint: Setpoint, nav: NavState, bias: BiasForce, dt_s: float) -> Wrench:
        """Wrench for the speed, heading and turn of the setpoint."""
        hull = self._hull
        bandwidth = self._parameters["PATH_BW_SURGE"]
        u, v, r = setpoint.surge_mps, setpoint.sway_mps, setpoint.yaw_rate_radps
        slow = u - nav.surge_mps
        gain = hull.m11_kg * bandwidth
        drag_x, _, _ = damping(hull, u, v, 0.0)
        _, drag_y, _ = damping(hull, u, self._through_water(v, nav), 0.0)
        offset = abs(slow) < max(_LARGE_ERROR_MPS, _LARGE_ERROR_SHARE * self._parameters["WP_SPEED"])
        growth = _INTEGRAL_SHARE * bandwidth * gain * slow if offset else 0.0
        bias.grow(growth, 0.0, 0.0, nav.yaw_rad, dt_s)
        moment = self._yaw.moment_nm(setpoint, nav, bias, dt_s)
        bias_x, bias_y, _ = bias.in_body(nav.yaw_rad)
        surge = hull.m11_kg * setpoint.surge_mps2 + drag_x + gain * slow + bias_x
        if self._limits.sway_n <= 0.0:
            return Wrench(surge, 0.0, moment)
        _, turning, _ = coriolis(hull, max(0.0, nav.surge_mps), 0.0, r)
        sway = turning + drag_y + hull.m22_kg * _SWAY_SHARE * bandwidth * (v - nav.sway_mps) + bias_y
        return Wrench(surge, self._gentle(sway, moment), moment)

    def _through_water(self, sway_mps: float, nav: NavState) -> float:
        """Sideways speed that has to be paid for: what the current does of it, it does for nothing."""
        if nav.current_north_mps is not None and nav.current_east_mps is not None:
            return sway_mps - ned_to_body(nav.current_north_mps, nav.current_east_mps, nav.yaw_rad)[1]
        bound = self._parameters["DP_SPEED_SWAY"]
        return min(bound, max(-bound, sway_mps))

    def _gentle(self, sway_n: float, moment_nm: float) -> float:
        """Sideways help cut to a part of the limit, and given up as the turn needs the same thrusters."""
        spare = min(1.0, max(0.0, (1.0 - abs(moment_nm) / self._limits.yaw_nm) / _YAW_RESERVE))
        bound = _SWAY_LIMIT_SHARE * self._limits.sway_n * spare
        return min(bound, max(-bound, sway_n))
