"""Rudders that drift are fins: what their blades add to the damping of the hull."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from companion.config.devices import ThrusterConfig
from companion.config.dimensions.derivation import top_speed_mps
from companion.config.dimensions.form import WATER_KGPM3
from companion.config.hull import HullConfig

STRAIGHTENED = 0.6  # share of a drift angle that the blade sees (MMG, Yasukawa and Yoshimura 2015)


def with_fins(hull: HullConfig, thrusters: Sequence[ThrusterConfig], surge_n: float) -> HullConfig:
    """The hull with what the blades of its rudders add to its damping, which the allocation leaves to it. `surge_n`:
    the largest thrust ahead.

    The side force of a blade is −C u (v + x r) at small angles, C = ½ ρ A ∂C_L/∂δ γ U/u (MMG), with γ = `STRAIGHTENED`
    and U/u of a steady run at the top speed. The hull has no term for u r in its sway.
    """
    return _finned(hull, thrusters, surge_n, 1.0)


def without_fins(hull: HullConfig, thrusters: Sequence[ThrusterConfig], surge_n: float) -> HullConfig:
    """The hull of which `with_fins` made `hull`."""
    return _finned(hull, thrusters, surge_n, -1.0)


def _finned(hull: HullConfig, thrusters: Sequence[ThrusterConfig], surge_n: float, sign: float) -> HullConfig:
    if not any(thruster.kind == "rudder" for thruster in thrusters):
        return hull
    damping, top_mps = hull.damping, top_speed_mps(hull, surge_n)
    for thruster in thrusters:
        rudder = thruster.rudder
        if rudder is None or thruster.propeller_m is None or not math.isfinite(top_mps):
            continue
        share_n = surge_n / sum(t.kind == "rudder" for t in thrusters)
        disc_kgpm = 0.5 * WATER_KGPM3 * 0.25 * math.pi * thruster.propeller_m**2
        speed_mps = math.sqrt(rudder.inflow(share_n, top_mps, disc_kgpm))
        fin = 0.5 * WATER_KGPM3 * rudder.area_m2 * rudder.lift_scale * rudder.slope * STRAIGHTENED
        fin *= sign * speed_mps / top_mps
        damping = replace(
            damping,
            y_uv=damping.y_uv + fin,
            n_uv=damping.n_uv + fin * rudder.x_m,
            n_ur=damping.n_ur + fin * rudder.x_m**2,
        )
    return replace(hull, damping=damping)
