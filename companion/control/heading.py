"""Yaw loop of a boat under way: PD with feed-forward, and the moment's share of the bias."""

from __future__ import annotations

import math

from companion.config import VesselConfig
from companion.control.bias import BiasForce
from companion.control.dynamic_positioning import pole_placement
from companion.control.model import coriolis, damping
from companion.core.angles import wrap_pi
from companion.core.types import NavState, Setpoint, Wrench
from companion.params import Parameters

_DAMPING = 0.9
_INTEGRAL_SHARE = 0.1
_SWING_SHARE = 0.6  # of a nozzle's way to its stop: so far it gets in 1/bandwidth; where it gets less far, its rate limit makes the loop swing
_LARGE_ERROR_RAD = math.radians(25.0)  # a turn, not an offset to be learnt


class YawLoop:
    """`moment_nm(setpoint, nav, bias, dt_s)`. Remembers nothing itself. Beyond _LARGE_ERROR_RAD the boat turns at a steady rate.

    Its bandwidth is PATH_BW_YAW, or as much as a jet's nozzle can follow at the rate that the vessel's file says."""

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._hull = config.hull
        self._most_radps = _followed_radps(config)
        self._parameters = parameters

    def moment_nm(self, setpoint: Setpoint, nav: NavState, bias: BiasForce, dt_s: float) -> float:
        """Moment that holds `setpoint.yaw_rad`, turning at `setpoint.yaw_rate_radps`."""
        hull = self._hull
        rate = setpoint.yaw_rate_radps
        error = 0.0 if setpoint.yaw_rad is None else wrap_pi(nav.yaw_rad - setpoint.yaw_rad)
        ahead = abs(nav.surge_mps)
        resisting = hull.damping.n_r + hull.damping.n_ur * ahead
        bandwidth = min(self._parameters["PATH_BW_YAW"], self._most_radps)
        kp, ki, kd = pole_placement(hull.m33_kgm2, resisting, bandwidth, _DAMPING, _INTEGRAL_SHARE)
        fastest = math.radians(self._parameters["PATH_YAW_RATE"])
        if abs(error) < _LARGE_ERROR_RAD:
            bias.grow(0.0, 0.0, -ki * error, nav.yaw_rad, dt_s)
        bound = kd * fastest / kp
        pull = min(bound, max(-bound, error))
        _, _, drag = damping(hull, ahead, 0.0, rate)
        _, _, munk = coriolis(hull, nav.surge_mps, nav.sway_mps, 0.0)
        munk += hull.damping.n_uv * ahead * nav.sway_mps
        bounded_munk = min(0.25 * kp, max(-0.25 * kp, munk))
        return hull.m33_kgm2 * setpoint.yaw_radps2 + drag + bounded_munk - kp * pull - kd * (nav.yaw_rate_radps - rate) + bias.in_body(nav.yaw_rad)[2]


def _followed_radps(config: VesselConfig) -> float:
    """Bandwidth that the steering can follow in large turns, in rad/s; infinite where it is not a nozzle that turns the boat."""
    jet = config.thrusters[0]
    stops = [abs(stop) for stop in (jet.azimuth_min_rad, jet.azimuth_max_rad) if stop is not None]
    return jet.azimuth_rate_radps / (_SWING_SHARE * max(stops)) if jet.kind == "jet" and stops else math.inf


class HeadingControl:
    """Setpoints of kind HEADING: heading held, surge and sway as the stick asks."""

    def __init__(self, yaw: YawLoop) -> None:
        self._yaw = yaw

    def update(self, setpoint: Setpoint, nav: NavState, bias: BiasForce, dt_s: float) -> Wrench:
        """Wrench with the stick's forces and the yaw loop's moment."""
        stick = setpoint.wrench
        moment = self._yaw.moment_nm(setpoint, nav, bias, dt_s)
        return Wrench(0.0 if stick is None else stick.surge_n, 0.0 if stick is None else stick.sway_n, moment)
