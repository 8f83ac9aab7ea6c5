"""A sail with its sheet, or a wing with its tail, and a keel, as a vessel's file describes them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from companion.config.fields import FROM_DEGREES, FROM_DEGREES_OR_NONE, STRICT, Positive, means


@dataclass(frozen=True, slots=True)
class SailConfig:
    """The sails of a rig, as one sail on one sheet. Its throttle is the sheet: 0 is free, 1 hauled in.

    The wind carries the boom to leeward, at most as far as the sheet lets it: `boom_max_rad` free, `boom_min_rad`
    hauled in. A sail whose sheet lets it lie in the wind luffs.

    With `attack_max_rad` it is a rigid wing that turns freely on its mast, and a tail sets its angle to the wind. Its
    throttle −1…1 is that angle as a share of `attack_max_rad`, positive where a wind from ahead pushes to starboard. At
    0 the wing lies in the wind. It has no boom.
    """

    __pydantic_config__ = STRICT
    area_m2: Annotated[Positive, means("Area of all sails.")]
    aspect: Annotated[float, Field(ge=0.5, le=10.0), means("Aspect ratio of a sail: height over mean width.")]
    x_m: Annotated[float, means("Centre of the area ahead of the middle of the boat.")]
    height_m: Annotated[Positive, means("Centre of the area above the centre of the keel.")]
    righting_nm: Annotated[Positive, means("Righting moment for each radian of heel: weight times metacentric height.")]
    boom_max_rad: Annotated[
        float,
        Field(alias="boom_max_deg", ge=30.0, le=90.0),
        FROM_DEGREES,
        means("Angle of the boom from the middle of the boat with the sheet free."),
    ] = math.radians(85.0)
    boom_min_rad: Annotated[
        float,
        Field(alias="boom_min_deg", ge=0.0, lt=30.0),
        FROM_DEGREES,
        means("Angle of the boom with the sheet hauled in."),
    ] = math.radians(5.0)
    attack_max_rad: Annotated[
        float | None,
        Field(alias="attack_max_deg", ge=5.0, le=15.0),
        FROM_DEGREES_OR_NONE,
        means("Of a wing sail with a tail: its angle to the wind at full throttle. Left out: a soft sail on a sheet."),
    ] = None
    force_scale: Annotated[Positive, means("Force of this sail over what the coefficients say.")] = 1.0

    def boom_rad(self, sheet: float) -> float:
        """The largest angle of the boom at a sheet 0 (free) to 1 (hauled in)."""
        share = min(1.0, max(0.0, sheet))
        return self.boom_max_rad - share * (self.boom_max_rad - self.boom_min_rad)

    def sheet(self, boom_rad: float) -> float:
        """The sheet 0…1 that lets the boom go out that far."""
        share = (self.boom_max_rad - boom_rad) / (self.boom_max_rad - self.boom_min_rad)
        return min(1.0, max(0.0, share))


@dataclass(frozen=True, slots=True)
class KeelConfig:
    """The fin that keeps a simulated sailing boat from going sideways."""

    __pydantic_config__ = STRICT
    span_m: Annotated[Positive, means("Depth of the fin below the hull.")]
    chord_m: Annotated[Positive, means("Length of the fin along the boat.")]
    x_m: Annotated[float, means("Where a quarter of its length lies, ahead of the middle of the boat.")]
