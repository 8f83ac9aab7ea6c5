"""The controller's model of the hull: M ν̇ + C(ν) ν + D(ν) ν = τ in plain floats (Fossen 2021; the sign of C in the
theses is corrected)."""

from __future__ import annotations

from companion.config.hull import HullConfig
from companion.core.actuation import Wrench


def coriolis(hull: HullConfig, surge_mps: float, sway_mps: float, yaw_rate_radps: float) -> tuple[float, float, float]:
    """C(ν) ν as (surge N, sway N, yaw Nm)."""
    lateral = hull.m22_kg * sway_mps + hull.m23_kgm * yaw_rate_radps
    x = -lateral * yaw_rate_radps
    y = hull.m11_kg * surge_mps * yaw_rate_radps
    n = lateral * surge_mps - hull.m11_kg * surge_mps * sway_mps
    return x, y, n


def drift_moment_nm(hull: HullConfig, surge_mps: float, sway_mps: float) -> float:
    """The moment against that drift through the water: Munk's, and that of the lift (N_uv)."""
    _, _, munk_nm = coriolis(hull, surge_mps, sway_mps, 0.0)
    return munk_nm + hull.damping.n_uv * abs(surge_mps) * sway_mps


def damping(hull: HullConfig, surge_mps: float, sway_mps: float, yaw_rate_radps: float) -> tuple[float, float, float]:
    """D(ν) ν as (surge N, sway N, yaw Nm): the force against the motion."""
    d = hull.damping
    u, v, r = surge_mps, sway_mps, yaw_rate_radps
    au, av, ar = abs(u), abs(v), abs(r)
    x = hull.drag_n(u)
    y = (d.y_v + d.y_vv * av + d.y_rv * ar + d.y_uv * au) * v + (d.y_r + d.y_vr * av + d.y_rr * ar) * r
    n = (d.n_v + d.n_vv * av + d.n_rv * ar + d.n_uv * au) * v + (d.n_r + d.n_vr * av + d.n_rr * ar + d.n_ur * au) * r
    return x, y, n


def force_for(
    hull: HullConfig,
    surge_mps: float,
    sway_mps: float,
    yaw_rate_radps: float,
    surge_mps2: float,
    sway_mps2: float,
    yaw_radps2: float,
) -> Wrench:
    """The wrench for a velocity and an acceleration, in body axes: τ = M ν̇ + C(ν) ν + D(ν) ν."""
    cx, cy, cn = coriolis(hull, surge_mps, sway_mps, yaw_rate_radps)
    dx, dy, dn = damping(hull, surge_mps, sway_mps, yaw_rate_radps)
    return Wrench(
        hull.m11_kg * surge_mps2 + cx + dx,
        hull.m22_kg * sway_mps2 + hull.m23_kgm * yaw_radps2 + cy + dy,
        hull.yaw_coupling_kgm * sway_mps2 + hull.m33_kgm2 * yaw_radps2 + cn + dn,
    )


def in_current(
    hull: HullConfig, surge_mps: float, sway_mps: float, yaw_rate_radps: float, x_mps: float, y_mps: float
) -> Wrench:
    """The wrench that a velocity over ground takes in water that flows at (x, y) in body axes, beyond that in still
    water: M (ν̇_r − ν̇) + C(ν_r) ν_r − C(ν) ν + D(ν_r) ν_r − D(ν) ν, with ν_r = ν − ν_c through the water. The axes of a
    boat that turns turn the current, ν̇_c = (r y, −r x)."""
    u, v, r = surge_mps, sway_mps, yaw_rate_radps
    through = force_for(hull, u - x_mps, v - y_mps, r, -r * y_mps, r * x_mps, 0.0)
    still = force_for(hull, u, v, r, 0.0, 0.0, 0.0)
    return Wrench(through.surge_n - still.surge_n, through.sway_n - still.sway_n, through.yaw_nm - still.yaw_nm)
