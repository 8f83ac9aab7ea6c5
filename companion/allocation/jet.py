"""Thrust allocation of a water jet: surge and yaw → throttle and nozzle.

The nozzle deflects the thrust T to T (cos δ, sin δ) at x from the boat's origin, so that N = x T sin δ. Surge demands
T, yaw demands a force across of N / x. Without thrust the nozzle does not steer: if the thrust for surge cannot give
the yaw moment within the nozzle's stops, it is raised to at most JET_STEER_N, or the hull's drag at its speed; to some
times JET_STEER_N where that has long been too little to one side, because wind holds the bow.
"""

from __future__ import annotations

import math

from companion.allocation.jet_curve import JetCurve
from companion.allocation.steered import SteeredAllocator
from companion.config.vessel import VesselConfig
from companion.core.actuation import Allocation, ThrusterCommand, Wrench
from companion.core.estimate import NavState, Rig
from companion.params.store import Parameters

_START_SHARE = 0.6  # of the impeller's least thrust: a larger demand starts it
_STOP_SHARE = 0.25  # of the impeller's least thrust: a smaller demand stops it
_LEAST_THRUST_N = 1.0
# JET_STEER_N suffices for turns in the first time. After it the thrust grows by as much again in each of the second, to
# at most six times as much: the nozzle may be stuck. Slower, the boat gathers way across the wind before it turns.
_TURN_S, _MORE_S, _MOST = 3.0, 2.0, 6.0


def steering_thrust_n(usual_n: float, short_s: float) -> float:
    """The thrust in N that may be given for steering once JET_STEER_N, `usual_n`, has been too little for so long."""
    if short_s <= _TURN_S:
        return usual_n
    return usual_n * min(_MOST, 1.0 + (short_s - _TURN_S) / _MORE_S)


class JetAllocator(SteeredAllocator):
    """Wrench → Allocation, by the inverse of the jet's thrust curve at the present speed.

    The throttle rises no faster than the vessel's force rate at rest; the nozzle keeps its rate and its stops.
    Remembers the throttle, the nozzle's angle, how long the thrust for steering has been too little and to which side,
    and whether the jet has failed.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        super().__init__(config, parameters)
        self._curve = JetCurve(self._thruster)
        self._hull = config.hull
        self._throttle = 0.0
        self._short_s = 0.0
        self._across_n = 0.0

    def feel(self, rig: Rig | None, nav: NavState) -> None:
        """No effect."""

    def neutral(self) -> Allocation:
        """Stop the impeller; the nozzle stays where it is."""
        self._throttle = self._short_s = 0.0
        return self._result(None, 0.0)

    def _take_throttle(self, throttle: float, dt_s: float) -> None:
        self._open(max(0.0, throttle), dt_s)

    def _serve(self, wrench: Wrench, dt_s: float, surge_mps: float) -> None:
        across_n = wrench.yaw_nm / self._thruster.x_m
        stop_rad = self._high_rad if across_n >= 0.0 else -self._low_rad
        if across_n * self._across_n < 0.0:  # wind holds the bow to one side alone
            self._short_s = 0.0
        self._across_n = across_n
        steering_n = self._steering_n(abs(across_n) / math.sin(stop_rad), wrench.surge_n, surge_mps, dt_s)
        thrust_n = max(math.hypot(max(0.0, wrench.surge_n), across_n) if wrench.surge_n > 0.0 else 0.0, steering_n)
        self._open(self._wanted(thrust_n, surge_mps), dt_s)
        given_n = self._curve.thrust_n(self._throttle, surge_mps)
        if given_n > _LEAST_THRUST_N:
            self._steer(math.asin(min(1.0, max(-1.0, across_n / given_n))), dt_s)

    def _steering_n(self, wanted_n: float, surge_n: float, surge_mps: float, dt_s: float) -> float:
        """The thrust for steering, of that with which the nozzle at its stop would give the moment. What the water
        takes at the present speed lets the boat gather no way."""
        usual_n, drag_n = self._parameters["JET_STEER_N"], self._hull.drag_n(max(0.0, surge_mps))
        short = wanted_n > max(usual_n, drag_n, surge_n)
        self._short_s = max(0.0, self._short_s + (dt_s if short else -dt_s))
        self._short_s = min(self._short_s, _TURN_S + (_MOST - 1.0) * _MORE_S)
        return min(wanted_n, max(steering_thrust_n(usual_n, self._short_s), drag_n))

    def _wanted(self, thrust_n: float, surge_mps: float) -> float:
        """The throttle for a thrust: 0, or at least the one at which the impeller turns; between them with
        hysteresis."""
        least = max(self._curve.least, self._parameters["JET_MIN_THR"])
        first_n = self._curve.thrust_n(least, surge_mps)
        share = _STOP_SHARE if self._throttle > 0.0 else _START_SHARE
        if first_n > 0.0 and thrust_n < share * first_n:
            return 0.0
        return max(least, self._curve.throttle(thrust_n, surge_mps)) if thrust_n > 0.0 else 0.0

    def _open(self, throttle: float, dt_s: float) -> None:
        """Move towards that throttle, up no faster than the force at rest may rise, down at once."""
        if self._failed or throttle < self._curve.least:
            self._throttle = 0.0
            return
        force_n = self._curve.thrust_n(
            max(self._throttle, self._curve.least), 0.0
        ) + self._thruster.force_rate_nps * max(0.0, dt_s)
        self._throttle = min(throttle, self._curve.most, self._curve.throttle(force_n, 0.0))

    def _result(self, demanded: Wrench | None, surge_mps: float) -> Allocation:
        thrust_n = self._curve.thrust_n(self._throttle, surge_mps)
        x, y = thrust_n * math.cos(self._angle_rad), thrust_n * math.sin(self._angle_rad)
        command = ThrusterCommand(thrust_n, self._throttle, self._angle_rad)
        return self._given(demanded, (command,), Wrench(x, y, self._thruster.x_m * y))
