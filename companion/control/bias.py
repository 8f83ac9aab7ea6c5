"""Integral action of all control laws: the steady force on the hull that the model does not explain (current, mean
wind, model error)."""

from __future__ import annotations

import math

from companion.config.vessel import LimitsConfig
from companion.core.actuation import Wrench
from companion.core.angles import wrap_pi
from companion.core.dead_zone import beyond_dead_zone
from companion.core.frames import body_to_ned, ned_to_body

_SHARE = 0.9  # of the limits: the most that the bias may take
_DEAD_SHARE = 0.01  # of the limits: a smaller shortfall is not saturation
_UNWIND_RADPS = 0.5
_BOW_SHARE = 0.25  # of what weather pushes the side with: what it pushes the bow with


class BiasForce:
    """A force in north and east and a moment, to add to the demanded wrench. The force stays fixed in NED while the
    boat turns. All laws share one bias, so that a change of law causes no bump.

    Of a boat without sideways thrust under way it turns with the boat: there it is mostly the model's error of the
    drag. With one that keeps a place (`keeps_across`) it stays in NED too: there it is wind.
    """

    __slots__ = ("_east_n", "_limits", "_most_nm", "_north_n", "_yaw_nm", "keeps_across")

    def __init__(self, limits: LimitsConfig, most_nm: float | None = None) -> None:
        """`most_nm`: the largest moment under way; None: `limits.yaw_nm`."""
        self._limits = limits
        self._most_nm = limits.yaw_nm if most_nm is None else most_nm
        self.keeps_across = False
        self.reset()

    def reset(self) -> None:
        """Set the bias to zero."""
        self._north_n = self._east_n = self._yaw_nm = 0.0

    def in_body(self, yaw_rad: float) -> tuple[float, float, float]:
        """The bias as (surge_n, sway_n, yaw_nm)."""
        x, y = ned_to_body(self._north_n, self._east_n, yaw_rad)
        return x, y, self._yaw_nm

    def grow(self, surge_nps: float, sway_nps: float, yaw_nmps: float, yaw_rad: float, dt_s: float) -> None:
        """Integrate rates in body axes (N/s, N/s, Nm/s) over `dt_s`, within the limits."""
        x, y = ned_to_body(self._north_n, self._east_n, yaw_rad)
        limits = self._limits
        across_n = limits.surge_n if self.keeps_across and limits.sway_n <= 0.0 else limits.sway_n
        bound_x, bound_y, bound_n = _SHARE * limits.surge_n, _SHARE * across_n, _SHARE * self._most_nm
        x = min(bound_x, max(-bound_x, x + surge_nps * dt_s))
        y = min(bound_y, max(-bound_y, y + sway_nps * dt_s))
        self._north_n, self._east_n = body_to_ned(x, y, yaw_rad)
        self._yaw_nm = min(bound_n, max(-bound_n, self._yaw_nm + yaw_nmps * dt_s))

    def add(self, surge_n: float, sway_n: float, yaw_nm: float, yaw_rad: float) -> None:
        """Take over a force and moment in body axes that another part has given until now, within the limits."""
        self.grow(surge_n, sway_n, yaw_nm, yaw_rad, 1.0)

    def turn(self, from_rad: float, to_rad: float) -> None:
        """The boat has turned its bow to the weather, a little: what pushed its side does not push its bow as hard.
        Kept whole, it would drive the boat past its point, against the weather. On an ellipse in place of a circle,
        but nothing grows by more than it would on the circle."""
        x, y = ned_to_body(self._north_n, self._east_n, from_rad)
        turned = wrap_pi(to_rad - from_rad)
        from_bow = -x * turned
        if from_bow * y < 0.0:
            from_bow = _given_back(y, from_bow / _BOW_SHARE) - y
        self._north_n, self._east_n = body_to_ned(x + _BOW_SHARE * y * turned, y + from_bow, to_rad)

    def take(self, along_n: float, north: float, east: float, yaw_rad: float) -> None:
        """Take over what another law has learnt along a unit vector (NED), within the limits."""
        x, y = ned_to_body(north, east, yaw_rad)
        bound = _SHARE * math.hypot(x * self._limits.surge_n, y * self._limits.sway_n)
        change = min(bound, max(-bound, along_n)) - (north * self._north_n + east * self._east_n)
        self._north_n += change * north
        self._east_n += change * east

    def unwind(self, demanded: Wrench, achieved: Wrench, yaw_rad: float, dt_s: float) -> None:
        """Reduce the bias by what the thrusters could not give in the last cycle: anti-windup by back-calculation. It
        ends at zero, so that saturation in a hard turn never leaves a bias of the other sign."""
        limits = self._limits
        x, y, n = self.in_body(yaw_rad)
        step = _UNWIND_RADPS * dt_s
        x = _given_back(x, step * beyond_dead_zone(achieved.surge_n - demanded.surge_n, _DEAD_SHARE * limits.surge_n))
        y = _given_back(y, step * beyond_dead_zone(achieved.sway_n - demanded.sway_n, _DEAD_SHARE * limits.sway_n))
        self._north_n, self._east_n = body_to_ned(x, y, yaw_rad)
        self._yaw_nm = _given_back(
            n, step * beyond_dead_zone(achieved.yaw_nm - demanded.yaw_nm, _DEAD_SHARE * limits.yaw_nm)
        )


def _given_back(bias: float, change: float) -> float:
    if bias * change >= 0.0:
        return bias
    return math.copysign(max(0.0, abs(bias) - abs(change)), bias)
