"""The reference of dynamic positioning: consistent, within limits, exact, without overshoot."""

from __future__ import annotations

import itertools
import math

import pytest

from companion.core.angles import wrap_pi
from companion.core.frames import body_to_ned
from companion.core.setpoint import PoseSetpoint, Setpoint
from companion.guidance.reference import ReferenceGenerator
from companion.guidance.stopping import SMOOTHING_S, stopping_point
from companion.params.store import Parameters
from tests.unit.control.simple_boat import nav_state

DT_S = 0.1


def run(generator: ReferenceGenerator, seconds: float = 400.0) -> list[Setpoint]:
    """Setpoints until arrival."""
    points = []
    for _ in range(round(seconds / DT_S)):
        points.append(generator.update(DT_S))
        if generator.arrived:
            return points
    pytest.fail("never arrived")


def pose(setpoint: Setpoint) -> tuple[float, float, float]:
    assert setpoint.north_m is not None and setpoint.east_m is not None and setpoint.yaw_rad is not None
    return setpoint.north_m, setpoint.east_m, setpoint.yaw_rad


@pytest.fixture
def generator() -> ReferenceGenerator:
    return ReferenceGenerator(Parameters())


def test_a_leg_ahead_is_a_trapezoid_smoothed(generator: ReferenceGenerator) -> None:
    generator.start(0.0, 0.0, 0.0)
    generator.retarget(10.0, 0.0, 0.0)
    points = run(generator)
    # at 0.5 m/s with 0.1 m/s² up and 0.085 m/s² down: 5.0 s + 5.88 s + (10 − 1.25 − 1.47)/0.5 s, and the smoothing's
    # lag
    assert len(points) * DT_S == pytest.approx(5.0 + 5.88 + 14.56 + SMOOTHING_S, abs=0.5)
    assert max(p.surge_mps for p in points) == pytest.approx(0.5, rel=1e-6)
    assert pose(points[-1]) == (10.0, 0.0, 0.0)
    assert max(pose(p)[0] for p in points) < 10.0 + 1e-4
    assert all(isinstance(p, PoseSetpoint) for p in points)
    assert points[-1].progress.distance_to_go_m == 0.0


def test_jerk_is_bounded(generator: ReferenceGenerator) -> None:
    generator.start(0.0, 0.0, 0.0)
    generator.retarget(10.0, 0.0, 0.0)
    accelerations = [0.0, *(p.surge_mps2 for p in run(generator))]
    jerk = max(abs(b - a) / DT_S for a, b in itertools.pairwise(accelerations))
    assert jerk <= (0.1 + 0.085) / SMOOTHING_S + 1e-6


def test_all_axes_arrive_together(generator: ReferenceGenerator) -> None:
    generator.start(0.0, 0.0, 0.0)
    generator.retarget(4.0, -3.0, math.radians(60.0))
    for point in run(generator):
        north, east, yaw = pose(point)
        assert east == pytest.approx(-0.75 * north, abs=1e-9)
        assert yaw == pytest.approx(math.radians(15.0) * north, abs=1e-9)


def test_heading_takes_the_shorter_turn(generator: ReferenceGenerator) -> None:
    generator.start(0.0, 0.0, math.radians(170.0))
    generator.retarget(0.0, 0.0, math.radians(-170.0))
    points = run(generator)
    assert all(abs(wrap_pi(pose(p)[2] - math.pi)) <= math.radians(10.0) + 1e-9 for p in points)
    assert all(p.yaw_rate_radps >= -1e-9 for p in points[:-2])


@pytest.mark.parametrize(("usual_dps", "hurried_dps"), [(2.0, 5.4), (3.0, 8.0), (20.0, 20.0)])
def test_a_hurried_turn_is_faster_but_never_wild(usual_dps: float, hurried_dps: float) -> None:
    generator = ReferenceGenerator(Parameters({"DP_YAW_RATE": usual_dps, "DP_ACC_YAW": 60.0}))
    for hurries, rate_dps in ((True, hurried_dps), (False, usual_dps)):
        generator.start(0.0, 0.0, 0.0)
        generator.retarget(0.0, 0.0, math.radians(150.0), None, hurries)
        assert max(p.yaw_rate_radps for p in run(generator)) == pytest.approx(math.radians(rate_dps), rel=1e-6)


def test_it_begins_where_and_as_the_boat_moves(generator: ReferenceGenerator) -> None:
    generator.start(3.0, 4.0, 0.7, surge_mps=0.4, sway_mps=-0.05, yaw_rate_radps=0.02)
    first = generator.update(DT_S)
    vn, ve = body_to_ned(0.4, -0.05, 0.7)
    assert pose(first)[0] == pytest.approx(3.0 + vn * DT_S, abs=1e-3)
    assert pose(first)[1] == pytest.approx(4.0 + ve * DT_S, abs=1e-3)
    assert first.surge_mps == pytest.approx(0.4, abs=2e-3)
    assert first.sway_mps == pytest.approx(-0.05, abs=2e-3)
    assert first.yaw_rate_radps == pytest.approx(0.02, abs=2e-3)


