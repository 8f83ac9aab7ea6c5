"""How the water flows around the hull of a simulated boat, beyond the derivatives of `HullConfig`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from companion.config.fields import STRICT, NonNegative, Positive, means

Equations = Literal["companion", "otter_2023", "otter_2024", "otter_mended"]
LiftLaw = Literal["clarke", "inoue"]


@dataclass(frozen=True, slots=True)
class CrossFlowConfig:
    """Drag of the flow across the hull, strip by strip. It comes on top of the damping."""

    __pydantic_config__ = STRICT
    coefficient: Annotated[Positive, means("Drag coefficient of a strip, on its draft (Hoerner 1965; 0.6 to 2).")]
    length_m: Annotated[Positive | None, means("Length. Left out: that of the waterline.")] = None
    draft_m: Annotated[Positive | None, means("Draft. Left out: that of the hull.")] = None
    hulls: Annotated[
        int, Field(ge=1, le=2), means("Hulls that meet the flow; 1 where one lies in the other's lee.")
    ] = 1
    strips: Annotated[int, Field(ge=4, le=100), means("Number of strips.")] = 20


@dataclass(frozen=True, slots=True)
class LiftConfig:
    """Forces of a hull under way by a published regression, and of fins such as skegs, struts and pods."""

    __pydantic_config__ = STRICT
    law: Annotated[LiftLaw, means("The regression: `clarke` (1983) or `inoue` (1981), of bare hulls on even keel.")]
    fin_area_m2: Annotated[NonNegative, means("Lateral area of all fins.")] = 0.0
    fin_aspect: Annotated[Positive, means("Aspect ratio of a fin, with its image in the hull.")] = 2.0
    fin_x_m: Annotated[float | None, means("Where the fins are, ahead of the middle. Left out: at the stern.")] = None
