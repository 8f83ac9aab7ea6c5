"""What the water and the battery take of the thrust of a simulated boat."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from companion.config.fields import FROM_DEGREES, STRICT, NonNegative, Positive, means


@dataclass(frozen=True, slots=True)
class LossConfig:
    """Losses of propellers, each by published figures; a plant without this table has none of them."""

    __pydantic_config__ = STRICT
    propeller_m: Annotated[
        Positive | None,
        means("Diameter of the propellers. Left out: as the thruster says; without it there is no loss that needs it."),
    ] = None
    advance_ratio: Annotated[
        Positive,
        means("Speed over revolutions times diameter at which a propeller gives no thrust: it grows with the pitch."),
    ] = 0.88
    depth_m: Annotated[Positive | None, means("Depth of the shafts below the water. Left out: the draft.")] = None
    inflow: Annotated[bool, means("Thrust falls with the water's speed along the shaft.")] = True
    cross_flow: Annotated[bool, means("Water across the shaft drags, since the propeller takes it along.")] = True
    ventilation: Annotated[bool, means("Thrust falls where the propeller comes near the surface, as in waves.")] = True
    interaction: Annotated[bool, means("Thrust falls in the race of another thruster.")] = True
    sag: Annotated[bool, means("Thrust falls with the square of the battery's voltage.")] = True
    deduction: Annotated[
        float, Field(ge=0.0, le=0.5), means("Share of the thrust that is lost because the race pulls at the hull.")
    ] = 0.0
    azimuth_lag_s: Annotated[NonNegative, means("Time constant with which an azimuth follows its command.")] = 0.0
    backlash_rad: Annotated[
        float, Field(alias="backlash_deg", ge=0.0, le=30.0), FROM_DEGREES, means("Play of the azimuths' gears.")
    ] = 0.0
