"""A small truth of its own for the navigation tests: a boat that circles and rolls, in closed form, and what its
sensors would say."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from companion.config import vessel as vessel_config
from companion.config.vessel import VesselConfig
from companion.core.estimate import NavState
from companion.core.geodesy import LocalFrame
from companion.core.readings import FixType, GnssFix, GroundVelocity, Heading, Imu, Reading
from companion.nav.estimator import Estimator
from companion.params.store import Parameters

LEVER = np.array([-0.81, 0.0, -0.2])
IMU_HZ = 100
GNSS_EVERY = 5
_GATHERS_S = 4.0


@dataclass(frozen=True)
class Voyage:
    """A circle of `radius_m` at `speed_mps` (0: at rest), rolling and pitching as given, for `duration_s`.

    `to_and_fro_m`: amplitude of a swing to the north-east every 10 s, as by a push ahead and astern. `rests_s`: it goes
    no way so long, and gathers its speed within 4 s then."""

    duration_s: float = 60.0
    speed_mps: float = 1.0
    radius_m: float = 10.0
    roll_rad: float = math.radians(2.0)
    pitch_rad: float = math.radians(1.0)
    yaw_rad: float = 0.0
    to_and_fro_m: float = 0.0
    rests_s: float = 0.0
    position_sigma_m: float = 0.02
    heading_sigma_rad: float = math.radians(0.2)
    velocity_sigma_mps: float = 0.03
    accelerometer_bias: tuple[float, float, float] = (0.03, -0.02, 0.05)
    gyro_bias: tuple[float, float, float] = (0.002, -0.002, 0.0015)
    gravity_mps2: float = 9.8214  # at 63.44° north
    seed: int = 1
    lever: tuple[float, float, float] = (-0.81, 0.0, -0.2)
    imu_lever: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Truth:
    """Arrays over time: one row an IMU sample."""

    t_s: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    attitude: np.ndarray
    rotation: np.ndarray
    rates: np.ndarray
    force: np.ndarray


def _rotations(attitude: np.ndarray) -> np.ndarray:
    (cr, cp, cy), (sr, sp, sy) = np.cos(attitude).T, np.sin(attitude).T
    rows = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def _begun(t: np.ndarray) -> np.ndarray:
    """Time at full speed, of a boat that begins at 0; without a step of the acceleration."""
    share = np.clip(t / _GATHERS_S, 0.0, 1.0)
    return _GATHERS_S * share**4 * (share * share - 3.0 * share + 2.5) + np.maximum(t - _GATHERS_S, 0.0)


def sail(voyage: Voyage) -> Truth:
    """The motion, and what perfect inertial sensors at `imu_lever` would measure."""
    t = np.arange(0, round(voyage.duration_s * IMU_HZ) + 1) / IMU_HZ

    def pose(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        turn = voyage.speed_mps / voyage.radius_m * (_begun(t - voyage.rests_s) if voyage.rests_s else t)
        heave = 0.03 * np.sin(1.7 * t)
        swing = math.sqrt(0.5) * voyage.to_and_fro_m * np.cos(2.0 * math.pi * t / 10.0)
        north, east = voyage.radius_m * np.sin(turn), voyage.radius_m * (1.0 - np.cos(turn))
        position = np.stack([north + swing, east + swing, heave], axis=1)
        attitude = np.stack(
            [
                voyage.roll_rad * np.sin(2.1 * t),
                0.01 + voyage.pitch_rad * np.sin(1.7 * t + 1.0),
                voyage.yaw_rad + turn + 0.05 * np.sin(0.3 * t),
            ],
            axis=1,
        )
        return position, attitude

    def imu_position(t: np.ndarray) -> np.ndarray:
        position, attitude = pose(t)
        return position + _rotations(attitude) @ np.array(voyage.imu_lever)

    d = 1e-4
    position, attitude = pose(t)
    rotation = _rotations(attitude)
    velocity = (pose(t + d)[0] - pose(t - d)[0]) / (2 * d)
    acceleration = (imu_position(t + d) - 2 * imu_position(t) + imu_position(t - d)) / d**2
    change = np.swapaxes(rotation, 1, 2) @ (_rotations(pose(t + d)[1]) - _rotations(pose(t - d)[1])) / (2 * d)
    rates = np.stack([change[:, 2, 1], change[:, 0, 2], change[:, 1, 0]], axis=1)
    force = np.einsum("tji,tj->ti", rotation, acceleration - np.array([0.0, 0.0, voyage.gravity_mps2]))
    return Truth(t, position, velocity, attitude, rotation, rates, force)


def config_of(voyage: Voyage, latency_s: float = 0.0) -> VesselConfig:
    """ReVolt with the sensors where the voyage has them, and a latency that is known exactly."""
    config = vessel_config.load(vessel_config.find("revolt"))
    gnss, imu = config.sensors
    x, y, z = voyage.lever
    gnss = replace(gnss, x_m=x, y_m=y, z_m=z, latency_s=latency_s, latency_accuracy_s=0.0)
    x, y, z = voyage.imu_lever
    return replace(config, sensors=(gnss, replace(imu, x_m=x, y_m=y, z_m=z)))


Alter = Callable[[int, list[Reading]], list[Reading]]


def readings_of(voyage: Voyage, truth: Truth, frame: LocalFrame) -> list[list[Reading]]:
    """For each IMU sample time, what the sensors say then: the IMU always, the receiver at 20 Hz."""
    random = np.random.default_rng(voyage.seed)
    count = len(truth.t_s)
    force = truth.force + voyage.accelerometer_bias + 0.01 * random.standard_normal((count, 3))
    rates = truth.rates + voyage.gyro_bias + 0.0017 * random.standard_normal((count, 3))
    lever = np.array(voyage.lever)
    antenna = truth.position + truth.rotation @ lever + voyage.position_sigma_m * random.standard_normal((count, 3))
    swing = np.einsum("tij,tj->ti", truth.rotation, np.cross(truth.rates, lever))
    speed = truth.velocity + swing + voyage.velocity_sigma_mps * random.standard_normal((count, 3))
    yaw = truth.attitude[:, 2] + voyage.heading_sigma_rad * random.standard_normal(count)
    said: list[list[Reading]] = []
    for k, t_s in enumerate(truth.t_s.tolist()):
        row: list[Reading] = [Imu(t_s, "imu", *force[k].tolist(), *rates[k].tolist())]
        if k % GNSS_EVERY == 0:
            lat, lon = frame.to_geodetic(float(antenna[k, 0]), float(antenna[k, 1]))
            accuracy = voyage.position_sigma_m
            row += [
                GnssFix(t_s, "gnss", lat, lon, 10.0, FixType.RTK_FIXED, 14, 0.8, accuracy),
                Heading(t_s, "gnss", math.remainder(float(yaw[k]), 2 * math.pi)),
                GroundVelocity(t_s, "gnss", float(speed[k, 0]), float(speed[k, 1])),
            ]
        said.append(row)
    return said


@dataclass
class Passage:
    """A run of the estimator: its states, and the truth's row of each."""

    truth: Truth
    states: list[NavState]
    rows: list[int]

    def errors(self, after_s: float, before_s: float = math.inf) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """(position m, heading rad, velocity m/s): horizontal error of each state in that time."""
        chosen = [(s, k) for s, k in zip(self.states, self.rows, strict=True) if after_s <= s.t_s < before_s]
        position = [
            math.hypot(s.north_m - self.truth.position[k, 0], s.east_m - self.truth.position[k, 1]) for s, k in chosen
        ]
        yaw = [math.remainder(s.yaw_rad - self.truth.attitude[k, 2], 2 * math.pi) for s, k in chosen]
        velocity = [
            math.hypot(s.north_mps - self.truth.velocity[k, 0], s.east_mps - self.truth.velocity[k, 1])
            for s, k in chosen
        ]
        return np.array(position), np.abs(np.array(yaw)), np.array(velocity)


def rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def navigate(
    voyage: Voyage,
    alter: Alter | None = None,
    tick_every: int = 10,
    delay: int = 0,
    parameters: dict[str, float] | None = None,
    config: VesselConfig | None = None,
) -> Passage:
    """Sail the voyage through an estimator at 10 Hz. `alter(sample, readings)` may change what the sensors say;
    `delay`: samples by which all but the IMU come in late (and the configuration knows it)."""
    truth = sail(voyage)
    config = config or config_of(voyage, latency_s=delay / IMU_HZ)
    estimator = Estimator(config, Parameters(parameters))
    said = readings_of(voyage, truth, LocalFrame(config.home.lat_deg, config.home.lon_deg))
    passage = Passage(truth, [], [])
    batch: list[Reading] = []
    for k in range(len(said)):
        row = alter(k, said[k]) if alter is not None else said[k]
        batch += [reading for reading in row if isinstance(reading, Imu)] if delay else row
        if delay and k >= delay:
            late = alter(k - delay, said[k - delay]) if alter is not None else said[k - delay]
            batch += [reading for reading in late if not isinstance(reading, Imu)]
        if k % tick_every == 0:
            passage.states.append(estimator.update(batch[::-1], float(truth.t_s[k])))
            passage.rows.append(k)
            batch = []
    return passage
