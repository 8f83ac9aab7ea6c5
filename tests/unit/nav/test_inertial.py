"""What the solution with an inertial sensor makes of the slow errors of positions, at rest."""

from __future__ import annotations

import math
import random

import pytest

from companion.core.readings import Imu
from companion.nav.inertial import InertialSolution
from companion.nav.lever_arms import ZERO, quaternion_of, rotation
from companion.nav.measured_off import Wander
from companion.nav.outliers import Verdict
from companion.nav.solution import Motion

G = 9.82


def at_rest(wander_m: float) -> InertialSolution:
    made = InertialSolution(G, ZERO)
    made.expect_wander(Wander(wander_m, 300.0), another=False)
    made.sample(Imu(0.0, "imu", 0.0, 0.0, -G, 0.0, 0.0, 0.0))
    made.start(Motion(0.0, ZERO, ZERO, ZERO, ZERO, 0.1, 0.05, 0.01), (0.0, 0.0))
    return made


def fixes(
    made: InertialSolution, north_m: float, from_s: float, seconds: float, heading: bool = False
) -> list[Verdict]:
    """Samples at 100 Hz, a fix and a velocity every tenth of a second, and a heading."""
    verdicts = []
    for k in range(1, round(seconds * 100) + 1):
        t_s = from_s + k / 100
        made.sample(Imu(t_s, "imu", 0.0, 0.0, -G, 0.0, 0.0, 0.0))
        if k % 10 == 0:
            made.velocity(t_s, 0.0, 0.0, ZERO, 0.02)
            if heading:
                made.heading(t_s, 0.0, 0.005)
            verdicts.append(made.position(t_s, north_m, 0.0, ZERO, 0.02))
    return verdicts


def test_the_first_position_after_the_start_says_where_the_boat_is() -> None:
    """As far as it is off by its slow error, which the sigma holds."""
    made = at_rest(0.5)
    assert fixes(made, 0.1, 0.0, 0.1) == [Verdict.ACCEPT]
    motion = made.motion(0.1)
    assert motion.position[0] == pytest.approx(0.1, abs=1e-6)
    assert motion.position_sigma_m == pytest.approx(0.5, abs=0.01)


def test_a_jump_that_the_slow_error_explains_does_not_move_the_boat() -> None:
    """As when other satellites come. One that it does not explain moves it."""
    made = at_rest(0.5)
    fixes(made, 0.0, 0.0, 10.0)
    assert Verdict.REJECT in fixes(made, 1.2, 10.0, 5.0)
    motion, place = made.motion(15.0), made.place(15.0)
    assert abs(motion.position[0]) < 0.9 and place.north_m == pytest.approx(1.2, abs=0.02)
    assert motion.position[0] + made.filter.wander[0] == pytest.approx(1.2, abs=0.02)
    assert Verdict.RESET in fixes(made, 30.0, 15.0, 5.0)
    assert made.motion(20.0).position[0] == pytest.approx(30.0, abs=0.05)


def test_another_receiver_shares_a_part_of_the_slow_error() -> None:
    made = at_rest(0.5)
    fixes(made, 0.3, 0.0, 10.0)
    fixes(made, 0.6, 10.0, 10.0)
    before = made.filter.wander[0]
    made.expect_wander(Wander(0.5, 300.0), another=True)
    assert made.filter.wander[0] == pytest.approx(0.7 * before)


def settled(wander_m: float = 0.008) -> InertialSolution:
    """At rest at its place for 30 s, so that its gyro's bias is known."""
    made = at_rest(wander_m)
    fixes(made, 0.0, 0.0, 30.0, heading=True)
    return made


def test_a_fixed_solution_that_jumps_does_not_move_the_boat_and_makes_it_unsure() -> None:
    """By less than the gate rejects: ambiguities that are solved wrongly. Back again, all is as before."""
    made = settled()
    assert Verdict.REJECT not in fixes(made, 0.2, 30.0, 20.0)
    motion = made.motion(50.0)
    assert abs(motion.position[0]) < 0.06 and motion.position_sigma_m > 0.1
    assert made.place(50.0).north_m == pytest.approx(0.2, abs=0.02)
    fixes(made, 0.0, 50.0, 10.0)
    motion = made.motion(60.0)
    assert abs(motion.position[0]) < 0.02 and motion.position_sigma_m < 0.03


