"""The filter's arithmetic against independent computation; one test for each erratum of the thesis's filter."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.spatial.transform import Rotation

from companion.nav.error_state import SIZE, ErrorStateFilter, FilterNoise
from companion.nav.lever_arms import (
    Vector,
    cross,
    euler_of,
    exponential,
    multiply,
    normal_gravity_mps2,
    quaternion_of,
    rotate,
    rotation,
    velocity_ned,
)
from companion.nav.measured_off import Wander

ATTITUDE = (0.3, -0.4, 2.0)
LEVER = (-0.81, 0.3, -0.2)
SIGMAS = [0.5] * 3 + [0.2] * 3 + [0.05] * 3 + [0.05] * 3 + [0.003] * 3
WANDER, HEADING_WANDER = Wander(0.3, 100.0), Wander(0.02, 50.0)
LATE_SIGMA_S = 0.1
WHOLE = [*SIGMAS, WANDER.sigma, WANDER.sigma, HEADING_WANDER.sigma, LATE_SIGMA_S]


def a_filter(attitude: Vector = ATTITUDE, noise: FilterNoise | None = None) -> ErrorStateFilter:
    made = ErrorStateFilter(9.82, noise)
    made.expect_wander(WANDER)
    made.expect_heading_wander(HEADING_WANDER)
    made.expect_late(LATE_SIGMA_S)
    made.late_s, made.heading_late, made.gaining = 0.07, True, (0.4, -0.3)
    made.start((3.0, -4.0, 0.1), (0.7, -0.2, 0.05), attitude, SIGMAS)
    random = np.random.default_rng(7)
    mix = 0.05 * random.standard_normal((SIZE, SIZE)) * np.asarray(WHOLE)[:, None]
    made.covariance += mix @ mix.T  # correlations, so that no term of a product can hide
    return made


def skew(vector: Vector) -> np.ndarray:
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def turned_by(made: ErrorStateFilter, error: np.ndarray) -> ErrorStateFilter:
    """The filter's nominal state with an error state put in: an independent ⊕."""
    other = ErrorStateFilter(made.gravity_mps2)
    other.position = tuple(np.add(made.position, error[0:3]).tolist())
    other.velocity = tuple(np.add(made.velocity, error[3:6]).tolist())
    matrix = Rotation.from_rotvec(error[6:9]).as_matrix() @ np.reshape(made.rotation, (3, 3))
    other.rotation = tuple(matrix.ravel().tolist())
    x, y, z, w = Rotation.from_matrix(matrix).as_quat()
    other.quaternion = (float(w), float(x), float(y), float(z))
    other.accelerometer_bias = tuple(np.add(made.accelerometer_bias, error[9:12]).tolist())
    other.gyro_bias = tuple(np.add(made.gyro_bias, error[12:15]).tolist())
    other.wander = tuple(np.add(made.wander, error[15:17]).tolist())
    other.heading_wander = made.heading_wander + float(error[17])
    other.late_s = made.late_s + float(error[18])
    other.rates, other.gaining, other.heading_late = made.rates, made.gaining, made.heading_late
    return other


def error_between(true: ErrorStateFilter, estimate: ErrorStateFilter) -> np.ndarray:
    turn = Rotation.from_matrix(np.reshape(true.rotation, (3, 3)) @ np.reshape(estimate.rotation, (3, 3)).T).as_rotvec()
    parts = [np.subtract(getattr(true, name), getattr(estimate, name)) for name in ("position", "velocity")]
    biases = [np.subtract(getattr(true, name), getattr(estimate, name)) for name in ("accelerometer_bias", "gyro_bias")]
    wander = [*np.subtract(true.wander, estimate.wander), true.heading_wander - estimate.heading_wander]
    return np.concatenate([*parts, turn, *biases, wander, [true.late_s - estimate.late_s]])


def numeric(function: object, made: ErrorStateFilter) -> np.ndarray:
    """Derivative of `function(filter)` with respect to the error state."""
    columns = []
    for i in range(SIZE):
        step = np.zeros(SIZE)
        step[i] = 1e-6
        columns.append((function(turned_by(made, step)) - function(turned_by(made, -step))) / 2e-6)  # type: ignore[operator]
    return np.array(columns).T


