"""Error-state Kalman filter of a boat: the arithmetic alone. `inertial.py` decides which measurements to fuse.

Nominal state in plain floats: position and velocity NED, attitude quaternion body → NED, biases of accelerometer and
gyro. Error state of 15, in this order: δp, δv, δθ, δa_bias, δω_bias, with δθ in NED (R = Exp(δθ) R̂). The 15×15
covariance is allocated once.

Source: Solà (2017), *Quaternion kinematics for the error-state Kalman filter*, sections 5 to 7 (global angular error).
Errata of the ReVolt thesis are corrected: the covariance is propagated with every sample, the gyro has its own noise,
the reset is P ← G P Gᵀ, and ∂ψ/∂w has its squares.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from companion.core.angles import wrap_pi
from companion.nav.lever_arms import (
    ZERO,
    Matrix,
    Quaternion,
    Vector,
    cross,
    euler_of,
    exponential,
    multiply,
    quaternion_of,
    relative,
    rotate,
    rotation,
    turned,
)

SIZE = 15
_P, _V, _TH, _AB, _WB = 0, 3, 6, 9, 12  # where each part of the error state begins
_LONGEST_STEP_S = 0.05


@dataclass(frozen=True, slots=True)
class FilterNoise:
    """Noise densities of the sensors, their biases at switch-on (one sigma), and the wander of the biases as
    first-order Gauss–Markov processes.

    The densities are those of a calibrated MEMS unit on a vibrating hull: a few times its data sheet.
    """

    accelerometer_mps2_rthz: float = 0.004
    gyro_radps_rthz: float = 2.0e-4
    accelerometer_switch_on_mps2: float = 0.05
    gyro_switch_on_radps: float = 3.5e-3
    accelerometer_bias_mps2: float = 0.01  # one sigma of the wander, steady
    accelerometer_bias_time_s: float = 600.0
    gyro_bias_radps: float = 5.0e-4
    gyro_bias_time_s: float = 1000.0


class Innovation:
    """A measurement minus its prediction: y1, y2 with their covariance s11, s12, s22, and the normalised innovation
    squared yᵀ S⁻¹ y. `size` 1: only y1 and s11 count."""

    __slots__ = ("normalised_square", "s11", "s12", "s22", "size", "y1", "y2")

    def __init__(self, size: int) -> None:
        self.size = size
        self.y1 = self.y2 = self.s11 = self.s12 = self.s22 = self.normalised_square = 0.0


def _flat(array: np.ndarray[Any, np.dtype[np.float64]]) -> memoryview[float]:
    """The array as a flat memoryview: writing through it costs a third of numpy indexing."""
    return array.data.cast("B").cast("d")


class _Rows:
    """Arrays for measurements of one size (1 or 2 scalars), allocated once."""

    def __init__(self, size: int) -> None:
        self.h = np.zeros((size, SIZE))
        self.hp = np.zeros((size, SIZE))
        self.gain = np.zeros((size, SIZE))
        self.s = np.zeros((size, size))
        self.s_inverse = np.zeros((size, size))
        self.y = np.zeros(size)
        self.h_transposed = self.h.T
        self.hp_transposed = self.hp.T
        self.h_flat = _flat(self.h)
        self.gain_flat = _flat(self.gain)
        self.s_flat = _flat(self.s)
        self.s_inverse_flat = _flat(self.s_inverse)
        self.innovation = Innovation(size)


def at_the_middle(ax: float, ay: float, az: float, wx: float, wy: float, wz: float, dt: float) -> Vector:
    """A force in body axes at the middle of a step that turns by `w` rad/s, in the axes of its begin: f + ½ dt ω × f.

    In the attitude of the begin itself a boat that rocks would feel a force half a step late, which the filter takes
    for a bias and a tilt: 0.3 m/s² and 2° in waves of 0.2 m at 50 Hz.
    """
    half = 0.5 * dt
    return ax + half * (wy * az - wz * ay), ay + half * (wz * ax - wx * az), az + half * (wx * ay - wy * ax)


class ErrorStateFilter:
    """Nominal state and covariance. Call `predict` for every IMU sample; for each measurement compute an innovation
    and, to accept it, `fuse` it at once.

    The reference point is the IMU; arguments are SI, NED or body as named. A sample is the mean of the step that it
    ends, as sensors with coning and sculling compensation give it: force and rates of one sample belong together.
    Remembers the nominal state and the covariance.
    """

    def __init__(self, gravity_mps2: float, noise: FilterNoise | None = None) -> None:
        self.noise = noise or FilterNoise()
        self.gravity_mps2 = gravity_mps2
        self.position: Vector = ZERO
        self.velocity: Vector = ZERO
        self.quaternion: Quaternion = (1.0, 0.0, 0.0, 0.0)
        self.rotation: Matrix = rotation(self.quaternion)
        self.accelerometer_bias: Vector = ZERO
        self.gyro_bias: Vector = ZERO
        self.rates: Vector = ZERO  # rad/s in body axes, bias removed
        self.covariance = np.zeros((SIZE, SIZE))
        self._transition = np.eye(SIZE)
        self._reset = np.eye(SIZE)
        self._work = np.zeros((SIZE, SIZE))
        self._noise_step = np.zeros(SIZE)
        self._noise_dt_s = -1.0
        self._single, self._pair = _Rows(1), _Rows(2)
        self._bind()

    def expect(self, noise: FilterNoise) -> None:
        """Take other noise densities from the next sample on."""
        self.noise, self._noise_dt_s = noise, -1.0

    def _bind(self) -> None:
        """Make views into the arrays."""
        self._diagonal = self.covariance.reshape(-1)[:: SIZE + 1]
        self._transition_transposed = self._transition.T
        self._reset_transposed = self._reset.T
        self._covariance_transposed = self.covariance.T
        self._f = _flat(self._transition)
        self._g = _flat(self._reset)
        self._p = _flat(self.covariance)
        self._q = _flat(self._noise_step)

    def start(self, position: Vector, velocity: Vector, attitude: Vector, sigmas: Sequence[float]) -> None:
        """Begin at a position (m), velocity (m/s) and (roll, pitch, yaw); the biases stay. `sigmas`: one for each of
        the 15 error states."""
        self.position, self.velocity = position, velocity
        self.quaternion = quaternion_of(*attitude)
        self.rotation = rotation(self.quaternion)
        self.covariance[:] = np.diag(np.square(np.asarray(sigmas, dtype=float)))

    def predict(self, force: Vector, rates: Vector, dt_s: float) -> None:
        """Propagate by one IMU sample: specific force (m/s²) and angular rate (rad/s) in body axes, means of the
        last `dt_s`."""
        ab, wb = self.accelerometer_bias, self.gyro_bias
        self.rates = wx, wy, wz = rates[0] - wb[0], rates[1] - wb[1], rates[2] - wb[2]
        ax, ay, az = force[0] - ab[0], force[1] - ab[1], force[2] - ab[2]
        if dt_s <= _LONGEST_STEP_S:
            self._step(ax, ay, az, wx, wy, wz, dt_s)
            return
        steps = math.ceil(dt_s / _LONGEST_STEP_S)
        for _ in range(steps):
            self._step(ax, ay, az, wx, wy, wz, dt_s / steps)

    def _step(self, ax: float, ay: float, az: float, wx: float, wy: float, wz: float, dt: float) -> None:
        r0, r1, r2, r3, r4, r5, r6, r7, r8 = self.rotation
        ax, ay, az = at_the_middle(ax, ay, az, wx, wy, wz, dt)
        fn, fe, fd = r0 * ax + r1 * ay + r2 * az, r3 * ax + r4 * ay + r5 * az, r6 * ax + r7 * ay + r8 * az
        self._propagate_covariance(fn, fe, fd, dt)
        down = fd + self.gravity_mps2
        vn, ve, vd = self.velocity
        pn, pe, pd = self.position
        half = 0.5 * dt * dt
        self.position = (pn + vn * dt + fn * half, pe + ve * dt + fe * half, pd + vd * dt + down * half)
        self.velocity = (vn + fn * dt, ve + fe * dt, vd + down * dt)
        self.quaternion = turned(self.quaternion, wx * dt, wy * dt, wz * dt)
        self.rotation = rotation(self.quaternion)

    def preview(self, samples: Iterable[tuple[Vector, Vector, float]]) -> tuple[Vector, Vector, Matrix, Vector]:
        """(position, velocity, rotation, rates) after further samples (force, rates, dt_s); the filter stays as it
        is."""
        p, v, _, r, w = self._ahead(samples)
        return p, v, r, w

    def carry_on(self, samples: Iterable[tuple[Vector, Vector, float]]) -> None:
        """Advance the nominal state by further samples (force, rates, dt_s); the covariance stays as it is."""
        self.position, self.velocity, self.quaternion, self.rotation, self.rates = self._ahead(samples)

    def _ahead(
        self, samples: Iterable[tuple[Vector, Vector, float]]
    ) -> tuple[Vector, Vector, Quaternion, Matrix, Vector]:
        p, v, q, r, w = self.position, self.velocity, self.quaternion, self.rotation, self.rates
        ab, wb = self.accelerometer_bias, self.gyro_bias
        for force, rates, dt in samples:
            w = wx, wy, wz = relative(rates, wb)
            ax, ay, az = relative(force, ab)
            fn, fe, fd = rotate(r, at_the_middle(ax, ay, az, wx, wy, wz, dt))
            half, down = 0.5 * dt * dt, fd + self.gravity_mps2
            p = (p[0] + v[0] * dt + fn * half, p[1] + v[1] * dt + fe * half, p[2] + v[2] * dt + down * half)
            v = (v[0] + fn * dt, v[1] + fe * dt, v[2] + down * dt)
            q = turned(q, w[0] * dt, w[1] * dt, w[2] * dt)
            r = rotation(q)
        return p, v, q, r, w

    def _propagate_covariance(self, fn: float, fe: float, fd: float, dt: float) -> None:
        """P ← F P Fᵀ + Q, with F from the attitude and the specific force (NED) of this step."""
        f, r = self._f, self.rotation
        if dt != self._noise_dt_s:
            self._set_step(dt)
        n, e, d = fn * dt, fe * dt, fd * dt  # δv̇ = −[f]× δθ − R δa_bias
        f[52], f[53], f[66], f[68], f[81], f[82] = d, -e, -d, n, e, -n  # flat: 15 · row + column
        r0, r1, r2, r3, r4, r5, r6, r7, r8 = r
        f[54] = f[102] = -r0 * dt
        f[55] = f[103] = -r1 * dt
        f[56] = f[104] = -r2 * dt
        f[69] = f[117] = -r3 * dt
        f[70] = f[118] = -r4 * dt
        f[71] = f[119] = -r5 * dt
        f[84] = f[132] = -r6 * dt
        f[85] = f[133] = -r7 * dt
        f[86] = f[134] = -r8 * dt
        self._transition.dot(self.covariance, self._work)
        self._work.dot(self._transition_transposed, self.covariance)
        self._diagonal += self._noise_step

    def _set_step(self, dt: float) -> None:
        """Set the elements of F and Q that depend on the step alone."""
        noise = self.noise
        f, q = self._f, self._q
        accelerometer_kept, gyro_kept = 1.0 - dt / noise.accelerometer_bias_time_s, 1.0 - dt / noise.gyro_bias_time_s
        f[3] = f[19] = f[35] = dt
        f[144] = f[160] = f[176] = accelerometer_kept
        f[192] = f[208] = f[224] = gyro_kept
        q[3] = q[4] = q[5] = noise.accelerometer_mps2_rthz**2 * dt
        q[6] = q[7] = q[8] = noise.gyro_radps_rthz**2 * dt
        q[9] = q[10] = q[11] = 2.0 * noise.accelerometer_bias_mps2**2 * dt / noise.accelerometer_bias_time_s
        q[12] = q[13] = q[14] = 2.0 * noise.gyro_bias_radps**2 * dt / noise.gyro_bias_time_s
        self._noise_dt_s = dt

    def position_innovation(
        self, north_m: float, east_m: float, lever_m: Vector, variance: float, lag_s: float = 0.0
    ) -> Innovation:
        """Innovation of a measured position of the point `lever_m` (body) from the IMU, `lag_s` before the state's time
        (negative: after it). `variance` in m² on each axis."""
        arm = rotate(self.rotation, lever_m)
        vn, ve, _ = self.velocity
        turn = rotate(self.rotation, cross(self.rates, lever_m)) if lag_s else ZERO
        h = self._pair.h_flat
        h[0] = h[SIZE + 1] = 1.0
        h[_V] = h[SIZE + _V + 1] = -lag_s
        self._set_arm(h, arm)
        y1 = north_m - (self.position[0] - lag_s * (vn + turn[0]) + arm[0])
        y2 = east_m - (self.position[1] - lag_s * (ve + turn[1]) + arm[1])
        return self._pair_innovation(y1, y2, variance)

    def velocity_innovation(self, north_mps: float, east_mps: float, lever_m: Vector, variance: float) -> Innovation:
        """Innovation of a measured velocity of the point `lever_m` (body) from the IMU; `variance` in (m/s)² on each
        axis."""
        arm = rotate(self.rotation, cross(self.rates, lever_m))
        h = self._pair.h_flat
        h[0] = h[SIZE + 1] = 0.0
        h[_V] = h[SIZE + _V + 1] = 1.0
        self._set_arm(h, arm)
        return self._pair_innovation(
            north_mps - self.velocity[0] - arm[0], east_mps - self.velocity[1] - arm[1], variance
        )

    @staticmethod
    def _set_arm(h: memoryview[float], arm: Vector) -> None:
        """The first two rows of −[arm]×: the effect of an attitude error on a vector fixed to the hull."""
        h[_TH + 1], h[_TH + 2] = arm[2], -arm[1]
        h[SIZE + _TH], h[SIZE + _TH + 2] = -arm[2], arm[0]

    def heading_innovation(self, yaw_rad: float, variance: float, lag_s: float = 0.0) -> Innovation:
        """Innovation, wrapped, of a measured heading `lag_s` before the state's time; `variance` in rad².

        ψ = atan2(w_e, w_n) of the body's x axis w."""
        wn, we, wd = self.rotation[0], self.rotation[3], self.rotation[6]
        level = max(wn * wn + we * we, 1e-6)
        h = self._single.h_flat
        h[0] = h[2] = h[_V + 2] = 0.0
        h[_TH], h[_TH + 1], h[_TH + 2] = -wn * wd / level, -we * wd / level, 1.0
        return self._single_innovation(wrap_pi(yaw_rad - math.atan2(we, wn) + lag_s * self.rates[2]), variance)

    def fuse_down(self, position_m: float, position_variance: float, velocity_variance: float) -> None:
        """A boat stays on the water: fuse `position_m` as down position and 0 as down velocity, with large variances
        (m², (m/s)²)."""
        h = self._single.h_flat
        h[_TH] = h[_TH + 1] = h[_TH + 2] = h[_V + 2] = 0.0
        h[2] = 1.0
        self.fuse(self._single_innovation(position_m - self.position[2], position_variance))
        h[2] = 0.0
        h[_V + 2] = 1.0
        self.fuse(self._single_innovation(-self.velocity[2], velocity_variance))
        h[_V + 2] = 0.0

    def _pair_innovation(self, y1: float, y2: float, variance: float) -> Innovation:
        rows, found = self._pair, self._pair.innovation
        rows.h.dot(self.covariance, rows.hp)
        rows.hp.dot(rows.h_transposed, rows.s)
        s = rows.s_flat
        found.y1, found.y2 = y1, y2
        found.s11, found.s12, found.s22 = s[0] + variance, 0.5 * (s[1] + s[2]), s[3] + variance
        determinant = found.s11 * found.s22 - found.s12 * found.s12
        found.normalised_square = (found.s22 * y1 * y1 - 2.0 * found.s12 * y1 * y2 + found.s11 * y2 * y2) / determinant
        return found

    def _single_innovation(self, y: float, variance: float) -> Innovation:
        rows, found = self._single, self._single.innovation
        rows.h.dot(self.covariance, rows.hp)
        rows.hp.dot(rows.h_transposed, rows.s)
        found.y1, found.s11 = y, rows.s_flat[0] + variance
        found.normalised_square = y * y / found.s11
        return found

    def fuse(self, innovation: Innovation) -> None:
        """Fuse the innovation that was computed last: P ← P − P Hᵀ S⁻¹ H P (symmetric by form), then inject the
        error."""
        if innovation.size == 1:
            rows = self._single
            np.multiply(rows.hp, 1.0 / innovation.s11, rows.gain)
            y = innovation.y1
            correction = [gain * y for gain in rows.gain_flat]
        else:
            rows = self._pair
            determinant = innovation.s11 * innovation.s22 - innovation.s12 * innovation.s12
            inverse = rows.s_inverse_flat
            inverse[0], inverse[3] = innovation.s22 / determinant, innovation.s11 / determinant
            inverse[1] = inverse[2] = -innovation.s12 / determinant
            rows.s_inverse.dot(rows.hp, rows.gain)
            rows.y[0], rows.y[1] = innovation.y1, innovation.y2
            correction = rows.y.dot(rows.gain).tolist()
        rows.hp_transposed.dot(rows.gain, self._work)
        self.covariance -= self._work
        self._inject(correction)

    def _inject(self, c: list[float]) -> None:
        """Add the error state `c` to the nominal state and reset it: P ← G P Gᵀ, made exactly symmetric."""
        p, v, a, w = self.position, self.velocity, self.accelerometer_bias, self.gyro_bias
        self.position = (p[0] + c[0], p[1] + c[1], p[2] + c[2])
        self.velocity = (v[0] + c[3], v[1] + c[4], v[2] + c[5])
        self.accelerometer_bias = (a[0] + c[9], a[1] + c[10], a[2] + c[11])
        self.gyro_bias = (w[0] + c[12], w[1] + c[13], w[2] + c[14])
        self.rates = (self.rates[0] - c[12], self.rates[1] - c[13], self.rates[2] - c[14])
        x, y, z = c[6], c[7], c[8]
        self.quaternion = multiply(exponential(x, y, z), self.quaternion)
        self.rotation = rotation(self.quaternion)
        g = self._g  # I + ½ [δθ]×
        g[97], g[98], g[111], g[113], g[126], g[127] = -0.5 * z, 0.5 * y, 0.5 * z, -0.5 * x, -0.5 * y, 0.5 * x
        self._reset.dot(self.covariance, self._work)
        self._work.dot(self._reset_transposed, self.covariance)
        np.add(self.covariance, self._covariance_transposed, self._work)
        np.multiply(self._work, 0.5, self.covariance)

    def reset_position(
        self, north_m: float, east_m: float, lever_m: Vector, variance: float, velocity_variance: float
    ) -> None:
        """Restart the position at a measured one (m, `variance` m²); the velocity stays, with `velocity_variance`
        added."""
        arm = rotate(self.rotation, lever_m)
        self.position = (north_m - arm[0], east_m - arm[1], self.position[2])
        self._forget((_P, _P + 1), variance)
        self.inflate((_V, _V + 1), velocity_variance)

    def reset_velocity(self, north_mps: float, east_mps: float, lever_m: Vector, variance: float) -> None:
        """Restart the velocity at a measured one (m/s, `variance` (m/s)²)."""
        arm = rotate(self.rotation, cross(self.rates, lever_m))
        self.velocity = (north_mps - arm[0], east_mps - arm[1], self.velocity[2])
        self._forget((_V, _V + 1), variance)

    def reset_heading(self, yaw_rad: float, variance: float) -> None:
        """Restart the heading at a measured one (`variance` rad²); roll and pitch stay."""
        roll, pitch, _ = self.euler()
        self.quaternion = quaternion_of(roll, pitch, yaw_rad)
        self.rotation = rotation(self.quaternion)
        self._forget((_TH + 2,), variance)

    def _forget(self, states: Sequence[int], variance: float) -> None:
        for i in states:
            self.covariance[i, :] = 0.0
            self.covariance[:, i] = 0.0
            self.covariance[i, i] = variance

    def inflate(self, states: Sequence[int], variance: float) -> None:
        """Add `variance` to single error states."""
        for i in states:
            self.covariance[i, i] += variance

    def inflate_position(self, variance: float) -> None:
        """Add variance (m²) to the horizontal position, for example when the type of fix changes."""
        self.inflate((_P, _P + 1), variance)

    def inflate_heading(self, variance: float) -> None:
        """Add variance (rad²) to the heading, for example when another source takes over."""
        self.inflate((_TH + 2,), variance)

    def euler(self) -> Vector:
        """(roll, pitch, yaw) in radians."""
        return euler_of(self.rotation)

    def sigmas(self) -> tuple[float, float, float]:
        """One sigma of horizontal position (m), horizontal velocity (m/s) and heading (rad)."""
        p = self._p
        return (
            math.sqrt(max(0.5 * (p[0] + p[SIZE + 1]), 0.0)),
            math.sqrt(max(0.5 * (p[48] + p[64]), 0.0)),
            math.sqrt(max(p[128], 0.0)),
        )

    def velocity_sigmas(self) -> tuple[float, float]:
        """One sigma of the horizontal velocity, and of the acceleration that tilt and bias leave in it: of the worse
        axis."""
        p, g, r = self._p, self.gravity_mps2, self.rotation
        worst = 0.0
        for tilt, sign, row in ((_TH + 1, -g, r[0:3]), (_TH, g, r[3:6])):  # δv̇ = −[f]× δθ − R δa_bias, f ≈ (0, 0, −g)
            h = ((tilt, sign), *((_AB + i, -row[i]) for i in range(3)))
            worst = max(worst, sum(a * b * p[SIZE * i + j] for i, a in h for j, b in h))
        return math.sqrt(max(p[48], p[64], 0.0)), math.sqrt(worst)

    def bias_sigmas(self) -> tuple[float, float]:
        """One sigma of the accelerometer's bias (m/s²) on the worse of the level axes, and of the gyro's (rad/s) about
        the worse of them."""
        variances = self._diagonal
        return (
            math.sqrt(max(variances[_AB], variances[_AB + 1], 0.0)),
            math.sqrt(max(variances[_WB], variances[_WB + 1], 0.0)),
        )

    def healthy(self) -> bool:
        """False if a number is not finite: the filter must restart."""
        sums = self._p[0] + self._p[48] + self._p[96] + self._p[128]
        return all(map(math.isfinite, (sums, *self.position, *self.velocity, *self.quaternion)))
