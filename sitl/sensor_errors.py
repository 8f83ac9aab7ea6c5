"""Errors that sensors have from how they are made and where they stand: axes, vibration, currents, the hull's wind."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass

from companion.config.sensor_errors import SensorErrorConfig
from companion.config.vessel import HomeConfig
from companion.core.angles import TWO_PI, wrap_pi
from companion.core.geomagnetism import decimal_year, field_nt
from sitl.battery import BatteryModel
from sitl.noise import stream
from sitl.thrusters import ThrusterModel

_BLADES = 3  # the blades shake as strongly as the shaft, at three times its revolutions and a third of its velocity
_ARM_M = 0.5  # the hull shakes about a point as far from the sensor (assumed)
_LEVELS_S = 10.0  # in which an attitude filter follows its magnetometer
_DEVIATES_EVERY = 10  # samples between two steps of that
_UPWASH_RAD = 0.5  # by which the hull turns the wind across, over the share by which it is faster
_SHADOW_RAD = math.radians(20.0)  # half width of the lee of mast and gear

Vector = tuple[float, float, float]
Matrix = tuple[float, float, float, float, float, float, float, float, float]
Sample = tuple[float, float, float, float, float, float, float, float, float]


@dataclass(frozen=True, slots=True)
class Aboard:
    """What disturbs the sensors, and how much of it they take."""

    errors: SensorErrorConfig
    thrusters: Sequence[ThrusterModel]
    battery: BatteryModel


class CurrentField:
    """The magnetic field of the battery's current at a sensor: proportional to it, in a direction from the seed."""

    def __init__(self, aboard: Aboard, name: str, home: HomeConfig, epoch_unix_ns: int, seed: int) -> None:
        rng = stream(seed, f"{name} current")
        self._nt_per_a = _scaled(_direction(rng), aboard.errors.compass_nt_per_a)
        self._battery = aboard.battery
        north, east, down = field_nt(home.lat_deg, home.lon_deg, decimal_year(epoch_unix_ns))
        self._level_nt, self._whole_nt = math.hypot(north, east), math.hypot(north, east, down)

    @property
    def share(self) -> Vector:
        """(x, y, z) in body axes, over the Earth's field."""
        return _scaled(self._nt_per_a, self._battery.current_a / self._whole_nt)

    def deviation_rad(self, magnetic_rad: float) -> float:
        """By which a level compass shows too much at that magnetic heading."""
        x, y, _ = _scaled(self._nt_per_a, self._battery.current_a / self._level_nt)
        shown_rad = math.atan2(math.sin(magnetic_rad) - y, math.cos(magnetic_rad) + x)
        return wrap_pi(shown_rad - magnetic_rad)


def current_field(
    aboard: Aboard | None, name: str, home: HomeConfig, epoch_unix_ns: int, seed: int
) -> CurrentField | None:
    """The field at the sensor `name`; None without such errors."""
    if aboard is None or aboard.errors.compass_nt_per_a == 0.0:
        return None
    return CurrentField(aboard, name, home, epoch_unix_ns, seed)


