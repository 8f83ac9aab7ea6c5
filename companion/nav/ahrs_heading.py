"""A raw magnetometer as a heading source: calibration, the AHRS that `AHRS_LAW` chooses, and the correction towards the course."""

from __future__ import annotations

import math

from companion.config import NavigatedBoat, SensorConfig
from companion.core.angles import wrap_pi
from companion.core.types import Heading, HeadingBy, Imu, MagneticField
from companion.nav.ahrs import Ahrs
from companion.nav.course_correction import CourseCorrection
from companion.nav.lever_arms import Vector, normal_gravity_mps2, relative
from companion.nav.thesis_ahrs import ThesisAhrs
from companion.params import Parameters

_PERIOD_S = 0.095
_THESIS = 1
_FIELD_AGE_S = 2.0  # without a field the gyro alone carries the heading for that long
_LAST_SIGMA_RAD = math.radians(20.0)


class AhrsHeading:
    """In: inertial samples and magnetic fields of one device, velocities over ground. Out: a true `Heading` ten times a second.

    Remembers the filter, the correction towards the course, and when field and heading last came.
    """

    def __init__(self, row: SensorConfig, gravity_mps2: float, parameters: Parameters) -> None:
        self._row = row
        self._gravity_mps2 = gravity_mps2
        self._parameters = parameters
        self.filter: Ahrs | ThesisAhrs = Ahrs(gravity_mps2)
        self._law = 0
        self._correction = CourseCorrection()
        self._field_s = self._heading_s = -math.inf
        self.corrected_rad = 0.0

    def imu(self, imu: Imu) -> Heading | None:
        """One inertial sample."""
        self._choose()
        t_s, ahrs = imu.t_s, self.filter
        ahrs.sample(
            t_s, (imu.x_mps2, imu.y_mps2, imu.z_mps2), (imu.roll_rate_radps, imu.pitch_rate_radps, imu.yaw_rate_radps)
        )
        if not ahrs.running or 0.0 <= t_s - self._heading_s < _PERIOD_S:
            return None
        thesis = self._law == _THESIS
        yaw = ahrs.attitude[2]
        drift = None if thesis else self._parameters["AHRS_DRIFT"]
        turn = self._correction.update(t_s, wrap_pi(yaw + self._row.heading_offset_rad), ahrs.rates[2], self._parameters["AHRS_COURSE_T"], drift)
        if turn != 0.0:
            ahrs.turn(turn)
            self.corrected_rad = wrap_pi(self.corrected_rad + turn)
        self._heading_s = t_s
        sigma = ahrs.yaw_sigma_rad
        if t_s - self._field_s > _FIELD_AGE_S or sigma > _LAST_SIGMA_RAD:
            return None
        yaw_rad = wrap_pi(yaw + turn + self._row.heading_offset_rad)
        return Heading(t_s, self._row.name, yaw_rad, max(sigma, self._row.heading_accuracy_rad or 0.0), HeadingBy.COMPASS)

    def _choose(self) -> None:
        law = int(self._parameters["AHRS_LAW"])
        if law != self._law:
            self._law, self.corrected_rad = law, 0.0
            self.filter = ThesisAhrs(self._gravity_mps2) if law == _THESIS else Ahrs(self._gravity_mps2)

    def field(self, field: MagneticField, declination_rad: float) -> None:
        """One sample of the magnetometer, as it came."""
        self._field_s = field.t_s
        self.filter.magnetic(field.t_s, calibrated(self._row, field), declination_rad)

    def velocity(self, t_s: float, north_mps: float, east_mps: float, sigma_mps: float, lever_m: Vector) -> None:
        """Velocity over ground of the point `lever_m` from the boat's origin."""
        self._correction.velocity(t_s, north_mps, east_mps)
        row = self._row
        self.filter.velocity(t_s, north_mps, east_mps, sigma_mps, relative(lever_m, (row.x_m, row.y_m, row.z_m)))


def calibrated(row: SensorConfig, field: MagneticField) -> Vector:
    """mag_matrix · (measured − mag_offset), in body axes."""
    (a, b, c), (d, e, f), (g, h, i) = row.mag_matrix
    ox, oy, oz = row.mag_offset
    x, y, z = field.x - ox, field.y - oy, field.z - oz
    return a * x + b * y + c * z, d * x + e * y + f * z, g * x + h * y + i * z


def ahrs_headings(config: NavigatedBoat, parameters: Parameters) -> dict[str, AhrsHeading]:
    """One for each sensor whose file says that its heading comes from its raw magnetometer, by name."""
    gravity_mps2 = normal_gravity_mps2(config.home.lat_deg)
    return {row.name: AhrsHeading(row, gravity_mps2, parameters) for row in config.sensors if row.heading == "ahrs"}
