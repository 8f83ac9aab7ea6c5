"""What the sensors measure of the true motion: lever arms, noise, slow errors. The emulators turn it into bytes."""

from __future__ import annotations

import math
from collections.abc import Set
from dataclasses import dataclass

from companion.config.devices import SensorConfig
from companion.config.vessel import ConfigError, HomeConfig
from companion.core.angles import wrap_pi
from companion.core.geodesy import LocalFrame
from companion.core.geomagnetism import decimal_year, declination_rad
from sitl.environment import Waves
from sitl.faults import OFFSETS_M
from sitl.hull import Hull
from sitl.noise import Bridge, GaussMarkov, Normals, stream
from sitl.sensor_errors import Aboard, CurrentField, ImuErrors, current_field

_SQRT_HALF = math.sqrt(0.5)
_WILD_EVERY = 10


@dataclass(frozen=True, slots=True)
class Grade:
    """How good a receiver is: one sigma on each axis, of white noise and of a slow error."""

    quality: int  # in GGA
    satellites: int
    hdop: float
    white_m: float
    slow_m: float
    slow_tau_s: float
    velocity_mps: float
    heading_rad: float = math.radians(0.10)  # of the white noise, and of the slow error


FLOAT = Grade(5, 16, 0.7, 0.02, 0.15, 120.0, 0.02)
GRADES = {
    "rtk": Grade(4, 18, 0.6, 0.005, 0.008, 60.0, 0.015),
    "sbas": Grade(2, 14, 0.8, 0.05, 0.25, 150.0, 0.03),
    "standalone": Grade(1, 11, 1.1, 0.15, 1.2, 300.0, 0.06),
    "basin": Grade(
        4, 18, 0.6, 0.001, 0.001, 60.0, 0.005, math.radians(0.02)
    ),  # cameras in a towing tank that print the same sentences
    "float": FLOAT,
}
HEADING_TAU_S = 30.0
_ALTITUDE_FACTOR = 1.7
_COMMON_TAU_S = 300.0  # orbits, clocks, ionosphere, troposphere
_MULTIPATH_TAU_S = 60.0  # what is left to each receiver under way
_COMMON_STEP_S = 0.1


def grade(name: str) -> Grade:
    """The grade of that name. Raises ConfigError with the grades there are."""
    if name not in GRADES:
        raise ConfigError([f"gnss '{name}': one of {', '.join(GRADES)}"])
    return GRADES[name]


def gravity_mps2(lat_deg: float) -> float:
    """Normal gravity on the WGS 84 ellipsoid (Somigliana)."""
    s2 = math.sin(math.radians(lat_deg)) ** 2
    return 9.7803253359 * (1.0 + 0.00193185265241 * s2) / math.sqrt(1.0 - 0.00669437999013 * s2)


@dataclass(frozen=True, slots=True)
class GnssSample:
    """One solution of a receiver. The position is None without a fix, the heading None without a baseline solution."""

    grade: Grade
    position: tuple[float, float, float] | None  # latitude and longitude in degrees, altitude in m
    north_mps: float
    east_mps: float
    heading_rad: float | None  # of the antenna baseline


class CommonWander:
    """The slow error that receivers near each other share (orbits, clocks, ionosphere): `share` of the variance.

    Of a plain receiver's error that share is about 0.9 with the same satellites. Its usual budget of range errors is
    1.1 m of clocks, 0.8 m of orbits, 0.2 m of troposphere and several metres of ionosphere, all shared, against at most
    1 m of multipath and noise of its own (Kaplan & Hegarty 2006, chapter 7; Misra & Enge 2011, chapter 5). With SBAS it
    is about half: its corrections take most of what is shared. Receivers that use other satellites share less.

    A function of time, seed and grade alone. For a time before the newest one it returns the newest error.
    """

    def __init__(self, share: float, seed: int) -> None:
        """Raises ConfigError where `share` is not 0 to 1."""
        if not 0.0 <= share <= 1.0:
            raise ConfigError([f"common share of the receivers' errors {share:g}: must be from 0 to 1"])
        self.share = share
        rng = Normals(stream(seed, "common wander"))
        self._walks = [GaussMarkov(rng, 1.0, _COMMON_TAU_S) for _ in range(3)]
        self._steps = 0

    def at(self, t_s: float, grade: Grade) -> tuple[float, float, float]:
        """(north, east, up) in m at `t_s`, for receivers of that grade."""
        due = round(t_s / _COMMON_STEP_S)
        while self._steps < due:
            self._steps += 1
            for walk in self._walks:
                walk.update(_COMMON_STEP_S)
        scale = math.sqrt(self.share) * grade.slow_m
        north, east, up = (scale * walk.value for walk in self._walks)
        return north, east, up


