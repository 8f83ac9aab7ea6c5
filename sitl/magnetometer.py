"""A magnetometer aboard: the Earth's field, distorted by the boat's iron."""

from __future__ import annotations

import math
from dataclasses import replace

from companion.config.devices import SensorConfig
from companion.config.vessel import ConfigError, HomeConfig, VesselConfig
from companion.core.geomagnetism import decimal_year, field_nt
from sitl.noise import Normals, stream
from sitl.sensor_errors import Aboard, current_field

MAGNETIC_DRIVER = "mtdata2"  # of sensors whose magnetometer is simulated
_WHITE = 0.004  # noise of one sample, as a share of the field
_LEFT_OFFSET = 0.002  # hard iron left by a calibration, as a share of the field
_LEFT_MATRIX = 0.002  # soft iron left by a calibration, in each element
_OFFSET = (0.14, -0.09, 0.17)  # a boat whose file has no calibration: engine, battery and cables
_MATRIX = ((1.05, 0.03, -0.01), (0.03, 0.95, 0.02), (-0.01, 0.02, 1.02))


class MagnetometerModel:
    """In: true attitude; out: the field in body axes, in the device's unit (1 is the Earth's field at home).

    Hard and soft iron are what the vessel's file corrects (`mag_offset`, `mag_matrix`), plus a small rest from the
    seed, as no calibration is perfect.
    """

    def __init__(
        self, config: SensorConfig, home: HomeConfig, epoch_unix_ns: int, seed: int, aboard: Aboard | None = None
    ) -> None:
        """`aboard`: whose battery's current disturbs it; None: nothing does."""
        import numpy as np

        self._current = current_field(aboard, config.name, home, epoch_unix_ns, seed)
        self._ned = _unit(field_nt(home.lat_deg, home.lon_deg, decimal_year(epoch_unix_ns)))
        draw = Normals(stream(seed, f"{config.name} iron")).gauss
        distortion = np.linalg.inv(np.array(config.mag_matrix))
        left = np.eye(3) + np.array([[draw(0.0, _LEFT_MATRIX) for _ in range(3)] for _ in range(3)])
        self._matrix: list[list[float]] = (distortion @ left).tolist()
        self._offset = (
            distortion @ np.array([draw(0.0, _LEFT_OFFSET) for _ in range(3)]) + np.array(config.mag_offset)
        ).tolist()
        self._normals = Normals(stream(seed, f"{config.name} field"))

    def sample(self, roll_rad: float, pitch_rad: float, yaw_rad: float) -> tuple[float, float, float]:
        """(x, y, z) of the field at an attitude."""
        n, e, d = self._ned
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        x, y = c * n + s * e, c * e - s * n
        c, s = math.cos(pitch_rad), math.sin(pitch_rad)
        x, z = c * x - s * d, s * x + c * d
        c, s = math.cos(roll_rad), math.sin(roll_rad)
        y, z = c * y + s * z, c * z - s * y
        normals = self._normals
        x, y, z = (
            row[0] * x + row[1] * y + row[2] * z + offset + _WHITE * normals.next()
            for row, offset in zip(self._matrix, self._offset, strict=True)
        )
        if self._current is not None:
            dx, dy, dz = self._current.share
            x, y, z = x + dx, y + dy, z + dz
        return x, y, z


def with_magnetometer(vessel: VesselConfig) -> VesselConfig:
    """The same vessel with its inertial sensor's magnetometer as the only compass, and with iron aboard. Raises
    ConfigError for a vessel without such a sensor."""
    if not any(sensor.driver == MAGNETIC_DRIVER for sensor in vessel.sensors):
        raise ConfigError([f"{vessel.name}: no sensor with a magnetometer (driver {MAGNETIC_DRIVER})"])
    return replace(vessel, sensors=tuple(_single(sensor) for sensor in vessel.sensors))


def _single(sensor: SensorConfig) -> SensorConfig:
    if sensor.driver != MAGNETIC_DRIVER:
        return replace(sensor, antennas=1)
    offset, matrix = (sensor.mag_offset, sensor.mag_matrix) if any(sensor.mag_offset) else (_OFFSET, _MATRIX)
    wander_rad = sensor.heading_wander_rad or math.radians(1.0)
    return replace(sensor, heading="ahrs", heading_wander_rad=wander_rad, mag_offset=offset, mag_matrix=matrix)


def _unit(vector: tuple[float, float, float]) -> tuple[float, float, float]:
    length = math.hypot(*vector)
    return vector[0] / length, vector[1] / length, vector[2] / length
