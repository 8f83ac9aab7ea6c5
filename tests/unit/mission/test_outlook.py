"""What a person is told of a mission before it is sailed."""

from __future__ import annotations

import pytest

from companion.mission.outlook import (
    battery_lasts_s,
    battery_warning,
    distance,
    duration,
    first_leg_warning,
    full_battery_s,
)
from companion.mission.summary import Leg


def leg(length_m: float | None, speed_mps: float = 0.6) -> Leg:
    return Leg(2, 16, length_m, 0.0, speed_mps, (length_m or 0.0) / speed_mps, 0.0)


@pytest.mark.parametrize(
    ("length_m", "text"), [(0.0, "0 m"), (999.4, "999 m"), (12_340.0, "12.3 km"), (8_212_000.0, "8212 km")]
)
def test_distances(length_m: float, text: str) -> None:
    assert distance(length_m) == text


@pytest.mark.parametrize(
    ("time_s", "text"),
    [(0.0, "0 min"), (3540.0, "59 min"), (3590.0, "1:00 h"), (12_300.0, "3:25 h"), (1.4e7, "3889 h")],
)
def test_durations(time_s: float, text: str) -> None:
    assert duration(time_s) == text


@pytest.mark.parametrize(("length_m", "most_m"), [(900.0, 1000.0), (9e6, 0.0), (None, 1000.0)])
def test_a_first_leg_that_nobody_needs_to_be_told(length_m: float | None, most_m: float) -> None:
    assert first_leg_warning(leg(length_m), most_m) is None
    assert first_leg_warning(None, most_m) is None


def test_a_long_first_leg_is_told_with_its_length_and_time() -> None:
    assert first_leg_warning(leg(12_340.0), 1000.0) == "Item 3 is 12.3 km away, 5:43 h (MIS_DIST_1WP)"
    worst = first_leg_warning(leg(20_000_000.0), 1000.0)
    assert worst is not None and len(worst) <= 50


def test_how_long_the_battery_lasts() -> None:
    full_s = full_battery_s(120.0)
    assert battery_lasts_s(full_s, 0.62, 0.12) == pytest.approx(3600.0)
    assert battery_lasts_s(full_s, None, 0.12) == pytest.approx(0.88 * 7200.0), "not measured: taken as full"
    assert battery_lasts_s(full_s, 0.1, 0.12) == 0.0
    assert battery_lasts_s(full_battery_s(0.0), 0.5, 0.12) is None, "not known"
    assert full_battery_s(0.0, 5000.0) == 5000.0 and full_battery_s(10.0, 5000.0) == 600.0


def test_a_battery_that_does_not_last_is_told_with_both_times() -> None:
    assert battery_warning(12_340.0, 12_300.0, 4200.0) == "Mission: 12.3 km, 3:25 h; battery lasts 1:10 h"
    assert battery_warning(12_340.0, 4200.0, 4200.0) is None and battery_warning(12_340.0, 4200.0, None) is None
