"""A large error of the speed is learnt only from a boat that does not accelerate."""

from __future__ import annotations

import math

import pytest

from companion.config.vessel import find, load
from companion.control.bias import BiasForce
from companion.control.heading import YawLoop
from companion.control.path_control import PathControl
from companion.control.speed_stall import SpeedStall
from companion.core.setpoint import PathSetpoint
from companion.params.store import Parameters
from companion.params.table import table_of
from tests.unit.control.simple_boat import nav_state

MOST_MPS, DT_S = 0.3, 0.1


def learnt(wanted_mps: float, from_mps: float, time_constant_s: float) -> list[float]:
    """What is learnt from in each tick of 12 s of a boat that nears its speed so."""
    stall = SpeedStall()
    speeds = [wanted_mps + (from_mps - wanted_mps) * math.exp(-k * DT_S / time_constant_s) for k in range(120)]
    return [stall.offset_mps(wanted_mps - speed, speed, MOST_MPS, DT_S) for speed in speeds]


@pytest.mark.parametrize(("wanted_mps", "from_mps"), [(2.0, 0.0), (0.0, 2.0), (-1.0, 1.0), (17.0, 0.0)])
def test_an_acceleration_is_not_learnt(wanted_mps: float, from_mps: float) -> None:
    assert all(offset == 0.0 for offset in learnt(wanted_mps, from_mps, 4.0)[:70] if abs(offset) >= MOST_MPS)


@pytest.mark.parametrize("wanted_mps", [0.5, -0.5])
def test_a_boat_that_stands_is_learnt_from_after_a_while_within_bounds(wanted_mps: float) -> None:
    offsets = learnt(wanted_mps, 0.0, 1.0e9)
    assert offsets[:28] == [0.0] * 28
    assert offsets[40:] == [math.copysign(MOST_MPS, wanted_mps)] * 80


def test_a_small_error_is_learnt_at_once_and_ends_a_stall() -> None:
    stall = SpeedStall()
    for _ in range(60):
        stall.offset_mps(0.5, 0.0, MOST_MPS, DT_S)
    assert stall.offset_mps(0.2, 0.3, MOST_MPS, DT_S) == 0.2
    assert stall.offset_mps(0.5, 0.0, MOST_MPS, DT_S) == 0.0


def test_a_stream_that_balances_the_speed_loop_does_not_hold_the_boat() -> None:
    """Otter came home past its point and lay 7 m downstream for good: 0.5 m/s too slow, and nothing was learnt."""
    boat = load(find("otter"))
    parameters = Parameters(boat.parameters, table_of(boat))
    bias, control = BiasForce(boat.limits), PathControl(boat, parameters, YawLoop(boat, parameters))
    resisting_n, surge_mps, farthest_n = 0.25 * boat.limits.surge_n, 0.0, 0.0
    for k in range(600):
        wrench = control.update(PathSetpoint(0.0, 0.5), nav_state(surge_mps=surge_mps, t_s=k * DT_S), bias, DT_S)
        surge_mps += (wrench.surge_n - resisting_n - 77.0 * surge_mps) / boat.hull.m11_kg * DT_S
        farthest_n = max(farthest_n, abs(bias.in_body(0.0)[0]))
    assert surge_mps == pytest.approx(0.5, abs=0.05)
    assert farthest_n < 2.0 * resisting_n
