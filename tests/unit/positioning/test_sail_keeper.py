"""Hold under sail: to and fro across the wind."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config.vessel import find, load, parse
from companion.core.estimate import NavState
from companion.core.setpoint import PathSetpoint, WrenchSetpoint
from companion.params.store import Parameters
from companion.positioning.sail_keeper import SailKeeper
from tests.unit.config.test_sail import with_motor
from tests.unit.estimates import AT_REST

BOAT = load(find("sailbot"))

WIND_FROM_NORTH = replace(AT_REST, wind_speed_mps=5.0, wind_from_rad=0.0, yaw_rad=math.radians(80.0))


def at(north_m: float, east_m: float) -> NavState:
    return replace(WIND_FROM_NORTH, north_m=north_m, east_m=east_m)


def keeper() -> SailKeeper:
    found = SailKeeper(BOAT, Parameters({"DP_WATCH_R": 10.0, "DP_SPEED_AHEAD": 0.8}))
    found.start(at(0.0, 0.0))
    return found


def heading_deg(found: SailKeeper, nav: NavState) -> float:
    setpoint = found.update(nav, None, 2.0, 0.1)
    assert isinstance(setpoint, PathSetpoint)
    return math.degrees(setpoint.yaw_rad) % 360.0


def test_it_sails_on_to_its_side_and_turns_there() -> None:
    found = keeper()
    assert 45.0 < heading_deg(found, at(0.0, 0.0)) < 90.0
    assert 45.0 < heading_deg(found, at(0.0, 4.0)) < 90.0
    assert 270.0 < heading_deg(found, at(0.0, 4.6)) < 315.0
    assert 270.0 < heading_deg(found, at(0.0, 0.0)) < 315.0
    assert 45.0 < heading_deg(found, at(0.0, -4.6)) < 90.0


def test_to_leeward_it_aims_against_the_wind_and_to_windward_before_it() -> None:
    assert heading_deg(keeper(), at(-10.0, 0.0)) < 45.0
    assert 90.0 < heading_deg(keeper(), at(10.0, 0.0)) < 180.0


@pytest.mark.parametrize(("wind_mps", "speed_mps"), [(3.0, 0.8), (8.0, 1.452), (12.0, 2.0)])
def test_its_speed_is_that_of_hold_and_enough_for_a_tack(wind_mps: float, speed_mps: float) -> None:
    setpoint = keeper().update(replace(at(0.0, 0.0), wind_speed_mps=wind_mps), None, 2.0, 0.1)
    assert isinstance(setpoint, PathSetpoint)
    assert setpoint.surge_mps == pytest.approx(speed_mps)


def test_a_new_point_is_reached_inside_its_watch_circle() -> None:
    found = keeper()
    assert found.arrived
    found.hold(50.0, 0.0, 0.0, None)
    found.update(at(0.0, 0.0), None, 2.0, 0.1)
    assert not found.arrived
    found.update(at(42.0, 0.0), None, 2.0, 0.1)
    assert found.arrived
    assert found.target[:2] == (50.0, 0.0)


def test_it_sails_by_the_last_wind_and_drifts_without_any() -> None:
    found = keeper()
    found.update(at(0.0, 0.0), None, 2.0, 0.1)
    unknown = replace(at(0.0, 0.0), wind_from_rad=None, wind_speed_mps=None)
    assert isinstance(found.update(unknown, None, 2.0, 0.1), PathSetpoint)
    blind = SailKeeper(BOAT, Parameters())
    blind.start(unknown)
    assert isinstance(blind.update(unknown, None, 2.0, 0.1), WrenchSetpoint)


def test_with_the_motor_it_drifts_near_the_point_and_goes_back_by_it() -> None:
    found = SailKeeper(parse(with_motor(), "boat.toml"), Parameters({"DP_WATCH_R": 10.0, "SAIL_MOTOR": 2}))
    found.start(at(0.0, 0.0))
    assert isinstance(found.update(at(2.0, 0.0), None, 2.0, 0.1), WrenchSetpoint)
    back = found.update(at(9.0, 0.0), None, 2.0, 0.1)
    assert isinstance(back, PathSetpoint)
    assert math.degrees(back.yaw_rad) % 360.0 == pytest.approx(180.0)
    found.hold(100.0, 0.0, 0.0, None)
    assert isinstance(found.update(at(9.0, 0.0), None, 2.0, 0.1), PathSetpoint)
