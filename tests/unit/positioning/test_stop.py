"""Where a boat without sideways thrust holds after a stop."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config.vessel import find, load
from companion.core.estimate import NO_ESTIMATE, NavState
from companion.core.setpoint import PathSetpoint, WrenchSetpoint
from companion.params.store import Parameters
from companion.params.table import table_of
from companion.positioning.bow_keeper import BowKeeper
from companion.positioning.drift import DriftKeeper
from companion.positioning.stop import Stop
from tests.unit.rudder_boat import SKIFF

REST_MPS = 0.2


def at(north_m: float, surge_mps: float, yaw_rad: float = 0.0) -> NavState:
    return replace(
        NO_ESTIMATE,
        north_m=north_m,
        yaw_rad=yaw_rad,
        surge_mps=surge_mps,
        north_mps=surge_mps * math.cos(yaw_rad),
        east_mps=surge_mps * math.sin(yaw_rad),
    )


def begun(planned_m: float, surge_mps: float = 2.0) -> Stop:
    stop = Stop(REST_MPS)
    stop.begin(at(0.0, surge_mps), (planned_m, 0.0))
    return stop


def test_the_place_of_rest_is_held() -> None:
    stop = begun(20.0)
    assert stop.place(at(2.0, 1.0)) is None and stop.lasts
    assert stop.place(at(3.0, 0.1)) == (3.0, 0.0) and not stop.lasts


def test_where_the_boat_does_not_rest_in_time_the_planned_point_is_held() -> None:
    stop = begun(5.0)
    assert stop.place(at(5.5, 1.0)) == (5.0, 0.0) and not stop.lasts


def test_a_boat_carried_aside_does_not_stop_for_ever() -> None:
    stop = begun(5.0)
    assert stop.place(replace(at(0.0, 1.0), east_m=6.0)) == (5.0, 0.0)


def test_a_stop_from_sailing_astern() -> None:
    stop = begun(-20.0, surge_mps=-2.0)
    assert stop.place(at(-2.0, -1.0)) is None
    assert stop.place(at(-3.0, -0.1)) == (-3.0, 0.0)


def test_a_boat_at_rest_has_nothing_to_stop() -> None:
    assert not begun(0.1, surge_mps=0.1).lasts


def otter() -> BowKeeper:
    config = load(find("otter"))
    return BowKeeper(config, Parameters(config.parameters, table_of(config)))


def test_two_motors_brake_with_all_they_have_and_hold_there() -> None:
    keeper = otter()
    keeper.start(at(0.0, 2.0, yaw_rad=0.0))
    braking = keeper.update(at(1.0, 1.5), None, 1.0, 0.1)
    assert isinstance(braking, PathSetpoint) and braking.surge_mps == 0.0 and braking.yaw_rad == 0.0
    assert not keeper.arrived
    keeper.update(at(2.0, 0.1), None, 1.0, 0.1)
    assert keeper.target[:2] == (2.0, 0.0) and keeper.arrived


def test_a_boat_that_only_drifts_aside_holds_where_it_is() -> None:
    """The point was planned 2.4 m on, by a braking aside that it has no thrust for: towards a fence."""
    keeper = otter()
    keeper.start(replace(at(0.0, 0.1), sway_mps=0.42, east_mps=0.42))
    assert keeper.target[:2] == (0.0, 0.0)


def test_a_point_that_is_given_is_held_at_once() -> None:
    keeper = otter()
    keeper.start(at(0.0, 2.0))
    keeper.hold(4.0, 0.0, 0.0, None)
    going = keeper.update(at(0.5, 2.0), None, 1.0, 0.1)
    assert isinstance(going, PathSetpoint) and going.surge_mps > 0.0 and keeper.target[:2] == (4.0, 0.0)


@pytest.mark.parametrize("rest_m", [40.0, 90.0])
def test_a_jet_holds_where_it_has_coasted_to(rest_m: float) -> None:
    config = load(find("rescuerunner"))
    keeper = DriftKeeper(config, Parameters(config.parameters))
    keeper.start(at(0.0, 16.0))
    planned_m = keeper.target[0]
    assert planned_m > 100.0
    for north_m in range(0, int(rest_m), 5):
        assert isinstance(keeper.update(at(float(north_m), 5.0), None, 8.0, 0.05), WrenchSetpoint)
    keeper.update(at(rest_m, 1.0), None, 8.0, 0.05)
    assert keeper.target[0] == rest_m


def test_a_rudder_is_not_asked_to_hold_the_heading_while_the_boat_brakes() -> None:
    """It would do so by thrust ahead: a barge drove on for 10 m, over its fence."""
    keeper = BowKeeper(SKIFF, Parameters(SKIFF.parameters))
    keeper.start(at(0.0, 1.4))
    turned = keeper.update(at(1.0, 1.0, yaw_rad=0.6), None, 1.0, 0.1)
    assert isinstance(turned, PathSetpoint) and turned.surge_mps == 0.0 and turned.yaw_rad == 0.6
