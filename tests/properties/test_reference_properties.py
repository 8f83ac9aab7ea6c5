"""Whatever is asked of the reference, it stays consistent, within its limits, and arrives."""

from __future__ import annotations

import math

from hypothesis import given, settings
from hypothesis import strategies as st

from companion.baselines.reference import ThesisReference
from companion.core.frames import body_to_ned
from companion.core.setpoint import Setpoint
from companion.guidance.reference import ReferenceGenerator
from companion.params.store import Parameters

DT_S = 0.1
PARAMETERS = Parameters()
angles = st.floats(-math.pi, math.pi)
targets = st.tuples(st.floats(-10.0, 10.0), st.floats(-10.0, 10.0), angles, st.integers(1, 200))
motions = st.tuples(st.floats(-0.2, 0.5), st.floats(-0.1, 0.1), st.floats(-0.05, 0.05))


def consistent(a: Setpoint, b: Setpoint, tolerance: float) -> None:
    """`b` follows from `a` by the velocities and accelerations they state."""
    assert a.north_m is not None and a.east_m is not None and a.yaw_rad is not None
    assert b.north_m is not None and b.east_m is not None and b.yaw_rad is not None
    before, after = body_to_ned(a.surge_mps, a.sway_mps, a.yaw_rad), body_to_ned(b.surge_mps, b.sway_mps, b.yaw_rad)
    # the stated acceleration is that of the body-frame velocity; in NED the rotation comes on top
    push = body_to_ned(
        b.surge_mps2 - b.yaw_rate_radps * b.sway_mps, b.sway_mps2 + b.yaw_rate_radps * b.surge_mps, b.yaw_rad
    )
    for i, (p, q) in enumerate(((a.north_m, b.north_m), (a.east_m, b.east_m))):
        assert abs(q - p - 0.5 * (before[i] + after[i]) * DT_S) < tolerance
        assert abs(after[i] - before[i] - push[i] * DT_S) < tolerance
    turned = math.remainder(b.yaw_rad - a.yaw_rad, 2.0 * math.pi)
    assert abs(turned - 0.5 * (a.yaw_rate_radps + b.yaw_rate_radps) * DT_S) < tolerance
    assert abs(b.yaw_rate_radps - a.yaw_rate_radps - b.yaw_radps2 * DT_S) < tolerance


def within_limits(s: Setpoint) -> None:
    p = PARAMETERS
    slack = 1.02
    assert -p["DP_SPEED_ASTERN"] * slack <= s.surge_mps <= p["DP_SPEED_AHEAD"] * slack
    assert abs(s.sway_mps) <= p["DP_SPEED_SWAY"] * slack
    assert abs(s.yaw_rate_radps) <= math.radians(p["DP_YAW_RATE"]) * slack


def accelerates_within_limits(s: Setpoint) -> None:
    """In body axes, less the centripetal part that comes of turning while moving."""
    ax, ay = s.surge_mps2 - s.yaw_rate_radps * s.sway_mps, s.sway_mps2 + s.yaw_rate_radps * s.surge_mps
    assert abs(ax) <= 1.05 * PARAMETERS["DP_ACC_SURGE"]
    assert abs(ay) <= 1.1 * PARAMETERS["DP_ACC_SWAY"]
    assert abs(s.yaw_radps2) <= 1.02 * math.radians(PARAMETERS["DP_ACC_YAW"])


@settings(deadline=None, derandomize=True, max_examples=60)
@given(angles, motions, st.lists(targets, min_size=1, max_size=3))
def test_any_sequence_of_targets(
    yaw: float, motion: tuple[float, float, float], sequence: list[tuple[float, float, float, int]]
) -> None:
    generator = ReferenceGenerator(PARAMETERS)
    generator.start(0.0, 0.0, yaw, *motion)
    last = generator.update(DT_S)
    for north, east, heading, steps in sequence:
        generator.retarget(north, east, heading)
        for _ in range(steps):
            now = generator.update(DT_S)
            consistent(last, now, 1e-8)  # the last 1e-7 are taken at once, spread over the smoothing
            accelerates_within_limits(now)
            last = now
    for _ in range(5000):
        last = generator.update(DT_S)
        if generator.arrived:
            break
    assert generator.arrived
    assert (last.north_m, last.east_m) == sequence[-1][:2]
    assert last.yaw_rad is not None
    assert abs(math.remainder(last.yaw_rad - sequence[-1][2], 2.0 * math.pi)) < 1e-9
    assert last.surge_mps == last.sway_mps == last.yaw_rate_radps == 0.0


@settings(deadline=None, derandomize=True, max_examples=60)
@given(angles, targets)
def test_from_rest_speeds_keep_their_limits_and_nothing_overshoots(
    yaw: float, target: tuple[float, float, float, int]
) -> None:
    generator = ReferenceGenerator(PARAMETERS)
    generator.start(0.0, 0.0, yaw)
    north, east, heading, _ = target
    generator.retarget(north, east, heading)
    whole = math.hypot(north, east)
    gone = -1e-9
    for _ in range(5000):
        now = generator.update(DT_S)
        within_limits(now)
        assert now.north_m is not None and now.east_m is not None
        along = math.hypot(now.north_m, now.east_m)
        assert gone - 1e-9 <= along <= whole + 1e-6
        gone = along
        if generator.arrived:
            break
    assert generator.arrived


@settings(deadline=None, derandomize=True, max_examples=20)
@given(angles, targets)
def test_the_thesis_filter_is_consistent_to_the_order_of_its_step(
    yaw: float, target: tuple[float, float, float, int]
) -> None:
    reference = ThesisReference(PARAMETERS)
    reference.start(0.0, 0.0, yaw)
    reference.retarget(*target[:3])
    last = reference.update(DT_S)
    for _ in range(200):
        now = reference.update(DT_S)
        consistent(last, now, 0.02)
        last = now