def test_a_reset_by_decimetres_leaves_the_position_as_unsure() -> None:
    """Whether it was wrong before or is now, nobody knows. Of one by many metres, it was the estimate."""
    made = settled()
    assert Verdict.RESET in fixes(made, 0.6, 30.0, 5.0)
    motion = made.motion(35.0)
    assert motion.position[0] == pytest.approx(0.6, abs=0.1) and 0.3 < motion.position_sigma_m < 0.5
    assert Verdict.RESET in fixes(made, 30.0, 35.0, 5.0)
    assert made.motion(40.0).position_sigma_m < 0.1


def test_positions_that_wander_faster_than_is_said_make_the_boat_unsure() -> None:
    """Multipath of a decimetre in a minute, of which velocities know nothing."""
    made = settled()
    off_m, t_s = 0.0, 30.0
    for k in range(120):
        off_m = 0.1 * math.sin(k / 10.0)
        fixes(made, off_m, t_s, 0.5)
        made.expect_wander(Wander(0.008, 300.0), another=False)
        t_s += 0.5
        motion = made.motion(t_s)
        assert abs(motion.position[0]) < 3.0 * max(motion.position_sigma_m, 0.03), t_s
    assert motion.position_sigma_m > 0.03


def test_after_it_has_begun_anew_the_next_measurements_count_alone() -> None:
    made = settled()
    made.begin_anew()
    assert fixes(made, 0.2, 30.0, 0.1) == [Verdict.ACCEPT]
    made.heading(30.1, 0.3, 0.01)
    motion = made.motion(30.1)
    assert motion.position[0] == pytest.approx(0.2, abs=0.01) and motion.attitude[2] == pytest.approx(0.3, abs=0.01)


def test_tilt_and_bias_that_hide_each_other_go_together_when_it_begins_anew() -> None:
    """What late velocities make of a boat that is level: 3 degrees of roll, and a bias that takes them off again."""
    made = settled()
    made.filter.accelerometer_bias = (0.2, -G * math.sin(math.radians(3.0)), 0.0)
    made.filter.gyro_bias = (0.0, 0.0, math.radians(1.5))
    made.filter.quaternion = quaternion_of(math.radians(-3.0), -math.asin(0.2 / G), 0.0)
    made.filter.rotation = rotation(made.filter.quaternion)
    made.begin_anew()
    roll, pitch, _ = made.filter.euler()
    assert math.degrees(abs(roll)) < 0.1 and math.degrees(abs(pitch)) < 0.1
    assert made.filter.accelerometer_bias == made.filter.gyro_bias == ZERO
    assert made.motion(30.0).yaw_sigma_rad > math.radians(10.0)


def test_a_receiver_whose_latency_nobody_knows_leaves_a_boat_under_way_unsure() -> None:
    made = settled()
    made.filter.velocity = (2.0, 0.0, 0.0)
    known_m = made.motion(30.0).position_sigma_m
    made.filter.expect_late(0.15)
    made.filter.reset_position(0.0, 0.0, ZERO, 1e-4, 0.0)
    assert known_m < 0.05
    assert made.motion(30.0).position_sigma_m == pytest.approx(0.15 * 2.0 / math.sqrt(2.0), rel=0.02)  # on one axis


def test_a_filter_that_begins_in_a_wave_soon_knows_how_the_boat_heaves() -> None:
    """That a boat floats tells little of it: heave lasts as long as its waves, and is no new error each time."""
    made, heave_m, radps, worst_mps = at_rest(0.5), 0.15, 4.0, 0.0
    for k in range(1, 3001):
        t_s = k / 100
        made.sample(Imu(t_s, "imu", 0.0, 0.0, -G - heave_m * radps**2 * math.sin(radps * t_s), 0.0, 0.0, 0.0))
        if k % 10 == 0:
            made.velocity(t_s, 0.0, 0.0, ZERO, 0.02)
        if k > 1500:
            worst_mps = max(worst_mps, abs(made.filter.velocity[2] - heave_m * radps * math.cos(radps * t_s)))
    assert worst_mps < 0.15 * heave_m * radps


