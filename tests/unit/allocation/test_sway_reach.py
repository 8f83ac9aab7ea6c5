"""The sideways force left after a failure, against thrusts drawn at random."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import pytest

from companion.allocation.geometry import Thruster, thrusters_of
from companion.allocation.sway_reach import sway_reach_n
from companion.config.vessel import find, load

ABOAT = thrusters_of(load(find("aboat")))
REVOLT = thrusters_of(load(find("revolt")))


@pytest.mark.parametrize("yaw_nm", [-60.0, 0.0, 35.0])
def test_one_azimuth_gives_the_force_of_its_moment(yaw_nm: float) -> None:
    least_n, most_n = sway_reach_n(ABOAT, {0}, yaw_nm, 0.0)
    assert least_n == pytest.approx(most_n, abs=0.5)
    assert most_n == pytest.approx(yaw_nm / ABOAT[1].x_m, abs=0.5)


def test_a_moment_beyond_all_thrust_leaves_some_force() -> None:
    least_n, most_n = sway_reach_n(ABOAT, {0}, 1000.0, 0.0)
    assert -ABOAT[1].max_n <= least_n <= most_n < 0.0


def test_without_thrusters_there_is_none() -> None:
    assert sway_reach_n(ABOAT, {0, 1}, 10.0, 0.0) == (0.0, 0.0)


@pytest.mark.parametrize(("boat", "failed"), [(ABOAT, set()), (REVOLT, set()), (REVOLT, {0}), (REVOLT, {2})])
def test_no_thrust_drawn_gives_more(boat: tuple[Thruster, ...], failed: set[int]) -> None:
    rng = random.Random(1)
    left = [t for i, t in enumerate(boat) if i not in failed]
    most_nm = sum(t.max_n * math.hypot(t.x_m, t.y_m) for t in left)
    spare_n = math.inf
    for _ in range(400):
        sway_n = yaw_nm = 0.0
        for t in left:
            force = rng.choice((-t.max_n if t.turns else t.min_n, t.max_n, 0.0))
            azimuth = rng.choice((0.5 * math.pi, rng.uniform(-math.pi, math.pi))) if t.turns else t.rest_rad
            sway_n += math.sin(azimuth) * force
            yaw_nm += (t.x_m * math.sin(azimuth) - t.y_m * math.cos(azimuth)) * force
        if abs(yaw_nm) < 0.5 * most_nm:
            _, most_n = sway_reach_n(boat, failed, yaw_nm, 0.0)
            assert sway_n < most_n + 0.01
            spare_n = min(spare_n, most_n - sway_n)
    assert spare_n < 0.2 * sum(t.max_n for t in boat)


def twin_and_bow(spread_m: float) -> tuple[Thruster, ...]:
    """Two thrusters at the stern, and one across the bow."""
    row = load(find("otter")).thrusters[0]
    rows = [replace(row, x_m=-0.9, y_m=0.5 * side * spread_m) for side in (-1.0, 1.0)]
    bow = replace(row, x_m=0.8, y_m=0.0, azimuth_rad=0.5 * math.pi)
    return thrusters_of(replace(load(find("otter")), thrusters=(*rows, bow)))


@pytest.mark.parametrize(("yaw_nm", "surge_n"), [(0.0, -20.0), (3.0, -20.0), (-2.0, 15.0), (1.0, 0.0)])
@pytest.mark.parametrize("spread_m", [0.42, 1.6])
def test_two_that_do_not_turn_give_moment_and_way(spread_m: float, yaw_nm: float, surge_n: float) -> None:
    boat = twin_and_bow(spread_m)
    least_n, most_n = sway_reach_n(boat, {0}, yaw_nm, surge_n)
    slack_n = 0.1 * (boat[1].max_n + boat[2].max_n)
    given = [(yaw_nm + 0.5 * spread_m * x) / 0.8 for x in (surge_n - slack_n, surge_n + slack_n)]  # at the bow
    assert (least_n, most_n) == pytest.approx((min(given), max(given)))


def test_the_moment_comes_before_the_way() -> None:
    boat = twin_and_bow(1.6)
    least_n, most_n = sway_reach_n(boat, {0}, 0.8 * boat[2].max_n, 1000.0)
    assert most_n == pytest.approx(boat[2].max_n) and least_n == pytest.approx(most_n)
    assert sway_reach_n(boat, {2}, 5.0, 20.0) == pytest.approx((0.0, 0.0)), "side by side they push straight ahead"