def rocking(t_s: float) -> tuple[float, float, float, float]:
    """A boat in waves that roll it, carry it to starboard and back, and lift it most while it rolls: roll, velocity to
    starboard, the acceleration of that, and the one downwards."""
    return (
        0.2 * math.sin(4.0 * t_s),
        0.3 * math.sin(4.0 * t_s + 0.8),
        1.2 * math.cos(4.0 * t_s + 0.8),
        1.2 * math.cos(4.0 * t_s),
    )


def felt_in_waves(t_s: float) -> tuple[Vector, Vector]:
    """Its specific force and rates in body axes."""
    roll, _, sway_mps2, down_mps2 = rocking(t_s)
    c, s = math.cos(roll), math.sin(roll)
    down = down_mps2 - 9.82
    return (0.0, c * sway_mps2 + s * down, c * down - s * sway_mps2), (0.8 * math.cos(4.0 * t_s), 0.0, 0.0)


@pytest.mark.parametrize("delay_s", [0.01, 0.0], ids=["means of a step", "values at its end"])
def test_waves_are_no_bias_and_no_tilt(delay_s: float) -> None:
    """Force and attitude half a step apart look like both: 0.11 to 0.18 m/s² and 0.8° to 1.1° after a minute."""
    made, dt_s = ErrorStateFilter(9.82), 0.02
    made.start((0.0, 0.0, 0.0), (0.0, rocking(0.0)[1], 0.0), (0.0, 0.0, 0.0), SIGMAS)
    for k in range(1, 3001):
        made.predict(*felt_in_waves(k * dt_s - delay_s), dt_s)
        if k % 10 == 0:
            made.fuse(made.velocity_innovation(0.0, rocking(k * dt_s)[1], (0.0, 0.0, 0.0), 0.03**2))
            made.fuse(made.heading_innovation(0.0, 0.01**2))
            made.fuse_down(0.0, 0.3**2, 0.3**2)
    tilt = math.asin(made.rotation[7]) - rocking(60.0)[0]
    assert abs(made.accelerometer_bias[1]) < 0.1
    assert abs(tilt) < math.radians(0.5)


def test_erratum_1_heading_derivative() -> None:
    """∂ψ/∂w = [w2, −w1] / (w1² + w2²): against differences, at an attitude far from level."""
    made = a_filter()
    made.heading_innovation(0.0, 0.01)
    expected = numeric(lambda f: np.array(math.atan2(f.rotation[3], f.rotation[0]) + f.heading_wander), made)
    assert made._single.h[0] == pytest.approx(expected, abs=1e-6)


def test_erratum_2_reset_is_g_p_gt() -> None:
    """P after a fusion is the textbook update, then G P Gᵀ with G = I + ½ [δθ]×."""
    made = a_filter()
    prior = made.covariance.copy()
    innovation = made.heading_innovation(ATTITUDE[2] + 0.4, 0.01)
    h = made._single.h[0].copy()
    gain = prior @ h / (h @ prior @ h + 0.01)
    made.fuse(innovation)
    joseph = (np.eye(SIZE) - np.outer(gain, h)) @ prior @ (np.eye(SIZE) - np.outer(gain, h)).T + 0.01 * np.outer(
        gain, gain
    )
    g = np.eye(SIZE)
    g[6:9, 6:9] += 0.5 * skew(tuple((gain * innovation.y1)[6:9].tolist()))
    assert made.covariance == pytest.approx(g @ joseph @ g.T, abs=1e-12)
    assert np.abs(g @ joseph @ g - g @ joseph @ g.T).max() > 1e-6  # the printed form differs visibly here
    assert (made.covariance == made.covariance.T).all()


def test_reset_jacobian_against_differences() -> None:
    """G itself: how a remaining error looks after the mean of it has been injected."""
    mean = np.array([0.02, -0.01, 0.03])
    jacobian = np.empty((3, 3))
    for i in range(3):
        step = np.zeros(3)
        step[i] = 1e-6
        ends = [(Rotation.from_rotvec(mean + s) * Rotation.from_rotvec(mean).inv()).as_rotvec() for s in (step, -step)]
        jacobian[:, i] = (ends[0] - ends[1]) / 2e-6
    assert jacobian == pytest.approx(np.eye(3) + 0.5 * skew(tuple(mean.tolist())), abs=3e-4)