def test_what_the_sums_say_of_the_boats_origin_stays_where_another_sensor_takes_over() -> None:
    """It sits two metres further ahead, in a turn: the receiver seemed to jump by them."""
    made = InertialSolution(G, ZERO)
    made.sample(Imu(0.0, "imu", 0.0, 0.0, -G, 0.0, 0.0, 0.5))
    made.start(Motion(0.0, ZERO, (1.0, 0.0, 0.0), (0.0, 0.0, 0.7), ZERO, 0.1, 0.05, 0.01), (0.0, 0.0))
    made.sample(Imu(0.01, "imu", 0.0, 0.0, -G, 0.0, 0.0, 0.5))

    def of_the_origin() -> tuple[float, ...]:
        sums, arm, swing = made.odometer, made.offset(made.lever_m), made.swing
        return (
            sums.north_m - arm.north_m,
            sums.east_m - arm.east_m,
            sums.north_mps - swing[0],
            sums.east_mps - swing[1],
        )

    before = of_the_origin()
    made.carry_over((2.0, 0.0, 0.0), made.filter.noise)
    assert math.hypot(*made.swing) == pytest.approx(1.0, rel=0.01)
    assert of_the_origin() == pytest.approx(before)


def test_a_boat_that_lies_still_learns_nothing_of_a_latency() -> None:
    """Its own noise seemed to tell: after ten minutes with one fix a second the values were 0.4 s early, by eight sigmas."""
    draw, made = random.Random(1), at_rest(0.008)
    made.filter.expect_late(0.15)
    for k in range(1, 20 * 600):
        t_s, noise = k / 20, [draw.gauss(0.0, 1.0) for _ in range(10)]
        force, rates = [0.01 * one for one in noise[:3]], [0.002 * one for one in noise[3:6]]
        made.sample(Imu(t_s, "imu", force[0], force[1], force[2] - G, *rates))
        if k % 20 == 0:
            made.velocity(t_s, 0.03 * noise[6], 0.03 * noise[7], ZERO, 0.03)
            made.position(t_s, 0.01 * noise[8], 0.01 * noise[9], ZERO, 0.02)
    assert abs(made.filter.late_s) < 0.05 and made.filter.late_sigma_s() > 0.1


def test_an_estimate_that_no_velocity_holds_comes_back_within_some_positions() -> None:
    """It has run away at 3 m/s and is sure of it: the rejected positions lie on a line, and tell its velocity, too."""
    made = at_rest(0.0)
    for k in range(1, 3300):
        t_s = k / 100
        made.sample(Imu(t_s, "imu", 0.0, 0.0, -G, 0.0, 0.0, 0.0))
        if k % 10 == 0:
            made.heading(t_s, 0.0, 0.005)
        if k % 100 == 0:
            made.position(t_s, 0.0, 0.0, ZERO, 0.02)
        if k == 2050:
            made.filter.velocity = (3.0, 0.0, 0.0)
    north, east, _ = made.motion(made.t_s).position
    assert math.hypot(north, east) < 0.3
    assert math.hypot(*made.filter.velocity[:2]) < 0.2


def test_where_velocities_hold_the_estimate_positions_that_leave_it_on_a_line_are_not_believed() -> None:
    made = at_rest(0.0)
    fixes(made, 0.0, 0.0, 20.0, heading=True)
    for k in range(1, 1500):
        t_s = 20.0 + k / 100
        made.sample(Imu(t_s, "imu", 0.0, 0.0, -G, 0.0, 0.0, 0.0))
        if k % 10 == 0:
            made.velocity(t_s, 0.0, 0.0, ZERO, 0.02)
        if k % 100 == 0:
            assert made.position(t_s, 3.0 * k / 100, 0.0, ZERO, 0.02) is Verdict.REJECT


def test_a_velocity_between_two_samples_of_a_slow_sensor_is_of_its_time() -> None:
    """It counted as of the last sample: a boat that gathers way by 1 m/s² was 0.05 m/s faster by then."""
    made = at_rest(0.0)
    for k in range(1, 31):
        t_s = k / 10
        made.sample(Imu(t_s, "imu", 1.0, 0.0, -G, 0.0, 0.0, 0.0))
        made.velocity(t_s, t_s, 0.0, ZERO, 0.01)
    before_mps = made.filter.velocity[0]
    made.velocity(t_s + 0.05, t_s + 0.05, 0.0, ZERO, 0.01)
    assert made.judged["velocity"].square < 1.0
    assert made.filter.velocity[0] == pytest.approx(before_mps, abs=0.005)