class ImuErrors:
    """What an inertial sensor with imperfect axes on a shaking hull tells: samples as `ImuModel` measures them → as
    told. Remembers the angle of each propeller, and the deviation that its attitude filter has taken.

    * Scale factors and axes: (I + E) times the truth, E from the seed, for accelerometers and gyros apart. The sensor's
      own roll and pitch follow its accelerometers.
    * Vibration: of each propeller a velocity that grows with the revolutions, at the shaft's and the blades' frequency,
      sampled where the frequency lies above half of the sampling rate: it then shows as a slower one.
    """

    def __init__(
        self, aboard: Aboard, field: CurrentField | None, north_rad: float, name: str, dt_s: float, seed: int
    ) -> None:
        """`field`: at its magnetometer; None: nothing disturbs it. `north_rad`: direction of magnetic north; `dt_s`:
        between two samples."""
        rng = stream(seed, f"{name} axes")
        errors = aboard.errors
        self._accelerometer = _axes(rng, errors)
        self._gyro = _axes(rng, errors)
        self._thrusters, self._dt_s = tuple(aboard.thrusters), dt_s
        self._field, self._north_rad = field, north_rad
        self._full_radps = TWO_PI * errors.full_rps
        peak_mps = math.sqrt(2.0) * errors.vibration_mps
        self._shakes = [  # of each thruster at full revolutions: acceleration and rate
            (*_scaled(_direction(rng), peak_mps * self._full_radps), *_scaled(_direction(rng), peak_mps / _ARM_M))
            for _ in self._thrusters
        ]
        self._angles = [rng.uniform(0.0, TWO_PI) for _ in self._thrusters]
        self._follows = -math.expm1(-_DEVIATES_EVERY * dt_s / _LEVELS_S)
        self._deviation_rad, self._samples = 0.0, 0

    def told(self, sample: Sample, yaw_rad: float) -> Sample:
        """The sample with the errors, at that true heading."""
        x, y, z, p, q, r, roll, pitch, yaw = sample
        ax, ay, az, gx, gy, gz = self._shaken()
        xx, xy, xz, yx, yy, yz, zx, zy, zz = self._accelerometer
        pp, pq, pr, qp, qq, qr, rp, rq, rr = self._gyro
        self._samples += 1
        if self._field is not None and self._samples % _DEVIATES_EVERY == 0:
            deviation_rad = self._field.deviation_rad(yaw_rad - self._north_rad)
            self._deviation_rad += self._follows * (deviation_rad - self._deviation_rad)
        return (
            xx * x + xy * y + xz * z + ax,
            yx * x + yy * y + yz * z + ay,
            zx * x + zy * y + zz * z + az,
            pp * p + pq * q + pr * r + gx,
            qp * p + qq * q + qr * r + gy,
            rp * p + rq * q + rr * r + gz,
            roll + yz,
            pitch - xz,
            wrap_pi(yaw + self._deviation_rad),
        )

    def _shaken(self) -> tuple[float, float, float, float, float, float]:
        """Acceleration and rate of turn of the vibration now."""
        ax = ay = az = gx = gy = gz = 0.0
        angles, step = self._angles, self._full_radps * self._dt_s
        for i, thruster in enumerate(self._thrusters):
            share = abs(thruster.throttle())
            if share == 0.0:
                continue
            angle = angles[i] = (angles[i] + step * share) % TWO_PI
            shaft, blades = math.sin(angle), math.sin(_BLADES * angle)
            shake, rock = share * share * (shaft + blades), share * (shaft + blades / _BLADES)
            x, y, z, p, q, r = self._shakes[i]
            ax, ay, az = ax + shake * x, ay + shake * y, az + shake * z
            gx, gy, gz = gx + rock * p, gy + rock * q, gz + rock * r
        return ax, ay, az, gx, gy, gz


def distorted_wind(errors: SensorErrorConfig, speed_mps: float, angle_rad: float) -> tuple[float, float]:
    """Speed and angle (from the bow, from where it blows) of the wind at a sensor above the hull: faster and more
    across where it rises over the side, slower behind mast and gear."""
    across = math.sin(angle_rad)
    behind = wrap_pi(angle_rad - errors.shadow_from_rad) / _SHADOW_RAD
    share = (1.0 + errors.wind_upwash * across * across) * (1.0 - errors.wind_shadow * math.exp(-behind * behind))
    turned = _UPWASH_RAD * errors.wind_upwash * math.sin(2.0 * angle_rad)
    return speed_mps * share, angle_rad + turned


def _axes(rng: random.Random, errors: SensorErrorConfig) -> Matrix:
    """I + E, row by row: scale factors on the diagonal, angles beside it."""

    def scale() -> float:
        return 1.0 + rng.gauss(0.0, errors.imu_scale)

    def angle() -> float:
        return rng.gauss(0.0, errors.imu_misalignment_rad)

    return scale(), angle(), angle(), angle(), scale(), angle(), angle(), angle(), scale()


def _direction(rng: random.Random) -> Vector:
    """A unit vector, in all directions alike."""
    x, y, z = rng.gauss(0.0, 1.0), rng.gauss(0.0, 1.0), rng.gauss(0.0, 1.0)
    return _scaled((x, y, z), 1.0 / math.sqrt(x * x + y * y + z * z))


def _scaled(vector: Vector, factor: float) -> Vector:
    return vector[0] * factor, vector[1] * factor, vector[2] * factor