class GnssModel:
    """A dual-antenna receiver. In: true motion; out: `GnssSample` for its antenna. Remembers its slow errors."""

    def __init__(
        self,
        config: SensorConfig,
        home: HomeConfig,
        grade_name: str,
        dt_s: float,
        seed: int,
        common: CommonWander | None = None,
    ) -> None:
        """`dt_s`: between two samples; `common`: the slow error it shares with other receivers, None for none."""
        self._config = config
        self._home = home
        self._common = common
        self._own_share = 1.0 if common is None else math.sqrt(1.0 - common.share)
        self._frame = LocalFrame(home.lat_deg, home.lon_deg)
        self._grade = grade(grade_name)
        self._dt_s = dt_s
        rng = self._rng = Normals(stream(seed, f"{config.name} white"))
        most_s = math.inf if common is None else _MULTIPATH_TAU_S
        self._slow = {
            g: [GaussMarkov(draws, g.slow_m, min(most_s, g.slow_tau_s)) for _ in range(3)]
            for g in GRADES.values()
            for draws in (Normals(stream(seed, f"{config.name} float")) if g is FLOAT else rng,)
        }
        self._slow_heading = GaussMarkov(rng, self._grade.heading_rad, HEADING_TAU_S)
        self._samples = 0
        self.slow_m = 0.0, 0.0  # its newest slow error, north and east

    def antenna(self, hull: Hull, waves: Waves) -> tuple[float, float]:
        """North and east of home, m, where the antenna truly is."""
        config = self._config
        x, y, _ = _levelled(config.x_m, config.y_m, config.z_m, waves.roll_rad, waves.pitch_rad)
        c, s = math.cos(hull.yaw_rad), math.sin(hull.yaw_rad)
        return hull.north_m + c * x - s * y, hull.east_m + s * x + c * y

    def sample(self, hull: Hull, waves: Waves, faults: Set[str]) -> GnssSample:
        """The next solution, for the true motion and the active faults."""
        self._samples += 1
        now = GRADES["standalone"] if "rtk_lost" in faults else FLOAT if "rtk_float" in faults else self._grade
        heading_error = self._slow_heading.update(self._dt_s) + self._rng.gauss(0.0, now.heading_rad)
        if "gnss_lost" in faults:
            return GnssSample(now, None, 0.0, 0.0, None)
        rng, config = self._rng, self._config
        x, y, down = _levelled(config.x_m, config.y_m, config.z_m, waves.roll_rad, waves.pitch_rad)
        c, s = math.cos(hull.yaw_rad), math.sin(hull.yaw_rad)
        slow_north, slow_east, slow_up = [process.update(self._dt_s) for process in self._slow[now]]
        if self._common is not None:
            shared = self._common.at(self._samples * self._dt_s, now)
            slow_north, slow_east, slow_up = (
                self._own_share * own + other
                for own, other in zip((slow_north, slow_east, slow_up), shared, strict=True)
            )
        self.slow_m = slow_north, slow_east
        north_m = hull.north_m + c * x - s * y + slow_north + rng.gauss(0.0, now.white_m)
        east_m = hull.east_m + s * x + c * y + slow_east + rng.gauss(0.0, now.white_m)
        altitude_m = (
            self._home.altitude_m - down - waves.heave_m + _ALTITUDE_FACTOR * (slow_up + rng.gauss(0.0, now.white_m))
        )
        x_mps = waves.pitch_rate_radps * config.z_m - hull.yaw_rate_radps * y
        y_mps = hull.yaw_rate_radps * x - waves.roll_rate_radps * config.z_m
        return GnssSample(
            now,
            (*self._place(north_m, east_m, faults), altitude_m),
            hull.north_mps + c * x_mps - s * y_mps + rng.gauss(0.0, now.velocity_mps),
            hull.east_mps + s * x_mps + c * y_mps + rng.gauss(0.0, now.velocity_mps),
            None if "heading_lost" in faults else wrap_pi(hull.yaw_rad - config.heading_offset_rad + heading_error),
        )

    def _place(self, north_m: float, east_m: float, faults: Set[str]) -> tuple[float, float]:
        for distance_m in OFFSETS_M if faults else ():
            if f"gnss_off_{distance_m}m" in faults:
                north_m, east_m = north_m + _SQRT_HALF * distance_m, east_m + _SQRT_HALF * distance_m
        lat_deg, lon_deg = self._frame.to_geodetic(north_m, east_m)
        if "gnss_wild" in faults and self._samples % _WILD_EVERY == 0:
            return 0.001 * lat_deg, lon_deg
        return lat_deg, lon_deg


