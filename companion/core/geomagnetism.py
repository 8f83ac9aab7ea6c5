"""Where magnetic north is, by the World Magnetic Model."""

from __future__ import annotations

import functools
import math
from typing import Any

_YEAR_S = 365.2425 * 86400.0
_FIRST_YEAR, _LAST_YEAR = 2025.0, 2035.0  # the model's own span and five years more, in which it is still within a degree nearly everywhere
_MIDDLE_YEAR = 2027.5
_WEAKEST_NT = 2000.0  # horizontal field below which the model's authors call a compass unusable


def decimal_year(time_unix_ns: int | None) -> float:
    """Absolute time as a year with its fraction, to a day or two; where none is known, the middle of the model's span."""
    if time_unix_ns is None:
        return _MIDDLE_YEAR
    return min(max(1970.0 + time_unix_ns * 1e-9 / _YEAR_S, _FIRST_YEAR), _LAST_YEAR)


def declination_rad(lat_deg: float, lon_deg: float, year: float) -> float | None:
    """Angle from true to magnetic north at sea level, positive east; None near the magnetic poles, where a compass does not point.

    Source: WMM2025 (NOAA and British Geological Survey), computed by pygeomag. A millisecond or so: not for every reading.
    """
    field = _field(lat_deg, lon_deg, year)
    return math.radians(field.d) if field.h >= _WEAKEST_NT else None


def field_nt(lat_deg: float, lon_deg: float, year: float) -> tuple[float, float, float]:
    """The Earth's field at sea level in nT, NED (true north). Source and cost as of `declination_rad`."""
    field = _field(lat_deg, lon_deg, year)
    return field.x, field.y, field.z


def _field(lat_deg: float, lon_deg: float, year: float) -> Any:
    return _model().calculate(glat=lat_deg, glon=lon_deg, alt=0.0, time=year, allow_date_outside_lifespan=True)


@functools.cache
def _model() -> Any:
    from pygeomag import GeoMag  # only a boat with a compass pays for it

    return GeoMag()
