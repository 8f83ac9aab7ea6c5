"""Azimuth thrusters at their end stops, with a demand that they can only give the other way round."""

from __future__ import annotations

import math

import pytest

from companion.allocation.allocator import Allocator
from companion.cli.new_file import Answers, file_text
from companion.config.vessel import VesselConfig, find, load, parse
from companion.core.actuation import Wrench
from companion.params.store import Parameters

DT_S = 0.1
ABOAT = load(find("aboat"))
Demand = tuple[float, float, float]


def missing_n(allocator: Allocator, begin: Demand, end: Demand, duration_s: float) -> list[float]:
    """Force that is missing in each cycle, while the demand goes evenly from one to the other."""
    count, found = round(duration_s / DT_S), []
    for k in range(count):
        x, y, n = (a + (b - a) * k / count for a, b in zip(begin, end, strict=True))
        got = allocator.update(Wrench(x, y, n), DT_S).achieved
        found.append(math.hypot(got.surge_n - x, got.sway_n - y))
    return found


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_demand_that_grows_beyond_the_stops_is_given_after_some_seconds(side: float) -> None:
    """As sailed: the boat stops with a crosswind, both motors turn with the demand to their stops, and the wind rises
    from the other side. They stayed there until 80 N were missing, for half a minute."""
    allocator = Allocator(ABOAT, Parameters(ABOAT.parameters))
    missing_n(allocator, (30.0, -6.0 * side, 2.0), (5.0, -6.0 * side, 2.0), 20.0)
    missing_n(allocator, (5.0, -6.0 * side, 2.0), (-11.0, 0.0, 2.0), 9.0)
    missing = missing_n(allocator, (-11.0, 0.0, 2.0), (-60.0, 26.0 * side, 2.0), 18.0)
    assert max(missing) < 45.0
    assert max(missing[-60:]) < 1.0


def test_motors_do_not_turn_round_for_little() -> None:
    allocator = Allocator(ABOAT, Parameters(ABOAT.parameters))
    missing_n(allocator, (5.0, -6.0, 2.0), (-3.0, -6.0, 2.0), 6.0)
    before = [command.azimuth_rad for command in allocator.update(Wrench(-3.0, -6.0, 2.0), DT_S).thrusters]
    missing_n(allocator, (-3.0, -6.0, 2.0), (-6.0, -4.0, 2.0), 10.0)
    after = [command.azimuth_rad for command in allocator.update(Wrench(-6.0, -4.0, 2.0), DT_S).thrusters]
    assert after == pytest.approx(before, abs=0.3)


def made(layout: str, form: str) -> VesselConfig:
    """A boat of `companion new`, whose thrusters have stops."""
    answers = Answers(
        "boat", "Boat", form, 4.0, 1.6, 400.0, None, None, None, layout, "200", None, 0.0,
        "microcontroller", "two", 63.4, 10.4,
    )  # fmt: skip
    return parse(file_text(answers), "boat.toml")


def shares_given(boat: VesselConfig, axis: str, demands: list[Wrench], seconds: float) -> float:
    """Share of the time in which half of what is demanded on one axis is given, where the demands take turns."""
    allocator, found = Allocator(boat, Parameters(boat.parameters)), []
    for k in range(600):
        demand = demands[int(k * DT_S / seconds) % len(demands)]
        given, asked = getattr(allocator.update(demand, DT_S).achieved, axis), getattr(demand, axis)
        found.append(given / asked > 0.5)
    return sum(found[100:]) / len(found[100:])


def test_pods_at_their_stops_do_not_turn_round_for_every_gust() -> None:
    """A barge in a crosswind: for a little thrust astern both pods turned from stop to stop, one after the other, and
    gave nothing for five seconds. It went over its fence."""
    boat = made("two-azimuths", "barge")
    x, y = boat.limits.surge_n, boat.limits.sway_n
    across = [Wrench(0.12 * x, 0.9 * y, 0.0), Wrench(-0.12 * x, 0.9 * y, 0.0)]
    assert shares_given(boat, "sway_n", across, 4.0) > 0.9


def turned_over(boat: VesselConfig, surge: float, yaw: float, surge_mps: float, seconds: float) -> list[Wrench]:
    """What is given in each cycle after a moment changed its sign, beside a force that stays. In shares of limits."""
    allocator = Allocator(boat, Parameters(boat.parameters))
    x, n = surge * boat.limits.surge_n, yaw * boat.limits.yaw_nm
    for _ in range(50):
        allocator.update(Wrench(x, 0.0, n), DT_S, surge_mps, planned=True)
    return [
        allocator.update(Wrench(x, 0.0, -n), DT_S, surge_mps, planned=True).achieved
        for _ in range(round(seconds / DT_S))
    ]


@pytest.mark.parametrize("form", ["monohull", "planing"])
@pytest.mark.parametrize(("surge", "yaw"), [(0.6, 0.9), (0.3, 0.6), (0.8, 1.0), (0.6, -0.9)])
def test_a_lone_outboard_whose_moment_changes_its_sign_goes_on_pushing_ahead(
    form: str, surge: float, yaw: float
) -> None:
    """It reversed at its stop, braked the boat by 80 N where 85 N ahead were asked for, and stayed there for 2 s."""
    boat = made("azimuth", form)
    given = turned_over(boat, surge, yaw, 1.0, 3.0)
    assert min(wrench.surge_n for wrench in given) >= -1.0e-6
    late = given[15:]  # its turn from stop to stop takes 1.2 s
    assert all(wrench.surge_n > 0.8 * surge * boat.limits.surge_n for wrench in late)
    assert all(-wrench.yaw_nm / (yaw * boat.limits.yaw_nm) > 0.8 for wrench in late)


def test_a_lone_outboard_under_way_does_not_steer_by_a_push_astern() -> None:
    """With hardly any thrust ahead asked for, it steered into a corner by thrust astern, and stood still there."""
    given = turned_over(made("azimuth", "planing"), 0.05, 0.4, 1.0, 3.0)
    assert min(wrench.surge_n for wrench in given) >= -1.0e-6
    at_rest = turned_over(made("azimuth", "planing"), 0.0, 0.4, 0.0, 0.8)
    assert at_rest[-1].surge_n < 0.0, "at rest it answers sooner so"


def test_a_lone_outboard_that_is_to_brake_reverses() -> None:
    boat = made("azimuth", "planing")
    allocator = Allocator(boat, Parameters(boat.parameters))
    x, n = boat.limits.surge_n, boat.limits.yaw_nm
    for _ in range(30):
        allocator.update(Wrench(0.5 * x, 0.0, 0.1 * n), DT_S, 1.5, planned=True)
    given = [allocator.update(Wrench(-0.5 * x, 0.0, 0.1 * n), DT_S, 1.5, planned=True) for _ in range(20)]
    assert all(a.achieved.surge_n < -0.4 * x for a in given[12:])


def test_a_lone_outboard_turns_the_bow_in_waves() -> None:
    """A canoe was carried off: each wave changed the sign of the thrust that was asked for, and the outboard swung from
    stop to stop without any."""
    boat = made("azimuth", "monohull")
    x, n = boat.limits.surge_n, boat.limits.yaw_nm
    waves = [Wrench(0.5 * x, 0.0, n), Wrench(-0.4 * x, 0.0, n)]
    assert shares_given(boat, "yaw_nm", waves, 1.2) > 0.8
