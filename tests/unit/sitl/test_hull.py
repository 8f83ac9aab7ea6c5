"""The hull against closed forms and an independent integration."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

from companion.config.hull import DampingConfig, HullConfig
from companion.config.vessel import find, load
from sitl.hull import Hull, dynamics

VESSEL = load(find("revolt"))
assert VESSEL.sitl is not None
SAILED = VESSEL.sitl.plants["as_sailed"].hull
THESIS = VESSEL.sitl.plants["thesis"].hull
UNDAMPED = HullConfig(m11_kg=263.93, m22_kg=306.44, m33_kgm2=322.15, m23_kgm=7.0)
EVERYTHING = HullConfig(
    25.8,
    33.8,
    2.76,
    1.0948,
    1.2,
    DampingConfig(0.72, 1.33, 5.87, 0.89, 36.5, 0.8, 7.25, 0.845, 3.45, -0.03, -3.96, -0.13, 1.9, -0.08, 0.75),
)
speeds = st.floats(-2.0, 2.0)


def run(hull: Hull, force: tuple[float, float, float], seconds: float, dt_s: float = 0.01) -> None:
    for _ in range(round(seconds / dt_s)):
        hull.step(*force, dt_s)


def test_steady_surge_speed_is_thrust_over_damping() -> None:
    hull = Hull(SAILED)
    run(hull, (50.0, 0.0, 0.0), 80.0)
    assert hull.surge_mps == pytest.approx(50.0 / 50.66, rel=1e-6)
    assert hull.surge_mps * 3600.0 / 1852.0 == pytest.approx(2.0, abs=0.1)  # the thesis's top speed in knots


def test_surge_rises_with_its_time_constant() -> None:
    hull = Hull(THESIS)
    run(hull, (50.0, 0.0, 0.0), 5.21)
    assert hull.surge_mps == pytest.approx(50.0 / 50.66 * -math.expm1(-5.21 * 50.66 / 263.93), rel=1e-5)


def test_steady_sway_of_the_sailed_plant_is_that_of_its_quadratic() -> None:
    hull = Hull(SAILED)
    for _ in range(20_000):
        hull.step(0.0, 20.0, 7.0 * hull.yaw_rate_radps, 0.01)
        hull.yaw_rate_radps = 0.0
    expected = (-8.0 + math.sqrt(8.0**2 + 4.0 * 353.0 * 20.0)) / (2.0 * 353.0)
    assert hull.water_sway_mps == pytest.approx(expected, rel=1e-6)


@given(speeds, speeds, speeds)
@settings(deadline=None, derandomize=True, max_examples=100)
def test_coriolis_does_no_work(u: float, v: float, r: float) -> None:
    derivative = dynamics(UNDAMPED)(u, v, r, 0.0, 0.0, 0.0)
    inertia = np.array([[263.93, 0, 0], [0, 306.44, 7.0], [0, 7.0, 322.15]])
    assert np.array([u, v, r]) @ inertia @ np.array(derivative) == pytest.approx(0.0, abs=1e-9)


@given(speeds, speeds, speeds, st.tuples(*[st.floats(-50.0, 50.0)] * 3))
@settings(deadline=None, derandomize=True, max_examples=100)
def test_derivative_is_the_matrix_equation(u: float, v: float, r: float, force: tuple[float, float, float]) -> None:
    assert dynamics(EVERYTHING)(u, v, r, *force) == pytest.approx(matrix_derivative(u, v, r, force), rel=1e-9, abs=1e-9)


def matrix_derivative(u: float, v: float, r: float, force: tuple[float, float, float]) -> np.ndarray:
    """Fossen's matrices written out, for the hull with every coefficient."""
    inertia = np.array([[25.8, 0, 0], [0, 33.8, 1.0948], [0, 1.2, 2.76]])
    mean = 0.5 * (1.0948 + 1.2)
    c13, c23 = -(33.8 * v + mean * r), 25.8 * u
    coriolis = np.array([[0, 0, c13], [0, 0, c23], [-c13, -c23, 0]])
    damping = np.array(
        [
            [0.72 + 1.33 * abs(u) + 5.87 * u * u, 0, 0],
            [0, 0.89 + 36.5 * abs(v) + 0.8 * abs(r), 7.25 + 0.845 * abs(v) + 3.45 * abs(r)],
            [0, -0.03 - 3.96 * abs(v) - 0.13 * abs(r), 1.9 - 0.08 * abs(v) + 0.75 * abs(r)],
        ]
    )
    nu = np.array([u, v, r])
    return np.linalg.solve(inertia, np.array(force) - coriolis @ nu - damping @ nu)


