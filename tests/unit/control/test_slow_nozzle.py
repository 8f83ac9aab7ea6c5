"""What a boat does until its nozzle has come back."""

from __future__ import annotations

import math

import pytest

from companion.config.vessel import find, load
from companion.control.slow_nozzle import SlowNozzle
from companion.core.actuation import Wrench

JET_BOAT = load(find("rescuerunner"))
LAG_S = 0.3


@pytest.mark.parametrize("pushed_nm", [500.0, -500.0, 150.0])
@pytest.mark.parametrize("held_nm", [0.0, 200.0])
def test_the_rest_of_a_turn_is_that_of_a_moment_that_falls_evenly(pushed_nm: float, held_nm: float) -> None:
    """Against the motion itself, step by step, without damping and lag: within a tenth."""
    nozzle = SlowNozzle(JET_BOAT, math.radians(24.0))
    nozzle.rate_radps, nozzle.pushed = math.radians(5.0), Wrench(1300.0, 0.0, pushed_nm)
    foreseen = nozzle.foreseen(held_nm, 0.0)
    slew_nmps = 1300.0 * 1.6 * nozzle.rate_radps
    lasts_s, dt_s, rate, turned = abs(pushed_nm - held_nm) / slew_nmps, 0.001, 0.0, 0.0
    for k in range(round(lasts_s / dt_s)):
        rate += dt_s * (pushed_nm - held_nm) * (1.0 - k * dt_s / lasts_s) / JET_BOAT.hull.m33_kgm2
        turned += dt_s * rate
    assert foreseen.time_s == pytest.approx(lasts_s + LAG_S)
    share = foreseen.time_s / lasts_s  # the lag counts as a part of the fall
    assert foreseen.grown_radps == pytest.approx(share * rate, rel=0.1)
    assert foreseen.turned_rad == pytest.approx(share * share * turned, rel=0.1)


def test_a_hull_that_resists_turns_on_by_less_and_no_nozzle_is_waited_for_without_thrust() -> None:
    nozzle = SlowNozzle(JET_BOAT, math.radians(24.0))
    nozzle.rate_radps, nozzle.pushed = math.radians(14.0), Wrench(1300.0, 0.0, 500.0)
    free, resisted = nozzle.foreseen(0.0, 0.0), nozzle.foreseen(0.0, 1000.0)
    assert 0.0 < resisted.turned_rad < free.turned_rad and 0.0 < resisted.grown_radps < free.grown_radps
    nozzle.pushed = Wrench(0.0, 0.0, 0.0)
    assert nozzle.foreseen(10000.0, 0.0).time_s == pytest.approx(2.0 * 24.0 / 14.0 + LAG_S)
