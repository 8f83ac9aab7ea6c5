"""Damping of sway and yaw: cross-flow drag by strips, lift of the hull under way, and waves."""

from __future__ import annotations

import math

from companion.config.dimensions.figure import Figure
from companion.config.dimensions.form import GRAVITY_MPS2, WATER_KGPM3, Dimensions

_SECOND_HULL = 0.6  # drag of the hull in the lee of the other, over that of one alone (cylinders in tandem, Hoerner)
_ENDS_SWAY, _ENDS_YAW = 0.9, 0.85  # what strips at the ends with less draft leave of L T and of L⁴ T
_LEAST_SWAY_MPS = 0.05  # speed below which drag is taken as linear: slow drift is laminar and wavy
# Share of its draft that a hull draws at its transom, if it planes or has its jet there; RescueRunner's turning circle
# has it so. N_r is what the section at the transom gives, ∝ T² (slender bodies: Faltinsen 2005, 10).
_TRANSOM_DRAFT = 0.5
_YAW_TIME = 8.0  # of √(L/g): time constant of slow turns. Published models have 1.6 to 57.


def _pressure(boat: Dimensions) -> float:
    """½ ρ C_D T of all hulls, N per m and (m/s)²."""
    hulls = 1.0 if boat.hulls == 1 else 1.0 + _SECOND_HULL
    return 0.5 * WATER_KGPM3 * boat.traits.cross_flow * boat.draft_m * hulls


def sway_quadratic(boat: Dimensions) -> float:
    """y_vv: ½ ρ C_D ∫ T dx, in N per (m/s)²."""
    return _ENDS_SWAY * _pressure(boat) * boat.length_m


def yaw_quadratic(boat: Dimensions) -> float:
    """n_rr: ½ ρ C_D ∫ T |x|³ dx = ½ ρ C_D T L⁴ / 32, in Nm per (rad/s)²."""
    return _ENDS_YAW * _pressure(boat) * boat.length_m**4 / 32.0


def yaw_linear(boat: Dimensions, m33_kgm2: float) -> float:
    """n_r: the inertia over a time constant of 8 √(L/g), in Nm per (rad/s)."""
    return m33_kgm2 / (_YAW_TIME * math.sqrt(boat.length_m / GRAVITY_MPS2))


def _lift(boat: Dimensions, by_transom: bool) -> tuple[float, float, float]:
    """(y_uv, n_uv, n_ur) of Clarke's regression, which holds for each hull (Clarke, Gedling and Hine 1983).
    `by_transom`: it has the n_ur of the draft that is left at the transom; its chines keep the side force."""
    draft_m, beam_m, length_m = boat.draft_m, boat.hull_beam_m, boat.length_m
    unit = boat.hulls * 0.5 * math.pi * WATER_KGPM3 * draft_m**2
    y_uv = unit * (1.0 + 0.4 * boat.block * beam_m / draft_m)
    n_ur = unit * length_m**2 * max(0.1, 0.25 + 0.039 * beam_m / draft_m - 0.56 * beam_m / length_m)
    if by_transom:
        n_ur *= _TRANSOM_DRAFT**2
    # the Munk moment stands in the Coriolis terms, of which Clarke's N_v leaves half
    return y_uv, -0.5 * unit * length_m, n_ur


def figures(boat: Dimensions, m33_kgm2: float, by_transom: bool = False) -> tuple[Figure, ...]:
    """All terms of sway and yaw. `m33_kgm2`: inertia in yaw, as derived or given. `by_transom`: it planes, or its jet
    lies in a transom, where it draws little."""
    y_vv, n_rr = sway_quadratic(boat), yaw_quadratic(boat)
    y_uv, n_uv, n_ur = _lift(boat, by_transom)
    strips = "strip theory; Faltinsen, Sea Loads (1990), 6"
    clarke = "Clarke, Gedling and Hine 1983"
    by_draft = "with half the draft at the transom: " if by_transom else ""
    return (
        Figure("hull.damping.y_v", y_vv * _LEAST_SWAY_MPS, 8.0, "y_vv · 0.05 m/s", strips),
        Figure("hull.damping.y_vv", y_vv, 3.0, "½ ρ C_D ∫ T dx", strips),
        Figure(
            "hull.damping.n_r",
            yaw_linear(boat, m33_kgm2),
            7.0,
            "m33 / (8 √(L/g))",
            "middle of published models",
        ),
        Figure("hull.damping.n_rr", n_rr, 7.0, "½ ρ C_D T L⁴ / 32", strips),
        Figure("hull.damping.y_uv", y_uv, 2.5, "½ π ρ T² (1 + 0.4 C_B B/T)", clarke),
        Figure("hull.damping.n_uv", n_uv, 2.5, "−¼ π ρ T² L: half of the Munk moment", clarke),
        Figure("hull.damping.n_ur", n_ur, 2.5, by_draft + "½ π ρ T² L² (¼ + 0.039 B/T − 0.56 B/L)", clarke),
    )
