"""Declination, against the values that come with the model."""

from __future__ import annotations

import math

import pytest

from companion.core.geomagnetism import decimal_year, declination_rad


@pytest.mark.parametrize(
    ("lat_deg", "lon_deg", "year", "declination_deg"),
    [(80.0, 0.0, 2025.0, 1.28), (0.0, 120.0, 2025.0, -0.16), (-80.0, 240.0, 2025.0, 68.78)],
)
def test_wmm2025_test_values(lat_deg: float, lon_deg: float, year: float, declination_deg: float) -> None:
    """NOAA's WMM2025 test values at sea level."""
    found = declination_rad(lat_deg, lon_deg, year)
    assert found is not None
    assert math.degrees(found) == pytest.approx(declination_deg, abs=0.006)


def test_near_the_magnetic_pole_there_is_no_declination() -> None:
    assert declination_rad(86.0, 142.0, 2025.0) is None


def test_year() -> None:
    assert decimal_year(1_780_315_200_000_000_000) == pytest.approx(2026.414, abs=0.005)  # 2026-06-01T12:00Z
    assert decimal_year(None) == 2027.5
    assert decimal_year(0) == 2025.0
    assert decimal_year(10**19) == 2035.0