def test_erratum_3_the_gyro_has_its_own_noise() -> None:
    noise = FilterNoise(accelerometer_mps2_rthz=0.1, gyro_radps_rthz=1e-3)
    made = ErrorStateFilter(9.82, noise)
    made.start((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), [0.0] * 15)
    for _ in range(100):
        made.predict((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.01)  # no force, so tilt does not reach the velocity
    p = made.covariance
    assert np.diag(p)[6:9] == pytest.approx([1e-6] * 3, rel=0.05)  # 1e-3² rad²/s over 1 s
    assert np.diag(p)[3:6] == pytest.approx([1e-2] * 3, rel=0.05)


def test_erratum_4_the_covariance_is_propagated_with_every_sample() -> None:
    """While the boat swings round, one F of the last sample over the whole gap would give quite another covariance."""
    made = a_filter(noise=FilterNoise(accelerometer_bias_time_s=1e9, gyro_bias_time_s=1e9))
    expected = made.covariance.copy()
    noise = made.noise
    rates, force, dt = (0.0, 0.0, 1.5), (0.5, 0.2, -9.7), 0.01
    q = np.zeros(SIZE)
    q[3:6], q[6:9] = noise.accelerometer_mps2_rthz**2 * dt, noise.gyro_radps_rthz**2 * dt
    q[15:17], q[17] = 2.0 * WANDER.sigma**2 * dt / 100.0, 2.0 * HEADING_WANDER.sigma**2 * dt / 50.0
    q[18] = 5e-4**2 * dt
    attitude = Rotation.from_euler("ZYX", ATTITUDE[::-1])
    start = attitude
    for _ in range(200):
        a = np.zeros((SIZE, SIZE))
        matrix = attitude.as_matrix()
        a[0:3, 3:6] = np.eye(3)
        a[3:6, 6:9] = -skew(tuple((matrix @ force).tolist()))
        a[3:6, 9:12] = a[6:9, 12:15] = -matrix
        a[15:18, 15:18] = -np.diag([0.01, 0.01, 0.02])
        f = expm(a * dt)
        expected = f @ expected @ f.T + np.diag(q)
        attitude = attitude * Rotation.from_rotvec(np.multiply(rates, dt))
        made.predict(force, rates, dt)
    scale = np.sqrt(np.diag(expected))
    assert (made.covariance / np.outer(scale, scale)) == pytest.approx(expected / np.outer(scale, scale), abs=0.02)
    assert np.reshape(made.rotation, (3, 3)) == pytest.approx(attitude.as_matrix(), abs=1e-9)
    assert (start.inv() * attitude).magnitude() == pytest.approx(3.0, abs=1e-6)


def test_transition_against_differences() -> None:
    """F of one step: the error after a step, for a small error before it, through the nominal equations alone."""
    noise = FilterNoise(accelerometer_bias_time_s=1e12, gyro_bias_time_s=1e12)
    made = a_filter(noise=noise)
    force, rates, dt = (0.5, 0.2, -9.7), (0.1, -0.2, 0.3), 0.01

    def after(begun: ErrorStateFilter) -> ErrorStateFilter:
        begun.predict(force, rates, dt)
        return begun

    base = after(turned_by(made, np.zeros(SIZE)))
    columns = []  # of the nominal state: the slow errors, which it keeps, fade in the covariance alone
    for i in range(SIZE):
        step = np.zeros(SIZE)
        step[i] = 1e-5
        columns.append(error_between(after(turned_by(made, step)), base) / 1e-5)
    made.predict(force, rates, dt)
    assert made._transition == pytest.approx(np.array(columns).T, abs=1.5e-3)
    assert np.diag(made._transition)[15:] == pytest.approx([1.0 - 1e-4, 1.0 - 1e-4, 1.0 - 2e-4, 1.0])


def test_erratum_5_heading_innovation_is_wrapped() -> None:
    made = a_filter((0.0, 0.0, math.radians(179.0)))
    innovation = made.heading_innovation(math.radians(-179.0), 0.01)
    assert innovation.y1 == pytest.approx(math.radians(2.0))
    made.fuse(innovation)
    assert abs(math.degrees(made.euler()[2])) > 179.0


def test_erratum_5_bias_variance_is_bounded() -> None:
    """Without measurements for hours the variance of the biases approaches its steady value and no more."""
    made = ErrorStateFilter(9.82)
    made.start((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), [0.0] * 15)
    for _ in range(1000):
        made._propagate_covariance(0.0, 0.0, -9.82, 10.0)
    sigma = np.sqrt(np.diag(made.covariance))
    assert sigma[9:12] == pytest.approx([made.noise.accelerometer_bias_mps2] * 3, rel=0.02)
    assert sigma[12:15] == pytest.approx([made.noise.gyro_bias_radps] * 3, rel=0.02)


def test_erratum_6_gravity_of_the_latitude() -> None:
    """WGS 84: 9.78033 at the equator, 9.83218 at the poles, 9.80620 at 45°; Trondheim has 9.8214."""
    assert normal_gravity_mps2(0.0) == pytest.approx(9.7803253359, abs=1e-9)
    assert normal_gravity_mps2(90.0) == pytest.approx(9.8321849378, abs=1e-7)
    assert normal_gravity_mps2(45.0) == pytest.approx(9.8061977, abs=1e-6)
    assert normal_gravity_mps2(-63.4389) == pytest.approx(9.8217, abs=5e-4)


def test_erratum_6_lever_arm_velocity() -> None:
    """R (ω × l) is the derivative of R l."""
    rates, dt = (0.2, -0.3, 0.5), 1e-5
    begin = quaternion_of(*ATTITUDE)
    end = multiply(begin, exponential(*(rate * dt for rate in rates)))
    moved = np.subtract(rotate(rotation(end), LEVER), rotate(rotation(begin), LEVER)) / dt
    assert velocity_ned(rotation(begin), rates, LEVER) == pytest.approx(moved, abs=1e-5)


@pytest.mark.parametrize("lag_s", [0.0, 0.12])
def test_position_rows_against_differences(lag_s: float) -> None:
    made = a_filter()
    made.rates = (0.0, 0.0, 0.0)
    made.position_innovation(0.0, 0.0, LEVER, 0.01, lag_s)

    def predicted(f: ErrorStateFilter) -> np.ndarray:
        arm, lag = rotate(f.rotation, LEVER), lag_s + f.late_s
        then = [f.velocity[i] - 0.5 * f.late_s * f.gaining[i] for i in (0, 1)]
        return np.array([f.position[i] - lag * then[i] + arm[i] + f.wander[i] for i in (0, 1)])

    assert made._pair.h == pytest.approx(numeric(predicted, made), abs=1e-6)


def test_velocity_rows_against_differences() -> None:
    made = a_filter()
    made.rates = (0.1, -0.2, 0.5)
    made.position_innovation(0.0, 0.0, LEVER, 0.01, 0.1)  # must leave nothing behind in the shared rows
    made.velocity_innovation(0.0, 0.0, LEVER, 0.01)

    def predicted(f: ErrorStateFilter) -> np.ndarray:
        swing = rotate(f.rotation, cross(f.rates, LEVER))
        return np.array([f.velocity[i] - f.late_s * f.gaining[i] + swing[i] for i in (0, 1)])

    assert made._pair.h == pytest.approx(numeric(predicted, made), abs=1e-6)


def test_pair_update_is_the_textbook_update() -> None:
    made = a_filter()
    prior, h = made.covariance.copy(), None
    innovation = made.position_innovation(3.3, -4.5, LEVER, 0.04)
    h = made._pair.h.copy()
    late_m2 = prior[18, 18] * max(prior[3, 3], prior[4, 4]) + max(prior[18, 3] ** 2, prior[18, 4] ** 2)
    s = h @ prior @ h.T + (0.04 + late_m2) * np.eye(2)  # latency times velocity, of which H knows each alone
    y = np.array([innovation.y1, innovation.y2])
    assert innovation.normalised_square == pytest.approx(float(y @ np.linalg.solve(s, y)))
    correction = prior @ h.T @ np.linalg.solve(s, y)
    before = turned_by(made, np.zeros(SIZE))
    made.fuse(innovation)
    assert error_between(made, before) == pytest.approx(correction, abs=1e-9)
    assert np.linalg.eigvalsh(made.covariance).min() > 0.0


def test_the_boat_stays_on_the_water() -> None:
    made = a_filter((0.0, 0.0, 0.0))
    made.position, made.velocity = (0.0, 0.0, 1.0), (0.0, 0.0, 0.3)
    for _ in range(50):
        made.fuse_down(0.0, 0.09, 0.09)
    assert abs(made.position[2]) < 0.1
    assert abs(made.velocity[2]) < 0.05
    made.heading_innovation(0.0, 0.01)
    expected = np.eye(SIZE)[8] + np.eye(SIZE)[17]
    assert made._single.h[0] == pytest.approx(expected, abs=2e-3)  # nothing left behind in the shared row


def test_a_long_step_is_divided() -> None:
    """Half a second of steady turn in one step comes out as in many."""
    one, many = a_filter((0.0, 0.0, 0.0)), a_filter((0.0, 0.0, 0.0))
    one.predict((0.2, 0.0, -9.82), (0.0, 0.0, 1.0), 0.5)
    for _ in range(500):
        many.predict((0.2, 0.0, -9.82), (0.0, 0.0, 1.0), 0.001)
    assert one.position == pytest.approx(many.position, abs=0.005)
    assert one.euler() == pytest.approx(many.euler(), abs=1e-9)
    assert np.diag(one.covariance) == pytest.approx(np.diag(many.covariance), rel=0.02)


def test_preview_equals_predict_and_changes_nothing() -> None:
    made = a_filter()
    samples = [((0.1, 0.0, -9.8), (0.0, 0.1, 0.4), 0.01)] * 20
    before = made.covariance.copy()
    position, velocity, matrix, _ = made.preview(samples)
    assert (made.covariance == before).all()
    for force, rates, dt in samples:
        made.predict(force, rates, dt)
    assert position == pytest.approx(made.position, abs=1e-9)
    assert velocity == pytest.approx(made.velocity, abs=1e-9)
    assert euler_of(matrix) == pytest.approx(made.euler(), abs=1e-9)


def test_resets() -> None:
    made = a_filter()
    made.wander, made.heading_wander = (0.2, -0.1), 0.01
    made.reset_position(10.0, 20.0, LEVER, 0.04, 0.01)
    assert made.position_innovation(10.0, 20.0, LEVER, 1.0).normalised_square == pytest.approx(0.0, abs=1e-12)
    assert made.covariance[0, 0] == pytest.approx(
        0.04 + WANDER.sigma**2 + (0.7 * LATE_SIGMA_S) ** 2, abs=0.005
    )  # and by the attitude, over the arm
    assert made.covariance[0, 3] == pytest.approx(0.0, abs=1e-3)
    assert made.measured_sigma_m() == pytest.approx(0.2, abs=0.01)  # the next fix will be where this one was
    roll, pitch, _ = made.euler()
    made.reset_heading(-3.0, 0.01)
    assert made.euler() == pytest.approx((roll, pitch, -3.0))
    assert made.heading_innovation(-3.0, 1.0).y1 == pytest.approx(0.0, abs=1e-12)
    assert made.sigmas()[2] ** 2 == pytest.approx(0.01 + HEADING_WANDER.sigma**2)
    made.reset_velocity(1.0, 2.0, LEVER, 0.01)
    assert made.velocity_innovation(1.0, 2.0, LEVER, 1.0).normalised_square == pytest.approx(0.0, abs=1e-12)
    assert made.healthy()
    made.velocity = (math.nan, 0.0, 0.0)
    assert not made.healthy()


def test_quaternions_against_scipy() -> None:
    q, turn = quaternion_of(*ATTITUDE), (0.3, -0.2, 0.9)
    matrix = Rotation.from_euler("ZYX", ATTITUDE[::-1])
    assert np.reshape(rotation(q), (3, 3)) == pytest.approx(matrix.as_matrix())
    assert euler_of(rotation(q)) == pytest.approx(ATTITUDE)
    product = (matrix * Rotation.from_rotvec(turn)).as_matrix()
    assert np.reshape(rotation(multiply(q, exponential(*turn))), (3, 3)) == pytest.approx(product)


# --- slow errors ------------------------------------------------------------------------------------------------------


def fixes(made: ErrorStateFilter, east_m: float, seconds: int) -> None:
    """At rest, with a fix and a velocity each second."""
    for _ in range(100 * seconds):
        made.predict((0.0, 0.0, -9.82), (0.0, 0.0, 0.0), 0.01)
        if _ % 100 == 99:
            made.fuse(made.velocity_innovation(0.0, 0.0, (0.0, 0.0, 0.0), 0.05**2))
            made.fuse(made.position_innovation(0.0, east_m, (0.0, 0.0, 0.0), 0.1**2))


def at_rest(wander: Wander) -> ErrorStateFilter:
    made = ErrorStateFilter(9.82)
    made.expect_wander(wander)
    made.start((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), [0.1] * 6 + [0.01] * 3 + [0.01] * 3 + [0.001] * 3)
    return made


def test_averaging_does_not_remove_a_slow_error() -> None:
    """The sigma stays near that of the wander, the sigma of the next fix does not; without wander both go down."""
    made, without = at_rest(Wander(0.5, 300.0)), at_rest(Wander(0.0, 300.0))
    fixes(made, 0.0, 40)
    fixes(without, 0.0, 40)
    assert 0.4 < made.sigmas()[0] < 0.52
    assert made.measured_sigma_m() < 0.1 and without.sigmas()[0] < 0.1


def test_a_better_kind_of_fix_moves_the_boat_and_a_worse_one_does_not() -> None:
    made = at_rest(Wander(0.5, 300.0))
    fixes(made, 0.0, 40)
    made.expect_wander(Wander(0.01, 100.0))
    assert made.covariance[15, 15] == pytest.approx(0.01**2, rel=1e-3)  # what was known of the other one tells nothing
    fixes(made, 0.6, 5)
    assert made.position[1] == pytest.approx(0.6, abs=0.1) and 0.01 < made.sigmas()[0] < 0.1
    made.expect_wander(Wander(1.0, 300.0))
    fixes(made, 1.5, 5)
    assert made.position[1] == pytest.approx(0.6, abs=0.15) and made.wander[1] == pytest.approx(0.9, abs=0.15)


def test_a_claim_that_changes_a_little_is_the_same_wander() -> None:
    made = at_rest(Wander(0.5, 300.0))
    fixes(made, 0.0, 10)
    before = made.covariance.copy()
    made.expect_wander(Wander(0.6, 300.0))
    assert (made.covariance == before).all()
    made.expect_wander(Wander(0.6, 300.0), common=0.5)  # of another receiver, which shares a part
    assert made.covariance[15, 15] == pytest.approx(0.25 * before[15, 15] + 0.36 - 0.25 * 0.36)
    assert made.covariance[0, 15] == pytest.approx(0.5 * before[0, 15])


def test_velocities_whose_errors_last_let_the_position_stray() -> None:
    sigmas = []
    for walk in (0.0, 0.1):
        made = at_rest(Wander(0.0, 300.0))
        made.expect_walk(walk)
        for _ in range(1000):
            made.predict((0.0, 0.0, -9.82), (0.0, 0.0, 0.0), 0.01)
            made.fuse(made.velocity_innovation(0.0, 0.0, (0.0, 0.0, 0.0), 0.01**2))
        sigmas.append(made.sigmas()[0])
    assert sigmas[1] ** 2 - sigmas[0] ** 2 == pytest.approx(0.1**2 * 10.0, rel=0.01)


def test_what_measurements_are_off_by_can_be_put_back() -> None:
    made = at_rest(Wander(0.5, 300.0))
    fixes(made, 0.3, 5)
    then = made.measured_off
    fixes(made, 1.0, 5)
    made.put_off(then)
    assert made.measured_off == then and made.wander == (then.north_m, then.east_m)
