"""Feed-forward against the wind: its force on the hull."""

from __future__ import annotations

import math

from companion.config.hull import AIR_KGPM3, WindageConfig
from companion.core.estimate import NavState

_COUNTERED = 0.8  # share of the modelled force to counter: the wind at the mast is stronger than at the hull


def wind_force(windage: WindageConfig, length_m: float, nav: NavState) -> tuple[float, float, float]:
    """(surge_n, sway_n, yaw_nm) of the wind to counter, from the true wind and the boat's velocity; zeros if no wind is
    known.

    With (x, y) the velocity of the air past the hull and V its size: X = ½ρ cx A_F V x, Y = ½ρ cy A_L V y, N = −½ρ cn
    A_L L 2xy, which turns the boat beam to the wind (Fossen 2011, 8.1.3, with sin 2γ written out).
    """
    if nav.wind_speed_mps is None or nav.wind_from_rad is None:
        return 0.0, 0.0, 0.0
    towards = nav.wind_from_rad + math.pi - nav.yaw_rad
    x = nav.wind_speed_mps * math.cos(towards) - nav.surge_mps
    y = nav.wind_speed_mps * math.sin(towards) - nav.sway_mps
    speed = math.hypot(x, y)
    pressure = 0.5 * AIR_KGPM3 * _COUNTERED
    return (
        pressure * windage.cx * windage.frontal_m2 * speed * x,
        pressure * windage.cy * windage.lateral_m2 * speed * y,
        -pressure * windage.cn * windage.lateral_m2 * length_m * 2.0 * x * y,
    )
