"""Where a boat comes to rest, and whether that is inside."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config.vessel import find, load
from companion.modes.trial.circle import TrialCircle
from companion.modes.trial.expectation import expected
from tests.unit.conftest import AT_REST
from tests.unit.rudder_boat import SKIFF

EXPECTATION = expected(load(find("revolt")))


def at(north_m: float, north_mps: float, **more: float) -> object:
    return replace(AT_REST, north_m=north_m, north_mps=north_mps, surge_mps=north_mps, **more)


def test_what_the_model_expects() -> None:
    assert EXPECTATION.top_mps == pytest.approx(50.0 / 50.66, rel=1e-3)
    assert EXPECTATION.brake_mps2 == pytest.approx(50.0 / 263.93)
    assert EXPECTATION.sways and EXPECTATION.budget_s == pytest.approx(900.0 * 1.5**0.5)
    assert not expected(load(find("rescuerunner"))).sways


def test_it_leaves_when_it_would_stop_outside() -> None:
    circle = TrialCircle((0.0, 0.0), 20.0, EXPECTATION)
    inner = 20.0 - 1.5
    stop_m = 1.5 + 0.5 / (0.5 * 50.0 / 263.93)
    assert not circle.leaves(at(inner - stop_m - 0.1, 1.0), 0.0)  # type: ignore[arg-type]
    assert circle.leaves(at(inner - stop_m + 0.1, 1.0), 0.0)  # type: ignore[arg-type]
    assert not circle.leaves(at(inner + 1.0, -0.1), 0.0)  # type: ignore[arg-type]


def test_a_current_that_carries_it_out_while_it_turns_counts() -> None:
    circle = TrialCircle((0.0, 0.0), 20.0, EXPECTATION)
    nav = at(12.0, 0.2, current_north_mps=0.4, current_east_mps=0.0)
    assert not circle.leaves(nav, 0.0)  # type: ignore[arg-type]
    assert circle.leaves(nav, 20.0)  # type: ignore[arg-type]


def test_what_it_saw_of_braking_counts() -> None:
    circle = TrialCircle((0.0, 0.0), 20.0, EXPECTATION)
    believed = circle.brake_mps2
    circle.learn(0.9, 0.1, 16.0)
    assert circle.brake_mps2 == pytest.approx(0.7 * 0.05) and circle.brake_mps2 < believed
    circle.learn(0.9, 0.1, 8.0)
    assert circle.brake_mps2 == pytest.approx(0.7 * 0.05)
    circle.learn(0.1, 0.0, 8.0)  # too slow to tell
    assert circle.brake_mps2 == pytest.approx(0.7 * 0.05)


def test_a_rudder_boat_turns_slower_with_way_on_and_is_believed_to_turn_slower_still() -> None:
    skiff = expected(SKIFF)
    d, u = SKIFF.hull.damping, 0.5 * skiff.top_mps
    moment_nm = (d.n_r + d.n_ur * u + d.n_rr * skiff.turn_radps) * skiff.turn_radps
    assert moment_nm == pytest.approx(0.5 * SKIFF.limits.yaw_nm)
    circle = TrialCircle((0.0, 0.0), 20.0, skiff)
    assert circle.turning_s == pytest.approx(math.pi / (0.5 * skiff.turn_radps))


def test_what_it_saw_of_turning_counts() -> None:
    skiff = expected(SKIFF)
    circle = TrialCircle((0.0, 0.0), 20.0, skiff)
    believed_s = circle.turning_s
    circle.learn_turn(0.3, 10.0)  # too small a turn to tell
    assert circle.turning_s == believed_s
    circle.learn_turn(2.0, 4.0)
    assert circle.turning_s == pytest.approx(math.pi / 0.5)
    circle.learn_turn(2.0, 20.0)
    circle.learn_turn(2.0, 4.0)  # the least counts
    assert circle.turning_s == pytest.approx(math.pi / 0.1)


def test_a_boat_with_sideways_thrust_need_not_turn() -> None:
    assert TrialCircle((0.0, 0.0), 20.0, EXPECTATION).turning_s == 0.0


def test_a_current_that_would_carry_it_back_does_not_help() -> None:
    circle = TrialCircle((0.0, 0.0), 20.0, EXPECTATION)
    nav = at(19.0, 0.5, current_north_mps=-0.5, current_east_mps=0.0)
    assert circle.leaves(nav, 20.0)  # type: ignore[arg-type]


def test_the_circle_has_room_for_the_motor_check_in_a_strong_current() -> None:
    for name in ("revolt", "heron", "aboat"):
        e = expected(load(find(name)))
        assert e.radius_m >= 0.4 * e.top_mps * 25.0 and e.radius_m >= 10.0 * e.length_m
