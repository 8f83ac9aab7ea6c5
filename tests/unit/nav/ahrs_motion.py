"""A fast boat in turns and waves, in closed form, and the readings of its inertial sensor, magnetometer and receiver.
It knows no vessel's plant."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import chain
from typing import Any

import numpy as np
from scipy.ndimage import gaussian_filter1d

Array = np.ndarray[Any, np.dtype[np.float64]]
HZ = 200
GRAVITY_MPS2 = 9.8175  # Gothenburg
DECLINATION_RAD = math.radians(5.35)  # by the World Magnetic Model, in 2027
_DIP_RAD = math.radians(71.3)
_PART = tuple[float, float, float]  # seconds, speed m/s, sideways acceleration in g, positive to starboard

TURNS: tuple[_PART, ...] = (
    (25.0, 8.0, 0.0),
    (17.0, 8.0, 0.3),
    (12.0, 8.0, 0.0),
    (17.0, 8.0, -0.3),
    (10.0, 8.0, 0.0),
    (6.0, 8.0, 0.3),
    (6.0, 8.0, -0.3),
    (6.0, 8.0, 0.3),
    (25.0, 8.0, 0.1),
    (10.0, 3.0, 0.0),
    (12.0, 3.0, -0.1),
    (12.0, 8.0, 0.0),
    (34.0, 8.0, -0.3),
    (20.0, 8.0, 0.0),
)


@dataclass(frozen=True)
class Sailing:
    """What is sailed, and with what. Errors are one sigma of what the seed draws; `mounting_rad` turns all of the
    device about its vertical."""

    seed: int = 0
    parts: tuple[_PART, ...] = TURNS
    wave_rad: float = math.radians(5.0)
    wave_m: float = 0.25  # of the orbit
    heel: float = 0.6  # of the angle of the apparent vertical, into the turn
    slip_s: float = 0.2  # angle of drift over turn rate
    current_ne_mps: tuple[float, float] = (0.0, 0.0)
    yaw_rad: float = 0.0
    mounting_rad: float = 0.0
    gyro_bias_radps: float = math.radians(0.15)
    accelerometer_bias_mps2: float = 0.02
    vibration_mps2: float = 0.5
    iron: float = 0.0025  # left by the calibration, as a share of the field: offset and matrix
    velocity_lag_s: float = 0.0
    lever_m: tuple[float, float, float] = (-0.8, 0.0, -1.0)


@dataclass(frozen=True)
class Motion:
    """Rows of samples at 200 Hz. `velocity` is the receiver's, a row for each sample too; every twentieth is heard."""

    t_s: Array
    roll_rad: Array
    pitch_rad: Array
    yaw_rad: Array
    speed_mps: Array
    force: Array
    rates: Array
    field: Array
    velocity: Array


def _smooth(values: Array, sigma_s: float) -> Array:
    return np.asarray(gaussian_filter1d(values, sigma_s * HZ, mode="nearest"))


def _waves(random: np.random.Generator, t: Array, amplitude: float) -> Array:
    """Two sinusoids, that amplitude together."""
    periods, phases = random.uniform(2.2, 4.5, 2), random.uniform(0.0, 2 * math.pi, 2)
    return np.asarray(
        amplitude
        * sum(share * np.sin(2 * math.pi * t / p + f) for share, p, f in zip((0.6, 0.4), periods, phases, strict=True))
    )


def _rotation(roll: Array, pitch: Array, yaw: Array) -> Array:
    """Body → NED, a matrix a row."""
    (cr, cp, cy), (sr, sp, sy) = (np.cos(a) for a in (roll, pitch, yaw)), (np.sin(a) for a in (roll, pitch, yaw))
    rows = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
    return np.moveaxis(np.array(rows), -1, 0)


def sail(sailing: Sailing) -> Motion:
    random = np.random.default_rng(sailing.seed)
    speed = _smooth(np.array(list(chain.from_iterable([v] * round(s * HZ) for s, v, _ in sailing.parts))), 1.0)
    sideways = (
        _smooth(np.array(list(chain.from_iterable([g] * round(s * HZ) for s, _, g in sailing.parts))), 0.5)
        * GRAVITY_MPS2
    )
    t = np.arange(len(speed)) / HZ
    course_rate = sideways / np.maximum(speed, 1.0)
    course = sailing.yaw_rad + np.cumsum(course_rate) / HZ
    yaw = course + sailing.slip_s * course_rate + _waves(random, t, 0.3 * sailing.wave_rad)
    roll = sailing.heel * np.arctan(sideways / GRAVITY_MPS2) + _waves(random, t, sailing.wave_rad)
    pitch = math.radians(3.0) * speed / 8.0 + _waves(random, t, sailing.wave_rad)
    orbit = np.stack([_waves(random, t, sailing.wave_m) for _ in range(3)], axis=1)
    velocity = np.stack([speed * np.cos(course), speed * np.sin(course), 0.0 * t], axis=1) + np.gradient(
        orbit, 1 / HZ, axis=0
    )
    acceleration = np.gradient(velocity, 1 / HZ, axis=0)
    velocity = velocity + np.array([*sailing.current_ne_mps, 0.0])
    rotation = _rotation(roll, pitch, yaw)
    dr, dp, dy = (np.gradient(a, 1 / HZ) for a in (roll, pitch, yaw))
    rates = np.stack(
        [
            dr - dy * np.sin(pitch),
            dp * np.cos(roll) + dy * np.sin(roll) * np.cos(pitch),
            dy * np.cos(roll) * np.cos(pitch) - dp * np.sin(roll),
        ],
        axis=1,
    )
    force = np.einsum("tji,tj->ti", rotation, acceleration - np.array([0.0, 0.0, GRAVITY_MPS2]))
    h = math.cos(_DIP_RAD)
    field = rotation.transpose(0, 2, 1) @ np.array(
        [h * math.cos(DECLINATION_RAD), h * math.sin(DECLINATION_RAD), math.sin(_DIP_RAD)]
    )
    field = field @ (
        np.eye(3) + sailing.iron * random.standard_normal((3, 3))
    ).T + sailing.iron * random.standard_normal(3)
    antenna = velocity + np.einsum("tij,tj->ti", rotation, np.cross(rates, np.array(sailing.lever_m)))
    lag = round(sailing.velocity_lag_s * HZ)
    antenna = np.concatenate([np.repeat(antenna[:1], lag, axis=0), antenna[: len(t) - lag]])
    c, s = math.cos(sailing.mounting_rad), math.sin(sailing.mounting_rad)
    mount = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    count = (len(t), 3)
    return Motion(
        t,
        roll,
        pitch,
        yaw,
        np.linalg.norm(velocity[:, :2], axis=1),
        force @ mount.T
        + sailing.accelerometer_bias_mps2 * random.standard_normal(3)
        + sailing.vibration_mps2 * random.standard_normal(count),
        rates @ mount.T
        + sailing.gyro_bias_radps * random.standard_normal(3)
        + math.radians(0.1) * random.standard_normal(count),
        field @ mount.T + 0.005 * random.standard_normal(count),
        antenna[:, :2] + 0.06 * random.standard_normal((len(t), 2)),
    )
