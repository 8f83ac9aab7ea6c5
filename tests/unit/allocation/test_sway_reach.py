"""The sideways force left after a failure, against thrusts drawn at random."""

from __future__ import annotations

import math
import random

import pytest

from companion.allocation.geometry import Thruster, thrusters_of
from companion.allocation.sway_reach import sway_reach_n
from companion.config.vessel import find, load

ABOAT = thrusters_of(load(find("aboat")))
REVOLT = thrusters_of(load(find("revolt")))


@pytest.mark.parametrize("yaw_nm", [-60.0, 0.0, 35.0])
def test_one_azimuth_gives_the_force_of_its_moment(yaw_nm: float) -> None:
    least_n, most_n = sway_reach_n(ABOAT, {0}, yaw_nm)
    assert least_n == pytest.approx(most_n, abs=0.5)
    assert most_n == pytest.approx(yaw_nm / ABOAT[1].x_m, abs=0.5)


def test_a_moment_beyond_all_thrust_leaves_some_force() -> None:
    least_n, most_n = sway_reach_n(ABOAT, {0}, 1000.0)
    assert -ABOAT[1].max_n <= least_n <= most_n < 0.0


def test_without_thrusters_there_is_none() -> None:
    assert sway_reach_n(ABOAT, {0, 1}, 10.0) == (0.0, 0.0)


@pytest.mark.parametrize(("boat", "failed"), [(ABOAT, set()), (REVOLT, set()), (REVOLT, {0}), (REVOLT, {2})])
def test_no_thrust_drawn_gives_more(boat: tuple[Thruster, ...], failed: set[int]) -> None:
    rng = random.Random(1)
    nearest = math.inf
    for _ in range(400):
        sway_n = yaw_nm = 0.0
        for i, t in enumerate(boat):
            force = 0.0 if i in failed else rng.choice((-t.max_n if t.turns else t.min_n, t.max_n, 0.0))
            azimuth = rng.choice((0.5 * math.pi, rng.uniform(-math.pi, math.pi))) if t.turns else t.rest_rad
            sway_n += math.sin(azimuth) * force
            yaw_nm += (t.x_m * math.sin(azimuth) - t.y_m * math.cos(azimuth)) * force
        least_n, most_n = sway_reach_n(boat, failed, yaw_nm)
        if sway_n > most_n + 0.01:  # only with a moment beyond the share that is kept
            _, less = sway_reach_n(boat, failed, 2.0 * yaw_nm)
            assert less == pytest.approx(most_n, rel=1e-6)
            continue
        nearest = min(nearest, most_n - sway_n)
    assert nearest < 0.2 * sum(t.max_n for t in boat)
