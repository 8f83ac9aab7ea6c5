"""A boat that drifts aside bears away until it has way on."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.core.estimate import NavState, through_water
from companion.guidance.sail_way import SailWay
from tests.unit.estimates import AT_REST

CLOSE_RAD = math.radians(50.0)  # to starboard of a wind from north


def at(surge_mps: float, sway_mps: float, yaw_rad: float = CLOSE_RAD) -> NavState:
    return replace(AT_REST, surge_mps=surge_mps, sway_mps=sway_mps, yaw_rad=yaw_rad)


def after(way: SailWay, nav: NavState, seconds: float, wanted_rad: float = CLOSE_RAD) -> float:
    for _ in range(round(10.0 * seconds)):
        found = way.heading(wanted_rad, 0.0, nav, 0.1)
    return math.degrees(found)


def test_a_boat_that_drifts_aside_bears_away_until_there_is_way_on() -> None:
    way = SailWay()
    assert after(way, at(0.3, 0.3), 1.9) == pytest.approx(50.0)
    assert after(way, at(0.3, 0.3), 0.3) == pytest.approx(95.0) and way.gathers
    assert after(way, at(0.8, 0.1), 1.0) == pytest.approx(95.0)
    assert after(way, at(0.95, 0.1), 0.1) == pytest.approx(50.0) and not way.gathers


@pytest.mark.parametrize(("surge_mps", "sway_mps"), [(0.3, 0.1), (0.9, 0.4), (1.2, 0.9)])
def test_little_way_without_drift_and_much_way_are_no_stall(surge_mps: float, sway_mps: float) -> None:
    assert after(SailWay(), at(surge_mps, sway_mps), 10.0) == pytest.approx(50.0)


def test_it_bears_away_on_its_own_tack_and_no_longer_than_it_helps() -> None:
    port = at(0.2, -0.4, -CLOSE_RAD)
    way = SailWay()
    assert after(way, port, 3.0, CLOSE_RAD) == pytest.approx(-95.0)
    assert after(way, port, 9.0, CLOSE_RAD) == pytest.approx(-95.0)
    assert after(way, port, 2.2, CLOSE_RAD) == pytest.approx(50.0)


def test_a_course_further_off_the_wind_is_sailed() -> None:
    assert after(SailWay(), at(0.2, 0.4), 5.0, math.radians(120.0)) == pytest.approx(120.0)


def test_a_current_is_no_drift() -> None:
    nav = replace(at(0.3, 0.3, 0.0), current_north_mps=-0.9, current_east_mps=0.3)
    assert through_water(nav) == pytest.approx((1.2, 0.0))
    assert after(SailWay(), nav, 5.0) == pytest.approx(50.0)
