"""The thesis's pursuit: its signs, its limits, its live gains."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.baselines.following import ThesisFollowing
from companion.config.vessel import find, load
from companion.core.setpoint import ThrusterSetpoint, WrenchSetpoint
from companion.params.store import Parameters
from tests.unit.estimates import AT_REST
from tests.unit.following.leaders import leader_at

JET = load(find("rescuerunner"))


def law(**parameters: float) -> tuple[ThesisFollowing, Parameters]:
    table = Parameters(parameters)
    return ThesisFollowing(JET, table), table


@pytest.mark.parametrize("bearing_deg", [30.0, 100.0, 179.0, -30.0, -100.0, -179.0])
@pytest.mark.parametrize("yaw_deg", [0.0, 90.0, 200.0])
def test_it_turns_to_the_side_on_which_the_leader_is(bearing_deg: float, yaw_deg: float) -> None:
    """Also behind it, where arctan of a quotient turns the wrong way."""
    block, _ = law()
    at = math.radians(bearing_deg + yaw_deg)
    nav = replace(AT_REST, yaw_rad=math.remainder(math.radians(yaw_deg), math.tau))
    setpoint = block.update(nav, leader_at(40.0 * math.cos(at), 40.0 * math.sin(at)), 20.0, 0.05)
    assert isinstance(setpoint, ThrusterSetpoint) and setpoint.thrusters is not None
    azimuth = setpoint.thrusters[0].azimuth_rad
    assert azimuth is not None and math.copysign(1.0, block.nozzle) == math.copysign(1.0, bearing_deg)
    assert azimuth * JET.thrusters[0].x_m * bearing_deg > 0.0, "moment x T sin δ towards the leader"
    assert abs(azimuth) <= math.radians(24.0) + 1e-9


def test_distance_error_is_held_to_20_m() -> None:
    """0.15 · 20 m: 3 m/s from a standstill, however far the leader is."""
    found = []
    for far_m in (45.0, 300.0):
        block, _ = law(FOLT_KI_SPD=0.0)
        block.update(AT_REST, leader_at(far_m), 20.0, 0.05)
        found.append(block.throttle)
    assert found == pytest.approx([0.15 * 0.15 * 20.0] * 2, rel=1e-5)


def test_gains_are_live() -> None:
    block, table = law(FOLT_KI_SPD=0.0, FOLT_KD=0.0)
    block.update(AT_REST, leader_at(30.0, 3.0), 20.0, 0.05)
    before = block.nozzle
    table.set("FOLT_KP", 2.4)
    block.update(AT_REST, leader_at(30.0, 3.0), 20.0, 0.05)
    assert block.nozzle == pytest.approx(2.0 * before)


def test_it_samples_at_20_hz() -> None:
    block, _ = law()
    block.update(AT_REST, leader_at(30.0, 3.0), 20.0, 0.01)
    first = block.nozzle
    for _ in range(4):
        block.update(AT_REST, leader_at(30.0, -9.0), 20.0, 0.01)
        assert block.nozzle == first
    block.update(AT_REST, leader_at(30.0, -9.0), 20.0, 0.01)
    assert block.nozzle != first


def test_other_boats_get_shares_of_their_limits() -> None:
    revolt = load(find("revolt"))
    block = ThesisFollowing(revolt, Parameters())
    setpoint = block.update(AT_REST, leader_at(60.0, 60.0), 20.0, 0.2)
    assert isinstance(setpoint, WrenchSetpoint) and setpoint.wrench is not None
    assert setpoint.wrench.yaw_nm == pytest.approx(block.nozzle * revolt.limits.yaw_nm) and setpoint.wrench.yaw_nm > 0.0
    assert 0.0 < setpoint.wrench.surge_n <= revolt.limits.surge_n
