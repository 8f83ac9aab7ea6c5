"""Would it hold with one thruster less: against scipy, against what the ReVolt can do by hand, and what is said."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import astuple, replace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import linprog

from companion.allocation.geometry import Thruster, thrusters_of
from companion.config.devices import ThrusterConfig
from companion.config.vessel import VesselConfig
from companion.core.actuation import Wrench
from companion.core.decision import ModeId
from companion.positioning import consequence
from companion.positioning.consequence import is_met
from tests.unit.conftest import Boat

SIDES = 48


def shortfall(thrusters: Any, limits: Any, demand: Any, out: frozenset[int], radius: float) -> float:
    """Largest error, as a share of the limits, that a linear programme cannot avoid; discs as polygons inscribed in
    `radius` of them."""
    columns, rows, bounds = [], [], []
    used = [t for i, t in enumerate(thrusters) if i not in out]
    for t in used:
        angles = (0.0, math.pi / 2.0) if t.turns else (t.rest_rad,)
        for angle in angles:
            columns.append((math.cos(angle), math.sin(angle), t.x_m * math.sin(angle) - t.y_m * math.cos(angle)))
            bounds.append((None, None) if t.turns else (t.min_n, t.max_n))
    matrix = np.array(columns).T / np.array(limits)[:, None]
    target = np.array(demand) / np.array(limits)
    count, at = matrix.shape[1], 0
    for t in used:
        if t.turns:
            for k in range(SIDES):
                row = np.zeros(count + 1)
                angle = 2.0 * math.pi * k / SIDES
                row[at], row[at + 1] = math.cos(angle), math.sin(angle)
                rows.append((row, radius * t.max_n * math.cos(math.pi / SIDES) if radius == 1.0 else t.max_n))
            at += 2
        else:
            at += 1
    error = np.hstack([matrix, -np.ones((3, 1))]), np.hstack([-matrix, -np.ones((3, 1))])
    a = np.vstack([*(row for row, _ in rows), *error]) if rows else np.vstack(error)
    b = np.concatenate([[limit for _, limit in rows], target, -target])
    result = linprog([0.0] * count + [1.0], A_ub=a, b_ub=b, bounds=[*bounds, (0.0, None)])
    return float(result.x[-1])


def test_against_a_linear_programme(revolt: VesselConfig) -> None:
    thrusters, limits = thrusters_of(revolt), (50.0, 20.0, 32.0)
    random = np.random.default_rng(3)
    answers = []
    for _ in range(60):
        demand = tuple(random.uniform(-1.0, 1.0, 3) * limits * random.uniform(0.1, 1.0))
        out = frozenset({int(random.integers(0, 3))})
        met = is_met(thrusters, limits, Wrench(*demand), out)
        inner, outer = shortfall(thrusters, limits, demand, out, 1.0), shortfall(thrusters, limits, demand, out, 2.0)
        if inner < 0.008:
            assert met
        if outer > 0.013:
            assert not met
        answers.append(met)
    assert 10 < sum(answers) < 50


@pytest.mark.parametrize(
    ("demand", "out", "met"),
    [
        ((25.0, 0.0, 3.7), 1, True),  # one pod, 0.15 m to port of the middle: its thrust turns the bow to starboard
        ((26.5, 0.0, 3.9), 1, False),
        ((0.0, 4.0, 0.0), 2, True),  # without the bow: 4 N at −1.65 m are 6.6 Nm, and 25 N each way at 0.15 m give 7.5
        ((0.0, 5.0, 0.0), 2, False),
        ((0.0, 12.0, 0.0), 0, True),
        ((0.0, -12.0, 0.0), 0, False),  # the bow thruster pulls 6.1 N to port, of which two in three are needed
        ((0.0, 0.0, 0.0), 2, True),
    ],
)
def test_against_cases_worked_by_hand(
    revolt: VesselConfig, demand: tuple[float, float, float], out: int, met: bool
) -> None:
    assert is_met(thrusters_of(revolt), (50.0, 20.0, 32.0), Wrench(*demand), frozenset({out})) is met


def pod(low_deg: float | None, high_deg: float | None, min_n: float) -> Thruster:
    low, high = (None if a is None else math.radians(a) for a in (low_deg, high_deg))
    return Thruster(ThrusterConfig("pod", "azimuth", 0.0, 0.0, 10.0, min_n, 10.0, 10.0, 50.0, 0.0, 1.0, low, high))


@pytest.mark.parametrize(
    ("sector", "min_n", "angle_deg", "met"),
    [
        ((-45.0, 45.0), -10.0, 30.0, True),
        ((-45.0, 45.0), -10.0, 60.0, False),
        ((-270.0, 270.0), 0.0, 170.0, True),
        ((-100.0, 100.0), -10.0, 170.0, True),
        ((-115.0, 115.0), 0.0, 170.0, False),
        ((-115.0, 115.0), -4.0, 170.0, False),
        ((-115.0, 115.0), -4.0, 80.0, True),
        ((-178.0, 178.0), 0.0, 170.0, True),
        ((None, None), 0.0, 170.0, True),
    ],
)
def test_sectors(sector: tuple[float | None, float | None], min_n: float, angle_deg: float, met: bool) -> None:
    angle = math.radians(angle_deg)
    demand = Wrench(9.0 * math.cos(angle), 9.0 * math.sin(angle), 0.0)
    assert is_met((pod(*sector, min_n),), (10.0, 10.0, 0.0), demand, frozenset()) is met


def test_without_any_thruster_only_a_zero_wrench_is_met(revolt: VesselConfig) -> None:
    everything = frozenset(range(3))
    assert is_met(thrusters_of(revolt), (50.0, 20.0, 32.0), Wrench(0.0, 0.0, 0.0), everything)
    assert not is_met(thrusters_of(revolt), (50.0, 20.0, 32.0), Wrench(5.0, 0.0, 0.0), everything)


# --- what is said --------------------------------------------------------------------------------------------------


def holding(boat: Boat) -> Any:
    boat.supervisor.request_mode(ModeId.HOLD, boat.now_s)
    boat.supervisor.arm(boat.now_s)
    boat.step(5.0)
    return boat


def test_announced_only_when_the_answer_changes(boat: Boat) -> None:
    holding(boat)
    boat.step(30.0)
    assert "consequence" not in boat.names()
    boat.supervisor.thrust_achieved(Wrench(0.0, 8.0, 0.0))
    boat.step(120.0)
    assert [text for name, text in boat.said if name == "consequence"] == ["Would not hold if bow failed"]
    boat.supervisor.thrust_achieved(Wrench(0.0, 1.0, 0.0))
    boat.step(120.0)
    assert boat.names().count("consequence") == 1 and boat.names().count("consequence_over") == 1


def test_near_the_limit_it_is_not_announced_again_and_again(boat: Boat) -> None:
    """Without the bow there are some 4 N; the mean goes to and fro over it, by more than the margin."""
    holding(boat)
    for _ in range(10):
        for sway_n in (6.0, 2.0):
            boat.supervisor.thrust_achieved(Wrench(0.0, sway_n, 0.0))
            boat.step(20.0)
    assert boat.names().count("consequence") == 1 and "consequence_over" not in boat.names()


def test_a_gust_does_not_count(boat: Boat) -> None:
    holding(boat)
    boat.step(60.0)
    boat.supervisor.thrust_achieved(Wrench(0.0, 15.0, 0.0))
    boat.step(3.0)
    boat.supervisor.thrust_achieved(Wrench(0.0, 0.0, 0.0))
    boat.step(60.0)
    assert "consequence" not in boat.names()


def test_with_one_dead_already_the_next_one_counts(boat: Boat) -> None:
    holding(boat)
    boat.supervisor.thruster_failed(0, True)
    boat.supervisor.thrust_achieved(Wrench(5.0, 0.0, 0.0))
    boat.step(60.0)
    assert "Would not hold if stern_starboard failed" in boat.texts()


def test_it_can_be_switched_off(make_boat: Callable[..., Boat]) -> None:
    boat = holding(make_boat(DP_CONSEQ=0))
    boat.supervisor.thrust_achieved(Wrench(0.0, 8.0, 0.0))
    boat.step(60.0)
    assert "consequence" not in boat.names()


def test_a_boat_without_sideways_thrust_has_no_check(make_boat: Callable[..., Boat], revolt: VesselConfig) -> None:
    boat = holding(make_boat(replace(revolt, limits=replace(revolt.limits, sway_n=0.0))))
    boat.supervisor.thrust_achieved(Wrench(20.0, 8.0, 0.0))
    boat.step(60.0)
    assert "consequence" not in boat.names()


def test_one_thruster_a_tick_and_the_answer_soon(boat: Boat, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[float] = []

    def counted(*arguments: Any) -> bool:
        asked.append(boat.now_s)
        return is_met(*arguments)

    monkeypatch.setattr(consequence, "is_met", counted)
    holding(boat)
    boat.supervisor.thrust_achieved(Wrench(3.0, 0.0, 0.0))
    boat.step(40.0)
    assert (
        len(asked) == len(set(asked)) and 60 <= len(asked) <= 90
    )  # three thrusters, each once a second after the first 15 s
    boat.supervisor.thruster_failed(0, True)
    boat.step(1.5)
    assert "Would not hold if stern_starboard failed" in boat.texts()


@pytest.mark.parametrize("ticks", range(11))
def test_a_thruster_may_fail_anywhere_in_a_round(boat: Boat, ticks: int) -> None:
    holding(boat)
    boat.supervisor.thrust_achieved(Wrench(3.0, 0.0, 0.0))
    boat.step(20.0)
    for _ in range(ticks):
        boat.step()
    boat.supervisor.thruster_failed(0, True)
    boat.step(1.4)  # at most a second to the next round, which then takes a tick a thruster
    assert boat.texts()[-1] == "Would not hold if stern_starboard failed"


def test_a_wrench_out_of_reach_is_refused_in_a_few_steps(revolt: VesselConfig) -> None:
    thrusters, limits = thrusters_of(revolt), (50.0, 20.0, 32.0)
    demand, out = Wrench(0.0, 15.0, 0.0), frozenset({2})
    assert shortfall(thrusters, limits, astuple(demand), out, 2.0) > 0.05
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(consequence, "_MOST_STEPS", 20)
        patch.setattr(consequence, "_error", counted_errors := Counted(consequence._error))
        assert not is_met(thrusters, limits, demand, out)
    assert counted_errors.count < 20


class Counted:
    """A function that counts its calls."""

    def __init__(self, function: Any) -> None:
        self.function, self.count = function, 0

    def __call__(self, *arguments: Any) -> Any:
        self.count += 1
        return self.function(*arguments)
