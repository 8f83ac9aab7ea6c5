"""The stick's surge force in Heading, limited so that the boat keeps to a speed limit."""

from __future__ import annotations

import math
from dataclasses import replace

from companion.config.vessel import VesselConfig
from companion.control.model import damping
from companion.core.estimate import NavState
from companion.core.setpoint import HeadingSetpoint
from companion.params.store import Parameters

_LONGEST_GAP_S = 0.5  # between two calls: after a longer one the integral begins anew


class SurgeGovernor:
    """Proportional to the speed that the limit leaves, with drag fed forward and an integral against wind and current.

    With the proportional part alone a wind of 5 m/s astern moves a boat that is told to stop at 0.02 m/s, without end.
    Remembers the force that pushes the boat over the limit, positive ahead, and when it was called last.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._hull = config.hull
        self._strongest_n = config.limits.surge_n
        self._parameters = parameters
        self._pushed_n = 0.0
        self._then_s = -math.inf

    def limited(
        self, setpoint: HeadingSetpoint, nav: NavState, limit_mps: float, braking_mps2: float, now_s: float
    ) -> HeadingSetpoint:
        """The setpoint, with what pushes it and at most the surge force m11 (2ω (u_lim − u) − a) + X(u_lim) − pushed.

        The limit counts in the direction of the force, at none in that of the motion. ω is PATH_BW_SURGE; `pushed` is
        the integral of m11 ω² (u − u_lim), which makes both poles −ω: wind that the error of the modelled drag hides
        shows while the boat slows down, and is to be learnt on the last metres. An infinite limit clears it.
        """
        dt_s, self._then_s = now_s - self._then_s, now_s
        if not 0.0 <= dt_s <= _LONGEST_GAP_S or math.isinf(limit_mps):
            self._pushed_n = dt_s = 0.0
        if math.isinf(limit_mps):
            return setpoint
        wrench, mass, bandwidth = setpoint.wrench, self._hull.m11_kg, self._parameters["PATH_BW_SURGE"]
        sign = math.copysign(1.0, wrench.surge_n or nav.surge_mps)
        slack_mps = limit_mps - sign * nav.surge_mps
        pushed_n = sign * self._pushed_n
        drag_n, _, _ = damping(self._hull, limit_mps, 0.0, 0.0)
        most_n = mass * (2.0 * bandwidth * slack_mps - braking_mps2) + drag_n - pushed_n
        governed = sign * wrench.surge_n > most_n
        rate = -mass * bandwidth**2 * slack_mps if governed else -0.5 * bandwidth * pushed_n
        self._pushed_n = sign * min(self._strongest_n, max(0.0, pushed_n + rate * dt_s))
        if not governed:
            return setpoint
        return replace(setpoint, wrench=replace(wrench, surge_n=sign * most_n), pushed_n=sign * pushed_n)
