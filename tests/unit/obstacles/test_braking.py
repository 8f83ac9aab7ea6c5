"""The speed from which the boat stops in time."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.config.vessel import find, load
from companion.obstacles.braking import Braking
from companion.params.store import Parameters

OTTER, JET = load(find("otter")), load(find("rescuerunner"))


@given(st.floats(0.0, 60.0), st.floats(-0.5, 0.5))
def test_the_boat_stops_within_the_way(way_m: float, stream_mps: float) -> None:
    """The stopping distance integrated anew, in finer steps and only with the boat's own figures."""
    parameters = Parameters()
    braking = Braking(OTTER, parameters)
    speed = braking.speed_mps(way_m, stream_mps)
    left, length_m, dt_s = speed, speed * braking.lag_s, 0.01
    thrust_n = 0.6 * min(OTTER.limits.surge_n, 2.0 * 66.7)
    while left > 0.0:
        force_n = thrust_n + OTTER.hull.drag_n(left - stream_mps)
        length_m += left * dt_s
        left -= min(1.5 * parameters["PATH_ACC"], force_n / OTTER.hull.m11_kg) * dt_s
    assert length_m <= way_m + 0.05 * way_m + 0.1


def test_the_current_behind_asks_for_less_speed_of_a_boat_that_cannot_reverse() -> None:
    parameters = Parameters()
    parameters.set("PATH_ACC", 5.0)
    braking = Braking(JET, parameters)
    with_it, still, against = (braking.speed_mps(20.0, stream) for stream in (0.4, 0.0, -0.4))
    assert with_it < still < against
    assert math.isinf(braking.way_m(30.0, 0.0))


def test_nothing_ahead_is_no_limit() -> None:
    assert math.isinf(Braking(OTTER, Parameters()).speed_mps(math.inf, 0.0))
    assert Braking(OTTER, Parameters()).speed_mps(0.0, 0.0) == pytest.approx(0.0)