def _levelled(x: float, y: float, z: float, roll_rad: float, pitch_rad: float) -> tuple[float, float, float]:
    """A vector in body axes, rotated by roll and pitch into the level frame with the boat's heading."""
    c, s = math.cos(roll_rad), math.sin(roll_rad)
    y, z = c * y - s * z, s * y + c * z
    c, s = math.cos(pitch_rad), math.sin(pitch_rad)
    return c * x + s * z, y, c * z - s * x


_COMPASS_WHITE_RAD = math.radians(0.3)
_COMPASS_SLOW_RAD = math.radians(1.5)
_COMPASS_TAU_S = 300.0


def north_of(home: HomeConfig, epoch_unix_ns: int) -> float:
    """Direction of magnetic north at home, clockwise from true north."""
    return declination_rad(home.lat_deg, home.lon_deg, decimal_year(epoch_unix_ns)) or 0.0


class CompassModel:
    """A magnetometer. In: true heading; out: magnetic heading in rad. Remembers its slow error."""

    def __init__(
        self,
        config: SensorConfig,
        home: HomeConfig,
        epoch_unix_ns: int,
        dt_s: float,
        seed: int,
        field: CurrentField | None = None,
    ) -> None:
        """`dt_s`: between two samples; `field`: of the battery's current, None for none."""
        self._field = field
        self._north_rad = north_of(home, epoch_unix_ns)
        self._dt_s = dt_s
        self._rng = Normals(stream(seed, f"{config.name} white"))
        self._slow = GaussMarkov(self._rng, _COMPASS_SLOW_RAD, _COMPASS_TAU_S)

    def sample(self, yaw_rad: float) -> float:
        """Magnetic heading in rad."""
        error = self._slow.update(self._dt_s) + self._rng.gauss(0.0, _COMPASS_WHITE_RAD)
        if self._field is not None:
            error += self._field.deviation_rad(yaw_rad - self._north_rad)
        return wrap_pi(yaw_rad - self._north_rad + error)


# An MTi-710 class sensor at 100 Hz: noise densities 60 µg/√Hz and 0.01 °/s/√Hz over 50 Hz; biases left by calibration.
ACCEL_WHITE_MPS2 = 0.0045
ACCEL_BIAS_MPS2 = 0.02
GYRO_WHITE_RADPS = math.radians(0.07)
GYRO_BIAS_RADPS = math.radians(0.03)
BIAS_TAU_S = 1800.0
_TILT_RAD = math.radians(0.2)
_TILT_TAU_S = 60.0
YAW_RAD = math.radians(1.0)
YAW_TAU_S = 300.0
_SLOW_EVERY = 50  # samples between two steps of the slow errors

_Vector = tuple[float, float, float]
ImuSample = tuple[float, float, float, float, float, float, float, float, float]


