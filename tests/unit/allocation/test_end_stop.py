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


def test_a_lone_outboard_turns_the_bow_in_waves() -> None:
    """A canoe was carried off: each wave changed the sign of the thrust that was asked for, and the outboard swung from
    stop to stop without any."""
    boat = made("azimuth", "monohull")
    x, n = boat.limits.surge_n, boat.limits.yaw_nm
    waves = [Wrench(0.5 * x, 0.0, n), Wrench(-0.4 * x, 0.0, n)]
    assert shares_given(boat, "yaw_nm", waves, 1.2) > 0.8
