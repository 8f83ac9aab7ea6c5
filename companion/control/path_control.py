"""Control under way along a path: speed by surge, heading by yaw, and some sway force if the boat has it."""

from __future__ import annotations

from companion.config.vessel import VesselConfig
from companion.control.bias import BiasForce
from companion.control.heading import YawLoop
from companion.control.model import coriolis, damping
from companion.core.actuation import Wrench
from companion.core.estimate import NavState
from companion.core.frames import ned_to_body
from companion.core.setpoint import PathSetpoint
from companion.params.store import Parameters

_INTEGRAL_SHARE = 0.25
_SWAY_SHARE = 0.5  # bandwidth of sway as a share of that of surge
_SWAY_LIMIT_SHARE = 0.75  # of the vessel's sway limit: the thrusters must give speed and heading too
_YAW_RESERVE = 0.4  # share of the yaw limit that must be spare for full sway
_LARGE_ERROR_MPS = 0.3  # a larger speed error is an acceleration, not an offset to learn
_LARGE_ERROR_SHARE = 0.25  # the same as a share of WP_SPEED; the larger of both applies


class PathControl:
    """Law for path setpoints. The `bias` given to `update` is the integral of speed and heading. Remembers nothing
    itself.

    τ_x = m11 u̇_d + D(u_d) + m11 ω (u_d − u) + bias; τ_y controls the sideways speed and gives the centripetal force of
    bends (m11 u r); τ_n is that of `YawLoop`.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters, yaw: YawLoop) -> None:
        self._hull = config.hull
        self._limits = config.limits
        self._parameters = parameters
        self._yaw = yaw

    def update(self, setpoint: PathSetpoint, nav: NavState, bias: BiasForce, dt_s: float) -> Wrench:
        """The wrench for the setpoint, before saturation, without the part against the wind."""
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
        """The sideways speed through the water, which costs force; within DP_SPEED_SWAY if no current is known."""
        if nav.current_north_mps is not None and nav.current_east_mps is not None:
            return sway_mps - ned_to_body(nav.current_north_mps, nav.current_east_mps, nav.yaw_rad)[1]
        bound = self._parameters["DP_SPEED_SWAY"]
        return min(bound, max(-bound, sway_mps))

    def _gentle(self, sway_n: float, moment_nm: float) -> float:
        """The sway force within a share of its limit, reduced as the yaw moment needs the same thrusters."""
        spare = min(1.0, max(0.0, (1.0 - abs(moment_nm) / self._limits.yaw_nm) / _YAW_RESERVE))
        bound = _SWAY_LIMIT_SHARE * self._limits.sway_n * spare
        return min(bound, max(-bound, sway_n))
