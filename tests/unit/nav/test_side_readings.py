"""Absolute time and true wind."""

from __future__ import annotations

import math

import pytest

from companion.nav.side_readings import AbsoluteTime, TrueWind


def test_absolute_time_is_exact_and_smooths_the_arrival() -> None:
    time = AbsoluteTime()
    assert time.at_ns(0.0) is None
    time.update(10.0, 1_763_726_400_000_000_000)
    assert time.at_ns(12.5) == 1_763_726_402_500_000_000
    time.update(11.05, 1_763_726_401_000_000_000)  # came 50 ms late: a tenth of it is taken over
    assert time.at_ns(12.0) == 1_763_726_402_000_000_000 - 5_000_000


def test_a_jump_of_the_absolute_time_counts_once_it_has_lasted() -> None:
    """Whether it is a lie is told after a tick. Single ones, and those of another receiver, count for nothing."""
    time = AbsoluteTime()
    time.update(19.0, 1_763_726_409_000_000_000)
    time.update(20.0, 1_763_800_000_000_000_000)
    assert time.at_ns(20.0) == 1_763_726_410_000_000_000
    time.update(21.0, 1_763_726_411_000_000_000)
    time.update(22.0, 1_763_800_002_000_000_000)
    assert time.at_ns(22.0) == 1_763_726_412_000_000_000
    time.update(22.1, 1_763_800_002_100_000_000)
    assert time.at_ns(22.1) == 1_763_726_412_100_000_000
    time.update(22.5, 1_763_800_002_500_000_000)
    assert time.at_ns(23.0) == 1_763_800_003_000_000_000


def test_true_wind() -> None:
    """A boat going north at 2 m/s in 5 m/s of wind from the east feels (2 from ahead, 5 from starboard)."""
    wind = TrueWind(2.0)
    apparent, angle = math.hypot(2.0, 5.0), math.atan2(5.0, 2.0)
    wind.update(1.0, apparent, angle, 0.0, 2.0, 0.0)
    speed, direction = wind.at(1.1)
    assert speed == pytest.approx(5.0)
    assert direction == pytest.approx(math.radians(90.0))
    wind.update(1.1, apparent, angle - math.radians(30.0), math.radians(30.0), 2.0, 0.0)
    assert wind.at(1.1) == pytest.approx((5.0, math.radians(90.0)))
    assert wind.at(3.2) == (None, None)
