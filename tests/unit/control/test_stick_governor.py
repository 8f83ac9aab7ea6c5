"""The stick's force under a speed limit: a hull that moves one way, pushed by wind."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from companion.config.vessel import VesselConfig, bundled, find, load
from companion.control.controller import Controller
from companion.control.model import damping
from companion.control.stick_governor import StickGovernor, StickLimit
from companion.core.actuation import ZERO_WRENCH, Wrench
from companion.core.setpoint import HeadingSetpoint, PoseSetpoint
from companion.params.store import Parameters
from tests.unit.control.simple_boat import REVOLT
from tests.unit.estimates import AT_REST

DT_S = 0.1
AHEAD = (1.0, 0.0)


def sail(
    config: VesselConfig, stick_n: float, push_n: float, limit_mps: float, speed_mps: float = 0.0
) -> tuple[float, float]:
    """Speed after five minutes of the stick held, and the way made in the last minute. `push_n`: a steady force."""
    governor, way_m = StickGovernor(config, Parameters()), 0.0
    for tick in range(3000):
        nav = replace(AT_REST, surge_mps=speed_mps)
        asked = HeadingSetpoint(0.0, Wrench(stick_n, 0.0, 0.0))
        limit = StickLimit((math.copysign(1.0, stick_n), 0.0), limit_mps)
        got = governor.limited(asked, nav, [limit], tick * DT_S).wrench.surge_n
        got = max(-config.limits.surge_n, min(config.limits.surge_n, got))
        drag_n, _, _ = damping(config.hull, speed_mps, 0.0, 0.0)
        speed_mps += (got + push_n - drag_n) / config.hull.m11_kg * DT_S
        way_m += speed_mps * DT_S if tick >= 2400 else 0.0
    return speed_mps, way_m


@pytest.mark.parametrize("name", bundled())
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_boat_pushed_over_its_limit_comes_to_rest(name: str, sign: float) -> None:
    config = load(find(name))
    full = sign * config.limits.surge_n
    speed_mps, way_m = sail(config, full, 0.1 * full, 0.0)
    assert abs(speed_mps) < 1e-4 and abs(way_m) < 0.01


@pytest.mark.parametrize(("push_n", "slowest_mps"), [(0.0, 0.299), (5.0, 0.299), (-5.0, 0.25)])
def test_the_boat_goes_at_the_limit_and_below_it_against_the_wind(push_n: float, slowest_mps: float) -> None:
    speed_mps, _ = sail(REVOLT, 50.0, push_n, 0.3)
    assert slowest_mps <= speed_mps <= 0.301


def test_a_boat_that_moves_slowly_the_other_way_is_limited_all_the_same() -> None:
    governor = StickGovernor(REVOLT, Parameters())
    full = HeadingSetpoint(0.0, Wrench(50.0, 0.0, 0.0))
    got = governor.limited(full, replace(AT_REST, surge_mps=-0.01), [StickLimit(AHEAD, 0.0)], 0.0).wrench.surge_n
    assert got == pytest.approx(REVOLT.hull.m11_kg * 2.0 * Parameters()["PATH_BW_SURGE"] * 0.01)


def test_what_has_pushed_the_boat_is_known_to_the_law_that_holds_it_then() -> None:
    """A boat of 4.7 m that Hold took over 3 m before its fence was pushed 0.9 m further, its hull over the line."""
    governor, controller, speed_mps = StickGovernor(REVOLT, Parameters()), Controller(REVOLT, Parameters()), 0.0
    for tick in range(1200):
        nav = replace(AT_REST, surge_mps=speed_mps)
        asked = governor.limited(
            HeadingSetpoint(0.0, Wrench(50.0, 0.0, 0.0)), nav, [StickLimit(AHEAD, 0.0)], tick * DT_S
        )
        given = controller.update(asked, nav, ZERO_WRENCH, DT_S)
        speed_mps += (given.surge_n + 5.0) / REVOLT.hull.m11_kg * DT_S
    holds = controller.update(PoseSetpoint(0.0, 0.0, 0.0), AT_REST, given, DT_S)
    assert holds.surge_n == pytest.approx(-5.0, abs=0.1)


def test_what_pushes_ever_harder_speeds_the_boat_up_little() -> None:
    """A boat that slows down with a model of too much drag: the wind from astern shows as the drag falls. It came to its
    line at 0.26 m/s, and went over it."""
    governor, speed_mps, growth_nps = StickGovernor(REVOLT, Parameters()), 0.0, 0.5
    for tick in range(300):
        nav = replace(AT_REST, surge_mps=speed_mps)
        asked = governor.limited(
            HeadingSetpoint(0.0, Wrench(50.0, 0.0, 0.0)), nav, [StickLimit(AHEAD, 0.0)], tick * DT_S
        )
        push_n = growth_nps * tick * DT_S
        speed_mps += (asked.wrench.surge_n + push_n) / REVOLT.hull.m11_kg * DT_S
    bandwidth = Parameters()["PATH_BW_SURGE"]
    assert speed_mps < 1.2 * growth_nps / (REVOLT.hull.m11_kg * bandwidth**2)


def test_no_limit_leaves_the_stick_alone_and_clears_the_integral() -> None:
    governor, fast = StickGovernor(REVOLT, Parameters()), replace(AT_REST, surge_mps=0.2)
    full = HeadingSetpoint(0.0, Wrench(50.0, 0.0, 0.0))
    first = governor.limited(full, fast, [StickLimit(AHEAD, 0.0)], 0.0)
    assert governor.limited(full, fast, [StickLimit(AHEAD, 0.0)], 0.1).wrench.surge_n == pytest.approx(
        first.wrench.surge_n
    )
    later = governor.limited(full, fast, [StickLimit(AHEAD, 0.0)], 0.2)
    assert later.wrench.surge_n < first.wrench.surge_n - 0.1
    assert governor.limited(full, fast, [StickLimit(AHEAD, math.inf)], 0.3) is full
    assert governor.limited(full, fast, [StickLimit(AHEAD, 0.0)], 0.4) == first


def test_after_a_gap_the_integral_begins_anew() -> None:
    governor, fast = StickGovernor(REVOLT, Parameters()), replace(AT_REST, surge_mps=0.2)
    full = HeadingSetpoint(0.0, Wrench(50.0, 0.0, 0.0))
    first = governor.limited(full, fast, [StickLimit(AHEAD, 0.0)], 0.0)
    for tick in range(1, 9):
        governor.limited(full, fast, [StickLimit(AHEAD, 0.0)], tick * DT_S)
    assert governor.limited(full, fast, [StickLimit(AHEAD, 0.0)], 60.0) == first


@pytest.mark.parametrize("name", ["revolt", "aboat", "cybership2"])
def test_a_stick_that_pushes_aside_is_limited_too(name: str) -> None:
    """ÅBOAT went over its fence sideways, the stick at a third: only the force ahead was limited."""
    config = load(find(name))
    governor, speed_mps, way_m = StickGovernor(config, Parameters()), 0.5, 0.0
    for tick in range(3000):
        nav = replace(AT_REST, sway_mps=speed_mps)
        full = HeadingSetpoint(0.0, Wrench(20.0, config.limits.sway_n, 0.0))
        got = governor.limited(full, nav, [StickLimit((0.0, 1.0), 0.0)], tick * DT_S).wrench
        assert got.surge_n == pytest.approx(20.0)  # along the line
        _, drag_n, _ = damping(config.hull, 0.0, speed_mps, 0.0)
        force_n = max(-config.limits.sway_n, got.sway_n) + 0.1 * config.limits.sway_n - drag_n
        speed_mps += force_n / config.hull.m22_kg * DT_S
        way_m += speed_mps * DT_S if tick >= 2400 else 0.0
    assert abs(speed_mps) < 1e-4 and abs(way_m) < 0.01


def test_what_has_pushed_the_boat_aside_is_known_to_the_law_that_holds_it_then() -> None:
    governor, controller, speed_mps = StickGovernor(REVOLT, Parameters()), Controller(REVOLT, Parameters()), 0.0
    for tick in range(1200):
        nav = replace(AT_REST, sway_mps=speed_mps)
        stick = HeadingSetpoint(0.0, Wrench(0.0, 20.0, 0.0))
        asked = governor.limited(stick, nav, [StickLimit((0.0, 1.0), 0.0)], tick * DT_S)
        given = controller.update(asked, nav, ZERO_WRENCH, DT_S)
        speed_mps += (given.sway_n + 3.0) / REVOLT.hull.m22_kg * DT_S
    holds = controller.update(PoseSetpoint(0.0, 0.0, 0.0), AT_REST, given, DT_S)
    assert holds.sway_n == pytest.approx(-3.0, abs=0.1)
