"""Areas above the water."""

from __future__ import annotations

from companion.config.dimensions.figure import Figure
from companion.config.dimensions.form import Dimensions

_LATERAL_SHARE = 0.85  # of length times height


def figures(boat: Dimensions) -> tuple[Figure, ...]:
    """Frontal and lateral area. The coefficients stay at the defaults of `[windage]` (Blendermann 1994)."""
    source = "proportions by form; Blendermann 1994"
    return (
        Figure(
            "windage.frontal_m2",
            boat.traits.frontal_share * boat.beam_m * boat.height_m,
            1.8,
            f"{boat.traits.frontal_share:g} B h",
            source,
        ),
        Figure(
            "windage.lateral_m2", _LATERAL_SHARE * boat.length_m * boat.height_m, 1.8, f"{_LATERAL_SHARE:g} L h", source
        ),
    )
