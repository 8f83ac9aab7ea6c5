"""Allocation of propellers with rudders beside other thrusters: which of them do what, and what is said of it."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from companion.allocation.choice import allocator_of
from companion.allocation.rudder_curve import RudderCurve
from companion.allocation.rudders import RuddersAllocator
from companion.cli.new_file import file_text
from companion.config.vessel import VesselConfig, parse
from companion.core.actuation import Allocation, ThrusterCommand, Wrench
from companion.params.store import Parameters
from tests.unit.rudder_boat import ANSWERS, SHIP_TEXT, SKIFF, beside

TWO = parse(file_text(replace(ANSWERS, layout="two-rudders", spread_m=0.4)), "two.toml")
BOW = parse(file_text(replace(ANSWERS, layout="rudder-bow", bow_motor="10")), "bow.toml")
DT_S = 0.1
SHIP = parse(SHIP_TEXT, "ship.toml")
_MODEL = replace(ANSWERS, layout="two-rudders", length_m=1.255, beam_m=0.29, mass_kg=23.8, motor="4", spread_m=0.156)
MODEL = parse(beside(file_text(_MODEL), bow=(0.466, 2.0)), "model.toml")
numbers, shares = st.floats(-1.5, 1.5), st.floats(-0.4, 0.4)


def made(boat: VesselConfig, **parameters: float) -> RuddersAllocator:
    found = allocator_of(boat, Parameters({**boat.parameters, **parameters}))
    assert isinstance(found, RuddersAllocator)
    return found


def settle(a: RuddersAllocator, wrench: Wrench, surge_mps: float = 0.0, steps: int = 80) -> Allocation:
    for _ in range(steps):
        result = a.update(wrench, DT_S, surge_mps)
    return result


def given_by(boat: VesselConfig, commands: tuple[ThrusterCommand, ...], surge_mps: float) -> tuple[float, float, float]:
    """(surge, sway, yaw) of commands, from the curves alone."""
    x = y = n = 0.0
    for thruster, command in zip(boat.thrusters, commands, strict=True):
        c, s = math.cos(thruster.azimuth_rad), math.sin(thruster.azimuth_rad)
        x, y = x + c * command.force_n, y + s * command.force_n
        n += (thruster.x_m * s - thruster.y_m * c) * command.force_n
        if thruster.rudder is not None:
            assert command.azimuth_rad is not None
            ahead_n, side_n = RudderCurve(thruster).force_n(command.force_n, command.azimuth_rad, surge_mps)
            drag_n = ahead_n - command.force_n
            x, y, n = x + drag_n, y + side_n, n + thruster.rudder.x_m * side_n - thruster.y_m * drag_n
    return x, y, n


def test_a_rudder_alone_keeps_its_own_allocation() -> None:
    assert not isinstance(allocator_of(SKIFF, Parameters(SKIFF.parameters)), RuddersAllocator)


@pytest.mark.parametrize("boat", [TWO, BOW])
@given(surge=numbers, yaw=numbers, surge_mps=st.floats(-1.0, 3.0))
def test_what_is_said_is_what_the_commands_give(boat: VesselConfig, surge: float, yaw: float, surge_mps: float) -> None:
    limits = boat.limits
    result = settle(made(boat), Wrench(surge * limits.surge_n, 0.0, yaw * limits.yaw_nm), surge_mps, steps=12)
    achieved = result.achieved
    assert (achieved.surge_n, achieved.sway_n, achieved.yaw_nm) == pytest.approx(
        given_by(boat, result.thrusters, surge_mps), abs=1e-9
    )
    for thruster, command in zip(boat.thrusters, result.thrusters, strict=True):
        assert thruster.min_n - 1e-9 <= command.force_n <= thruster.max_n + 1e-9
        assert (command.azimuth_rad is None) == (thruster.rudder is None)
        assert abs(command.azimuth_rad or 0.0) <= math.radians(35.0) + 1e-9


def test_under_way_the_blades_steer_and_the_screws_push_alike() -> None:
    result = settle(made(TWO), Wrench(60.0, 0.0, 8.0), 1.5)
    port, starboard = result.thrusters
    assert result.achieved.yaw_nm == pytest.approx(8.0, abs=0.2) and not result.limited[2]
    assert port.azimuth_rad == pytest.approx(starboard.azimuth_rad, abs=1e-3) and port.azimuth_rad is not None
    assert port.azimuth_rad < -math.radians(3.0)  # the stern goes to port
    assert abs(port.force_n - starboard.force_n) < 0.5 * 8.0 / 0.2  # less than half of the moment is theirs


@pytest.mark.parametrize("boat", [TWO, BOW, SHIP])
@settings(max_examples=40)
@given(surge=st.floats(-0.15, 0.4), sway=shares, yaw=shares, surge_mps=st.floats(-0.5, 2.0))
def test_a_moderate_demand_is_given(
    boat: VesselConfig, surge: float, sway: float, yaw: float, surge_mps: float
) -> None:
    x, y, n = boat.limits.surge_n, boat.limits.sway_n, boat.limits.yaw_nm
    asked = Wrench(surge * x, sway * y, yaw * n)
    achieved = settle(made(boat), asked, surge_mps, steps=120).achieved
    drag_n = 0.05 * x  # of the blades
    assert achieved.surge_n == pytest.approx(asked.surge_n, abs=0.03 * x + drag_n)
    assert achieved.yaw_nm == pytest.approx(asked.yaw_nm, abs=0.03 * n)
    assert y == 0.0 or achieved.sway_n == pytest.approx(asked.sway_n, abs=0.03 * y)


def test_at_rest_differential_thrust_turns_the_boat() -> None:
    result = settle(made(TWO), Wrench(0.0, 0.0, 0.5 * TWO.limits.yaw_nm))
    port, starboard = result.thrusters
    assert port.force_n > 1.0 and starboard.force_n < -1.0
    assert result.achieved.yaw_nm == pytest.approx(0.5 * TWO.limits.yaw_nm, rel=0.05)
    assert abs(result.achieved.surge_n) < 0.05 * TWO.limits.surge_n


def test_at_rest_the_rudder_behind_the_screw_that_pushes_ahead_helps() -> None:
    turn = Wrench(0.0, 0.0, 0.9 * TWO.limits.yaw_nm)
    result = settle(made(TWO), turn, steps=150)
    port, _ = result.thrusters
    assert result.achieved.yaw_nm == pytest.approx(turn.yaw_nm, rel=0.05)
    assert port.azimuth_rad is not None and port.azimuth_rad < -math.radians(5.0)


def test_the_blades_settle_with_the_thrust_that_serves_them() -> None:
    """More blade asks for less differential thrust, which leaves the blade less race: that must not swing."""
    a = made(TWO)
    settle(a, Wrench(0.0, 0.0, 0.8 * TWO.limits.yaw_nm), steps=100)
    angles = [settle(a, Wrench(0.0, 0.0, 0.8 * TWO.limits.yaw_nm), steps=1).thrusters[0].azimuth_rad for _ in range(30)]
    assert max(map(float, filter(None, angles))) - min(map(float, filter(None, angles))) < math.radians(2.0)


def test_at_rest_the_bow_thruster_turns_the_boat_and_under_way_the_blade() -> None:
    turn = Wrench(0.0, 0.0, 0.5 * BOW.limits.yaw_nm)
    _, bow = settle(made(BOW), turn).thrusters
    assert bow.force_n * BOW.thrusters[1].x_m == pytest.approx(turn.yaw_nm, rel=0.1)
    screw, less = settle(made(BOW), replace(turn, surge_n=50.0), 2.0).thrusters
    assert screw.azimuth_rad is not None and screw.azimuth_rad < -math.radians(1.5)
    assert abs(less.force_n) < 0.5 * bow.force_n


@pytest.mark.parametrize("seed", range(5))
def test_in_positioning_every_axis_is_given_in_every_cycle(seed: int) -> None:
    """A ship of 1.25 m with two screws and a thruster across the bow gave half of the sideways force, in a calm."""
    demands, a = random.Random(seed), made(MODEL)
    x, y, n = (MODEL.limits.surge_n, MODEL.limits.sway_n, MODEL.limits.yaw_nm)
    surge, sway, yaw = 0.0, 0.5 * y, 0.0
    for i in range(300):
        surge += 0.02 * x * demands.uniform(-1.0, 1.0) - 0.05 * surge
        yaw += 0.02 * n * demands.uniform(-1.0, 1.0) - 0.05 * yaw
        achieved = a.update(Wrench(surge, sway, yaw), DT_S, demands.uniform(-0.05, 0.05)).achieved
        if i > 30:
            assert achieved.sway_n == pytest.approx(sway, abs=0.05 * y)
            assert achieved.yaw_nm == pytest.approx(yaw, abs=0.05 * n)
            assert achieved.surge_n == pytest.approx(surge, abs=0.05 * x)


def test_thrust_that_comes_and_goes_carries_no_rudder() -> None:
    a = made(BOW)
    for i in range(100):
        result = a.update(Wrench(40.0 if i // 3 % 2 else -40.0, 0.0, 2.0), DT_S)
        assert result.achieved.yaw_nm == pytest.approx(2.0, abs=0.6) or i < 10


def test_thrust_is_added_for_the_blade_where_the_bow_thruster_has_failed() -> None:
    a, turn = made(BOW), Wrench(0.0, 0.0, BOW.limits.yaw_nm)
    a.set_failed(1, True)
    result = settle(a, turn)
    screw, bow = result.thrusters
    assert bow.force_n == 0.0 and 5.0 < screw.force_n <= 0.35 * BOW.thrusters[0].max_n
    assert result.achieved.yaw_nm > 0.8 * turn.yaw_nm
    back = settle(a, Wrench(0.0, 0.0, 0.0)).thrusters[0]
    assert abs(back.force_n) < 1.0
    assert settle(made(BOW, RUD_STEER=0.0), turn).thrusters[0].force_n < 1.0


def test_a_screw_that_fails_leaves_the_other_with_its_rudder() -> None:
    a = made(TWO)
    a.set_failed(0, True)
    result = settle(a, Wrench(30.0, 0.0, 0.0), 1.5)
    port, starboard = result.thrusters
    assert port.force_n == 0.0 and starboard.force_n == pytest.approx(30.0, abs=5.0)
    assert result.achieved.yaw_nm == pytest.approx(0.0, abs=0.3)  # by the rudders, against the lone screw


def test_sticks_reach_screws_blades_and_bow_thruster() -> None:
    a = made(BOW)
    commands = (ThrusterCommand(0.0, 0.5, -0.4), ThrusterCommand(0.0, -0.7, None))
    for _ in range(60):
        result = a.direct(commands, surge_mps=1.0)
    screw, bow = result.thrusters
    assert (screw.throttle, bow.throttle) == (pytest.approx(0.5), pytest.approx(-0.7))
    assert screw.azimuth_rad == pytest.approx(-0.4)
    assert a.neutral().thrusters[0].force_n == 0.0 and a.neutral().thrusters[0].azimuth_rad == pytest.approx(-0.4)


def test_a_slower_blade_is_turned_no_faster() -> None:
    a = made(BOW)
    a.set_turn_rate(0, 0.05)
    command = (ThrusterCommand(0.0, 0.5, 0.4),)
    assert a.direct(command, 1.0).thrusters[0].azimuth_rad == pytest.approx(0.05)


def test_numbers_that_are_not_finite_ask_for_nothing() -> None:
    result = settle(made(TWO), Wrench(math.nan, 0.0, 5.0), math.inf, steps=3)
    assert all(command.force_n == 0.0 for command in result.thrusters)
