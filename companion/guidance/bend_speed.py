"""The highest speed in a bend of a boat that its thrusters' moment turns, by its hull model.

A hull under way resists a turn the more, the faster it goes: at the speed u in a bend of curvature κ a steady turn
takes (n_r + n_ur u) r + n_rr r², with r = u κ. A hull with fins at the stern, as rudders are, resists more, since it
drifts outwards with v: (−n_uv − (m22 − m11)) u v. What steers it at the stern pushes it outwards besides. What drift
turns a hull further into its bend is left out.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from companion.config.hull import HullConfig
from companion.config.yaw_limit import YawLimit
from companion.guidance.sideslip import SteeredHull, steady_slip_mps

TURN_SHARE = 0.7
"""Of the yaw moment, that bends are planned with; the rest is for wind, waves and corrections."""
_SPEEDS = 64
_FASTEST_MPS = 30.0
_HALVINGS = 20

Floats = NDArray[np.float64]


class BendSpeeds:
    """`of(curvature)` → m/s. It never changes. `top_mps`: no speed beyond it is known."""

    def __init__(self, steered: SteeredHull, limit: YawLimit, top_mps: float, resistance: float = 1.0) -> None:
        """`resistance`: times the hull's damping in yaw."""
        self._steered, self._limit, self._top_mps, self._resistance = steered, limit, top_mps, resistance
        speeds = np.linspace(0.0, min(top_mps, _FASTEST_MPS), _SPEEDS + 1)[1:]
        rates = [self.rate_radps(float(u), TURN_SHARE) for u in speeds]
        bends = np.minimum.accumulate(np.array(rates) / speeds)
        self._bend_1pm, self._mps = bends[::-1].copy(), speeds[::-1].copy()

    def resisted(self, resistance: float) -> BendSpeeds:
        """The same where the water resists a turn so many times as hard as the hull's damping says."""
        return BendSpeeds(self._steered, self._limit, self._top_mps, resistance)

    def rate_radps(self, speed_mps: float, share: float = 1.0) -> float:
        """The yaw rate of a steady turn at that speed, by that share of the moment."""
        hull = self._steered.hull
        moment_nm = share * self._limit.nm(hull.drag_n(speed_mps), speed_mps) / self._resistance
        return steady_turn_radps(hull, speed_mps, moment_nm, self._steered.steers_1pm)

    def of(self, curvature_1pm: Floats) -> Floats:
        """The speed at each absolute curvature; infinite where the top speed is possible."""
        found: Floats = np.interp(curvature_1pm, self._bend_1pm, self._mps, left=math.inf)
        return found

    def at(self, curvature_1pm: float) -> float:
        """As `of`, for one."""
        return float(np.interp(curvature_1pm, self._bend_1pm, self._mps, left=math.inf))


def steady_turn_radps(hull: HullConfig, surge_mps: float, moment_nm: float, steers_1pm: float = 0.0) -> float:
    """The yaw rate at which the damping of the hull at that speed takes the moment; infinite without damping.
    `steers_1pm`: as in `SteeredHull`, of what gives the moment."""
    fastest_radps = _turn_radps(hull, surge_mps, moment_nm)
    against_kg = -hull.damping.n_uv - (hull.m22_kg - hull.m11_kg)
    if against_kg <= 0.0 or not math.isfinite(fastest_radps):
        return fastest_radps
    low, high = 0.0, fastest_radps
    for _ in range(_HALVINGS):
        rate_radps = 0.5 * (low + high)
        drift_nm = against_kg * abs(surge_mps) * _drift_mps(hull, surge_mps, rate_radps, steers_1pm)
        low, high = (
            (rate_radps, high) if _turn_radps(hull, surge_mps, moment_nm - drift_nm) > rate_radps else (low, rate_radps)
        )
    return 0.5 * (low + high)


def _turn_radps(hull: HullConfig, surge_mps: float, moment_nm: float) -> float:
    """Of a hull that does not drift in the turn."""
    d = hull.damping
    linear = d.n_r + d.n_ur * abs(surge_mps)
    moment_nm = max(0.0, moment_nm)
    if d.n_rr > 0.0:
        return (math.sqrt(linear * linear + 4.0 * d.n_rr * moment_nm) - linear) / (2.0 * d.n_rr)
    return moment_nm / linear if linear > 0.0 else math.inf


def _drift_mps(hull: HullConfig, surge_mps: float, rate_radps: float, steers_1pm: float) -> float:
    """The speed outwards at which the water turns the hull's way: y_v v + y_vv v² + y_uv u v = m11 u r, and what steers
    it at the stern."""
    if steers_1pm:
        return abs(steady_slip_mps(SteeredHull(hull, steers_1pm), abs(surge_mps), rate_radps))
    d, ahead_mps = hull.damping, abs(surge_mps)
    linear, force_n = d.y_v + d.y_uv * ahead_mps, hull.m11_kg * ahead_mps * rate_radps
    if d.y_vv > 0.0:
        return (math.sqrt(linear * linear + 4.0 * d.y_vv * force_n) - linear) / (2.0 * d.y_vv)
    return force_n / linear if linear > 0.0 else 0.0
