"""Holding inside a circle with little thrust variation: how firmly dynamic positioning has to act (green DP).

The mean force of wind and current must be given in any case, and a constant thrust gives it at least energy: power
grows as |F|^1.5, so that every variation about the mean costs more. What can be saved is the answer to gusts and to the
noise of the estimate, while the boat will stay inside the circle without it (Hvamb 2001, A new concept for
fuel-tight DP control).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.config.vessel import VesselConfig
from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.core.frames import ned_to_body
from companion.core.setpoint import PoseSetpoint

_SOFT = 0.2  # of the bandwidth, deep inside the circle
_SOFT_YAW = 0.4
_NEAR_SHARE, _EDGE_SHARE = 0.3, 0.75  # of the circle: where the law begins to firm up, and where it is whole
_MOST_OFF_RAD = math.radians(8.0)  # what the circle is for the position, for the heading
_SIGMAS = 2.0  # of the position's accuracy, by which the circle is smaller
_ANSWER = 1.5  # time for the whole law to answer, over its bandwidth
_RESERVE_SHARE = 0.9  # of the limits
_LEAST_RESERVE_SHARE = 0.1
_CHANGE_S = 1.5  # smooths the acceleration
_RELAX_S = 15.0  # time constant with which the law softens; it firms up at once
_WIND_S = 60.0  # of the mean wind


@dataclass(frozen=True, slots=True)
class Firmness:
    """Share of the bandwidth to use, of the position and of the heading; 1: the whole law."""

    place: float = 1.0
    yaw: float = 1.0


WHOLE = Firmness()


class Economy:
    """`update` every cycle → Firmness. Remembers the last one, and the velocity and its change over ground."""

    def __init__(self, config: VesselConfig) -> None:
        self._hull = config.hull
        self._limits = config.limits
        self.restart()

    def restart(self) -> None:
        """Begin with the whole law."""
        self._last = WHOLE
        self._velocity: tuple[float, float] | None = None
        self._change = (0.0, 0.0)

    def update(
        self,
        setpoint: PoseSetpoint,
        nav: NavState,
        bias: tuple[float, float, float],
        bandwidth_radps: float,
        dt_s: float,
    ) -> Firmness:
        """`bias`: the steady force and moment that the law counters, in body axes. `bandwidth_radps`: that of the whole
        law, on the slower of surge and sway."""
        self._see_change(nav, dt_s)
        circle_m = setpoint.circle_m - _SIGMAS * nav.position_accuracy_m
        if not circle_m > 0.0 or _moves(setpoint):
            self._last = WHOLE
            return WHOLE
        answer_s = _ANSWER / bandwidth_radps
        used = self._furthest_m(setpoint, nav, bias, answer_s) / circle_m
        turned = abs(wrap_pi(nav.yaw_rad - setpoint.yaw_rad + nav.yaw_rate_radps * answer_s)) / _MOST_OFF_RAD
        relax = dt_s / (dt_s + _RELAX_S)
        self._last = Firmness(
            _relaxed(self._last.place, _firm(used, _SOFT), relax),
            _relaxed(self._last.yaw, _firm(turned, _SOFT_YAW), relax),
        )
        return self._last

    def _see_change(self, nav: NavState, dt_s: float) -> None:
        velocity = (nav.north_mps, nav.east_mps)
        before, self._velocity = self._velocity, velocity
        if before is None or dt_s <= 0.0:
            self._change = (0.0, 0.0)
            return
        share = dt_s / (dt_s + _CHANGE_S)
        north, east = self._change
        self._change = (
            north + share * ((velocity[0] - before[0]) / dt_s - north),
            east + share * ((velocity[1] - before[1]) / dt_s - east),
        )

    def _furthest_m(
        self, setpoint: PoseSetpoint, nav: NavState, bias: tuple[float, float, float], answer_s: float
    ) -> float:
        """Largest distance from the setpoint, now and until the whole law has answered and stopped the boat, if thrust
        stays as it is."""
        horizon_s = answer_s + self._stopping_s(nav, bias)
        north_m, east_m = nav.north_m - setpoint.north_m, nav.east_m - setpoint.east_m
        furthest_m = math.hypot(north_m, east_m)
        for t_s in (0.5 * horizon_s, horizon_s):
            half = 0.5 * t_s * t_s
            furthest_m = max(
                furthest_m,
                math.hypot(
                    north_m + nav.north_mps * t_s + self._change[0] * half,
                    east_m + nav.east_mps * t_s + self._change[1] * half,
                ),
            )
        return furthest_m

    def _stopping_s(self, nav: NavState, bias: tuple[float, float, float]) -> float:
        """Half of the time to stop with the thrust that the mean force leaves, on the slower axis: the mean speed
        meanwhile is half of the present."""
        hull, limits = self._hull, self._limits
        u, v = ned_to_body(nav.north_mps, nav.east_mps, nav.yaw_rad)
        surge_n = max(_LEAST_RESERVE_SHARE * limits.surge_n, _RESERVE_SHARE * limits.surge_n - abs(bias[0]))
        sway_n = max(_LEAST_RESERVE_SHARE * limits.sway_n, _RESERVE_SHARE * limits.sway_n - abs(bias[1]))
        return 0.5 * max(abs(u) * hull.m11_kg / surge_n, abs(v) * hull.m22_kg / sway_n)


class MeanForce:
    """A force and moment in body axes, smoothed. Remembers the mean."""

    def __init__(self) -> None:
        self._mean: tuple[float, float, float] | None = None

    def restart(self) -> None:
        """Forget the mean."""
        self._mean = None

    def update(self, force: tuple[float, float, float], firmness: Firmness, dt_s: float) -> tuple[float, float, float]:
        """The mean, and of what `force` is beyond it the share that the law is firm by."""
        if self._mean is None:
            self._mean = force
        part = dt_s / (dt_s + _WIND_S)
        x, y, n = (mean + part * (new - mean) for mean, new in zip(self._mean, force, strict=True))
        self._mean = (x, y, n)
        if firmness == WHOLE:
            return force
        place, yaw = firmness.place, firmness.yaw
        return x + place * (force[0] - x), y + place * (force[1] - y), n + yaw * (force[2] - n)


def _moves(setpoint: PoseSetpoint) -> bool:
    return setpoint.surge_mps != 0.0 or setpoint.sway_mps != 0.0


def _firm(used: float, soft: float) -> float:
    """Share of the bandwidth where so much of the room is used."""
    x = min(1.0, max(0.0, (used - _NEAR_SHARE) / (_EDGE_SHARE - _NEAR_SHARE)))
    return soft + (1.0 - soft) * x * x * (3.0 - 2.0 * x)


def _relaxed(last: float, now: float, share: float) -> float:
    return now if now >= last else last + share * (now - last)
