"""Where the weather comes from, by the force that would keep the boat at rest against it: from what its thrusters gave
and how it moved.

A boat that is driven off its point asks for far more: for the way back, and against its drift. Towards that force it
would turn its bow past the weather, and be driven off on the other side. So it would towards the force at rest: weather
on the bow pushes a hull mostly sideways. Its mean would change as the bow turns, and lag behind.
"""

from __future__ import annotations

import math

from companion.config.hull import HullConfig
from companion.control.model import damping
from companion.core.actuation import Wrench
from companion.core.estimate import NavState, without_waves
from companion.core.frames import body_to_ned, ned_to_body

_MEAN_S = 10.0  # which the turn of the bow must not outrun
_GAP_S = 1.0
# How much harder weather pushes on the side than on the bow: wind about so much, waves more, wind and current together
# may less. Any figure has the bow in the weather in the end. With 1 the bow swung 40° to either side of waves for good;
# with 8 ReVolt came round so slowly that wind and current carried it 5 m off meanwhile.
ON_THE_SIDE = 3.0


class WeatherForce:
    """`see(nav, achieved, dt_s)` every tick; `into` points into the weather.

    By the momentum of the hull: what the thrusters gave, less what sped the boat up, less the water's drag on its
    drift, which it has not at rest. The part from the side counts for as much as it would be on the bow, so that the
    mean is the same on every heading. Remembers the mean, for how long it was taken, and the last momentum and time.
    """

    def __init__(self, hull: HullConfig) -> None:
        self._hull = hull
        self.restart()

    def restart(self) -> None:
        """Take the mean anew."""
        self._into = (0.0, 0.0)
        self._momentum: tuple[float, float] | None = None
        self._taken_s = 0.0
        self._t_s = -math.inf

    @property
    def into(self) -> tuple[float, float] | None:
        """(north, east) in N into the weather, as long as the mean force that would hold the boat bow on; None until it
        has been taken for some seconds."""
        return self._into if self._taken_s >= 0.5 * _MEAN_S else None

    def see(self, nav: NavState, achieved: Wrench, dt_s: float) -> None:
        """`achieved`: what the thrusters gave in the last cycle, of `dt_s`. After a gap the mean begins anew."""
        if dt_s <= 0.0:
            return
        if nav.t_s - self._t_s > _GAP_S:
            self.restart()
        self._t_s = nav.t_s
        nav, hull = without_waves(nav), self._hull
        x, y = ned_to_body(nav.current_north_mps or 0.0, nav.current_east_mps or 0.0, nav.yaw_rad)
        now_x, now_y, _ = damping(hull, nav.surge_mps - x, nav.sway_mps - y, 0.0)
        rest_x, rest_y, _ = damping(hull, -x, -y, 0.0)
        held = body_to_ned(achieved.surge_n - now_x + rest_x, achieved.sway_n - now_y + rest_y, nav.yaw_rad)
        momentum = body_to_ned(hull.m11_kg * nav.surge_mps, hull.m22_kg * nav.sway_mps, nav.yaw_rad)
        self._taken_s += dt_s
        share = dt_s / min(_MEAN_S, self._taken_s)
        before = momentum if self._momentum is None else self._momentum
        gained = momentum[0] - before[0], momentum[1] - before[1]
        self._momentum = momentum
        force = ned_to_body(held[0] - gained[0] / dt_s, held[1] - gained[1] / dt_s, nav.yaw_rad)
        north, east = body_to_ned(force[0], force[1] / ON_THE_SIDE, nav.yaw_rad)
        self._into = self._into[0] + share * (north - self._into[0]), self._into[1] + share * (east - self._into[1])
