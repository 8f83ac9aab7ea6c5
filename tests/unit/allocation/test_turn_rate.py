"""How fast a thruster turns, learned from its reports."""

from __future__ import annotations

import math
import random

import pytest

from companion.allocation.turn_rate import TurnRate

CONFIGURED_RADPS = math.radians(70.0)
STOP_RAD = math.radians(24.0)
DT_S = 0.05


class Nozzle:
    """A position servo with a time constant and a fastest turn, whose reports are late and rounded."""

    def __init__(self, rate_radps: float, lag_s: float, late: int = 2) -> None:
        self.turn = TurnRate(CONFIGURED_RADPS)
        self._rate_radps, self._lag_s = rate_radps, lag_s
        self._at_rad, self._now_s = 0.0, 0.0
        self._late = [0.0] * late

    def hold(self, seconds: float, command_rad: float, wiggle_rad: float = 0.0, seed: int = 0) -> int:
        """How often the rate has changed markedly."""
        draw, changes = random.Random(seed), 0
        for _ in range(round(seconds / DT_S)):
            self._now_s += DT_S
            wanted = command_rad + draw.uniform(-wiggle_rad, wiggle_rad)
            step = (wanted - self._at_rad) * min(1.0, DT_S / self._lag_s)
            most = self._rate_radps * DT_S
            self._at_rad += min(most, max(-most, step))
            self._late.append(round(self._at_rad, 3))
            changes += self.turn.update(wanted, self._late.pop(0), self._now_s)
        return changes

    def swing(self, times: int, seconds: float = 3.0, by_rad: float = STOP_RAD) -> int:
        return sum(self.hold(seconds, by_rad * (-1) ** k) for k in range(times))


@pytest.mark.parametrize("rate_deg", [10.0, 14.0, 25.0])
@pytest.mark.parametrize("lag_s", [0.05, 0.2])
def test_a_slow_nozzle_is_learned_in_a_few_swings(rate_deg: float, lag_s: float) -> None:
    nozzle = Nozzle(math.radians(rate_deg), lag_s)
    assert nozzle.swing(6) > 0
    assert math.degrees(nozzle.turn.rate_radps) == pytest.approx(rate_deg, rel=0.2) and nozzle.turn.slow


def test_a_slow_nozzle_is_learned_before_a_bend_asks_for_all_of_it() -> None:
    """A boat in waves asks for 10 degrees to either side; only commands 17 degrees away told, the first in a bend."""
    nozzle = Nozzle(math.radians(14.0), 0.2)
    nozzle.swing(10, 1.2, math.radians(10.0))
    assert math.degrees(nozzle.turn.rate_radps) == pytest.approx(14.0, rel=0.2) and nozzle.turn.slow


@pytest.mark.parametrize("rate_deg", [8.0, 10.0, 14.0])
def test_one_turn_of_a_second_tells(rate_deg: float) -> None:
    """A boat that is steered gently asks for one such turn in a bend, and then for small ones."""
    nozzle = Nozzle(math.radians(rate_deg), 0.2)
    for k in range(5):
        nozzle.hold(0.05, math.radians(4.0 * (k + 1)))
    nozzle.hold(0.6, math.radians(24.0))
    assert math.degrees(nozzle.turn.rate_radps) == pytest.approx(rate_deg, rel=0.2) and nozzle.turn.slow


@pytest.mark.parametrize("late", [0, 2, 4])
@pytest.mark.parametrize("lag_s", [0.1, 0.25, 0.35])
def test_no_command_makes_a_gear_with_a_lag_a_slow_one(lag_s: float, late: int) -> None:
    """Steps, ramps and swings of any size and length, of a gear whose reports come up to 0.2 s late."""
    draw = random.Random(7)
    nozzle = Nozzle(CONFIGURED_RADPS, lag_s, late)
    at_rad = 0.0
    for _ in range(400):
        goal_rad, steps = draw.uniform(-STOP_RAD, STOP_RAD), draw.choice((1, 4, 10, 30, 60))
        for k in range(steps):
            nozzle.hold(DT_S, at_rad + (goal_rad - at_rad) * (k + 1) / steps)
            assert not nozzle.turn.slow
        at_rad = goal_rad


@pytest.mark.parametrize("lag_s", [0.05, 0.2, 0.3])
def test_small_commands_do_not_make_a_nozzle_with_a_lag_a_slow_one(lag_s: float) -> None:
    nozzle = Nozzle(CONFIGURED_RADPS, lag_s)
    for degrees in (4.0, 8.0, 12.0):
        nozzle.swing(10, 1.2, math.radians(degrees))
    assert not nozzle.turn.slow and nozzle.turn.rate_radps > 0.5 * CONFIGURED_RADPS


@pytest.mark.parametrize("lag_s", [0.05, 0.15])
def test_a_nozzle_as_the_file_says_is_left_alone(lag_s: float) -> None:
    nozzle = Nozzle(CONFIGURED_RADPS, lag_s)
    nozzle.swing(10)
    nozzle.hold(60.0, 0.0, wiggle_rad=math.radians(5.0))
    assert nozzle.turn.rate_radps > 0.8 * CONFIGURED_RADPS and not nozzle.turn.slow


def test_one_that_stands_is_stuck_and_teaches_nothing() -> None:
    nozzle = Nozzle(0.0, 0.1)
    assert nozzle.swing(6) == 0 and nozzle.turn.rate_radps == CONFIGURED_RADPS


def test_one_that_is_well_again_is_used_as_before() -> None:
    nozzle = Nozzle(math.radians(14.0), 0.1)
    nozzle.swing(6)
    nozzle.turn.begin_anew()
    assert nozzle.turn.rate_radps == CONFIGURED_RADPS and not nozzle.turn.slow
