"""A boat whose bow the weather can hold far off learns that moment."""

import math
from dataclasses import replace

import pytest

from companion.config.vessel import VesselConfig, find, load
from companion.control.bias import BiasForce
from companion.control.heading import YawLoop
from companion.core.estimate import NO_ESTIMATE
from companion.core.setpoint import PathSetpoint
from companion.params.store import Parameters
from companion.params.table import table_of


def learnt_nm(boat: VesselConfig, rate_radps: float) -> float:
    """Moment that the bias has learnt after five seconds, two radians off the heading."""
    loop = YawLoop(boat, Parameters(boat.parameters, table_of(boat)))
    bias = BiasForce(boat.limits)
    nav = replace(NO_ESTIMATE, yaw_rad=2.0, yaw_rate_radps=rate_radps)
    for _ in range(50):
        loop.moment_nm(PathSetpoint(0.0, 0.0), nav, bias, 0.1)
    return bias.in_body(2.0)[2]


@pytest.mark.parametrize("name", ["otter", "wamv16"])
def test_a_stalled_turn_is_learnt_and_a_running_one_is_not(name: str) -> None:
    boat = load(find(name))
    assert learnt_nm(boat, 0.0) < -0.1 * boat.limits.yaw_nm
    assert learnt_nm(boat, -math.radians(20.0)) == 0.0


def test_a_rudder_may_stall_too() -> None:
    """A skiff weaved: its bow stood 100° off, and the loop asked for next to no moment against what it had learnt."""
    propeller = load(find("rescuerunner")).thrusters[0]
    boat = replace(load(find("otter")), thrusters=(replace(propeller, kind="rudder"),))
    assert learnt_nm(boat, 0.0) < -0.1 * boat.limits.yaw_nm


def test_boats_with_turning_thrusters_learn_no_turn() -> None:
    assert learnt_nm(load(find("revolt")), 0.0) == 0.0
    assert learnt_nm(load(find("rescuerunner")), 0.0) == 0.0
