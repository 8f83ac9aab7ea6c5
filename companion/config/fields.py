"""Kinds of fields in a vessel's file."""

from __future__ import annotations

import math
from typing import Annotated, Any

from pydantic import AfterValidator, ConfigDict, Field

STRICT = ConfigDict(extra="forbid", allow_inf_nan=False)
FROM_DEGREES = AfterValidator(math.radians)
FROM_DEGREES_OR_NONE = AfterValidator(lambda degrees: None if degrees is None else math.radians(degrees))
VECTOR_FROM_DEGREES_OR_NONE = AfterValidator(
    lambda angles: None if angles is None else tuple(math.radians(angle) for angle in angles)
)
SECTORS_FROM_DEGREES = AfterValidator(lambda sectors: tuple((math.radians(a), math.radians(b)) for a, b in sectors))

Name = Annotated[str, Field(pattern=r"^[a-z][a-z0-9_]{0,31}$")]
Positive = Annotated[float, Field(gt=0.0)]
NonNegative = Annotated[float, Field(ge=0.0)]
Vector = tuple[float, float, float]
Latitude = Annotated[float, Field(ge=-89.0, le=89.0)]
Longitude = Annotated[float, Field(ge=-180.0, le=180.0)]


def means(text: str) -> Any:
    """What a key means, as the generated page of the vessel file has it. It stands in the annotation of the key."""
    return Field(description=text)


DERIVED = "derived"


def derived(text: str) -> Any:
    """As `means`, for a key that is filled in before the file is checked, where other keys say enough
    (`companion.config.dimensions`)."""
    return Field(description=text, json_schema_extra={DERIVED: True})
