"""A boat whose bow the weather holds far off heaves it round."""

import math
from dataclasses import replace

import pytest

from companion.config.vessel import VesselConfig, find, load
from companion.control.bias import BiasForce
from companion.control.controller import Controller
from companion.control.heading import YawLoop
from companion.core.actuation import ZERO_WRENCH
from companion.core.estimate import NO_ESTIMATE
from companion.core.setpoint import NEUTRAL_SETPOINT, PathSetpoint
from companion.params.store import Parameters
from companion.params.table import table_of

TURN = PathSetpoint(0.0, 0.0)


def heaved_nm(boat: VesselConfig, rate_radps: float) -> float:
    """By how much the moment has grown after five seconds two radians off the heading, as a share of its limit."""
    loop = YawLoop(boat, Parameters(boat.parameters, table_of(boat)))
    bias = BiasForce(boat.limits)
    nav = replace(NO_ESTIMATE, yaw_rad=2.0, yaw_rate_radps=rate_radps)
    moments = [loop.moment_nm(TURN, nav, bias, 0.1) for _ in range(50)]
    assert bias.in_body(2.0)[2] == 0.0, "what holds the bow is nothing to learn: it changes its side as the bow turns"
    return (moments[0] - moments[-1]) / boat.limits.yaw_nm


@pytest.mark.parametrize("name", ["otter", "wamv16"])
def test_a_stalled_turn_gets_more_moment_and_a_running_one_does_not(name: str) -> None:
    boat = load(find(name))
    assert heaved_nm(boat, 0.0) > 0.5
    assert heaved_nm(boat, -math.radians(20.0)) == 0.0


def test_a_rudder_may_stall_too() -> None:
    """A skiff weaved: its bow stood 100° off, and the loop asked for next to no moment against what it had learnt."""
    propeller = load(find("rescuerunner")).thrusters[0]
    boat = replace(load(find("otter")), thrusters=(replace(propeller, kind="rudder"),))
    assert heaved_nm(boat, 0.0) > 0.5


@pytest.mark.parametrize("name", ["revolt", "cybership2"])
def test_a_boat_that_can_push_sideways_gets_it_later(name: str) -> None:
    """CyberShip II lay 70° off the heading that a stream of 0.4 m/s asked for, with a sixth of its moment, and passed a
    waypoint 43 m off."""
    boat = load(find(name))
    assert heaved_nm(boat, 0.0) > 0.1
    assert heaved_nm(boat, -math.radians(20.0)) == 0.0


def test_a_jet_may_stall_too() -> None:
    """One of 9 kg ran over its fence, its bow 160° off: the nozzle at its stop, a fifth of its thrust."""
    boat = load(find("rescuerunner"))
    assert heaved_nm(boat, 0.0) > 0.25
    assert heaved_nm(boat, -math.radians(20.0)) == 0.0


def test_an_outboard_does_not_stall() -> None:
    jet = load(find("rescuerunner"))
    assert heaved_nm(replace(jet, thrusters=(replace(jet.thrusters[0], kind="azimuth"),)), 0.0) == 0.0


def test_the_heave_ends_with_the_turn() -> None:
    """A boat of 4 kg turned its bow through the wind to its other beam: it had learnt there what held it on the first.
    It was carried off."""
    boat = load(find("otter"))
    loop, bias = YawLoop(boat, Parameters(boat.parameters, table_of(boat))), BiasForce(boat.limits)
    for _ in range(50):
        loop.moment_nm(TURN, replace(NO_ESTIMATE, yaw_rad=2.0), bias, 0.1)
    fresh = YawLoop(boat, Parameters(boat.parameters, table_of(boat)))
    for yaw_rad in (0.0, -0.5):
        there = replace(NO_ESTIMATE, yaw_rad=yaw_rad)
        assert loop.moment_nm(TURN, there, bias, 0.1) == pytest.approx(
            fresh.moment_nm(TURN, there, BiasForce(boat.limits), 0.1), abs=0.05 * boat.limits.yaw_nm
        )


def test_what_held_the_bow_is_forgotten_while_the_boat_is_neutral() -> None:
    """BlueBoat, disarmed with its bow against a quay, began its next turn with all its moment, and turned at 67 deg/s
    in place of 36."""
    boat = load(find("blueboat"))
    fresh, held = (Controller(boat, Parameters(boat.parameters, table_of(boat))) for _ in range(2))
    nav = replace(NO_ESTIMATE, yaw_rad=2.0)
    for _ in range(300):
        held.update(TURN, nav, ZERO_WRENCH, 0.1)
    assert held.update(TURN, nav, ZERO_WRENCH, 0.1) != fresh.update(TURN, nav, ZERO_WRENCH, 0.1)
    held.update(NEUTRAL_SETPOINT, nav, ZERO_WRENCH, 0.1)
    fresh.reset()
    assert held.update(TURN, nav, ZERO_WRENCH, 0.1) == fresh.update(TURN, nav, ZERO_WRENCH, 0.1)