def true_imu(gravity_mps2: float, hull: Hull, waves: Waves) -> tuple[float, float, float, float, float, float]:
    """What a perfect inertial sensor in the middle of the boat feels: specific force x, y, z in m/s², roll, pitch, yaw
    rate in rad/s, axes forward, starboard, down. Where the rates are means of the last step, so are the forces."""
    roll, pitch = _meant(waves)
    c_roll, s_roll, c_pitch, s_pitch = math.cos(roll), math.sin(roll), math.cos(pitch), math.sin(pitch)
    turn_radps = hull.turn_radps
    forward, starboard = hull.surge_mps2, hull.sway_mps2
    felt_mps2 = gravity_mps2 - waves.heave_mps2
    z = s_pitch * forward - c_pitch * felt_mps2
    return (
        c_pitch * forward + s_pitch * felt_mps2,
        c_roll * starboard + s_roll * z,
        c_roll * z - s_roll * starboard,
        waves.roll_rate_radps - turn_radps * s_pitch,
        waves.pitch_rate_radps * c_roll + turn_radps * s_roll * c_pitch,
        turn_radps * c_roll * c_pitch - waves.pitch_rate_radps * s_roll,
    )


def _meant(waves: Waves) -> tuple[float, float]:
    """Roll and pitch that the boat had with its rates and accelerations: in the middle of the last step, or now."""
    return (
        waves.roll_rad - waves.half_step_s * waves.roll_rate_radps,
        waves.pitch_rad - waves.half_step_s * waves.pitch_rate_radps,
    )


def imu_errors(
    aboard: Aboard | None, name: str, home: HomeConfig, epoch_unix_ns: int, dt_s: float, seed: int
) -> ImuErrors | None:
    """The errors of the inertial sensor `name`; None where it has none."""
    if aboard is None:
        return None
    field = current_field(aboard, name, home, epoch_unix_ns, seed)
    return ImuErrors(aboard, field, north_of(home, epoch_unix_ns), name, dt_s, seed)


class StrapdownMean:
    """What a sensor sends that integrates, as an MTi does: the constant forces and rates that turn it, and change its
    velocity, by as much as those since the last time have. Remembers both sums, in the axes of the last time.

    Source: Bortz (1971), *A new mathematical formulation for strapdown inertial navigation*, to the second order.
    """

    def __init__(self, dt_s: float) -> None:
        self._dt_s = dt_s
        self._turned: _Vector = (0.0, 0.0, 0.0)  # rad
        self._gained: _Vector = (0.0, 0.0, 0.0)  # m/s
        self._newest: ImuSample = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        self._count = 0

    def take(self, sample: ImuSample) -> None:
        """Add a sample: means of the last step."""
        dt_s, turned, self._newest = self._dt_s, self._turned, sample
        self._count += 1
        step = sample[3] * dt_s, sample[4] * dt_s, sample[5] * dt_s
        middle = turned[0] + 0.5 * step[0], turned[1] + 0.5 * step[1], turned[2] + 0.5 * step[2]
        gain = sample[0] * dt_s, sample[1] * dt_s, sample[2] * dt_s
        once = _cross(middle, gain)
        self._gained = _sum(_sum(self._gained, gain), once, _cross(middle, once), 0.5)
        once = _cross(turned, step)
        self._turned = _sum(_sum(turned, step), once, _cross(turned, once), 1.0 / 6.0, 0.5)

    def taken(self) -> ImuSample:
        """The sample since the last time; the sums begin again."""
        if self._count == 1:
            self._begin()
            return self._newest
        time_s, turned, gained = self._count * self._dt_s, self._turned, self._gained
        self._begin()
        once = _cross(turned, gained)
        x, y, z = _sum(gained, once, _cross(turned, once), -1.0 / 6.0, -0.5)
        p, q, r = turned
        values = (x / time_s, y / time_s, z / time_s, p / time_s, q / time_s, r / time_s)
        return *values, *self._newest[6:]

    def _begin(self) -> None:
        self._count, self._turned, self._gained = 0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)


def _cross(a: _Vector, b: _Vector) -> _Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _sum(a: _Vector, b: _Vector, c: _Vector = (0.0, 0.0, 0.0), share: float = 0.0, of_both: float = 1.0) -> _Vector:
    """a + of_both · (b + share · c)."""
    x, y, z = b[0] + share * c[0], b[1] + share * c[1], b[2] + share * c[2]
    return a[0] + of_both * x, a[1] + of_both * y, a[2] + of_both * z


