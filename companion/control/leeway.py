"""How fast wind drives a hull sideways through the water: the balance of its push on the side and the hull's drag."""

from __future__ import annotations

import math

from companion.config.vessel import VesselConfig
from companion.control.model import damping
from companion.control.wind import wind_force
from companion.core.estimate import NavState
from companion.core.frames import body_to_ned

_LEAST_S = 1.0  # shorter gusts are left alone, also on a light hull
_HALVINGS = 12


class Leeway:
    """Call it every tick. Remembers the speed sideways, which answers the wind as late as the hull does."""

    def __init__(self, config: VesselConfig) -> None:
        self._config = config
        self.restart()

    def restart(self) -> None:
        """Begin with the wind of the next tick."""
        self._sway_mps: float | None = None

    def update(self, nav: NavState, dt_s: float) -> tuple[float, float]:
        """(north_mps, east_mps) of the leeway on the present heading; zeros while no wind is known."""
        hull, ahead = self._config.hull, abs(nav.surge_mps)
        _, push_n, _ = wind_force(self._config.windage, self._config.length_m, nav)
        steady = math.copysign(self._balanced_mps(abs(push_n), ahead), push_n)
        if self._sway_mps is None:
            self._sway_mps = steady
        drag_nspm = hull.damping.y_v + hull.damping.y_uv * ahead + hull.damping.y_vv * abs(self._sway_mps)
        late_s = max(_LEAST_S, hull.m22_kg / drag_nspm if drag_nspm > 0.0 else math.inf)
        self._sway_mps += min(1.0, dt_s / late_s) * (steady - self._sway_mps)
        return body_to_ned(0.0, self._sway_mps, nav.yaw_rad)

    def _balanced_mps(self, push_n: float, ahead_mps: float) -> float:
        """The speed sideways at which the hull resists as much; the boat's own speed bounds it."""
        low, high = 0.0, max(1.0, ahead_mps)
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            if damping(self._config.hull, ahead_mps, middle, 0.0)[1] < push_n:
                low = middle
            else:
                high = middle
        return 0.5 * (low + high)