@pytest.mark.parametrize("config", [SAILED, THESIS])
def test_energy_only_falls_without_force(config: HullConfig) -> None:
    rng = random.Random(1)
    for _ in range(5):
        hull = Hull(config)
        hull.place(0.0, 0.0, 0.0, rng.uniform(-1, 1), rng.uniform(-0.5, 0.5), rng.uniform(-0.5, 0.5))
        before = math.inf
        for _ in range(2000):
            nu = np.array([hull.water_surge_mps, hull.water_sway_mps, hull.yaw_rate_radps])
            energy = nu @ np.array([[263.93, 0, 0], [0, 306.44, 7.015], [0, 7.015, 322.15]]) @ nu
            assert energy < before
            before = energy
            hull.step(0.0, 0.0, 0.0, 0.01)
        assert before < 1.0


def test_whole_motion_agrees_with_an_independent_integration() -> None:
    current = (0.2, -0.1)
    force = (3.0, 0.5, 0.2)

    def rate(_t: float, state: np.ndarray) -> np.ndarray:
        _, _, yaw, u, v, r = state
        c, s = math.cos(yaw), math.sin(yaw)
        return np.array([c * u - s * v + current[0], s * u + c * v + current[1], r, *matrix_derivative(u, v, r, force)])

    hull = Hull(EVERYTHING)
    hull.set_current(*current)
    hull.place(0.0, 0.0, 0.3, 0.2, -0.1, 0.1)
    u0, v0 = hull.water_surge_mps, hull.water_sway_mps
    expected = solve_ivp(rate, (0.0, 20.0), [0.0, 0.0, 0.3, u0, v0, 0.1], rtol=1e-10, atol=1e-12).y[:, -1]
    run(hull, force, 20.0)
    assert (hull.north_m, hull.east_m) == pytest.approx(expected[:2], abs=1e-3)
    assert math.remainder(hull.yaw_rad - expected[2], 2.0 * math.pi) == pytest.approx(0.0, abs=1e-3)
    assert (hull.water_surge_mps, hull.water_sway_mps, hull.yaw_rate_radps) == pytest.approx(expected[3:], abs=1e-4)


def test_a_boat_left_alone_ends_up_with_the_current() -> None:
    hull = Hull(THESIS)
    hull.set_current(0.3, -0.2)
    run(hull, (0.0, 0.0, 0.0), 120.0)
    assert (hull.north_mps, hull.east_mps) == pytest.approx((0.3, -0.2), abs=1e-4)


def test_a_boat_that_turns_while_it_drifts_is_carried_straight() -> None:
    hull = Hull(UNDAMPED)
    hull.set_current(0.3, -0.2)
    hull.place(0.0, 0.0, 0.0, 0.3, -0.2, 0.5)
    hull.water_sway_mps = -7.0 / 306.44 * 0.5  # momentum of the water that turns with it
    run(hull, (0.0, 0.0, 0.0), 4.0 * math.pi)
    assert (hull.north_m, hull.east_m) == pytest.approx((0.3 * 4.0 * math.pi, -0.2 * 4.0 * math.pi), abs=0.05)


def test_a_change_of_current_does_not_jerk_the_boat() -> None:
    hull = Hull(SAILED)
    hull.place(0.0, 0.0, 1.0, 0.5, 0.1, 0.0)
    before = hull.north_mps, hull.east_mps
    hull.set_current(0.4, 0.4)
    assert (hull.surge_mps, hull.sway_mps) == pytest.approx((0.5, 0.1))
    hull.step(0.0, 0.0, 0.0, 1e-6)
    assert (hull.north_mps, hull.east_mps) == pytest.approx(before, abs=1e-5)


def test_mean_acceleration_and_turn_add_up_to_the_motion() -> None:
    hull = Hull(SAILED)
    hull.set_current(0.1, 0.2)
    hull.place(0.0, 0.0, 0.5, 0.4, 0.1, 0.3)
    north_mps, east_mps, yaw_rad = hull.north_mps, hull.east_mps, hull.yaw_rad
    for _ in range(1000):
        hull.step(20.0, 5.0, 3.0, 0.01)
        mid = yaw_rad + 0.005 * hull.turn_radps
        north_mps += 0.01 * (math.cos(mid) * hull.surge_mps2 - math.sin(mid) * hull.sway_mps2)
        east_mps += 0.01 * (math.sin(mid) * hull.surge_mps2 + math.cos(mid) * hull.sway_mps2)
        yaw_rad += 0.01 * hull.turn_radps
    assert (north_mps, east_mps) == pytest.approx((hull.north_mps, hull.east_mps), abs=1e-9)
    assert math.remainder(yaw_rad - hull.yaw_rad, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-9)
