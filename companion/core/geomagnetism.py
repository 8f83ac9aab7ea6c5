"""The Earth's magnetic field by the World Magnetic Model."""

from __future__ import annotations

import functools
import math
from typing import Any

_YEAR_S = 365.2425 * 86400.0
# The model's span, and five more years in which it is still within a degree nearly everywhere.
_FIRST_YEAR, _LAST_YEAR = 2025.0, 2035.0
_MIDDLE_YEAR = 2027.5
_WEAKEST_NT = 2000.0  # horizontal field below which the model's authors call a compass unusable


def decimal_year(time_unix_ns: int | None) -> float:
    """The decimal year, to a day or two, held within the model's span; the middle of that span if the time is None."""
    if time_unix_ns is None:
        return _MIDDLE_YEAR
    return min(max(1970.0 + time_unix_ns * 1e-9 / _YEAR_S, _FIRST_YEAR), _LAST_YEAR)


def declination_rad(lat_deg: float, lon_deg: float, year: float) -> float | None:
    """Declination at sea level: angle from true to magnetic north, positive east. None near the magnetic poles, where a
    compass is unusable.

    Source: WMM2025 (NOAA and British Geological Survey), computed by pygeomag. It takes about a millisecond: too long
    for every reading.
    """
    field = _field(lat_deg, lon_deg, year)
    return math.radians(field.d) if field.h >= _WEAKEST_NT else None


def field_nt(lat_deg: float, lon_deg: float, year: float) -> tuple[float, float, float]:
    """The field at sea level in nT, as (north, east, down) from true north. Source and cost as for
    `declination_rad`."""
    field = _field(lat_deg, lon_deg, year)
    return field.x, field.y, field.z


def _field(lat_deg: float, lon_deg: float, year: float) -> Any:
    return _model().calculate(glat=lat_deg, glon=lon_deg, alt=0.0, time=year, allow_date_outside_lifespan=True)


@functools.cache
def _model() -> Any:
    from pygeomag import GeoMag  # imported late: only a boat with a compass needs it

    return GeoMag()
