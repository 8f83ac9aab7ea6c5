"""What wind and current push a boat with that lies adrift, before positioning takes it up. Its integral would take half
a minute to learn that, while the boat lies behind its reference."""

from __future__ import annotations

import math

from companion.config.hull import HullConfig
from companion.control.model import damping
from companion.core.actuation import ZERO_WRENCH, Wrench
from companion.core.estimate import NavState, without_waves
from companion.core.frames import body_to_ned

_MEAN_S = 8.0
_LEAST_S = 4.0
_GAP_S = 1.0


class FreeDrift:
    """`see(nav, achieved, dt_s)` every tick adrift; `push` at the end of it.

    By the momentum of the hull: what sped it up, and the water's drag on its motion. Of a boat that the weather carries
    steadily, that is the drag at its drift. Remembers the mean force, for how long it was taken, and the last momentum
    and time.
    """

    def __init__(self, hull: HullConfig) -> None:
        self._hull = hull
        self.forget()

    def forget(self) -> None:
        """Begin anew with the next `see`."""
        self._restart(-math.inf)

    def _restart(self, t_s: float) -> None:
        self._mean = (0.0, 0.0)
        self._momentum: tuple[float, float] | None = None
        self._taken_s, self._t_s = 0.0, t_s

    def see(self, nav: NavState, achieved: Wrench, dt_s: float) -> None:
        """`achieved`: what the thrusters gave in the last cycle, of `dt_s`. After any thrust, a gap, or without a valid
        estimate, the mean begins anew."""
        if nav.t_s - self._t_s > _GAP_S or not nav.position_valid or achieved != ZERO_WRENCH:
            self._restart(nav.t_s)
        self._t_s = nav.t_s
        if dt_s <= 0.0 or not nav.position_valid:
            return
        nav, hull = without_waves(nav), self._hull
        x, y, _ = damping(hull, nav.surge_mps, nav.sway_mps, 0.0)
        north, east = body_to_ned(x, y, nav.yaw_rad)
        momentum = body_to_ned(hull.m11_kg * nav.surge_mps, hull.m22_kg * nav.sway_mps, nav.yaw_rad)
        before = momentum if self._momentum is None else self._momentum
        self._momentum = momentum
        north, east = north + (momentum[0] - before[0]) / dt_s, east + (momentum[1] - before[1]) / dt_s
        self._taken_s += dt_s
        share = dt_s / min(_MEAN_S, self._taken_s)
        self._mean = self._mean[0] + share * (north - self._mean[0]), self._mean[1] + share * (east - self._mean[1])

    def push(self, t_s: float) -> tuple[float, float] | None:
        """(north, east) in N at the time `t_s`; None where it was not seen until just before, and for some seconds."""
        return self._mean if t_s - self._t_s <= _GAP_S and self._taken_s >= _LEAST_S else None
