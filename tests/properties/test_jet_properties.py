"""Thrust of a jet and its inverse undo each other, and no demand leads out of the limits."""

from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from companion.allocation.jet import JetAllocator
from companion.allocation.jet_curve import JetCurve
from companion.config.vessel import find, load
from companion.core.actuation import Wrench
from companion.params.store import Parameters

VESSEL = load(find("rescuerunner"))
CURVE = JetCurve(VESSEL.thrusters[0])


@given(st.floats(0.021, 0.999), st.floats(0.0, 22.0))
def test_throttle_to_thrust_and_back(throttle: float, surge_mps: float) -> None:
    """But where the boat outruns the jet so far that more water leaving brakes more: there two throttles give one
    thrust."""
    exit_mps = 6.0 + 27.0 * throttle**1.32
    if exit_mps > 0.45 * surge_mps * 1.001:
        assert math.isclose(
            CURVE.throttle(CURVE.thrust_n(throttle, surge_mps), surge_mps), throttle, rel_tol=1e-4, abs_tol=1e-4
        )


@given(st.floats(-3000.0, 8000.0), st.floats(-3.0, 25.0))
def test_thrust_to_throttle_and_back(thrust_n: float, surge_mps: float) -> None:
    given_n = CURVE.thrust_n(CURVE.throttle(thrust_n, surge_mps), surge_mps)
    low, high = CURVE.thrust_n(CURVE.least, surge_mps), CURVE.thrust_n(CURVE.most, surge_mps)
    if thrust_n >= high:
        assert math.isclose(given_n, high, rel_tol=1e-9)
    elif thrust_n > low:
        assert math.isclose(given_n, thrust_n, rel_tol=1e-6, abs_tol=1e-3)
    else:
        assert given_n <= max(low, thrust_n) + 1e-6 or given_n == low


@given(
    st.lists(
        st.tuples(st.floats(-5000.0, 6000.0), st.floats(-2000.0, 2000.0), st.floats(-3.0, 25.0)),
        min_size=1,
        max_size=30,
    )
)
def test_within_limits_and_true_to_what_it_says(demands: list[tuple[float, float, float]]) -> None:
    a = JetAllocator(VESSEL, Parameters(VESSEL.parameters))
    for surge_n, yaw_nm, surge_mps in demands:
        result = a.update(Wrench(surge_n, 0.0, yaw_nm), 0.05, surge_mps)
        (command,) = result.thrusters
        assert command.azimuth_rad is not None
        assert 0.0 <= command.throttle <= 1.0 and abs(command.azimuth_rad) <= math.radians(24.0) + 1e-9
        x, y = command.force_n * math.cos(command.azimuth_rad), command.force_n * math.sin(command.azimuth_rad)
        assert math.isclose(result.achieved.surge_n, x, abs_tol=1e-9) and math.isclose(
            result.achieved.yaw_nm, -1.6 * y, abs_tol=1e-9
        )
        assert command.throttle == 0.0 or command.throttle >= 0.02
