"""Low-pass differencing of the pose."""

from __future__ import annotations

import math

import pytest

from companion.nav.no_imu import PoseSolution
from companion.nav.outliers import FirstWay, Verdict

LEVER = (-0.81, 0.0, -0.2)


def circling(solution: PoseSolution, until_s: float, begin_s: float = 0.0) -> None:
    """Noise-free antenna positions and headings at 20 Hz of a boat on a circle of 10 m at 1 m/s."""
    for k in range(round(begin_s * 20), round(until_s * 20)):
        t = k / 20
        yaw = 0.1 * t
        north, east = 10.0 * math.sin(yaw) - 0.81 * math.cos(yaw), 10.0 * (1.0 - math.cos(yaw)) - 0.81 * math.sin(yaw)
        solution.heading(t, math.remainder(yaw, 2.0 * math.pi), 0.01)
        if not solution.started:
            solution.begin(t, north, east, LEVER, 0.02)
        else:
            solution.position(t, north, east, LEVER, 0.02)


def test_heading_on_a_circle_over_the_wrap() -> None:
    solution = PoseSolution()
    circling(solution, 50.0)
    motion, yaw = solution.motion(50.0), 5.0
    assert motion.position[:2] == pytest.approx((10.0 * math.sin(yaw), 10.0 * (1.0 - math.cos(yaw))), abs=0.03)
    assert motion.velocity[:2] == pytest.approx((math.cos(yaw), math.sin(yaw)), abs=0.11)  # 2τ behind in a turn
    assert motion.attitude[2] == pytest.approx(math.remainder(yaw, 2.0 * math.pi), abs=0.005)
    assert motion.rates[2] == pytest.approx(0.1, abs=0.005)


@pytest.mark.parametrize("by_course", [False, True], ids=["by its antennas", "by its course"])
def test_a_boat_that_starts_in_a_turn_is_followed(by_course: bool) -> None:
    """Its rate of turn is not known yet, and a course is 15° off. Neither makes outliers of good headings."""
    solution = PoseSolution()
    if by_course:
        solution.heading(0.0, math.radians(-15.0), math.radians(15.0))
    for k in range(1, 80):
        t_s = k / 20
        verdict = solution.heading(t_s, 0.4 * t_s, math.radians(0.4))
        assert verdict is not Verdict.REJECT
        motion = solution.motion(t_s)
        assert abs(motion.attitude[2] - 0.4 * t_s) < 3.0 * motion.yaw_sigma_rad
    assert motion.attitude[2] == pytest.approx(0.4 * t_s, abs=math.radians(0.2))
    assert motion.rates[2] == pytest.approx(0.4, abs=0.01)


@pytest.mark.parametrize("sigma_deg", [0.3, 1.0])
@pytest.mark.parametrize("rate_hz", [5, 10, 20])
def test_a_boat_that_turns_round_its_point_is_followed(rate_hz: int, sigma_deg: float) -> None:
    """As an Otter does that holds: within a second it turns at 20 degrees a second, and stops as soon."""
    solution, yaw_rad, radps, dt_s = PoseSolution(), 0.0, 0.0, 1.0 / rate_hz
    for k in range(1, 8 * rate_hz):
        solution.heading(k * dt_s, math.remainder(yaw_rad, math.tau), math.radians(sigma_deg))
        change = 0.35 if 3.0 <= k * dt_s < 4.0 else -0.35 if 5.0 <= k * dt_s < 6.0 else 0.0
        yaw_rad, radps = yaw_rad + radps * dt_s, radps + change * dt_s
        off_rad = math.remainder(yaw_rad - solution.motion((k + 1) * dt_s).attitude[2], math.tau)
        assert abs(math.degrees(off_rad)) < 6.0, k * dt_s


def test_position_and_heading_outliers_are_rejected() -> None:
    solution = PoseSolution()
    circling(solution, 20.0)
    before = solution.motion(20.0)
    assert solution.position(20.0, 1e6, -1e6, LEVER, 0.02) is Verdict.REJECT
    assert solution.heading(20.0, before.attitude[2] + 2.0, 0.01) is Verdict.REJECT
    assert solution.motion(20.0) == before


def test_measured_velocity_is_preferred() -> None:
    solution = PoseSolution()
    circling(solution, 5.0)
    for k in range(100, 160):
        solution.velocity(k / 20, 0.5, -0.5, (0.0, 0.0, 0.0), 0.05)
    motion = solution.motion(8.0)
    assert motion.velocity[:2] == pytest.approx((0.5, -0.5), abs=0.02)
    assert motion.position[0] == pytest.approx(10.0 * math.sin(0.5) + 0.5 * 3.0, abs=0.4)  # carried on by it


