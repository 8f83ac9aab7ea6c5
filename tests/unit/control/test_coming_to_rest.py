"""What the integral learnt under way, as the boat comes to rest."""

from __future__ import annotations

from dataclasses import replace

import pytest

from companion.config.vessel import find, load
from companion.control.bias import BiasForce
from companion.control.coming_to_rest import ComingToRest, kept_share
from companion.control.controller import Controller
from companion.core.actuation import ZERO_WRENCH, Wrench
from companion.core.estimate import NavState
from companion.core.setpoint import PathSetpoint, PoseSetpoint, Setpoint, WrenchSetpoint
from companion.params.store import Parameters
from tests.unit.control.simple_boat import REVOLT, nav_state

DT_S = 0.1
FAST_MPS = 1.2
SLOWER = 0.8  # of the speed that was asked for


def under_way(surge_mps: float) -> NavState:
    return replace(nav_state(surge_mps=surge_mps), north_mps=surge_mps, east_mps=0.0, position_valid=True)


def brought_to_rest(between: Setpoint | None = None) -> tuple[float, float]:
    """The surge force in N that positioning demands at its point and at rest, after a minute at 80 % of the speed asked
    for, and the last that was demanded under way."""
    controller = Controller(REVOLT, Parameters(REVOLT.parameters))
    wrench = ZERO_WRENCH
    for _ in range(600):
        wrench = controller.update(PathSetpoint(0.0, 0.6, 0.0, 0.0), under_way(SLOWER * 0.6), wrench, DT_S)
    if between is not None:
        controller.update(between, under_way(0.0), ZERO_WRENCH, DT_S)
    demand = controller.update(PoseSetpoint(0.0, 0.0, 0.0), under_way(0.0), wrench, DT_S)
    return demand.surge_n, wrench.surge_n


def test_a_bias_against_drag_ends_with_the_way() -> None:
    """It drove the boat on: ÅBOAT 17 m from where it was to stop, a catamaran out of its fence."""
    rest_n, way_n = brought_to_rest()
    assert 0.0 < rest_n < 0.6 * way_n


def test_after_sticks_the_bias_is_that_of_the_sticks() -> None:
    kept_n, _ = brought_to_rest(WrenchSetpoint(Wrench(0.0, 0.0, 0.0)))
    shed_n, _ = brought_to_rest()
    assert kept_n > 1.2 * shed_n


@pytest.mark.parametrize("name", ["otter", "blueboat", "aboat"])
def test_a_boat_that_brakes_has_nothing_that_drives_it_on(name: str) -> None:
    """Hold brakes a fast boat by a path at rest before it positions it: the bias against drag drove ÅBOAT on at 0.6 m/s
    meanwhile, for 7 m, and a catamaran for 19 m."""
    config = load(find(name))
    sailed, fresh = (Controller(config, Parameters(config.parameters)) for _ in range(2))
    way = PathSetpoint(0.0, FAST_MPS)
    first = wrench = sailed.update(way, under_way(SLOWER * FAST_MPS), ZERO_WRENCH, DT_S)
    for _ in range(600):
        wrench = sailed.update(way, under_way(SLOWER * FAST_MPS), wrench, DT_S)
    learned_n = wrench.surge_n - first.surge_n
    driven = sailed.update(PathSetpoint(0.0, 0.0), under_way(0.3), wrench, DT_S)
    braked = fresh.update(PathSetpoint(0.0, 0.0), under_way(0.3), ZERO_WRENCH, DT_S)
    driven_n, braked_n = driven.surge_n, braked.surge_n
    assert learned_n > 1.0
    assert 0.0 < driven_n - braked_n < 0.6 * learned_n


def test_a_boat_that_waits_in_its_plan_keeps_what_it_learnt() -> None:
    """A planned path that has it at rest for a moment leads on."""
    controller = Controller(REVOLT, Parameters(REVOLT.parameters))
    wrench = ZERO_WRENCH
    for _ in range(600):
        wrench = controller.update(PathSetpoint(0.0, 0.6), under_way(SLOWER * 0.6), wrench, DT_S)
    waits = replace(PathSetpoint(0.0, 0.0), exact=True)
    controller.update(waits, under_way(SLOWER * 0.6), wrench, DT_S)
    after = controller.update(PathSetpoint(0.0, 0.6), under_way(SLOWER * 0.6), wrench, DT_S)
    assert after.surge_n == pytest.approx(wrench.surge_n, rel=0.1)


def test_what_stays_is_weather() -> None:
    slow, fast = (kept_share(REVOLT, under_way(speed), speed, 1.0, 0.0) for speed in (0.05, 0.9))
    assert 0.0 < fast < slow <= 1.0
    known = replace(under_way(0.9), current_north_mps=0.0, current_east_mps=0.0)
    assert kept_share(REVOLT, known, 0.9, 1.0, 0.0) < fast
    bare = replace(REVOLT, windage=replace(REVOLT.windage, frontal_m2=1.0, cx=1.0))
    assert kept_share(bare, under_way(0.9), 0.9, 1.0, 0.0) > fast


def test_across_the_way_all_of_the_bias_stays() -> None:
    coming, bias, nav = ComingToRest(REVOLT), BiasForce(REVOLT.limits), under_way(0.6)
    bias.grow(10.0, -5.0, 2.0, 0.0, 1.0)
    for _ in range(200):
        coming.sail(nav, DT_S)
    coming.rest(bias, nav)
    x, y, n = bias.in_body(0.0)
    assert 0.0 < x < 8.0
    assert (y, n) == pytest.approx((-5.0, 2.0))
    coming.rest(bias, nav)
    assert bias.in_body(0.0)[0] == pytest.approx(x)