def test_without_a_target_it_stops_at_the_stopping_point(generator: ReferenceGenerator) -> None:
    generator.start(0.0, 0.0, 0.3, surge_mps=0.4)
    points = run(generator)
    expected = stopping_point(nav_state(yaw_rad=0.3, surge_mps=0.4), Parameters())
    assert pose(points[-1])[:2] == pytest.approx(expected, abs=1e-9)
    assert math.hypot(*expected) == pytest.approx(0.4 * 0.75 + 0.4**2 / (2.0 * 0.085), rel=1e-6)
    along = [math.hypot(*pose(p)[:2]) for p in points]
    assert max(along) <= along[-1] + 1e-4, "no overshoot"


@pytest.mark.parametrize("further_m", [3.0, 5.0])
def test_retarget_under_way_on_the_same_line_does_not_overshoot(
    generator: ReferenceGenerator, further_m: float
) -> None:
    generator.start(0.0, 0.0, 0.0)
    generator.retarget(10.0, 0.0, 0.0)
    for _ in range(80):
        last = generator.update(DT_S)
    aim = pose(last)[0] + further_m
    generator.retarget(aim, 0.0, 0.0)
    points = run(generator)
    assert max(pose(p)[0] for p in points) < aim + 1e-4
    assert min(p.surge_mps for p in points) > -1e-3


def test_a_moving_target_is_followed_at_its_speed(generator: ReferenceGenerator) -> None:
    generator.start(0.0, 0.0, 0.0)
    for k in range(400):
        generator.retarget(0.03 * k, 0.0, 0.0)
        point = generator.update(DT_S)
    assert point.surge_mps == pytest.approx(0.3, abs=1e-3)
    assert 0.03 * 399 - pose(point)[0] < 1.0


def test_a_lower_speed_is_kept_and_limits_are_read_at_each_step() -> None:
    parameters = Parameters()
    generator = ReferenceGenerator(parameters)
    generator.start(0.0, 0.0, 0.0)
    generator.retarget(5.0, 0.0, 0.0, speed_mps=0.2)
    assert max(p.surge_mps for p in run(generator)) == pytest.approx(0.2, rel=1e-6)
    parameters.set("DP_SPEED_AHEAD", 0.3)
    generator.retarget(10.0, 0.0, 0.0)
    assert max(p.surge_mps for p in run(generator)) == pytest.approx(0.3, rel=1e-6)


def test_astern_and_sideways_have_their_own_limits(generator: ReferenceGenerator) -> None:
    generator.start(0.0, 0.0, 0.0)
    generator.retarget(-5.0, 0.0, 0.0)
    assert min(p.surge_mps for p in run(generator)) == pytest.approx(-0.2, rel=1e-6)
    generator.retarget(-5.0, 3.0, 0.0)
    assert max(p.sway_mps for p in run(generator)) == pytest.approx(0.1, rel=1e-6)


def test_target_and_arrived(generator: ReferenceGenerator) -> None:
    generator.start(1.0, 2.0, 3.0)
    generator.retarget(1.0, 3.0, -3.0)
    assert generator.target == pytest.approx((1.0, 3.0, -3.0))
    assert not generator.arrived
    run(generator)
    assert generator.arrived
    generator.retarget(1.0, 3.5, -3.0)
    assert not generator.arrived


def test_a_boat_that_spins_is_not_led_half_a_turn_on(generator: ReferenceGenerator) -> None:
    """Adrift it turned at 11°/s, and the reference, which brakes gently, took it 60° further before it came back."""
    generator.start(0.0, 0.0, 0.4, yaw_rate_radps=math.radians(11.0))
    generator.retarget(0.0, 0.0, 0.0)
    points = run(generator)
    assert max(pose(point)[2] for point in points) < 0.4 + math.radians(30.0)


def test_a_boat_that_spins_and_slides_is_not_led_round(generator: ReferenceGenerator) -> None:
    """ÅBOAT out of a hard turn by stick: its slide was braked gently, and its turn in step with that, once round."""
    generator.start(0.0, 0.0, 0.0, 1.2, -0.8, 0.76)
    generator.retarget(1.0, 0.0, 0.0)
    points = [pose(point) for point in run(generator)]
    assert max(abs(yaw_rad) for _, _, yaw_rad in points) < math.radians(120.0)
    assert max(math.hypot(north_m, east_m) for north_m, east_m, _ in points) < 5.0
