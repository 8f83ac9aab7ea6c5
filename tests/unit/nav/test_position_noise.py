"""How noisy positions are, whatever the receiver claims and the filter believes."""

import math
from dataclasses import replace

import numpy as np
import pytest

from companion.core.readings import FixType, GnssFix, Heading, Imu, Reading
from companion.nav.position_noise import PositionNoise
from tests.unit.nav.boat_truth import IMU_HZ, Alter, Voyage, navigate, rms


def taken(sigma_m: float, count: int = 40, wild: int = 0, seed: int = 722400) -> PositionNoise:
    """Of a boat whose estimate is wrong by 3 m/s and 0.1 m/s²; `wild`: each such one is 50 m off."""
    noise, random = PositionNoise(), np.random.default_rng(seed)
    for k in range(count):
        north, east = sigma_m * random.standard_normal(2)
        off_m = 50.0 if wild and k % wild == 0 else 0.0
        noise.take(float(k), 0, float(north) + 3.0 * k + 0.05 * k * k + off_m, float(east))
    return noise


def test_before_there_are_enough_positions_the_noise_may_be_all_that_is_claimed() -> None:
    assert taken(0.5, count=5).sigma_m(0.15, 0.5) == 0.5
    assert taken(0.1, count=15).sigma_m(0.15, 0.5) == 0.5


def test_what_is_said_counts_while_chance_explains_the_scatter() -> None:
    for seed in range(722400, 722420):
        assert taken(0.15, seed=seed).sigma_m(0.15, 0.5) <= 0.36


@pytest.mark.parametrize("sigma_m", [0.5, 1.0])
def test_more_noise_than_is_said_is_found_whatever_the_estimate_is_off_by(sigma_m: float) -> None:
    found = [taken(sigma_m, seed=seed).sigma_m(0.15, 0.5) for seed in range(722400, 722420)]
    assert np.mean(found) == pytest.approx(sigma_m, rel=0.25)


def test_some_wild_positions_are_no_noise() -> None:
    assert taken(0.1, wild=12).sigma_m(0.15, 0.5) < 0.5


def test_noise_that_begins_shows_soon() -> None:
    noise, random = PositionNoise(), np.random.default_rng(722401)
    for k in range(50):
        north, east = (0.05 if k < 40 else 1.0) * random.standard_normal(2)
        noise.take(float(k), 0, float(north), float(east))
    assert noise.sigma_m(0.15, 0.5) > 0.4


def test_another_run_of_the_inertial_sensor_is_no_noise() -> None:
    noise = PositionNoise()
    for k in range(60):
        noise.take(float(k), k // 20, 100.0 * (k // 20), 0.0)
    assert noise.sigma_m(0.15, 0.5) == 0.15


def without_velocities(claimed_m: float, every_s: float) -> Alter:
    """A receiver that sends GGA alone."""
    fix = FixType.DGPS if claimed_m < 1.0 else FixType.FIX_3D

    def alter(k: int, row: list[Reading]) -> list[Reading]:
        comes = k % round(every_s * IMU_HZ) == 0
        kept = [r for r in row if isinstance(r, Imu | Heading) or (comes and isinstance(r, GnssFix))]
        return [replace(r, fix=fix, position_accuracy_m=claimed_m) if isinstance(r, GnssFix) else r for r in kept]

    return alter


@pytest.mark.parametrize(
    ("claimed_m", "true_m", "every_s", "speed_mps", "off_m", "fast_mps"),
    [
        (0.5, 0.5, 1.0, 0.0, 2.0, 0.8),
        (0.5, 0.5, 1.0, 1.5, 2.0, 0.8),
        (0.5, 0.5, 0.2, 0.0, 1.0, 0.4),
        (0.5, 0.5, 0.2, 1.5, 1.0, 0.4),
        (0.5, 1.0, 1.0, 1.5, 4.5, 1.6),
        (0.5, 1.0, 0.2, 1.5, 2.5, 0.7),
        (2.0, 2.0, 1.0, 1.5, 7.0, 2.5),
        (2.0, 2.0, 0.2, 1.5, 3.5, 1.3),
    ],
)
def test_white_noise_without_velocities_does_not_set_the_estimate_loose(
    claimed_m: float, true_m: float, every_s: float, speed_mps: float, off_m: float, fast_mps: float
) -> None:
    """Only a part of the claim counted as noise: the gate rejected most positions, and the estimate left at up to
    40 m/s."""
    for seed in range(722410, 722413):
        voyage = Voyage(duration_s=90.0, speed_mps=speed_mps, radius_m=40.0, position_sigma_m=true_m, seed=seed)
        passage = navigate(voyage, without_velocities(claimed_m, every_s))
        position, _, velocity = passage.errors(20.0)
        assert position.max() < off_m
        assert velocity.max() < fast_mps
        states = [state for state in passage.states if state.t_s > 20.0]
        assert all(state.position_valid for state in states)
        claimed = rms(np.array([math.sqrt(2.0) * state.position_accuracy_m for state in states]))
        assert rms(position) < 1.7 * claimed


def test_noise_that_begins_under_way_does_not_set_the_estimate_loose() -> None:
    random = np.random.default_rng(722402)
    slow = without_velocities(0.5, 1.0)

    def alter(k: int, row: list[Reading]) -> list[Reading]:
        noisy_m = 0.5 if k >= 60 * IMU_HZ else 0.0
        return [
            replace(r, lat_deg=r.lat_deg + noisy_m * float(random.standard_normal()) / 111_000.0)
            if isinstance(r, GnssFix)
            else r
            for r in slow(k, row)
        ]

    passage = navigate(Voyage(duration_s=110.0, radius_m=40.0, position_sigma_m=0.05, seed=722403), alter)
    assert passage.errors(20.0, 60.0)[0].max() < 0.5
    assert passage.errors(60.0)[0].max() < 2.0
