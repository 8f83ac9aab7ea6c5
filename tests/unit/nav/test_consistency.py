"""Whether the filter's sigmas match its errors: the normalised estimation error squared over 16 seeds, inside
its 95 % band."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from companion.config.devices import FixErrors
from companion.config.vessel import VesselConfig
from companion.core.readings import Imu, Reading
from tests.unit.nav.boat_truth import IMU_HZ, Alter, Passage, Voyage, config_of, navigate

SEEDS = 16
DROPOUT_S = (14.0, 18.0)
INSTANTS_S = (10.0, 12.0, 13.9, 16.0, 17.9, 18.3, 19.5)


def told(voyage: Voyage) -> VesselConfig:
    """A vessel whose file describes its sensors exactly."""
    config = config_of(voyage)
    gnss, imu = config.sensors
    gnss = replace(
        gnss,
        accuracy_floor_m=0.001,
        rtk_fixed=FixErrors(wander_m=0.0, velocity_mps=voyage.velocity_sigma_mps),
        velocity_lasts_s=0.0,
        heading_accuracy_rad=voyage.heading_sigma_rad,
        heading_wander_rad=0.0,
    )
    imu = replace(
        imu, accelerometer_noise_mps2_rthz=0.01 / math.sqrt(IMU_HZ), gyro_noise_radps_rthz=0.0017 / math.sqrt(IMU_HZ)
    )
    return replace(config, sensors=(gnss, imu))


def wandering(random: np.random.Generator, samples: int) -> Alter:
    """Biases that wander as the filter assumes (0.01 m/s² in 600 s, 5e-4 rad/s in 1000 s), and a dropout of all but
    the IMU."""
    walks = [
        np.cumsum(sigma * math.sqrt(2.0 / tau_s / IMU_HZ) * random.standard_normal((samples, 3)), axis=0)
        for sigma, tau_s in ((0.01, 600.0), (5e-4, 1000.0))
    ]

    def alter(k: int, row: list[Reading]) -> list[Reading]:
        (ax, ay, az), (wx, wy, wz) = walks[0][k].tolist(), walks[1][k].tolist()
        changed: list[Reading] = []
        for reading in row:
            if isinstance(reading, Imu):
                reading = replace(
                    reading,
                    x_mps2=reading.x_mps2 + ax,
                    y_mps2=reading.y_mps2 + ay,
                    z_mps2=reading.z_mps2 + az,
                    roll_rate_radps=reading.roll_rate_radps + wx,
                    pitch_rate_radps=reading.pitch_rate_radps + wy,
                    yaw_rate_radps=reading.yaw_rate_radps + wz,
                )
            elif DROPOUT_S[0] <= reading.t_s < DROPOUT_S[1]:
                continue
            changed.append(reading)
        return changed

    return alter


def normalised_squares(passage: Passage) -> list[tuple[float, float, float]]:
    """(position, velocity, heading) at each instant."""
    truth = passage.truth
    found = []
    for state, k in zip(passage.states, passage.rows, strict=True):
        if round(state.t_s, 1) in INSTANTS_S:
            north, east = state.north_m - truth.position[k, 0], state.east_m - truth.position[k, 1]
            vn, ve = state.north_mps - truth.velocity[k, 0], state.east_mps - truth.velocity[k, 1]
            yaw = math.remainder(state.yaw_rad - truth.attitude[k, 2], 2.0 * math.pi)
            found.append(
                (
                    (north * north + east * east) / state.position_accuracy_m**2,
                    (vn * vn + ve * ve) / state.velocity_accuracy_mps**2,
                    (yaw / state.heading_accuracy_rad) ** 2,
                )
            )
    assert len(found) == len(INSTANTS_S)
    return found


@pytest.fixture(scope="module")
def squares() -> np.ndarray:
    """Seeds by instants by kinds."""
    runs = []
    for seed in range(SEEDS):
        random = np.random.default_rng(1000 + seed)
        accelerometer, gyro = 0.05 * random.standard_normal(3), 3.5e-3 * random.standard_normal(3)
        voyage = Voyage(
            duration_s=19.5,
            seed=seed,
            accelerometer_bias=tuple(accelerometer.tolist()),
            gyro_bias=tuple(gyro.tolist()),
        )
        passage = navigate(voyage, wandering(random, round(19.5 * IMU_HZ) + 1), config=told(voyage))
        runs.append(normalised_squares(passage))
    return np.array(runs)


@pytest.mark.parametrize(("kind", "axes"), [(0, 2), (1, 2), (2, 1)], ids=["position", "velocity", "heading"])
def test_normalised_innovations_stay_inside_the_chi_square_band(squares: np.ndarray, kind: int, axes: int) -> None:
    """The mean over the seeds at each instant; of seven instants by three kinds one may lie outside of a 95 % band by
    chance, so each kind may have one, and none may be outside of the 99.9 % band."""
    means = squares[:, :, kind].mean(axis=0)
    low, high = (chi2.ppf(share, axes * SEEDS) / SEEDS for share in (0.025, 0.975))
    lowest, highest = (chi2.ppf(share, axes * SEEDS) / SEEDS for share in (0.0005, 0.9995))
    assert ((means > low) & (means < high)).sum() >= len(INSTANTS_S) - 1, means
    assert ((means > lowest) & (means < highest)).all(), means
