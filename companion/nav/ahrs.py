"""Attitude and heading from gyro, accelerometer and magnetometer, aided by the receiver's velocity: a quaternion Kalman
filter.

State: attitude quaternion body → true NED (q̇ = ½ S(ω) q) and gyro bias. Error state of 6: δθ in NED (R = Exp(δθ) R̂),
whose third component is the yaw error whatever the tilt, and δb. The covariance is the upper triangle of a 6×6 in plain
floats: unrolled, it costs less than numpy.

The RescueRunner thesis (Hallhagen & Persson 2016, section 3.6; `companion/baselines/ahrs.py`) takes the specific force
as vertical whenever its length is about g. That holds in a turn of 0.3 g too: the tilt follows the apparent vertical,
and where the field dips by 70° each degree of tilt error turns the heading by up to 3°. This filter compares the
integral of the specific force over half a second with the change of the velocity over ground, so that centripetal and
other lasting accelerations drop out. Without velocities it uses gravity as the vertical, behind a gate. The
magnetometer corrects yaw and gyro bias only (section 3.6.3), weighted by the uncertainty of the tilt.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.core.angles import wrap_pi
from companion.nav.levelling import TILT_SIGMA_RAD, averaged, swung, tilt_by, unfelt_tilt_rad
from companion.nav.lever_arms import (
    ZERO,
    Matrix,
    Quaternion,
    Vector,
    euler_of,
    exponential,
    multiply,
    quaternion_of,
    relative,
    rotate,
    rotation,
    turned,
    velocity_ned,
)

_SPEED_AGE_S = 2.0  # how long a speed over ground counts for the start
_GAP_S = 0.5  # after a longer gap the turn in between is unknown: start again, keeping bias and correction
_LEVELLING_S = 1.0
_LEVELLING_MOST_S = 5.0  # of the mean force: over a longer time the gyro's bias carries it away
_TILT_SIGMA_RAD, _YAW_SIGMA_RAD = math.radians(5.0), math.radians(10.0)
_WINDOW_S, _LONGEST_WINDOW_S = 0.45, 1.5  # between two velocities that are compared
_VELOCITY_FLOOR_MPS = 0.06  # whatever accuracy the receiver claims: it filters, and its velocities lag
_GRAVITY_PERIOD_S = 0.1
_GRAVITY_AFTER_S = 1.5  # without a velocity
_GRAVITY_SHARE = 0.05  # of g, by which the length of the specific force may differ from it
_GRAVITY_RATE_RADPS = math.radians(4.0)
_GRAVITY_SIGMA_MPS2 = 1.5  # in waves, and ten times a second
_WINDOW_CHI_SQUARE = 8.0  # of both axes together, over the sum of their variances
_REJECTIONS = 10  # in a row, after which the tilt is wrong rather than the velocities
_RATES_TIME_S = 0.05
_TILT_SAMPLES = 50.0  # of the magnetometer that share one tilt error: averaging does not remove it
_FIELD_CHI_SQUARE = 16.0
_FIELD_REJECTED_S = 5.0  # after that long the heading is wrong rather than the field
_DIP_LIMIT = 8.0  # tangent of the dip, 82.9°: nearer to the poles each degree of tilt turns the heading by more than 8°
_DIP_TIME_S = 5.0  # time constant of the mean field that is compared with that
_FIELD_SHARE = 0.2  # by which the field's strength may differ from its mean
_FIELD_TIME_S = 60.0  # time constant of that mean

# Indices of the rows of a symmetric 6×6 in its upper triangle, row by row.
_ROWS = (
    (0, 1, 2, 3, 4, 5),
    (1, 6, 7, 8, 9, 10),
    (2, 7, 11, 12, 13, 14),
    (3, 8, 12, 15, 16, 17),
    (4, 9, 13, 16, 18, 19),
    (5, 10, 14, 17, 19, 20),
)
_DIAGONAL = (0, 6, 11, 15, 18, 20)


def is_too_steep(level: float, down: float) -> bool:
    """Whether a field of that horizontal and vertical part, any unit, dips so much that it tells no heading."""
    return level * _DIP_LIMIT < abs(down)


@dataclass(frozen=True, slots=True)
class AhrsNoise:
    """Noise of the sensors, one sigma each. `field_rad`: heading error of one magnetometer sample, with the residual
    deviation in waves. `force_mps2`: error of the mean specific force over a window, with its bias. `start_rad`: of the
    heading at the start."""

    gyro_radps_rthz: float = 5.0e-4
    gyro_switch_on_radps: float = 5.0e-3
    gyro_wander_radps_rts: float = 2.0e-5
    field_rad: float = math.radians(3.0)
    force_mps2: float = 0.06
    start_rad: float = _YAW_SIGMA_RAD


class Ahrs:
    """Call `sample` for every inertial sample, `magnetic` and `velocity` as they arrive, in order of time. Results:
    `attitude`, `rates`, `yaw_sigma_rad`.

    It starts by itself after a second of samples with a magnetic field; under way the tilt, and with it the heading by
    the field, is less sure then. Remembers quaternion, bias, covariance, the speed over ground, and the window since
    the last velocity that was used.
    """

    def __init__(self, gravity_mps2: float, noise: AhrsNoise | None = None, levelling_s: float = _LEVELLING_S) -> None:
        """`levelling_s`: over which the force is averaged before the start."""
        self._levelling_s = levelling_s
        self._gravity_mps2 = gravity_mps2
        self._noise = noise or AhrsNoise()
        self.running = False
        self.quaternion: Quaternion = (1.0, 0.0, 0.0, 0.0)
        self.rotation: Matrix = rotation(self.quaternion)
        self.gyro_bias: Vector = ZERO
        self.rates: Vector = ZERO  # body, bias removed, smoothed
        self._last_rates: Vector = ZERO
        self.covariance: list[float] = [0.0] * 21  # upper triangle
        self._t_s = -math.inf
        self._since_s = math.inf
        self._mean: Vector = ZERO
        self._mean_turn_radps = 0.0
        self._speed_mps, self._speed_s = 0.0, -math.inf
        self.steep_rad: float | None = None  # by how much the field dips, where that is too much
        self._dip, self._dip_s = (0.0, 0.0), -math.inf  # horizontal and vertical part of the mean field
        self._strength = 0.0
        self._strength_s = -math.inf
        self._turned_rad = 0.0
        # integral of the specific force in NED, and its duration, since the velocity in `_before`
        self._sum_n = self._sum_e = self._sum_d = self._sum_s = 0.0
        self._before: tuple[float, float, float] | None = None  # (time, north, east) of a velocity
        self._velocity_s = -math.inf
        self._field_s = -math.inf
        self._rejections = 0

    @property
    def attitude(self) -> Vector:
        """(roll, pitch, yaw) in rad, yaw from true north."""
        return euler_of(self.rotation)

    @property
    def yaw_sigma_rad(self) -> float:
        """One sigma of yaw by the filter's covariance, without the magnetometer's deviation; π before the start."""
        return math.sqrt(max(self.covariance[11], 0.0)) if self.running else math.pi

    # --- prediction ------------------------------------------------------------------------------------------------

    def sample(self, t_s: float, force: Vector, rates: Vector) -> None:
        """Specific force in m/s² and angular rate in rad/s, in body axes, at `t_s`. A sample that is not newer than the
        last is ignored."""
        dt = t_s - self._t_s
        if dt <= 0.0:
            return
        self._t_s = t_s
        if dt > _GAP_S:
            self.running = False
        if not self.running:
            self._last_rates = rates
            self._level(t_s, dt, force, rates)
            return
        bx, by, bz = self.gyro_bias
        lp, lq, lr = self._last_rates
        p, q, r = 0.5 * (rates[0] + lp) - bx, 0.5 * (rates[1] + lq) - by, 0.5 * (rates[2] + lr) - bz
        self._last_rates = rates
        share = min(dt / _RATES_TIME_S, 1.0)
        sp, sq, sr = self.rates
        self.rates = (sp + share * (p - sp), sq + share * (q - sq), sr + share * (r - sr))
        self._propagate(dt)
        self.quaternion = turned(self.quaternion, p * dt, q * dt, r * dt)
        self.rotation = matrix = rotation(self.quaternion)
        n, e, d = rotate(matrix, force)
        self._sum_n += n * dt
        self._sum_e += e * dt
        self._sum_d += d * dt
        self._sum_s += dt
        if t_s - self._velocity_s > _GRAVITY_AFTER_S:
            self._before = None
            if self._sum_s >= _GRAVITY_PERIOD_S:
                self._fuse_gravity()

    def _level(self, t_s: float, dt: float, force: Vector, rates: Vector) -> None:
        """Average the specific force, in the axes of now, and the rate of turn before the start."""
        if dt > _GAP_S:
            self._since_s, self._mean, self._mean_turn_radps, dt = t_s, force, rates[2], 0.0
        passed_s = min(max(t_s - self._since_s, 0.0), _LEVELLING_MOST_S)
        share = 1.0 / (1.0 + passed_s / max(dt, 1e-3))
        self._mean = averaged(swung(self._mean, relative(rates, self.gyro_bias), dt), force, share)
        self._mean_turn_radps += share * (rates[2] - self._mean_turn_radps)

    def _propagate(self, dt: float) -> None:
        """P ← F P Fᵀ + Q with F = [[1, −R dt], [0, 1]], block by block: B′ = B − R C dt, A′ = A − R dt Bᵀ − B′ (R
        dt)ᵀ."""
        a00, a01, a02, b00, b01, b02, a11, a12, b10, b11, b12, a22, b20, b21, b22, c00, c01, c02, c11, c12, c22 = (
            self.covariance
        )
        r00, r01, r02, r10, r11, r12, r20, r21, r22 = [dt * part for part in self.rotation]
        n00, n01, n02 = (
            b00 - r00 * c00 - r01 * c01 - r02 * c02,
            b01 - r00 * c01 - r01 * c11 - r02 * c12,
            b02 - r00 * c02 - r01 * c12 - r02 * c22,
        )
        n10, n11, n12 = (
            b10 - r10 * c00 - r11 * c01 - r12 * c02,
            b11 - r10 * c01 - r11 * c11 - r12 * c12,
            b12 - r10 * c02 - r11 * c12 - r12 * c22,
        )
        n20, n21, n22 = (
            b20 - r20 * c00 - r21 * c01 - r22 * c02,
            b21 - r20 * c01 - r21 * c11 - r22 * c12,
            b22 - r20 * c02 - r21 * c12 - r22 * c22,
        )
        noise = self._noise
        white, wander = noise.gyro_radps_rthz**2 * dt, noise.gyro_wander_radps_rts**2 * dt
        # fmt: off
        self.covariance = [
            a00 - r00 * (b00 + n00) - r01 * (b01 + n01) - r02 * (b02 + n02) + white,
            a01 - r00 * b10 - r01 * b11 - r02 * b12 - n00 * r10 - n01 * r11 - n02 * r12,
            a02 - r00 * b20 - r01 * b21 - r02 * b22 - n00 * r20 - n01 * r21 - n02 * r22,
            n00, n01, n02,
            a11 - r10 * (b10 + n10) - r11 * (b11 + n11) - r12 * (b12 + n12) + white,
            a12 - r10 * b20 - r11 * b21 - r12 * b22 - n10 * r20 - n11 * r21 - n12 * r22,
            n10, n11, n12,
            a22 - r20 * (b20 + n20) - r21 * (b21 + n21) - r22 * (b22 + n22) + white,
            n20, n21, n22,
            c00 + wander, c01, c02, c11 + wander, c12, c22 + wander,
        ]
        # fmt: on

    # --- measurements ----------------------------------------------------------------------------------------------

    def magnetic(self, t_s: float, field: Vector, declination_rad: float) -> bool:
        """Calibrated field in body axes, any unit. Its horizontal part corrects yaw; the first field after levelling
        starts the filter. Returns whether it counts."""
        if not self.running:
            return self._start(field, declination_rad)
        if not self._steady(t_s, math.hypot(*field)):
            return False
        north, east, down = rotate(self.rotation, field)
        if self._is_steep(t_s, north, east, down):
            return False
        level = math.hypot(north, east)
        p = self.covariance
        tilt_share = _TILT_SAMPLES * (down / level) ** 2 * 0.5 * (p[0] + p[6])
        innovation = wrap_pi(declination_rad + self._turned_rad - math.atan2(east, north))
        variance = self._noise.field_rad**2 + tilt_share
        if innovation * innovation <= _FIELD_CHI_SQUARE * (p[11] + variance):
            self._field_s = t_s
        elif t_s - self._field_s <= _FIELD_REJECTED_S:
            return False
        else:
            p[11] += _YAW_SIGMA_RAD**2
        self._fuse((0.0, 0.0, 1.0), innovation, variance, tilt=False)
        return True

    def _is_steep(self, t_s: float, north: float, east: float, down: float) -> bool:
        """Whether the field is too steep, or was in the mean of some seconds: near the limit waves make single ones
        look usable, by what their tilt is off."""
        share = 1.0 - math.exp(min(self._dip_s - t_s, 0.0) / _DIP_TIME_S)
        level, depth = self._dip
        self._dip = level, depth = (
            level + share * (math.hypot(north, east) - level),
            depth + share * (abs(down) - depth),
        )
        self._dip_s = t_s
        self.steep_rad = math.atan2(depth, level) if is_too_steep(level, depth) else None
        return self.steep_rad is not None or is_too_steep(math.hypot(north, east), down)

    def _steady(self, t_s: float, strength: float) -> bool:
        """Whether the field is about as strong as usual; passing steel changes it."""
        usual, gap_s = self._strength, t_s - self._strength_s
        self._strength_s = t_s
        if strength <= 0.0:
            return False
        self._strength += min(gap_s / _FIELD_TIME_S, 1.0) * (strength - usual)
        return abs(strength - usual) <= _FIELD_SHARE * usual

    def velocity(self, t_s: float, north_mps: float, east_mps: float, sigma_mps: float, lever_m: Vector = ZERO) -> None:
        """Velocity over ground of a point `lever_m` (body axes) from the inertial sensor; `sigma_mps` on each axis."""
        if t_s > self._speed_s:
            self._speed_mps, self._speed_s = math.hypot(north_mps, east_mps), t_s
        if not self.running or not t_s > self._velocity_s:
            return
        swing = velocity_ned(self.rotation, self.rates, lever_m)
        north, east = north_mps - swing[0], east_mps - swing[1]
        self._velocity_s = t_s
        before = self._before
        if before is not None and t_s - before[0] < _WINDOW_S:
            return
        if before is not None and t_s - before[0] <= _LONGEST_WINDOW_S and abs(self._sum_s - (t_s - before[0])) < 0.1:
            scale = (t_s - before[0]) / self._sum_s
            noise = 2.0 * max(sigma_mps, _VELOCITY_FLOOR_MPS) ** 2 + (self._noise.force_mps2 * self._sum_s) ** 2
            self._compare((north - before[1]) / scale, (east - before[2]) / scale, noise)
        self._before = (t_s, north, east)
        self._clear_sums()

    def _clear_sums(self) -> None:
        self._sum_n = self._sum_e = self._sum_d = self._sum_s = 0.0

    def _compare(self, north_mps: float, east_mps: float, variance: float) -> None:
        """Fuse the change of velocity against the integral of f̂: the true force is f̂ + δθ × f̂."""
        n, e, d = self._sum_n, self._sum_e, self._sum_d
        rows = (((0.0, d, -e), north_mps - n), ((-d, 0.0, n), east_mps - e))
        expected = sum(self._variance_of(h) + variance for h, _ in rows)
        outlier = sum(y * y for _, y in rows) > _WINDOW_CHI_SQUARE * expected
        if outlier and self._rejections < _REJECTIONS:
            self._rejections += 1
            return
        if outlier:
            for at in (0, 6, 11):
                self.covariance[at] += _TILT_SIGMA_RAD**2
        self._rejections = 0
        self._fuse(*rows[0], variance)
        n, e, d = self._sum_n, self._sum_e, self._sum_d  # rotated by the correction of the first axis
        self._fuse((-d, 0.0, n), east_mps - e, variance)

    def _fuse_gravity(self) -> None:
        """Without velocities: take the mean force of a tenth of a second as the vertical, if its length is about g and
        the boat does not turn."""
        n, e, d = (part / self._sum_s for part in (self._sum_n, self._sum_e, self._sum_d))
        self._clear_sums()
        turns = abs(self.rates[2]) > _GRAVITY_RATE_RADPS  # then an unknown centripetal force adds to gravity
        length = math.sqrt(n * n + e * e + d * d)
        if not turns and abs(length - self._gravity_mps2) <= _GRAVITY_SHARE * self._gravity_mps2:
            self._fuse((0.0, d, 0.0), -n, _GRAVITY_SIGMA_MPS2**2)
            self._fuse((-d, 0.0, 0.0), -e, _GRAVITY_SIGMA_MPS2**2)

    def _variance_of(self, h: Vector) -> float:
        p, (x, y, z) = self.covariance, h
        return x * (x * p[0] + 2.0 * (y * p[1] + z * p[2])) + y * (y * p[6] + 2.0 * z * p[7]) + z * z * p[11]

    def _fuse(self, h: Vector, innovation: float, variance: float, tilt: bool = True) -> None:
        """Fuse one scalar with the measurement row (h, 0, 0, 0). Without `tilt`, roll and pitch stay as they are;
        Joseph's form keeps the covariance correct then."""
        p, (x, y, z) = self.covariance, h
        g = [x * p[i] + y * p[j] + z * p[k] for i, j, k in zip(*_ROWS[:3], strict=True)]
        s = x * g[0] + y * g[1] + z * g[2] + variance
        k = [part / s for part in g]
        if not tilt:
            k[0] = k[1] = 0.0
        at = 0
        for i in range(6):
            gi, ki = g[i], k[i]
            more = ki * s - gi
            for j in range(i, 6):
                p[at] += more * k[j] - ki * g[j]
                at += 1
        self._inject([part * innovation for part in k])

    def _inject(self, error: list[float]) -> None:
        x, y, z = error[:3]
        small = multiply(exponential(x, y, z), self.quaternion)
        self.quaternion = turned(small, 0.0, 0.0, 0.0)
        self.rotation = rotation(self.quaternion)
        bx, by, bz = self.gyro_bias
        self.gyro_bias = (bx + error[3], by + error[4], bz + error[5])
        n, e, d = self._sum_n, self._sum_e, self._sum_d
        self._sum_n, self._sum_e, self._sum_d = n + y * d - z * e, e + z * n - x * d, d + x * e - y * n

    def turn(self, angle_rad: float) -> None:
        """Add `angle_rad` to the heading and to all later magnetometer headings: the magnetometer is off by that."""
        self._turned_rad = wrap_pi(self._turned_rad + angle_rad)
        self._inject([0.0, 0.0, angle_rad, 0.0, 0.0, 0.0])

    def _start(self, field: Vector, declination_rad: float) -> bool:
        """Start, if the boat is levelled and the field is one that will be used from then on, too."""
        if not self._t_s - self._since_s >= self._levelling_s:
            return False
        speed_mps = self._speed_mps if self._t_s - self._speed_s <= _SPEED_AGE_S else 0.0
        unfelt_rad = unfelt_tilt_rad(speed_mps, self._mean_turn_radps)
        roll, pitch = tilt_by(self._mean, speed_mps * self._mean_turn_radps if unfelt_rad else 0.0)
        north, east, down = rotate(rotation(quaternion_of(roll, pitch, 0.0)), field)
        if self._is_steep(self._t_s, north, east, down):
            return False
        dip = abs(down) / max(math.hypot(north, east), 1e-9)
        tilt_sigma_rad = math.hypot(_TILT_SIGMA_RAD, unfelt_rad)
        yaw_sigma_rad = max(math.hypot(self._noise.start_rad, dip * unfelt_rad), dip * TILT_SIGMA_RAD)
        self.quaternion = quaternion_of(roll, pitch, declination_rad + self._turned_rad - math.atan2(east, north))
        self.rotation = rotation(self.quaternion)
        self.covariance = [0.0] * 21
        bias = self._noise.gyro_switch_on_radps
        for at, sigma in zip(_DIAGONAL, (tilt_sigma_rad, tilt_sigma_rad, yaw_sigma_rad, bias, bias, bias), strict=True):
            self.covariance[at] = sigma * sigma
        self._strength = math.hypot(*field)
        self._field_s = self._t_s
        self.running = True
        self._before = None
        self._clear_sums()
        return True
