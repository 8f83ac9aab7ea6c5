"""DP_ECON: soft inside the circle, whole at its edge, and nothing of it where it is off."""

from __future__ import annotations

import itertools
import math
import random
from dataclasses import dataclass, replace
from functools import cache

import pytest

from companion.allocation.allocator import Allocator
from companion.baselines.controller_choice import controller_with_baselines
from companion.control.economy import WHOLE, Economy, Firmness, MeanForce
from companion.core.actuation import ZERO_WRENCH
from companion.core.setpoint import PoseSetpoint
from companion.params.store import Parameters
from companion.safety import Gate
from tests.unit.control.simple_boat import BOW_DOWN, REVOLT, SimpleBoat, nav_state

DT_S = 0.1
CALM = (0.0, 0.0, 0.0)


@dataclass
class Held:
    furthest_m: float
    variation: float
    power: float
    heading_rad: float


@cache  # the whole law is what every circle is compared with
def hold(circle_m: float, seed: int, force_n: float, gusts_n: float, seconds: float = 180.0) -> Held:
    """ReVolt in a force from abeam that varies like gusts, with the noise of RTK."""
    rng = random.Random(seed)
    boat, parameters = SimpleBoat(force_ned=(0.0, force_n)), Parameters(REVOLT.parameters)
    controller, allocator, gate = (
        controller_with_baselines(REVOLT, parameters),
        Allocator(REVOLT, parameters),
        Gate(REVOLT),
    )
    achieved, gust, last = ZERO_WRENCH, 0.0, [0.0] * len(REVOLT.thrusters)
    held, ticks = Held(0.0, 0.0, 0.0, 0.0), round((seconds + 90.0) / DT_S)
    for k in range(ticks):
        gust += -0.1 * DT_S * gust + gusts_n * math.sqrt(0.2 * DT_S) * rng.gauss(0.0, 1.0)
        boat.force_ned = (0.0, force_n + gust)
        nav = boat.nav()
        nav = replace(nav, north_m=nav.north_m + rng.gauss(0.0, 0.004), east_mps=nav.east_mps + rng.gauss(0.0, 0.01))
        setpoint = PoseSetpoint(0.0, 0.0, 0.0, circle_m=circle_m if k * DT_S > 60.0 else 0.0)
        allocation = allocator.update(controller.update(setpoint, nav, achieved, DT_S), DT_S)
        achieved = allocation.achieved
        boat.sail(gate.update(allocation, True, boat.t_s, DT_S, True, BOW_DOWN), DT_S)
        forces = [one.force_n for one in allocation.thrusters]
        if k * DT_S > 90.0:
            held.furthest_m = max(held.furthest_m, math.hypot(boat.north_m, boat.east_m))
            held.heading_rad = max(held.heading_rad, abs(boat.yaw_rad))
            held.variation += sum(abs(a - b) for a, b in zip(forces, last, strict=True))
            held.power += sum(abs(force) ** 1.5 for force in forces)
        last = forces
    return held


def test_gusts_are_answered_softly_and_the_boat_stays_inside() -> None:
    whole, soft = hold(0.0, 100, 3.0, 0.8), hold(1.0, 100, 3.0, 0.8)
    assert soft.variation < 0.5 * whole.variation
    assert soft.power < 1.02 * whole.power  # nearly all of it is the mean force
    assert soft.furthest_m < 1.0 and soft.heading_rad < math.radians(10.0)


@pytest.mark.parametrize(("circle_m", "seed"), list(itertools.product((0.25, 0.5, 1.0), (1, 2))))
def test_the_circle_is_kept_in_weather_in_which_the_whole_law_keeps_it(circle_m: float, seed: int) -> None:
    for force_n, gusts_n in ((0.0, 0.3), (5.0, 1.5)):
        whole = hold(0.0, seed, force_n, gusts_n, 90.0)
        assert whole.furthest_m < circle_m
        assert hold(circle_m, seed, force_n, gusts_n, 90.0).furthest_m < circle_m


def firmness(circle_m: float, seconds: float = 60.0, **motion: float) -> Firmness:
    economy, nav = Economy(REVOLT), nav_state(**motion)
    found = WHOLE
    for _ in range(round(seconds / DT_S)):
        found = economy.update(PoseSetpoint(0.0, 0.0, 0.0, circle_m=circle_m), nav, CALM, 0.4, DT_S)
    return found


def test_the_law_firms_up_towards_the_edge() -> None:
    shares = [firmness(1.0, north_m=at_m).place for at_m in (0.0, 0.2, 0.4, 0.6, 0.8, 2.0)]
    assert shares == sorted(shares) and shares[0] < 0.25 and shares[-1] == 1.0
    assert firmness(1.0, north_m=0.2, surge_mps=0.2).place == 1.0  # it will be outside before the law has answered
    assert firmness(1.0, yaw_rad=math.radians(8.0)).yaw == 1.0


def test_it_firms_up_at_once_and_softens_slowly() -> None:
    economy, inside, edge = Economy(REVOLT), nav_state(), nav_state(north_m=0.9)
    setpoint = PoseSetpoint(0.0, 0.0, 0.0, circle_m=1.0)
    for _ in range(600):
        economy.update(setpoint, inside, CALM, 0.4, DT_S)
    assert economy.update(setpoint, edge, CALM, 0.4, DT_S).place == 1.0
    assert economy.update(setpoint, inside, CALM, 0.4, DT_S).place > 0.9


def test_where_the_position_is_worse_than_the_circle_the_law_is_whole() -> None:
    economy = Economy(REVOLT)
    nav = replace(nav_state(), position_accuracy_m=0.6)
    assert economy.update(PoseSetpoint(0.0, 0.0, 0.0, circle_m=1.0), nav, CALM, 0.4, DT_S) == WHOLE


def test_under_way_the_law_is_whole() -> None:
    economy = Economy(REVOLT)
    setpoint = PoseSetpoint(0.0, 0.0, 0.0, surge_mps=0.1, circle_m=1.0)
    assert economy.update(setpoint, nav_state(), CALM, 0.4, DT_S) == WHOLE


def test_the_mean_of_a_force_stays_and_its_gusts_are_left_by_half() -> None:
    mean = MeanForce()
    for _ in range(6000):
        mean.update((4.0, 2.0, 1.0), WHOLE, DT_S)
    assert mean.update((6.0, 2.0, 1.0), Firmness(0.5, 0.0), DT_S) == pytest.approx((5.0, 2.0, 1.0), abs=0.01)
    assert mean.update((6.0, 2.1, 1.2), WHOLE, DT_S) == (6.0, 2.1, 1.2)
