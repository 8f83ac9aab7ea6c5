"""Error-state Kalman filter of a boat: the arithmetic alone. `inertial.py` decides which measurements to fuse.

Nominal state in plain floats: position and velocity NED, attitude quaternion body → NED, biases of accelerometer and
gyro, and what measurements are off by: the slow error (wander) of positions in north and east and of headings, and by
how much the values of the receiver in use are later than their times. Error state of 19, in this order: δp, δv, δθ,
δa_bias, δω_bias, δwander (north, east, heading), δlatency, with δθ in NED (R = Exp(δθ) R̂). The covariance is allocated
once.

A receiver's slow error is a first-order Gauss–Markov process, measured = true + wander + noise. As a state it tells the
filter what averaging can remove and what not: the covariance is that of the errors. So does the latency, a constant:
late values are those of a boat that was elsewhere, slower and on another heading (Skog & Händel 2011, *Time
synchronization errors in loosely coupled GPS-aided inertial navigation systems*).

Source: Solà (2017), *Quaternion kinematics for the error-state Kalman filter*, sections 5 to 7 (global angular error);
Bar-Shalom, Li & Kirubarajan (2001), *Estimation with Applications to Tracking and Navigation*, 8.2 (coloured noise by a
larger state). Errata of the ReVolt thesis are corrected: the covariance is propagated with every sample, the gyro has
its own noise, the reset is P ← G P Gᵀ, and ∂ψ/∂w has its squares.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

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
from companion.nav.matrix_in_place import Array, Flat, add_to_diagonal, flat, subtract, symmetrise
from companion.nav.measured_off import MeasuredOff, Wander

SIZE = 19
_P, _V, _TH, _AB, _WB, _W, _WH, _L = 0, 3, 6, 9, 12, 15, 17, 18  # where each part of the error state begins
_MOTION = 15  # states of motion and inertial sensor; what measurements are off by comes after them
_LONGEST_STEP_S = 0.05
_LARGE_TURN_RAD = 1e-3  # of an injected error: a smaller one changes no variance by a thousandth
_MEAN_S = 0.15  # of the acceleration that late velocities lack: half of a long latency
_LATE_WALK_S_RTS = 5e-4  # s/√s: 4 ms in a minute, since no latency is quite constant
_TELLS_MPS, _TELLS_MPS2 = 0.1, 0.05  # a latency shows in no less: below, the estimate's own noise seems to tell it
_UNSURE_SAMPLES = 300.0  # of a receiver that may be late without a state for it: a constant error of all of them
_LAG_TELLS = 0.03  # s, s²/2: below, a lag tells nothing of tilt and bias
_STEADY = 0.3  # share by which the sigma of a wander may change and be taken for the same wander


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


Pair = tuple[float, float]


class Innovation:
    """A measurement minus its prediction: y1, y2 with their covariance s11, s12, s22, and the normalised innovation
    squared yᵀ S⁻¹ y. `size` 1: only y1 and s11 count."""

    __slots__ = ("normalised_square", "s11", "s12", "s22", "size", "y1", "y2")

    def __init__(self, size: int) -> None:
        self.size = size
        self.y1 = self.y2 = self.s11 = self.s12 = self.s22 = self.normalised_square = 0.0


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
        self.h_flat = flat(self.h)
        self.gain_flat = flat(self.gain)
        self.s_flat = flat(self.s)
        self.s_inverse_flat = flat(self.s_inverse)
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
    Measurements of positions and headings are off by `wander` and `heading_wander`. Positions and velocities where
    `late`, headings where `heading_late`, are later than their times by `late_s`: those of the receiver in use. Another
    receiver may be late, too, by a sigma of `unsure_s`. Remembers the nominal state and the covariance.
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
        self.acceleration: Vector = ZERO  # m/s² in NED
        self.wander: Pair = (0.0, 0.0)  # m, north and east
        self.heading_wander = 0.0  # rad
        self.late_s = 0.0
        self.late, self.heading_late = True, False
        self.unsure_s = 0.0
        self.gaining: Pair = (0.0, 0.0)  # m/s², north and east: the mean of the last moment's acceleration
        self._late_sigma_s = 0.0
        self._wander, self._heading_wander = Wander(0.0, 1.0), Wander(0.0, 1.0)
        self._walk_mps_rthz = 0.0
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

    def expect_walk(self, walk_mps_rthz: float) -> None:
        """Measured velocities have errors that last; the position that they carry on strays by them as a random walk
        of that density (m/s/√Hz)."""
        if walk_mps_rthz != self._walk_mps_rthz:
            self._walk_mps_rthz, self._noise_dt_s = walk_mps_rthz, -1.0

    def expect_wander(self, wander: Wander, common: float = 1.0) -> None:
        """The slow error of positions from now on. `common`: its correlation with the one before; 1: it is the same
        error, 0: it has nothing to do with it."""
        before, self._wander = self._wander, wander
        if wander != before:
            self._noise_dt_s = -1.0
        kept = self._redraw((_W, _W + 1), before.sigma, wander.sigma, common)
        self.wander = kept * self.wander[0], kept * self.wander[1]

    def expect_heading_wander(self, wander: Wander, common: float = 1.0) -> None:
        """As `expect_wander`, of headings."""
        before, self._heading_wander = self._heading_wander, wander
        if wander != before:
            self._noise_dt_s = -1.0
        self.heading_wander *= self._redraw((_WH,), before.sigma, wander.sigma, common)

    def expect_late(self, sigma_s: float, another: bool = False) -> None:
        """One sigma of how late the receiver in use is beyond its times, before anything has told. `another`: it is
        another receiver than before."""
        if another or sigma_s != self._late_sigma_s:
            self._late_sigma_s, self.late_s = sigma_s, 0.0
            self._forget((_L,), sigma_s * sigma_s)

    def doubt_late(self, sigma_s: float) -> None:
        """The latency may have changed by so much."""
        self.inflate((_L,), sigma_s * sigma_s)

    def learn_late(self, late_s: float, sigma_s: float) -> None:
        """The latency has changed, or something else has been taken for it: it is that one, of that sigma."""
        self.late_s = late_s
        self._forget((_L,), sigma_s * sigma_s)

    @property
    def measured_late_s(self) -> float:
        """By how much the position or velocity that comes next is later than its time."""
        return self.late_s if self.late else 0.0

    def late_sigma_s(self) -> float:
        """One sigma of how late the receiver in use is beyond its times."""
        return math.sqrt(max(self._p[SIZE * _L + _L], 0.0))

    def _redraw(self, states: Sequence[int], before: float, sigma: float, common: float) -> float:
        """Another sigma of slow errors; returns the share of them that is kept. Of two errors the larger one is the
        smaller one and something more, whichever comes first: that is how they are correlated. A sigma that changes a
        little is reached with time."""
        if common == 1.0 and before > 0.0 and abs(sigma - before) <= _STEADY * before:
            return 1.0
        kept = common * min((sigma / before) ** 2, 1.0) if before > 0.0 else 0.0
        for i in states:
            self.covariance[i, :] *= kept
            self.covariance[:, i] *= kept
        self.inflate(states, max(sigma * sigma - (kept * before) ** 2, 0.0))
        return kept

    def _bind(self) -> None:
        """Make views into the arrays."""
        self._diagonal = self.covariance.reshape(-1)[:: SIZE + 1]
        self._transition_transposed = self._transition.T
        self._reset_transposed = self._reset.T
        self._covariance_transposed = self.covariance.T
        self._f = flat(self._transition)
        self._g = flat(self._reset)
        self._p = flat(self.covariance)
        self._q = flat(self._noise_step)
        self._work_flat = flat(self._work)

    def start(self, position: Vector, velocity: Vector, attitude: Vector, sigmas: Sequence[float]) -> None:
        """Begin at a measured position (m), velocity (m/s) and (roll, pitch, yaw); the biases stay. `sigmas`: one for
        each of the 15 first error states, without what the measurements are off by. What is known of the latency
        stays. Rates are those of the filter: set them before."""
        self.position, self.velocity = position, velocity
        self.quaternion = quaternion_of(*attitude)
        self.rotation = rotation(self.quaternion)
        turn_radps = self.turn_radps
        self.gaining = -turn_radps * velocity[1], turn_radps * velocity[0]  # as far as anything tells
        late_s2 = float(self.covariance[_L, _L])
        self.covariance[:] = 0.0
        self.covariance[_L, _L] = late_s2
        self._diagonal[:_MOTION] = np.square(np.asarray(sigmas, dtype=float))
        self._measure_velocity(float(sigmas[_V]) ** 2)
        self._measure_position(float(sigmas[_P]) ** 2, ZERO)
        self._measure_heading(float(sigmas[_TH + 2]) ** 2)

    def continue_from(self, other: ErrorStateFilter, position: Vector, variance: float) -> None:
        """Go on with another filter's velocity, attitude and biases, at a measured position (m, `variance` m²). The
        heading holds nothing of what measured headings are off by."""
        self.position, self.velocity = position, other.velocity
        self.quaternion, self.rotation = other.quaternion, other.rotation
        self.accelerometer_bias, self.gyro_bias = other.accelerometer_bias, other.gyro_bias
        self.rates, self.acceleration = other.rates, other.acceleration
        late_s2 = float(self.covariance[_L, _L])
        self.covariance[:] = 0.0
        self.covariance[_L, _L] = late_s2
        self.covariance[:_MOTION, :_MOTION] = other.covariance[:_MOTION, :_MOTION]
        self._forget((_P, _P + 1, _P + 2), variance)
        self._measure_position(variance, ZERO)
        self.heading_wander = 0.0
        self._forget((_WH,), self._heading_wander.sigma**2)

    def _measure_position(self, variance: float, arm: Vector) -> None:
        """The position comes straight from a measurement at `arm` (NED) from it: it holds the whole of what that, and
        the attitude, are off by."""
        self.wander = (0.0, 0.0)
        self._forget((_W, _W + 1), self._wander.sigma**2)
        off = np.zeros((2, SIZE))
        off[0, _W] = off[1, _W + 1] = 1.0
        if self.late:
            off[0, _L], off[1, _L] = -self.velocity[0], -self.velocity[1]
        off[0, _TH : _TH + 3], off[1, _TH : _TH + 3] = (0.0, arm[2], -arm[1]), (-arm[2], 0.0, arm[0])
        self._restart((_P, _P + 1), off, variance)

    def _measure_velocity(self, variance: float) -> None:
        """As `_measure_position`, of the velocity."""
        off = np.zeros((2, SIZE))
        if self.late:
            off[0, _L], off[1, _L] = -self.gaining[0], -self.gaining[1]
        self._restart((_V, _V + 1), off, variance)

    def _measure_heading(self, variance: float) -> None:
        """As `_measure_position`, of the heading."""
        self.heading_wander = 0.0
        self._forget((_WH,), self._heading_wander.sigma**2)
        off = np.zeros((1, SIZE))
        off[0, _WH] = 1.0
        if self.heading_late:
            off[0, _L] = -self.turn_radps
        self._restart((_TH + 2,), off, variance)

    def _restart(self, states: Sequence[int], off: Array, variance: float) -> None:
        """Of states: true = measured − `off` · error state − noise of that variance."""
        self._forget(states, 0.0)
        cross = -off.dot(self.covariance)
        own = -cross.dot(off.T)
        for k, i in enumerate(states):
            self.covariance[i, :], self.covariance[:, i] = cross[k], cross[k]
        for k, i in enumerate(states):
            for n, j in enumerate(states):
                self.covariance[i, j] = own[k, n] + (variance if i == j else 0.0)

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
        self.acceleration = fn, fe, down
        gn, ge = self.gaining
        share = dt / (_MEAN_S + dt)
        self.gaining = gn + share * (fn - gn), ge + share * (fe - ge)
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
        f[64], f[65], f[82], f[84], f[101], f[102] = d, -e, -d, n, e, -n  # flat: 19 · row + column
        r0, r1, r2, r3, r4, r5, r6, r7, r8 = r
        f[66] = f[126] = -r0 * dt
        f[67] = f[127] = -r1 * dt
        f[68] = f[128] = -r2 * dt
        f[85] = f[145] = -r3 * dt
        f[86] = f[146] = -r4 * dt
        f[87] = f[147] = -r5 * dt
        f[104] = f[164] = -r6 * dt
        f[105] = f[165] = -r7 * dt
        f[106] = f[166] = -r8 * dt
        self._transition.dot(self.covariance, self._work)
        self._work.dot(self._transition_transposed, self.covariance)
        add_to_diagonal(self._diagonal, self._noise_step, self._p, self._q)

    def _set_step(self, dt: float) -> None:
        """Set the elements of F and Q that depend on the step alone."""
        noise, wander, heading = self.noise, self._wander, self._heading_wander
        f, q = self._f, self._q
        accelerometer_kept, gyro_kept = 1.0 - dt / noise.accelerometer_bias_time_s, 1.0 - dt / noise.gyro_bias_time_s
        f[3] = f[23] = f[43] = dt
        f[180] = f[200] = f[220] = accelerometer_kept
        f[240] = f[260] = f[280] = gyro_kept
        f[300] = f[320] = 1.0 - dt / wander.time_s
        f[340] = 1.0 - dt / heading.time_s
        q[0] = q[1] = self._walk_mps_rthz**2 * dt
        q[3] = q[4] = q[5] = noise.accelerometer_mps2_rthz**2 * dt
        q[6] = q[7] = q[8] = noise.gyro_radps_rthz**2 * dt
        q[9] = q[10] = q[11] = 2.0 * noise.accelerometer_bias_mps2**2 * dt / noise.accelerometer_bias_time_s
        q[12] = q[13] = q[14] = 2.0 * noise.gyro_bias_radps**2 * dt / noise.gyro_bias_time_s
        q[15] = q[16] = 2.0 * wander.sigma**2 * dt / wander.time_s
        q[17] = 2.0 * heading.sigma**2 * dt / heading.time_s
        q[18] = _LATE_WALK_S_RTS**2 * dt if self._late_sigma_s > 0.0 else 0.0
        self._noise_dt_s = dt

    def position_innovation(
        self, north_m: float, east_m: float, lever_m: Vector, variance: float, lag_s: float = 0.0
    ) -> Innovation:
        """Innovation of a measured position of the point `lever_m` (body) from the IMU, `lag_s` before the state's time
        (negative: after it). `variance` in m² on each axis."""
        arm = rotate(self.rotation, lever_m)
        vn, ve, _ = self.velocity
        turn = rotate(self.rotation, cross(self.rates, lever_m))
        vn, ve, (gn, ge), late_s = vn + turn[0], ve + turn[1], self.gaining, self.measured_late_s
        mean_s = late_s + 0.5 * lag_s
        lag_s += late_s
        h = self._pair.h_flat
        h[0] = h[SIZE + 1] = h[_W] = h[SIZE + _W + 1] = 1.0
        h[_V] = h[SIZE + _V + 1] = -lag_s
        tells = self.late and math.hypot(vn, ve) > _TELLS_MPS
        h[_L], h[SIZE + _L] = (mean_s * gn - vn, mean_s * ge - ve) if tells else (0.0, 0.0)
        self._set_arm(h, arm)
        self._set_lag(h, -0.5 * lag_s * abs(lag_s))
        variance += _UNSURE_SAMPLES * self.unsure_s**2 * (vn * vn + ve * ve) + self._late_m2()
        y1 = north_m - (self.position[0] - lag_s * (vn - 0.5 * late_s * gn) + arm[0]) - self.wander[0]
        y2 = east_m - (self.position[1] - lag_s * (ve - 0.5 * late_s * ge) + arm[1]) - self.wander[1]
        return self._pair_innovation(y1, y2, variance)

    def velocity_innovation(
        self, north_mps: float, east_mps: float, lever_m: Vector, variance: float, late: bool = True, lag_s: float = 0.0
    ) -> Innovation:
        """Innovation of a measured velocity of the point `lever_m` (body) from the IMU; `variance` in (m/s)² on each
        axis. `late`: it is of a receiver. `lag_s`: over which the inertial sensor has brought it to the state's
        time."""
        arm = rotate(self.rotation, cross(self.rates, lever_m))
        h = self._pair.h_flat
        h[0] = h[SIZE + 1] = h[_W] = h[SIZE + _W + 1] = 0.0
        h[_V] = h[SIZE + _V + 1] = 1.0
        gn, ge = self.gaining
        if late:
            variance += _UNSURE_SAMPLES * self.unsure_s**2 * (gn * gn + ge * ge)
        late = late and self.late
        late_s = self.late_s if late else 0.0
        late_s2 = self._p[SIZE * _L + _L]
        if late and late_s2 > 0.0:  # as `_late_m2`, of latency times acceleration
            variance += late_s2 * self._acceleration_variance()
        h[_L], h[SIZE + _L] = (-gn, -ge) if late and math.hypot(gn, ge) > _TELLS_MPS2 else (0.0, 0.0)
        self._set_arm(h, arm)
        self._set_lag(h, lag_s)
        y1 = north_mps - (self.velocity[0] - late_s * gn) - arm[0]
        y2 = east_mps - (self.velocity[1] - late_s * ge) - arm[1]
        return self._pair_innovation(y1, y2, variance)

    def _late_m2(self) -> float:
        """Variance of a late position by the product of two errors, that of the latency and that of the velocity: both
        are large where a boat begins under way. H, which knows each of them alone, has nothing of it."""
        if not self.late:
            return 0.0
        p = self._p
        late_s2, north, east = p[SIZE * _L + _L], p[SIZE * _V + _V], p[SIZE * (_V + 1) + _V + 1]
        return late_s2 * max(north, east) + max(p[SIZE * _L + _V] ** 2, p[SIZE * _L + _V + 1] ** 2)

    @staticmethod
    def _set_arm(h: Flat, arm: Vector) -> None:
        """The first two rows of −[arm]×: the effect of an attitude error on a vector fixed to the hull."""
        h[_TH + 1], h[_TH + 2] = arm[2], -arm[1]
        h[SIZE + _TH], h[SIZE + _TH + 2] = -arm[2], arm[0]

    def _set_lag(self, h: Flat, factor: float) -> None:
        """The effect of errors of attitude and accelerometer on a measurement before the state's time: on a velocity
        `factor` is the lag, on a position −½ of its square. δv̇ = −[f]× δθ − R δa_bias."""
        if abs(factor) < _LAG_TELLS:
            factor = 0.0
        (gn, ge), g, r = self.gaining, self.gravity_mps2, self.rotation
        if factor:
            h[_TH + 1] += factor * g
            h[_TH + 2] += factor * ge
            h[SIZE + _TH] -= factor * g
            h[SIZE + _TH + 2] -= factor * gn
        for k in range(3):
            h[_AB + k], h[SIZE + _AB + k] = factor * r[k], factor * r[3 + k]

    def heading_innovation(self, yaw_rad: float, variance: float, lag_s: float = 0.0) -> Innovation:
        """Innovation, wrapped, of a measured heading `lag_s` before the state's time; `variance` in rad².

        ψ = atan2(w_e, w_n) of the body's x axis w."""
        wn, we, wd = self.rotation[0], self.rotation[3], self.rotation[6]
        level = max(wn * wn + we * we, 1e-6)
        h = self._single.h_flat
        h[0] = h[2] = h[_V + 2] = 0.0
        h[_TH], h[_TH + 1], h[_TH + 2] = -wn * wd / level, -we * wd / level, 1.0
        h[_WH] = 1.0
        h[_L] = -self.turn_radps if self.heading_late else 0.0
        if self.heading_late:
            lag_s += self.late_s
        predicted = math.atan2(we, wn) - lag_s * self.rates[2] + self.heading_wander
        return self._single_innovation(wrap_pi(yaw_rad - predicted), variance)

    @property
    def measured_off(self) -> MeasuredOff:
        """The estimates of what measurements are off by."""
        return MeasuredOff(*self.wander, self.heading_wander, self.late_s)

    def put_off(self, off: MeasuredOff) -> None:
        """Take other estimates of what measurements are off by: earlier ones."""
        self.wander, self.heading_wander, self.late_s = (off.north_m, off.east_m), off.heading_rad, off.late_s

    @property
    def turn_radps(self) -> float:
        """Rate of turn about the vertical."""
        _, q, r = self.rates
        r7, r8 = self.rotation[7], self.rotation[8]
        return (q * r7 + r * r8) / max(r7 * r7 + r8 * r8, 0.1)  # (q sin φ + r cos φ) / cos θ

    def fuse_down(self, position_m: float, position_variance: float, velocity_variance: float) -> None:
        """A boat stays on the water: fuse `position_m` as down position and 0 as down velocity, with large variances
        (m², (m/s)²)."""
        h = self._single.h_flat
        h[_TH] = h[_TH + 1] = h[_TH + 2] = h[_V + 2] = h[_WH] = h[_L] = 0.0
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
        subtract(self.covariance, self._work, self._p, self._work_flat)
        self._inject(correction)

    def _inject(self, c: list[float]) -> None:
        """Add the error state `c` to the nominal state and reset it: P ← G P Gᵀ, made exactly symmetric. G is left out
        where it changes nothing."""
        p, v, a, w = self.position, self.velocity, self.accelerometer_bias, self.gyro_bias
        self.position = (p[0] + c[0], p[1] + c[1], p[2] + c[2])
        self.velocity = (v[0] + c[3], v[1] + c[4], v[2] + c[5])
        self.accelerometer_bias = (a[0] + c[9], a[1] + c[10], a[2] + c[11])
        self.gyro_bias = (w[0] + c[12], w[1] + c[13], w[2] + c[14])
        self.rates = (self.rates[0] - c[12], self.rates[1] - c[13], self.rates[2] - c[14])
        self.wander = (self.wander[0] + c[15], self.wander[1] + c[16])
        self.heading_wander += c[17]
        self.late_s += c[18]
        x, y, z = c[6], c[7], c[8]
        self.quaternion = multiply(exponential(x, y, z), self.quaternion)
        self.rotation = rotation(self.quaternion)
        if max(abs(x), abs(y), abs(z)) > _LARGE_TURN_RAD:
            g = self._g  # I + ½ [δθ]×
            g[121], g[122], g[139], g[141], g[158], g[159] = -0.5 * z, 0.5 * y, 0.5 * z, -0.5 * x, -0.5 * y, 0.5 * x
            self._reset.dot(self.covariance, self._work)
            self._work.dot(self._reset_transposed, self.covariance)
        symmetrise(self.covariance, self._covariance_transposed, self._work, self._p)

    def reset_position(
        self, north_m: float, east_m: float, lever_m: Vector, variance: float, velocity_variance: float
    ) -> None:
        """Restart the position at a measured one (m, `variance` m², to which comes its wander); the velocity stays,
        with `velocity_variance` added."""
        arm, late_s = rotate(self.rotation, lever_m), self.measured_late_s
        turn = rotate(self.rotation, cross(self.rates, lever_m))
        vn = self.velocity[0] + turn[0] - 0.5 * late_s * self.gaining[0]
        ve = self.velocity[1] + turn[1] - 0.5 * late_s * self.gaining[1]
        self.position = (north_m + late_s * vn - arm[0], east_m + late_s * ve - arm[1], self.position[2])
        self._measure_position(variance, arm)
        self.inflate((_V, _V + 1), velocity_variance)

    def reset_velocity(self, north_mps: float, east_mps: float, lever_m: Vector, variance: float) -> None:
        """Restart the velocity at a measured one (m/s, `variance` (m/s)²)."""
        arm = rotate(self.rotation, cross(self.rates, lever_m))
        gn, ge = self.measured_late_s * self.gaining[0], self.measured_late_s * self.gaining[1]
        self.velocity = (north_mps + gn - arm[0], east_mps + ge - arm[1], self.velocity[2])
        self._measure_velocity(variance)

    def reset_heading(self, yaw_rad: float, variance: float) -> None:
        """Restart the heading at a measured one (`variance` rad², to which comes its wander); roll and pitch stay."""
        roll, pitch, _ = self.euler()
        turned_rad = self.late_s * self.turn_radps if self.heading_late else 0.0
        self.quaternion = quaternion_of(roll, pitch, yaw_rad + turned_rad)
        self.rotation = rotation(self.quaternion)
        self._measure_heading(variance)

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
        """Add variance (m²) to the horizontal position, on each axis."""
        self.inflate((_P, _P + 1), variance)

    def inflate_motion(self, velocity_variance: float, tilt_variance: float) -> None:
        """Add variance to the horizontal velocity ((m/s)²) and to roll and pitch (rad²)."""
        self.inflate((_V, _V + 1), velocity_variance)
        self.inflate((_TH, _TH + 1), tilt_variance)

    def widen_wander(self, variance: float) -> None:
        """Add variance (m²) to what positions are off by: that may have jumped."""
        self.inflate((_W, _W + 1), variance)

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
            math.sqrt(max(0.5 * (p[0] + p[20]), 0.0)),
            math.sqrt(max(0.5 * (p[60] + p[80]), 0.0)),
            math.sqrt(max(p[160], 0.0)),
        )

    def measured_sigma_m(self) -> float:
        """One sigma of the position that a receiver with this wander would measure without noise, on each axis."""
        p, (vn, ve, _) = self._p, self.velocity
        north = p[0] + p[300] + 2.0 * p[15] + vn * (vn * p[360] - 2.0 * (p[18] + p[303]))
        east = p[20] + p[320] + 2.0 * p[35] + ve * (ve * p[360] - 2.0 * (p[37] + p[322]))
        return math.sqrt(max(0.5 * (north + east), 0.0))

    def velocity_sigmas(self) -> tuple[float, float]:
        """One sigma of the horizontal velocity, and of the acceleration that tilt and bias leave in it: of the worse
        axis."""
        p = self._p
        return math.sqrt(max(p[60], p[80], 0.0)), math.sqrt(self._acceleration_variance())

    def _acceleration_variance(self) -> float:
        """Of the horizontal acceleration, by tilt and bias: of the worse axis, (m/s²)²."""
        p, g, r = self._p, self.gravity_mps2, self.rotation
        worst = 0.0
        for tilt, sign, row in ((_TH + 1, -g, r[0:3]), (_TH, g, r[3:6])):  # δv̇ = −[f]× δθ − R δa_bias, f ≈ (0, 0, −g)
            h = ((tilt, sign), *((_AB + i, -row[i]) for i in range(3)))
            worst = max(worst, sum(a * b * p[SIZE * i + j] for i, a in h for j, b in h))
        return worst

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
        sums = self._p[0] + self._p[60] + self._p[120] + self._p[160]
        return all(map(math.isfinite, (sums, *self.position, *self.velocity, *self.quaternion)))
