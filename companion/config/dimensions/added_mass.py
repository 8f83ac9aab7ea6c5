"""Added mass: surge by a regression, sway and yaw by strips with published coefficients of the section."""

from __future__ import annotations

import math
from bisect import bisect_right

from companion.config.dimensions.figure import Figure
from companion.config.dimensions.form import WATER_KGPM3, Dimensions
from companion.config.dimensions.inertia import yaw_inertia_kgm2

# Added mass coefficient of a rectangle that moves across its side 2a, by a/b: DNV-RP-C205 (2010), table D-1.
_RECTANGLE = ((0.1, 2.23), (0.2, 1.98), (0.5, 1.70), (1.0, 1.51), (2.0, 1.36), (5.0, 1.21), (10.0, 1.14))
_ELLIPSE_SECTION = math.pi / 4.0  # how full an ellipse is; its coefficient is 1
_ROUND_ENDS, _SQUARE_ENDS = 1.0 / 20.0, 1.0 / 12.0  # gyradius² of the strips over L²


def surge_kg(boat: Dimensions) -> float:
    """Added mass ahead: 2.7 ρ ∇^(5/3) / L² for each hull (Söding 1982, in Bertram 2012, 6.3)."""
    return boat.hulls * 2.7 * WATER_KGPM3 * math.pow(boat.hull_volume_m3, 5.0 / 3.0) / boat.length_m**2


def section(boat: Dimensions) -> float:
    """Coefficient of the midship section over that of an ellipse, by its fullness and its draft over half its beam."""
    full = boat.midship
    if full <= _ELLIPSE_SECTION:
        return full / _ELLIPSE_SECTION
    box = _rectangle(2.0 * boat.draft_m / boat.hull_beam_m)
    return 1.0 + (box - 1.0) * (full - _ELLIPSE_SECTION) / (1.0 - _ELLIPSE_SECTION)


def sway_kg(boat: Dimensions) -> float:
    """Added mass across: ½ π ρ C T² L c_p for each hull, the sum of strips whose draft falls off to the ends."""
    strip_kgpm = 0.5 * math.pi * WATER_KGPM3 * section(boat) * boat.draft_m**2
    return boat.hulls * strip_kgpm * boat.length_m * boat.prismatic


def yaw_kgm2(boat: Dimensions) -> float:
    """Added inertia: the strips of sway times x², and a catamaran's added mass ahead at its lever."""
    fullness = min(1.0, max(0.0, 3.0 * boat.prismatic - 2.0))
    gyradius2 = _ROUND_ENDS + fullness * (_SQUARE_ENDS - _ROUND_ENDS)
    return sway_kg(boat) * gyradius2 * boat.length_m**2 + surge_kg(boat) * (0.5 * boat.hull_spacing_m) ** 2


def figures(boat: Dimensions) -> tuple[Figure, ...]:
    """The three inertias of the model."""
    return (
        Figure(
            "hull.m11_kg",
            boat.mass_kg + surge_kg(boat),
            1.2,
            "m + 2.7 ρ ∇^(5/3) / L² for each hull",
            "Söding 1982, in Bertram, Practical Ship Hydrodynamics (2012)",
        ),
        Figure(
            "hull.m22_kg",
            boat.mass_kg + sway_kg(boat),
            1.7,
            "m + ½ π ρ C T² L c_p for each hull, C by section",
            "strip theory; DNV-RP-C205 (2010), table D-1",
        ),
        Figure(
            "hull.m33_kgm2",
            yaw_inertia_kgm2(boat) + yaw_kgm2(boat),
            1.7,
            "m k² with k = L/4 (a box for a barge), and the strips of sway times x²",
            "Fossen, Handbook (2021), 4.2; strip theory",
        ),
    )


def _rectangle(ratio: float) -> float:
    """The coefficient between the rows of the table, linear in log a/b; held at its ends."""
    ratios = [row[0] for row in _RECTANGLE]
    if ratio <= ratios[0]:
        return _RECTANGLE[0][1]
    if ratio >= ratios[-1]:
        return _RECTANGLE[-1][1]
    i = bisect_right(ratios, ratio) - 1
    (low, at_low), (high, at_high) = _RECTANGLE[i], _RECTANGLE[i + 1]
    return at_low + (at_high - at_low) * math.log(ratio / low) / math.log(high / low)
