"""The stick's force in Heading, limited so that the boat keeps to a speed limit."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from companion.config.vessel import VesselConfig
from companion.control.model import damping
from companion.core.estimate import NavState
from companion.core.frames import body_to_ned, ned_to_body
from companion.core.setpoint import HeadingSetpoint
from companion.params.store import Parameters

_LONGEST_GAP_S = 0.5  # between two calls: after a longer one the integral begins anew


class StickLimit(NamedTuple):
    """The highest speed over ground along `way`, a unit vector (NED), and the deceleration that keeps to it as it
    falls."""

    way: tuple[float, float]
    speed_mps: float
    braking_mps2: float = 0.0


class StickGovernor:
    """Proportional to the speed that the limit leaves, with drag fed forward and an integral against wind and current.

    With the proportional part alone a wind of 5 m/s astern moves a boat that is told to stop at 0.02 m/s, without end.
    Remembers the force that pushes the boat over the limit (NED), and when it was called last.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._hull = config.hull
        self._limits = config.limits
        self._parameters = parameters
        self._pushed_ned_n = (0.0, 0.0)
        self._then_s = -math.inf

    def limited(
        self, setpoint: HeadingSetpoint, nav: NavState, limits: Sequence[StickLimit], now_s: float
    ) -> HeadingSetpoint:
        """The setpoint, with what pushes it and at most the force m (2ω (v_lim − v) − a) + D(v_lim) − pushed along the
        way of each limit. The force across it stays.

        A boat without sideways thrust is limited along its hull: in the direction of the force, at none in that of the
        motion. ω is PATH_BW_SURGE; `pushed` is the integral of m ω² (v − v_lim), which makes both poles −ω: wind that
        the error of the modelled drag hides shows while the boat slows down, and is to be learnt on the last metres. It
        is cleared where no limit is finite.
        """
        dt_s, self._then_s = now_s - self._then_s, now_s
        limits = [limit for limit in limits if math.isfinite(limit.speed_mps)]
        if not 0.0 <= dt_s <= _LONGEST_GAP_S or not limits:
            self._pushed_ned_n, dt_s = (0.0, 0.0), 0.0
        for limit in limits:
            setpoint = self._within(limit, setpoint, nav, dt_s)
        return setpoint

    def _within(self, limit: StickLimit, setpoint: HeadingSetpoint, nav: NavState, dt_s: float) -> HeadingSetpoint:
        wrench, hull, bandwidth = setpoint.wrench, self._hull, self._parameters["PATH_BW_SURGE"]
        x, y = self._along(setpoint, nav, limit.way)
        north, east = body_to_ned(x, y, nav.yaw_rad)
        mass = hull.m11_kg * x * x + hull.m22_kg * y * y
        slack_mps = limit.speed_mps - (x * nav.surge_mps + y * nav.sway_mps)
        known_n = north * self._pushed_ned_n[0] + east * self._pushed_ned_n[1]
        pushed_n = max(0.0, known_n)
        drag_x, drag_y, _ = damping(hull, limit.speed_mps * x, limit.speed_mps * y, 0.0)
        most_n = mass * (2.0 * bandwidth * slack_mps - limit.braking_mps2) + x * drag_x + y * drag_y - pushed_n
        over_n = x * wrench.surge_n + y * wrench.sway_n - most_n
        rate = -mass * bandwidth**2 * slack_mps if over_n > 0.0 else -0.5 * bandwidth * pushed_n
        strongest_n = math.hypot(x * self._limits.surge_n, y * self._limits.sway_n)
        learnt_n = min(strongest_n, max(0.0, pushed_n + rate * dt_s)) - known_n
        self._pushed_ned_n = self._pushed_ned_n[0] + learnt_n * north, self._pushed_ned_n[1] + learnt_n * east
        if over_n <= 0.0:
            return setpoint
        governed = replace(wrench, surge_n=wrench.surge_n - over_n * x, sway_n=wrench.sway_n - over_n * y)
        return replace(setpoint, wrench=governed, pushed_ned_n=(pushed_n * north, pushed_n * east))

    def _along(self, setpoint: HeadingSetpoint, nav: NavState, way: tuple[float, float]) -> tuple[float, float]:
        """The unit vector in body axes along which the force is limited."""
        if self._limits.sway_n > 0.0:
            return ned_to_body(*way, nav.yaw_rad)
        return math.copysign(1.0, setpoint.wrench.surge_n or nav.surge_mps), 0.0
