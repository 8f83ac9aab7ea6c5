"""Moment of inertia of the bare boat in yaw."""

from __future__ import annotations

from companion.config.dimensions.form import Dimensions

_GYRATION = 0.25  # of the length: SNAME and Fossen (2021), 4.2, take 0.23 to 0.27 for slender hulls
_HULLS_SHARE = 0.7  # of a catamaran's mass that sits in the hulls and not between them


def yaw_inertia_kgm2(boat: Dimensions) -> float:
    """m k²: k = L/4 of a slender hull; of a barge that of a box, k² = (L² + B²)/12; the hulls of a catamaran add 0.7
    (s/2)², with s the distance between them."""
    if boat.form == "barge":
        return boat.mass_kg * (boat.length_m**2 + boat.beam_m**2) / 12.0
    k2_m2 = (_GYRATION * boat.length_m) ** 2 + _HULLS_SHARE * (0.5 * boat.hull_spacing_m) ** 2
    return boat.mass_kg * k2_m2