class ImuModel:
    """An inertial sensor with its own attitude filter, axes forward, starboard, down. Remembers its biases."""

    def __init__(
        self, config: SensorConfig, home: HomeConfig, dt_s: float, seed: int, errors: ImuErrors | None = None
    ) -> None:
        """`dt_s`: between two samples; `errors`: of its axes and of where it stands, None for none."""
        self._config, self._more = config, errors
        self._lever = bool(config.x_m or config.y_m or config.z_m)
        self._gravity_mps2 = gravity_mps2(home.lat_deg)
        self._slow_s = _SLOW_EVERY * dt_s
        self._dt_s = dt_s
        self._samples = 0
        self._normals = Normals(stream(seed, f"{config.name} white"))
        rng = Normals(stream(seed, f"{config.name} biases"))
        biases = [(ACCEL_BIAS_MPS2, BIAS_TAU_S)] * 3 + [(GYRO_BIAS_RADPS, BIAS_TAU_S)] * 3
        attitude = [(_TILT_RAD, _TILT_TAU_S)] * 2 + [(YAW_RAD, YAW_TAU_S)]
        self._slow = [GaussMarkov(rng, sigma, tau_s) for sigma, tau_s in biases + attitude]
        self._errors = tuple(process.value for process in self._slow)
        self._yaw = self._yaw_error(seed)
        self._rates: tuple[float, float, float] | None = None

    @property
    def biases(self) -> tuple[float, ...]:
        """Three of specific force in m/s², three of rate in rad/s: what an estimator should find."""
        return self._errors[:6]

    def sample(self, hull: Hull, waves: Waves) -> ImuSample:
        """(x, y, z specific force in m/s²; roll, pitch, yaw rate in rad/s; roll, pitch, yaw in rad)."""
        self._samples += 1
        if self._samples % _SLOW_EVERY == 0:
            self._errors = tuple([process.update(self._slow_s) for process in self._slow])
            if self._yaw is not None:
                self._yaw.lead_to(self._errors[8], self._slow_s)
        x, y, z, p, q, r = true_imu(self._gravity_mps2, hull, waves)
        if self._lever:
            dx, dy, dz = self._lever_arm(p, q, r)
            x, y, z = x + dx, y + dy, z + dz
        ex, ey, ez, ep, eq, er, e_roll, e_pitch, e_yaw = self._errors
        if self._yaw is not None:
            e_yaw = self._yaw.update(self._dt_s)
        normals = self._normals
        wx, wy = normals.pair()
        wz, wp = normals.pair()
        wq, wr = normals.pair()
        sample = (
            x + ex + ACCEL_WHITE_MPS2 * wx,
            y + ey + ACCEL_WHITE_MPS2 * wy,
            z + ez + ACCEL_WHITE_MPS2 * wz,
            p + ep + GYRO_WHITE_RADPS * wp,
            q + eq + GYRO_WHITE_RADPS * wq,
            r + er + GYRO_WHITE_RADPS * wr,
            waves.roll_rad + e_roll,
            waves.pitch_rad + e_pitch,
            wrap_pi(hull.yaw_rad - self._config.heading_offset_rad + e_yaw),
        )
        return sample if self._more is None else self._more.told(sample, hull.yaw_rad)

    def _yaw_error(self, seed: int) -> Bridge | None:
        """The slow error of yaw from sample to sample, where yaw serves as a compass: a filter that looked at each
        heading would see the steps of the slow errors."""
        if self._config.heading not in ("magnetic", "true"):
            return None
        rng = Normals(stream(seed, f"{self._config.name} yaw"))
        return Bridge(rng, YAW_RAD, YAW_TAU_S, self._errors[8])

    def _lever_arm(self, p: float, q: float, r: float) -> tuple[float, float, float]:
        """ω̇ × l + ω × (ω × l), with ω̇ over the last sample."""
        before, self._rates = self._rates or (p, q, r), (p, q, r)
        dp, dq, dr = ((now - then) / self._dt_s for now, then in zip((p, q, r), before, strict=True))
        x, y, z = self._config.x_m, self._config.y_m, self._config.z_m
        along = p * x + q * y + r * z
        squared = p * p + q * q + r * r
        return (
            dq * z - dr * y + p * along - squared * x,
            dr * x - dp * z + q * along - squared * y,
            dp * y - dq * x + r * along - squared * z,
        )
