"""The highest speed in a bend of a boat that its thrusters' moment turns, by its hull model.

A hull under way resists a turn the more, the faster it goes: at the speed u in a bend of curvature κ a steady turn
takes (n_r + n_ur u) r + n_rr r², with r = u κ.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from companion.config.hull import HullConfig
from companion.config.yaw_limit import YawLimit

TURN_SHARE = 0.7
"""Of the yaw moment, that bends are planned with; the rest is for wind, waves and corrections."""
_SPEEDS = 64
_FASTEST_MPS = 30.0

Floats = NDArray[np.float64]


class BendSpeeds:
    """`of(curvature)` → m/s. It never changes. `top_mps`: no speed beyond it is known."""

    def __init__(self, hull: HullConfig, limit: YawLimit, top_mps: float, resistance: float = 1.0) -> None:
        """`resistance`: times the hull's damping in yaw."""
        self._hull, self._limit, self._top_mps, self._resistance = hull, limit, top_mps, resistance
        speeds = np.linspace(0.0, min(top_mps, _FASTEST_MPS), _SPEEDS + 1)[1:]
        rates = [self.rate_radps(float(u), TURN_SHARE) for u in speeds]
        bends = np.minimum.accumulate(np.array(rates) / speeds)
        self._bend_1pm, self._mps = bends[::-1].copy(), speeds[::-1].copy()

    def resisted(self, resistance: float) -> BendSpeeds:
        """The same where the water resists a turn so many times as hard as the hull's damping says."""
        return BendSpeeds(self._hull, self._limit, self._top_mps, resistance)

    def rate_radps(self, speed_mps: float, share: float = 1.0) -> float:
        """The yaw rate of a steady turn at that speed, by that share of the moment."""
        moment_nm = share * self._limit.nm(self._hull.drag_n(speed_mps)) / self._resistance
        return steady_turn_radps(self._hull, speed_mps, moment_nm)

    def of(self, curvature_1pm: Floats) -> Floats:
        """The speed at each absolute curvature; infinite where the top speed is possible."""
        found: Floats = np.interp(curvature_1pm, self._bend_1pm, self._mps, left=math.inf)
        return found

    def at(self, curvature_1pm: float) -> float:
        """As `of`, for one."""
        return float(np.interp(curvature_1pm, self._bend_1pm, self._mps, left=math.inf))


def steady_turn_radps(hull: HullConfig, surge_mps: float, moment_nm: float) -> float:
    """The yaw rate at which the damping of the hull at that speed takes the moment; infinite without damping."""
    d = hull.damping
    linear = d.n_r + d.n_ur * abs(surge_mps)
    if d.n_rr > 0.0:
        return (math.sqrt(linear * linear + 4.0 * d.n_rr * moment_nm) - linear) / (2.0 * d.n_rr)
    return moment_nm / linear if linear > 0.0 else math.inf