def test_a_velocity_that_a_boat_has_left_behind_is_unsure() -> None:
    """A small boat gathers way by 0.5 m/s from one velocity to the next, and they are taken for outliers. A filter with
    an inertial sensor began there, sure of 0.03 m/s, and of a heading that it made of that."""
    solution = PoseSolution()
    solution.begin(0.0, 0.0, 0.0, (0.0, 0.0, 0.0), 0.02)
    for k in range(1, 51):
        solution.velocity(0.2 * k, 0.0, 0.0, (0.0, 0.0, 0.0), 0.035)
    assert solution.motion(10.0).velocity_sigma_mps < 0.1
    for k in range(1, 5):
        speed_mps = 0.5 * k
        solution.velocity(10.0 + 0.2 * k, speed_mps, 0.0, (0.0, 0.0, 0.0), 0.035)
        motion = solution.motion(10.0 + 0.2 * k)
        assert speed_mps - motion.velocity[0] <= 1.5 * motion.velocity_sigma_mps
    for k in range(30):
        solution.velocity(11.0 + 0.2 * k, 2.0, 0.0, (0.0, 0.0, 0.0), 0.035)
    assert solution.motion(17.0).velocity_sigma_mps < 0.3


def test_a_velocity_that_lies_makes_nothing_unsure() -> None:
    solution = PoseSolution()
    solution.begin(0.0, 0.0, 0.0, (0.0, 0.0, 0.0), 0.02)
    solution.velocity(0.2, 0.0, 0.0, (0.0, 0.0, 0.0), 0.035)
    solution.velocity(0.4, 3.0, 0.0, (0.0, 0.0, 0.0), 0.035, Verdict.REJECT)
    assert solution.motion(0.4).velocity_sigma_mps < 0.2


def test_rates_decay_without_measurements() -> None:
    solution = PoseSolution()
    circling(solution, 20.0)
    at, later = solution.motion(20.0), solution.motion(60.0)
    carried = math.hypot(later.position[0] - at.position[0], later.position[1] - at.position[1])
    assert carried == pytest.approx(5.0, rel=0.1)
    assert math.hypot(*later.velocity) < 1e-3
    assert later.position_sigma_m > 50.0


def test_the_velocity_that_it_began_with_is_forgotten_with_its_doubt() -> None:
    """The first fix after the begin says three quarters of the velocity: the sigma was that of a velocity known since
    long."""
    solution, antenna = PoseSolution(), (0.0, 0.0, 0.0)
    solution.begin(0.0, 0.0, 0.0, antenna, 0.02, FirstWay(0.0, 0.0, 3.0))
    assert solution.motion(0.0).velocity_sigma_mps == pytest.approx(3.0)
    for t_s in (1.0, 2.0, 3.0, 4.0):
        solution.position(t_s, 3.0 * t_s, 0.0, antenna, 0.02)
        motion = solution.motion(t_s)
        assert abs(motion.velocity[0] - 3.0) < 2.0 * motion.velocity_sigma_mps
    assert motion.velocity_sigma_mps < 0.5


def test_the_swing_of_an_antenna_whose_turn_is_not_known_yet_counts() -> None:
    solution = PoseSolution()
    solution.begin(0.0, 0.0, 0.0, LEVER, 0.02)
    solution.heading(0.0, 0.0, 0.01)
    solution.velocity(0.0, 1.0, 0.0, LEVER, 0.03)
    assert solution.motion(0.0).velocity_sigma_mps > 0.3
    other = PoseSolution()
    circling(other, 10.0)
    other.velocity(10.0, 1.0, 0.0, LEVER, 0.03)
    assert other.motion(10.0).velocity_sigma_mps < 0.1


def test_a_fast_boat_in_a_hard_turn_is_followed() -> None:
    """8 m/s and 0.5 rad/s: the velocity changes by 4 m/s², as a water jet does."""
    solution = PoseSolution()
    solution.begin(0.0, 0.0, 0.0, (0.0, 0.0, 0.0), 0.02)
    solution.heading(0.0, 0.0, 0.1)
    radius_m, verdicts = 16.0, set()
    for k in range(1, 100):
        t = 0.1 * k
        yaw = max(0.0, 0.5 * (t - 3.0))  # straight ahead for 3 s
        north = 8.0 * min(t, 3.0) + radius_m * math.sin(yaw)
        east = radius_m * (1.0 - math.cos(yaw))
        solution.heading(t, math.remainder(yaw, 2.0 * math.pi), 0.1)
        place = solution.position(t, north, east, (0.0, 0.0, 0.0), 0.02)
        speed = solution.velocity(t, 8.0 * math.cos(yaw), 8.0 * math.sin(yaw), (0.0, 0.0, 0.0), 0.02)
        verdicts |= {place, speed} if t > 1.5 else set()
        motion = solution.motion(t)
        if t > 1.5:
            assert motion.velocity[:2] == pytest.approx((8.0 * math.cos(yaw), 8.0 * math.sin(yaw)), abs=0.5)
            assert motion.position[:2] == pytest.approx((north, east), abs=0.4)
    assert verdicts == {Verdict.ACCEPT}
