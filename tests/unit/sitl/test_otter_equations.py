"""The Otter's published equations against Fossen's matrices written out, and what follows from them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from companion.config.hull import HullConfig
from sitl.otter_equations import EDITIONS, OtterHull

CONFIG = HullConfig(85.5, 162.5, 42.65)
TINY_S = 1e-6
speeds, rates, angles = st.floats(-2.0, 2.0), st.floats(-0.5, 0.5), st.floats(-0.2, 0.2)


def skew(a: np.ndarray) -> np.ndarray:
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def shifted(r: np.ndarray) -> np.ndarray:
    """The transformation of a matrix to a point at −r."""
    return np.block([[np.eye(3), skew(r).T], [np.zeros((3, 3)), np.eye(3)]])


def coriolis(inertia: np.ndarray, nu: np.ndarray) -> np.ndarray:
    """C(ν) of a symmetric inertia matrix (Fossen 2021, theorem 3.2)."""
    linear, angular = inertia[:3] @ nu, inertia[3:] @ nu
    return np.block([[np.zeros((3, 3)), -skew(linear)], [-skew(linear), -skew(angular)]])


def written_out(edition: str, pose: np.ndarray, nu: np.ndarray, tau: np.ndarray) -> np.ndarray:
    """ν̇ by 6 × 6 matrices. `pose`: heave, roll, pitch."""
    chosen = EDITIONS[edition]
    water, gravity, length, beam, width, side = chosen.water_kgpm3, 9.81, 2.0, 1.08, 0.25, 0.395
    load = np.array([0.05, 0.0, -0.35])
    centre = (55.0 * np.array([0.2, 0.0, -0.2]) + 25.0 * load) / 80.0
    own = 55.0 * np.diag([(0.4 * beam) ** 2, (0.25 * length) ** 2, (0.25 * length) ** 2])
    own = own - 55.0 * skew(centre) @ skew(centre) - 25.0 * skew(load) @ skew(load)
    at_centre = np.block([[80.0 * np.eye(3), np.zeros((3, 3))], [np.zeros((3, 3)), own]])
    move = shifted(centre)
    added = np.diag([5.5, 82.5, 55.0, 0.2 * own[0, 0], 0.8 * own[1, 1], 1.7 * own[2, 2]])
    mass = move.T @ at_centre @ move + added
    volume = 80.0 / water
    draft = volume / (2.0 * 0.4 * width * length)
    area, fine = 0.75 * length * width, 6.0 * 0.75**3 / (1.75 * 2.5)
    second_t = 2.0 * length * width**3 * fine / 12.0 + 2.0 * area * side**2
    second_l = 0.8 * 2.0 * width * length**3 / 12.0
    low = (2.5 * draft - 0.5 * volume / (length * width)) / 3.0 - (draft - centre[2])
    heave = water * gravity * 2.0 * area
    stiff = [80.0 * gravity * (low + second / volume) for second in (second_t, second_l)]
    aft = shifted(np.array([-0.2, 0.0, 0.0]))
    restoring = aft.T @ np.diag([0.0, 0.0, heave, *stiff, 0.0]) @ aft
    natural = np.sqrt(np.array([heave, *stiff]) / np.diag(mass)[2:5])
    damping = np.array(
        [24.4 * gravity / (6.0 * 0.5144), 0.0, *(2.0 * np.array([0.3, 0.2, 0.4]) * natural * np.diag(mass)[2:5]), 0.0]
    )
    damping[1] = 0.0 if chosen.sway_time_s is None else mass[1, 1] / chosen.sway_time_s
    damping[5] = mass[5, 5] * (1.0 + 10.0 * abs(nu[5]))
    whirl = np.block([[80.0 * skew(nu[3:]), np.zeros((3, 3))], [np.zeros((3, 3)), -skew(own @ nu[3:])]])
    turning = coriolis(added, nu)
    if not chosen.munk:
        turning[5, 0] = turning[5, 1] = turning[0, 5] = turning[1, 5] = 0.0
    c_r, s_r, c_p, s_p = math.cos(pose[1]), math.sin(pose[1]), math.cos(pose[2]), math.sin(pose[2])
    weight = 25.0 * gravity * np.array([-s_p, c_p * s_r, c_p * c_r])
    static = np.concatenate([weight, np.cross(load, weight)])
    if chosen.mended:
        static[:2] = 0.0
    places = (np.arange(20) + 0.5) / 10.0 - 1.0 if chosen.mended else np.arange(21) / 10.0 - 1.0
    across = nu[1] + places * nu[5]
    drag = np.interp(0.5 * width / draft, [0.5585, 0.6464], [1.0836, 0.9986])
    strip = -0.5 * 1026.0 * draft * drag * 0.1 * np.abs(across) * across
    cross = np.array([0.0, strip.sum(), 0.0, 0.0, 0.0, (places * strip).sum()])
    at = np.array([0.0, 0.0, *pose, 0.0])
    pushed = tau + static + cross - damping * nu - restoring @ at - (move.T @ whirl @ move + turning) @ nu
    return np.linalg.solve(mass, pushed)


@pytest.mark.parametrize("edition", EDITIONS)
@given(st.tuples(speeds, speeds, rates), st.tuples(rates, rates, rates), st.tuples(rates, angles, angles))
@settings(deadline=None, derandomize=True, max_examples=60)
def test_accelerations_are_those_of_the_matrices(
    edition: str,
    speed: tuple[float, float, float],
    turn: tuple[float, float, float],
    pose: tuple[float, float, float],
) -> None:
    hull = OtterHull(CONFIG, edition)
    hull.water_surge_mps, hull.water_sway_mps, hull.heave_mps = speed
    hull.roll_rate_radps, hull.pitch_rate_radps, hull.yaw_rate_radps = turn
    hull.heave_m, hull.roll_rad, hull.pitch_rad = pose
    hull.step(40.0, 5.0, -8.0, TINY_S)
    after = (
        *(hull.water_surge_mps, hull.water_sway_mps, hull.heave_mps),
        *(hull.roll_rate_radps, hull.pitch_rate_radps, hull.yaw_rate_radps),
    )
    found = (np.array(after) - np.array([*speed, *turn])) / TINY_S
    expected = written_out(edition, np.array(pose), np.array([*speed, *turn]), np.array([40.0, 5.0, 0, 0, 0, -8.0]))
    assert found == pytest.approx(expected, rel=1e-6, abs=1e-6)


def test_it_starts_in_its_trim_and_stays_there() -> None:
    hull = OtterHull(CONFIG, "otter_mended")
    trim = hull.heave_m, hull.pitch_rad
    for _ in range(1000):
        hull.step(0.0, 0.0, 0.0, 0.01)
    assert (hull.heave_m, hull.pitch_rad) == pytest.approx(trim, abs=1e-9)
    assert (hull.north_m, hull.east_m, hull.roll_rad) == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    assert -0.03 < hull.pitch_rad < -0.01, "the bow is down, by the published centres"


def test_the_published_weight_pushes_the_boat_ahead() -> None:
    hull = OtterHull(CONFIG, "otter_2024")
    assert hull.trim_n == pytest.approx(6.4, abs=0.1)
    for _ in range(3000):
        hull.step(0.0, 0.0, 0.0, 0.01)
    assert hull.surge_mps == pytest.approx(hull.trim_n / 77.55, rel=0.02)
    assert OtterHull(CONFIG, "otter_mended").trim_n == OtterHull(CONFIG, "otter_mended").trim_kg == 0.0


def test_a_boat_left_alone_ends_up_with_the_current() -> None:
    hull = OtterHull(CONFIG, "otter_mended")
    hull.set_current(0.3, -0.2)
    for _ in range(3000):
        hull.step(0.0, 0.0, 0.0, 0.01)
    assert (hull.north_mps, hull.east_mps) == pytest.approx((0.3, -0.2), abs=1e-4)
    north_m, east_m = hull.north_m, hull.east_m
    for _ in range(100):
        hull.step(0.0, 0.0, 0.0, 0.01)
    assert (hull.north_m - north_m, hull.east_m - east_m) == pytest.approx((0.3, -0.2), abs=1e-4)


@pytest.mark.parametrize("edition", EDITIONS)
def test_half_of_the_step_makes_little_difference(edition: str) -> None:
    ends = []
    for dt_s in (0.01, 0.005):
        hull = OtterHull(CONFIG, edition)
        for _ in range(round(20.0 / dt_s)):
            hull.step(80.0, 0.0, 8.0, dt_s)
        ends.append((hull.north_m, hull.east_m, hull.water_surge_mps, hull.water_sway_mps, hull.yaw_rate_radps))
    assert ends[0][:2] == pytest.approx(ends[1][:2], abs=0.05)
    assert ends[0][2:] == pytest.approx(ends[1][2:], abs=1e-3)


def test_felt_acceleration_and_turn_integrate_to_the_motion() -> None:
    hull = OtterHull(CONFIG, "otter_2024")
    turned = north_mps = 0.0
    for _ in range(500):
        yaw = hull.yaw_rad
        hull.step(80.0, 0.0, 8.0, 0.01)
        middle = yaw + 0.005 * hull.turn_radps
        north_mps += 0.01 * (math.cos(middle) * hull.surge_mps2 - math.sin(middle) * hull.sway_mps2)
        turned += 0.01 * hull.turn_radps
    assert turned == pytest.approx(hull.yaw_rad, abs=1e-9)
    assert north_mps == pytest.approx(hull.north_mps, abs=1e-9)


def test_the_boat_rolls_in_a_turn_and_comes_upright() -> None:
    hull = OtterHull(CONFIG, "otter_mended")
    for _ in range(1000):
        hull.step(80.0, 0.0, 12.0, 0.01)
    assert 1e-4 < abs(hull.roll_rad) < 0.1
    for _ in range(2000):
        hull.step(0.0, 0.0, 0.0, 0.01)
    assert hull.roll_rad == pytest.approx(0.0, abs=1e-4)


def test_a_change_of_current_does_not_jerk_a_boat_that_heels_and_pitches() -> None:
    hull = OtterHull(CONFIG, "otter_2024")
    for _ in range(500):
        hull.step(80.0, 0.0, 12.0, 0.01)
    before = hull.north_mps, hull.east_mps
    water = hull.water_surge_mps, hull.water_sway_mps
    hull.set_current(0.0, 0.0)
    assert (hull.water_surge_mps, hull.water_sway_mps) == pytest.approx(water, abs=1e-12)
    hull.set_current(0.3, 0.1)
    hull.step(80.0, 0.0, 12.0, 1e-6)
    assert (hull.north_mps, hull.east_mps) == pytest.approx(before, abs=1e-5)
