"""The observer of moments against a hull with the model's own equation of yaw; the heading in a closed loop."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import pytest

from companion.allocation.allocator import Allocator
from companion.baselines.controller_choice import controller_with_baselines
from companion.control.model import coriolis, damping
from companion.control.yaw_disturbance import YawDisturbance
from companion.core.actuation import ZERO_WRENCH
from companion.core.frames import ned_to_body
from companion.core.setpoint import PoseSetpoint
from companion.params.store import Parameters
from companion.safety import Gate
from tests.unit.control.simple_boat import BOW_DOWN, REVOLT, SimpleBoat, nav_state

DT_S = 0.1
HULL = REVOLT.hull


def observer(**values: float) -> YawDisturbance:
    parameters = Parameters(REVOLT.parameters)
    for name, value in values.items():
        assert parameters.set(name, value) is None
    return YawDisturbance(REVOLT, parameters)


def observed(
    moment_nm: float,
    seconds: float,
    current: tuple[float, float] | None = None,
    flows: bool = True,
    wind: tuple[float, float] | None = (0.0, 0.0),
    **values: float,
) -> float:
    """What is told of a moment on a hull that turns by it and by known moments. `flows`: the estimated current is
    there."""
    gusts, rate, yaw, told = observer(**values), 0.0, 0.3, 0.0
    known = 0.0
    for k in range(round(seconds / DT_S)):
        x, y = (0.0, 0.0) if current is None or not flows else ned_to_body(*current, yaw)
        told = gusts.update(nav_state(yaw_rad=yaw, yaw_rate_radps=rate, current=current, wind=wind), known, DT_S)
        known = 2.0 * math.sin(0.5 * k * DT_S)
        resisting = coriolis(HULL, -x, -y, rate)[2] + damping(HULL, -x, -y, rate)[2]
        rate += DT_S * (known + moment_nm - resisting) / HULL.m33_kgm2
        yaw += DT_S * rate
    return told


def test_a_moment_is_known_after_some_seconds() -> None:
    assert observed(1.5, 3.0, DP_INTEGRAL=0.0) == pytest.approx(1.5, rel=0.15)
    assert observed(0.0, 3.0, DP_INTEGRAL=0.0) == pytest.approx(0.0, abs=0.1)


def test_the_moment_of_a_known_current_is_none() -> None:
    assert observed(0.0, 3.0, current=(0.25, 0.0), DP_INTEGRAL=0.0) == pytest.approx(0.0, abs=0.1)


def test_a_current_that_may_be_the_push_of_an_unmeasured_wind_is_not_used() -> None:
    """CyberShip II, pushed by 1.5 N, took the moment of half a metre a second for one on its hull: 6° off."""
    estimated = {"current": (0.25, 0.0), "flows": False}
    assert observed(0.0, 3.0, **estimated, wind=None, DP_INTEGRAL=0.0) == pytest.approx(0.0, abs=0.1)  # type: ignore[arg-type]
    assert abs(observed(0.0, 3.0, **estimated, DP_INTEGRAL=0.0)) > 0.5  # type: ignore[arg-type]


def test_sway_that_turns_the_hull_by_its_added_mass_is_explained() -> None:
    hull = replace(HULL, m23_kgm=20.0, m32_kgm=20.0)
    gusts = YawDisturbance(replace(REVOLT, hull=hull), Parameters(REVOLT.parameters))
    told = []
    for k in range(60):
        sway, rate = 0.02 * k * DT_S, -20.0 * 0.02 * k * DT_S / hull.m33_kgm2
        resisting = coriolis(hull, 0.0, sway, rate)[2] + damping(hull, 0.0, sway, rate)[2]
        told.append(gusts.update(nav_state(sway_mps=sway, yaw_rate_radps=rate), resisting, DT_S))
    assert max(map(abs, told)) < 0.02


def test_what_lasts_is_left_to_the_integral() -> None:
    assert abs(observed(1.5, 90.0)) < 0.15


def test_a_quay_does_not_wind_it_up() -> None:
    """The hull does not turn, whatever the thrusters give."""
    gusts = observer(DP_INTEGRAL=0.0)
    told = [gusts.update(nav_state(), 1000.0, DT_S) for _ in range(600)]
    assert min(told) == -0.3 * REVOLT.limits.yaw_nm


def test_a_moment_that_is_no_number_is_forgotten() -> None:
    gusts = observer()
    for known in (0.0, 3.0, math.nan, 0.0, 0.0, 0.0):
        told = gusts.update(nav_state(), known, DT_S)
        assert math.isfinite(told)
    assert told == 0.0


def demand_of_a_gust(bow_on: bool) -> float:
    """After the boat has begun to turn without thrust."""
    controller = controller_with_baselines(REVOLT, Parameters(REVOLT.parameters))
    setpoint, demand = PoseSetpoint(0.0, 0.0, 0.0, bow_on=bow_on), ZERO_WRENCH
    for k in range(20):
        demand = controller.update(setpoint, nav_state(yaw_rate_radps=0.002 * k), ZERO_WRENCH, DT_S)
    return demand.yaw_nm


def test_a_boat_that_is_driven_off_does_not_answer_gusts(monkeypatch: pytest.MonkeyPatch) -> None:
    """It has no thrust to spare: ÅBOAT with one pod left was carried 11 m off, in place of 10 m."""
    answers, driven_off = demand_of_a_gust(False), demand_of_a_gust(True)
    monkeypatch.setattr(YawDisturbance, "update", lambda *_: 0.0)
    assert demand_of_a_gust(True) == driven_off
    assert answers < 1.2 * demand_of_a_gust(False) < 0.0


def largest_heading_rad(seed: int, gusts_nm: float) -> float:
    """ReVolt in Hold, in a moment that comes and goes like gusts."""
    rng, boat, parameters = random.Random(seed), SimpleBoat(), Parameters(REVOLT.parameters)
    controller, allocator, gate = (
        controller_with_baselines(REVOLT, parameters),
        Allocator(REVOLT, parameters),
        Gate(REVOLT),
    )
    achieved, gust, largest = ZERO_WRENCH, 0.0, 0.0
    for k in range(900):
        gust += -0.2 * DT_S * gust + gusts_nm * math.sqrt(0.4 * DT_S) * rng.gauss(0.0, 1.0)
        boat.moment_nm = gust
        allocation = allocator.update(controller.update(PoseSetpoint(0.0, 0.0, 0.0), boat.nav(), achieved, DT_S), DT_S)
        achieved = allocation.achieved
        boat.sail(gate.update(allocation, True, boat.t_s, DT_S, True, BOW_DOWN), DT_S)
        if k > 300:
            largest = max(largest, abs(boat.yaw_rad))
    return largest


@pytest.mark.parametrize("seed", range(4))
def test_gusts_turn_the_boat_less(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    now = largest_heading_rad(seed, 1.0)
    monkeypatch.setattr(YawDisturbance, "update", lambda *_: 0.0)
    assert now < 0.75 * largest_heading_rad(seed, 1.0)
