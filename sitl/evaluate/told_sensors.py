"""A vessel whose file tells exactly what its simulated sensors get wrong, so that only the filter is judged."""

from __future__ import annotations

import math
from dataclasses import replace

from companion.config.devices import FixErrors, SensorConfig
from companion.config.vessel import VesselConfig
from sitl.sensors import (
    ACCEL_BIAS_MPS2,
    ACCEL_WHITE_MPS2,
    BIAS_TAU_S,
    FLOAT,
    GRADES,
    GYRO_BIAS_RADPS,
    GYRO_WHITE_RADPS,
    HEADING_TAU_S,
    YAW_RAD,
    YAW_TAU_S,
    Grade,
)

_CORRECTED, _FIXED = 2, 4  # quality in GGA
_CORRECTED_SHARE = 0.5  # of `velocity_accuracy_mps`, which a fix with corrections has
_LEAST_M = 0.001
_LEAST_RAD = math.radians(0.005)  # of a yaw whose error is slow and nothing else


def told(vessel: VesselConfig, gnss: str) -> VesselConfig:
    """The vessel with the figures of receivers of that grade and of its inertial sensor in their rows, its yaw with
    them. What a heading made of the raw magnetic field is worth stays as the file says."""
    return replace(vessel, sensors=tuple(_told(row, GRADES[gnss]) for row in vessel.sensors))


def _told(row: SensorConfig, grade: Grade) -> SensorConfig:
    if row.driver == "nmea0183":
        return _receiver(row, grade)
    density = 1.0 / math.sqrt(row.rate_hz)
    if row.heading in ("magnetic", "true"):
        row = replace(row, heading_noise_rad=_LEAST_RAD, heading_wander_rad=YAW_RAD, heading_wander_s=YAW_TAU_S)
    return replace(
        row,
        accelerometer_noise_mps2_rthz=ACCEL_WHITE_MPS2 * density,
        gyro_noise_radps_rthz=GYRO_WHITE_RADPS * density,
        accelerometer_bias_mps2=ACCEL_BIAS_MPS2,
        gyro_bias_radps=GYRO_BIAS_RADPS,
        bias_s=BIAS_TAU_S,
    )


def _receiver(row: SensorConfig, grade: Grade) -> SensorConfig:
    plain = grade if grade.quality < _FIXED else GRADES["standalone"]
    share = _CORRECTED_SHARE if plain.quality == _CORRECTED else 1.0
    row = replace(
        row,
        accuracy_floor_m=_LEAST_M,
        position_noise_m=plain.white_m,
        position_wander_m=plain.slow_m,
        position_wander_s=plain.slow_tau_s,
        velocity_accuracy_mps=plain.velocity_mps / share,
        velocity_lasts_s=0.0,
        latency_accuracy_s=0.0,
        rtk_float=_errors(FLOAT),
        rtk_fixed=_errors(grade if grade.quality == _FIXED else GRADES["rtk"]),
    )
    if row.antennas == 1:
        return row
    return replace(
        row,
        heading_accuracy_rad=grade.heading_rad,
        heading_wander_rad=grade.heading_rad,
        heading_wander_s=HEADING_TAU_S,
    )


def _errors(grade: Grade) -> FixErrors:
    return FixErrors(grade.white_m, grade.slow_m, grade.slow_tau_s, grade.velocity_mps)
