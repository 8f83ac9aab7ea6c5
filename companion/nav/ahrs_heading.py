"""Heading from a raw magnetometer: calibration, the AHRS that `AHRS_LAW` chooses, and the correction to the course."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Protocol

from companion.config.devices import SensorConfig
from companion.config.vessel import NavigatedBoat
from companion.core.angles import wrap_pi
from companion.core.readings import Heading, HeadingBy, Imu, MagneticField
from companion.nav.ahrs import Ahrs, AhrsNoise, is_too_steep
from companion.nav.corrections import SensorCorrections
from companion.nav.course_correction import CourseCorrection
from companion.nav.lever_arms import (
    Matrix,
    Vector,
    normal_gravity_mps2,
    quaternion_of,
    relative,
    rotate,
    rotation,
)
from companion.params.store import Parameters

_PERIOD_S = 0.095
_THESIS = 1
_FIELD_AGE_S = 2.0  # how long the gyro alone may carry the heading without a field
_STEEP_S = 10.0  # without a field that tells a heading: waves and a tilt that is not known yet make some too steep
_LEVEL_AT_ONCE_S = 0.1
_UNFELT_START_RAD = math.radians(5.0)  # of a heading by a field that is levelled by no force
_LEVEL_TIME_S = 10.0  # of the mean force that levels the field without a gyro: over waves and turns
_UNTURNED_RAD = math.radians(4.0)  # accuracy of a heading by the field alone
_UNFELT_MPS2 = 1.5  # a boat's mean acceleration over half a second, where no accelerometer tells
_LARGEST_SIGMA_RAD = math.radians(20.0)


class AttitudeFilter(Protocol):
    """A filter for attitude from gyro, accelerometer and magnetometer: the companion's (`Ahrs`) or the thesis's."""

    @property
    def running(self) -> bool:
        """Whether there is an attitude."""
        ...

    @property
    def attitude(self) -> Vector:
        """(roll, pitch, yaw) in radians, yaw from true north."""
        ...

    @property
    def rates(self) -> Vector:
        """Body rates in rad/s, bias removed."""
        ...

    @property
    def yaw_sigma_rad(self) -> float:
        """One sigma of yaw."""
        ...

    def sample(self, t_s: float, force: Vector, rates: Vector) -> None:
        """One inertial sample: specific force (m/s²) and angular rate (rad/s) in body axes."""
        ...

    def magnetic(self, t_s: float, field: Vector, declination_rad: float) -> bool | None:
        """One calibrated magnetic field in body axes, any unit. Returns False where it does not count."""
        ...

    def velocity(self, t_s: float, north_mps: float, east_mps: float, sigma_mps: float, lever_m: Vector) -> None:
        """Velocity over ground of the point `lever_m` (body axes) from the inertial sensor."""
        ...

    def turn(self, angle_rad: float) -> None:
        """Add `angle_rad` to the heading and to all later magnetometer headings."""
        ...


class AhrsHeading:
    """Inertial samples and magnetic fields of one device, and velocities over ground → a true `Heading`, ten times a
    second.

    A new calibration of the device begins a new filter. `by_field_rad`: the heading by the magnetic field alone, of
    the time since the heading before, levelled by the filter's tilt; None without a field. It has what the gyro knows
    nothing of, so both can be compared. `steep_rad`: by how much the field dips, where it has long been too steep to
    tell a heading; None else. Remembers the filter, the correction to the course (`corrected_rad`), and the times of
    the last field that counted, of the last one that was not too steep, and of the last heading.
    """

    def __init__(
        self,
        row: SensorConfig,
        gravity_mps2: float,
        parameters: Parameters,
        corrections: SensorCorrections,
        baseline: Callable[[float], AttitudeFilter] | None = None,
    ) -> None:
        """`corrections`: those of the device. `baseline`: makes the thesis's filter, which AHRS_LAW 1 chooses, from the
        gravity in m/s²; None: not available."""
        self._baseline = baseline
        self._row = row
        self._gravity_mps2 = gravity_mps2
        self._parameters = parameters
        self._corrections, self._version = corrections, corrections.version
        self._trusted = True, True  # forces, rates
        self._level: Vector | None = None  # mean force, while the rates lie
        self._sample_s = -math.inf
        self.filter: AttitudeFilter = Ahrs(gravity_mps2)
        self._law = 0
        self._correction = CourseCorrection()
        self._field_s = self._heading_s = -math.inf
        self._flat_s = math.inf
        self.steep_rad: float | None = None
        self.corrected_rad = 0.0
        self.by_field_rad: float | None = None
        self._along = self._across = 0.0  # sum of unit vectors: the headings by field less the filter's

    def imu(self, imu: Imu) -> Heading | None:
        """Take one inertial sample, corrected and in body axes; returns a heading if one is due."""
        if not self._trusted[1]:
            return self._by_field_alone(imu)
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
        turn = self._correction.update(
            t_s, wrap_pi(yaw + self._row.heading_offset_rad), ahrs.rates[2], self._parameters["AHRS_COURSE_T"], drift
        )
        if turn != 0.0:
            ahrs.turn(turn)
            self.corrected_rad = wrap_pi(self.corrected_rad + turn)
        self._heading_s = t_s
        self.by_field_rad = self._mean_by_field_rad(yaw)
        sigma = ahrs.yaw_sigma_rad
        if t_s - self._field_s > _FIELD_AGE_S or sigma > _LARGEST_SIGMA_RAD:
            return None
        yaw_rad = wrap_pi(yaw + turn + self._row.heading_offset_rad)
        return Heading(
            t_s, self._row.name, yaw_rad, max(sigma, self._row.heading_accuracy_rad or 0.0), HeadingBy.COMPASS
        )

    def _mean_by_field_rad(self, yaw_rad: float) -> float | None:
        """The mean of the headings by field since the last call, carried on to now by the filter's `yaw_rad`."""
        along, across = self._along, self._across
        self._along = self._across = 0.0
        if along == across == 0.0:
            return None
        return wrap_pi(yaw_rad + math.atan2(across, along) + self.corrected_rad + self._row.heading_offset_rad)

    def trust(self, forces: bool, rates: bool) -> None:
        """Whether forces and rates of the samples are measured. A change begins a new filter.

        Samples without forces hold those of a level boat, and count for little. Without rates the heading is that of
        the field alone, levelled by the mean force of some seconds.
        """
        if (forces, rates) == self._trusted:
            return
        self._trusted = forces, rates
        self._level = None
        self._along = self._across = 0.0
        self.by_field_rad = None
        self.filter = self._new_filter()

    def _choose(self) -> None:
        law, version = int(self._parameters["AHRS_LAW"]), self._corrections.version
        if law != self._law or version != self._version:
            self._law, self._version, self.corrected_rad = law, version, 0.0
            self.filter = self._new_filter()

    def _new_filter(self) -> AttitudeFilter:
        if not self._trusted[0]:
            noise = AhrsNoise(force_mps2=_UNFELT_MPS2, start_rad=_UNFELT_START_RAD)
            return Ahrs(self._gravity_mps2, noise, _LEVEL_AT_ONCE_S)
        if self._law == _THESIS and self._baseline is not None:
            return self._baseline(self._gravity_mps2)
        return Ahrs(self._gravity_mps2)

    def _by_field_alone(self, imu: Imu) -> Heading | None:
        """A heading without the gyro, if one is due."""
        force = imu.x_mps2, imu.y_mps2, imu.z_mps2
        if self._level is None:
            self._level = force
        share = min(max(imu.t_s - self._sample_s, 0.0) / _LEVEL_TIME_S, 1.0)
        x, y, z = (mean + share * (now - mean) for mean, now in zip(self._level, force, strict=True))
        self._level, self._sample_s = (x, y, z), imu.t_s
        along, across = self._along, self._across
        if 0.0 <= imu.t_s - self._heading_s < _PERIOD_S or along == across == 0.0:
            return None
        self._heading_s = imu.t_s
        self._along = self._across = 0.0
        yaw_rad = wrap_pi(math.atan2(across, along) + self.corrected_rad + self._row.heading_offset_rad)
        sigma_rad = max(_UNTURNED_RAD, self._row.heading_accuracy_rad or 0.0)
        return Heading(imu.t_s, self._row.name, yaw_rad, sigma_rad, HeadingBy.COMPASS)

    def field(self, field: MagneticField, declination_rad: float, turn: Matrix | None = None) -> None:
        """Take one sample of the magnetometer, not yet calibrated. `turn`: from its axes to the boat's."""
        vector = self._corrections.field(field)
        vector = vector if turn is None else rotate(turn, vector)
        attitude = self._attitude()
        if attitude is not None:
            roll, pitch, yaw = attitude
            north, east, down = rotate(rotation(quaternion_of(roll, pitch, 0.0)), vector)
            if not is_too_steep(math.hypot(north, east), down):
                apart_rad = declination_rad - math.atan2(east, north) - yaw
                self._along += math.cos(apart_rad)
                self._across += math.sin(apart_rad)
        if self.filter.magnetic(field.t_s, vector, declination_rad) is not False:
            self._field_s = field.t_s
        self._watch_dip(field.t_s)

    def _watch_dip(self, t_s: float) -> None:
        steep_rad = self.filter.steep_rad if isinstance(self.filter, Ahrs) else None
        self._flat_s = t_s if steep_rad is None else min(self._flat_s, t_s)
        self.steep_rad = steep_rad if t_s - self._flat_s >= _STEEP_S else None

    def _attitude(self) -> Vector | None:
        """(roll, pitch, yaw) by which a field is levelled, and what its heading is set against; None: unknown."""
        if self._trusted[1]:
            return self.filter.attitude if self.filter.running else None
        if self._level is None:
            return None
        x, y, z = self._level
        return math.atan2(-y, -z), math.atan2(x, math.hypot(y, z)), 0.0

    def velocity(
        self, t_s: float, north_mps: float, east_mps: float, sigma_mps: float, lever_m: Vector, astern: bool = False
    ) -> None:
        """Take a velocity over ground, of the point `lever_m` from the boat's origin. `astern`: the boat may go stern
        first, so that its course is no heading."""
        if not astern:
            self._correction.velocity(t_s, north_mps, east_mps)
        row = self._row
        self.filter.velocity(t_s, north_mps, east_mps, sigma_mps, relative(lever_m, (row.x_m, row.y_m, row.z_m)))


def ahrs_headings(
    config: NavigatedBoat,
    parameters: Parameters,
    corrections: Mapping[str, SensorCorrections],
    baseline: Callable[[float], AttitudeFilter] | None = None,
) -> dict[str, AhrsHeading]:
    """One `AhrsHeading` for each sensor with `heading = "ahrs"`, by the sensor's name."""
    gravity_mps2 = normal_gravity_mps2(config.home.lat_deg)
    return {
        row.name: AhrsHeading(row, gravity_mps2, parameters, corrections[row.name], baseline)
        for row in config.sensors
        if row.heading == "ahrs"
    }
