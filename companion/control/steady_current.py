"""What the current demands of a boat that holds a point: the force and moment of the model in the mean of the estimated
current. Without it the integral alone would have to learn them, which takes a minute after each start.

Where no wind is measured, the estimated current has the wind's push in it. As a stream that would have moments and
forces across that a push has not: then the integral learns all of it."""

from __future__ import annotations

from companion.config.hull import HullConfig
from companion.control.model import in_current
from companion.core.actuation import Wrench
from companion.core.estimate import NavState
from companion.core.frames import ned_to_body

_MEAN_S = 60.0  # slower than the loops, so that what the estimate takes for current comes back to it late


class SteadyCurrent:
    """`update` every cycle, then `demand`. Remembers the mean current and for how long it has been taken."""

    def __init__(self, hull: HullConfig) -> None:
        self._hull = hull
        self.restart()

    def restart(self) -> None:
        """Begin with the next update that knows the current."""
        self._north_mps = self._east_mps = self._taken_s = 0.0

    def update(self, nav: NavState, dt_s: float) -> None:
        """Take a cycle; one without an estimate of the current, or a measured wind, leaves the mean as it is."""
        if nav.current_north_mps is None or nav.current_east_mps is None or nav.wind_speed_mps is None or dt_s <= 0.0:
            return
        self._taken_s = min(_MEAN_S, self._taken_s + dt_s)
        part = dt_s / self._taken_s
        self._north_mps += part * (nav.current_north_mps - self._north_mps)
        self._east_mps += part * (nav.current_east_mps - self._east_mps)

    def demand(self, surge_mps: float, sway_mps: float, yaw_rate_radps: float, yaw_rad: float) -> Wrench:
        """The wrench for that velocity over ground in the mean current, beyond that in still water."""
        x_mps, y_mps = ned_to_body(self._north_mps, self._east_mps, yaw_rad)
        return in_current(self._hull, surge_mps, sway_mps, yaw_rate_radps, x_mps, y_mps)
