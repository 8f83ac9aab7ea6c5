"""Feed-forward against the wind: its force on the hull."""

from __future__ import annotations

import math

from companion.config.hull import AT_HULL_SHARE, WindageConfig
from companion.core.estimate import Air, NavState, air_over_ground


class SlowWind:
    """The wind without gusts that are shorter than a given time. Remembers it."""

    def __init__(self) -> None:
        self.restart()

    def restart(self) -> None:
        """Begin with the wind of the next update."""
        self._air: Air | None = None

    @property
    def air(self) -> Air | None:
        """The low-pass filtered wind of the last update."""
        return self._air

    def update(self, nav: NavState, shortest_s: float, dt_s: float) -> Air | None:
        """The low-pass filtered wind; None while none is known."""
        now = air_over_ground(nav)
        if now is None or self._air is None:
            self._air = now
            return now
        part = dt_s / (dt_s + shortest_s)
        north, east = self._air
        self._air = north + part * (now[0] - north), east + part * (now[1] - east)
        return self._air


def wind_force(windage: WindageConfig, length_m: float, nav: NavState) -> tuple[float, float, float]:
    """(surge_n, sway_n, yaw_nm) of the wind to counter, from the true wind and the boat's velocity; zeros if no wind is
    known."""
    return force_of_air(windage, length_m, nav, air_over_ground(nav))


def force_of_air(
    windage: WindageConfig, length_m: float, nav: NavState, air: Air | None, turned_rad: float = 0.0
) -> tuple[float, float, float]:
    """As `wind_force`, of that wind, on a heading that is turned by `turned_rad`.

    Its moment turns the boat beam to the wind (Fossen 2011, 8.1.3, with sin 2γ written out).
    """
    if air is None:
        return 0.0, 0.0, 0.0
    yaw_rad = nav.yaw_rad + turned_rad
    c, s = math.cos(yaw_rad), math.sin(yaw_rad)
    x, y = c * air[0] + s * air[1] - nav.surge_mps, c * air[1] - s * air[0] - nav.sway_mps
    return windage.force(x, y, length_m, AT_HULL_SHARE)
