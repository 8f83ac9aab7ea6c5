"""The altitude of the boat's origin."""

from __future__ import annotations

from dataclasses import replace

import pytest

from companion.core.readings import FixType, GnssFix
from companion.nav.altitude import Altitude

FIX = GnssFix(0.0, "gnss", 63.0, 10.0, 12.0, FixType.RTK_FIXED, 18, 0.6)
LEVER = (0.0, 0.0, -1.5)


def test_the_first_fix_counts_in_full_and_further_ones_slowly() -> None:
    altitude = Altitude(40.0)
    altitude.take(FIX, LEVER)
    assert altitude.altitude_m == pytest.approx(10.5)
    altitude.take(replace(FIX, altitude_m=13.0), LEVER)
    assert 10.5 < altitude.altitude_m < 10.7
    for _ in range(200):
        altitude.take(replace(FIX, altitude_m=13.0), LEVER)
    assert altitude.altitude_m == pytest.approx(11.5, abs=1e-3)


def test_a_fix_without_one_changes_nothing() -> None:
    altitude = Altitude(40.0)
    altitude.take(replace(FIX, altitude_m=None), LEVER)
    assert altitude.altitude_m == 40.0
