"""Thrust allocation of a water jet: surge and yaw → throttle and nozzle.

The nozzle deflects the thrust T to T (cos δ, sin δ) at x from the boat's origin, so that N = x T sin δ. Surge demands
T, yaw demands a force across of N / x. Without thrust the nozzle does not steer: if the thrust for surge cannot give
the yaw moment within the nozzle's stops, it is raised to at most JET_STEER_N.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.allocation.jet_curve import JetCurve
from companion.config.vessel import VesselConfig
from companion.core.actuation import Allocation, ThrusterCommand, Wrench
from companion.params.store import Parameters

_LIMITED_SHARE = 0.01  # shortfall, as a share of the axis's limit, from which an axis counts as limited
_START_SHARE = 0.6  # of the impeller's least thrust: a larger demand starts it
_STOP_SHARE = 0.25  # of the impeller's least thrust: a smaller demand stops it
_LEAST_THRUST_N = 1.0


class JetAllocator:
    """Wrench → Allocation, by the inverse of the jet's thrust curve at the present speed.

    The throttle rises no faster than the vessel's force rate at rest; the nozzle keeps its rate and its stops.
    Remembers the throttle, the nozzle's angle, and whether the jet has failed.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        (thruster,) = config.thrusters
        self._thruster = thruster
        self._parameters = parameters
        self._curve = JetCurve(thruster)
        self._low_rad, self._high_rad = thruster.azimuth_min_rad or 0.0, thruster.azimuth_max_rad or 0.0
        self._limits = config.limits
        self._period_s = 1.0 / config.control_rate_hz
        self._throttle = 0.0
        self._nozzle_rad = 0.0
        self._failed = False

    def set_failed(self, index: int, failed: bool) -> None:
        """Mark the jet (index 0) as failed or not. A failed jet gives nothing."""
        if index == 0:
            self._failed = failed

    def neutral(self) -> Allocation:
        """Stop the impeller; the nozzle stays where it is."""
        self._throttle = 0.0
        return self._result(None, 0.0)

    def direct(
        self, thrusters: Sequence[ThrusterCommand], dt_s: float | None = None, surge_mps: float = 0.0
    ) -> Allocation:
        """Take throttle and nozzle as demanded, within limits and rates over `dt_s` (None: one control period): the
        manual path."""
        dt_s = self._period_s if dt_s is None else dt_s
        command = thrusters[0] if thrusters else None
        throttle = command.throttle if command is not None and math.isfinite(command.throttle) else 0.0
        if command is not None and command.azimuth_rad is not None and math.isfinite(command.azimuth_rad):
            self._steer(command.azimuth_rad, dt_s)
        self._open(max(0.0, throttle), dt_s)
        return self._result(None, surge_mps)

    def update(self, wrench: Wrench, dt_s: float, surge_mps: float = 0.0) -> Allocation:
        """Throttle and nozzle for surge and yaw; a jet cannot give sway. `surge_mps`: speed ahead through the water. A
        non-finite input counts as no demand."""
        if not all(map(math.isfinite, (wrench.surge_n, wrench.sway_n, wrench.yaw_nm, surge_mps))):
            wrench, surge_mps = Wrench(0.0, 0.0, 0.0), 0.0
        across_n = wrench.yaw_nm / self._thruster.x_m
        stop_rad = self._high_rad if across_n >= 0.0 else -self._low_rad
        steering_n = min(abs(across_n) / math.sin(stop_rad), self._parameters["JET_STEER_N"])
        thrust_n = max(math.hypot(max(0.0, wrench.surge_n), across_n) if wrench.surge_n > 0.0 else 0.0, steering_n)
        self._open(self._wanted(thrust_n, surge_mps), dt_s)
        given_n = self._curve.thrust_n(self._throttle, surge_mps)
        if given_n > _LEAST_THRUST_N:
            self._steer(math.asin(min(1.0, max(-1.0, across_n / given_n))), dt_s)
        return self._result(wrench, surge_mps)

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

    def _steer(self, nozzle_rad: float, dt_s: float) -> None:
        reach = self._thruster.azimuth_rate_radps * max(0.0, dt_s)
        held = min(self._high_rad, max(self._low_rad, math.remainder(nozzle_rad, math.tau)))
        self._nozzle_rad = min(self._nozzle_rad + reach, max(self._nozzle_rad - reach, held))

    def _result(self, demanded: Wrench | None, surge_mps: float) -> Allocation:
        thrust_n = self._curve.thrust_n(self._throttle, surge_mps)
        x, y = thrust_n * math.cos(self._nozzle_rad), thrust_n * math.sin(self._nozzle_rad)
        achieved = Wrench(x, y, self._thruster.x_m * y)
        commands = (ThrusterCommand(thrust_n, self._throttle, self._nozzle_rad),)
        if demanded is None:
            return Allocation(commands, achieved, (False, False, False))
        limited = (
            abs(demanded.surge_n - x) > _LIMITED_SHARE * self._limits.surge_n,
            False,
            abs(demanded.yaw_nm - achieved.yaw_nm) > _LIMITED_SHARE * self._limits.yaw_nm,
        )
        return Allocation(commands, achieved, limited)
