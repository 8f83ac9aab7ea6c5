"""What the inertial sensor says alone: sums of its steps, dead reckoning from some seconds ago, and the filter as it
was then, to go back to."""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from companion.nav.error_state import ErrorStateFilter, at_the_middle
from companion.nav.lever_arms import Quaternion, Vector, rotation, turned
from companion.nav.measured_off import MeasuredOff

_AXES_RAD = 0.004  # by which the gyro's axes may be askew: a turn about one tilts the others
_DOUBTED_SHARE = 0.3  # of the accelerometers' bias: what a filter takes for one may be a tilt, which stays in a turn
_KEPT_EVERY_S = 0.5
_KEPT_S = 13.0
_STEADY_S = 10.0
_LANE_EVERY_S, _LANE_LIFE_S = 6.0, 12.0
_POSITION_MPS, _VELOCITY_MPS2, _HEADING_RADPS = 0.05, 0.02, math.radians(0.1)  # growth of sigmas that went back


@dataclass(slots=True)
class InertialSums:
    """Sums of the filter's predictions, measurements left out: velocity in NED, the way that it makes, and the turn
    about the vertical. They have no meaning but their differences; `run` changes when those have none either.

    `turned_rad`: with the gyro's bias of ten seconds ago, which cannot come from a heading that has just begun to
    creep; `bias_sigma_radps`: one sigma of that bias.
    """

    run: int = 0
    north_mps: float = 0.0
    east_mps: float = 0.0
    north_m: float = 0.0
    east_m: float = 0.0
    turned_rad: float = 0.0
    bias_sigma_radps: float = math.inf
    _biases: deque[tuple[float, float, float]] = field(default_factory=deque)  # time, bias, sigma

    def begin(self) -> None:
        """The filter starts anew: no difference to what was before has a meaning."""
        self.run += 1
        self._biases.clear()
        self.bias_sigma_radps = math.inf

    def move(self, arm: tuple[float, float], swing: tuple[float, float]) -> None:
        """From now on the sums are of another point of the hull, that far (m) from the one before; `swing`: its
        velocity relative to that."""
        self.north_m += arm[0]
        self.east_m += arm[1]
        self.north_mps += swing[0]
        self.east_mps += swing[1]

    def learn(self, t_s: float, bias_radps: float, sigma_radps: float) -> None:
        """Take the gyro's bias about the vertical, as the filter knows it now."""
        biases = self._biases
        biases.append((t_s, bias_radps, sigma_radps))
        while len(biases) > 1 and biases[1][0] <= t_s - _STEADY_S:
            biases.popleft()
        self.bias_sigma_radps = biases[0][2]

    def add(self, dt_s: float, north_mps: float, east_mps: float, turn_radps: float, bias_radps: float) -> None:
        """Add a step of the prediction: changes of velocity, rate of turn, and the bias that was taken off it."""
        self.north_m += dt_s * (self.north_mps + 0.5 * north_mps)
        self.east_m += dt_s * (self.east_mps + 0.5 * east_mps)
        self.north_mps += north_mps
        self.east_mps += east_mps
        steady = self._biases[0][1] if self._biases else bias_radps
        self.turned_rad += dt_s * (turn_radps + bias_radps - steady)


class Lane:
    """Dead reckoning by the inertial sensor alone, from the filter as it was at `from_s`. In NED: `first`, the velocity
    of the boat's origin then; `velocity`, that of the sensor's place now.

    Source: as ArduPilot runs filters side by side, and PX4's yaw estimator; here without measurements at all.
    """

    __slots__ = (
        "_accelerometer_bias",
        "_ahead",
        "_gravity_mps2",
        "_gyro_bias",
        "_quaternion",
        "_sigma_mps",
        "_sigma_mps2",
        "_sigma_mps3",
        "_turn_sigma_mps2",
        "_turned_mps",
        "first",
        "from_s",
        "velocity",
    )

    def __init__(self, from_s: float, filter_: ErrorStateFilter, swing: tuple[float, float]) -> None:
        self.from_s = from_s
        self.velocity = filter_.velocity
        self.first = self.velocity[0] - swing[0], self.velocity[1] - swing[1]
        self._quaternion: Quaternion = filter_.quaternion
        self._accelerometer_bias, self._gyro_bias = filter_.accelerometer_bias, filter_.gyro_bias
        self._gravity_mps2 = filter_.gravity_mps2
        self._sigma_mps, self._sigma_mps2 = filter_.velocity_sigmas()
        bias_sigma_mps2, gyro_sigma_radps = filter_.bias_sigmas()
        doubted_mps2 = _DOUBTED_SHARE * math.hypot(self._accelerometer_bias[0], self._accelerometer_bias[1])
        self._turn_sigma_mps2 = math.hypot(bias_sigma_mps2, _AXES_RAD * self._gravity_mps2, doubted_mps2)
        self._sigma_mps3 = self._gravity_mps2 * gyro_sigma_radps
        self._ahead = filter_.rotation[0], filter_.rotation[3]
        self._turned_mps = 0.0

    def sigma_mps(self, now_s: float) -> float:
        """One sigma of the velocity on an axis, by the filter's covariance at the start. What tilt and bias leave is
        known together, not each alone: a boat that has turned since then feels the difference. The gyro tilts the lane:
        by its bias with time, by its axes in a turn."""
        passed_s = now_s - self.from_s
        tilted_mps = 0.5 * self._sigma_mps3 * passed_s * passed_s
        return math.hypot(self._sigma_mps, self._sigma_mps2 * passed_s, self._turned_mps, tilted_mps)

    def advance(self, force: Vector, rates: Vector, dt_s: float) -> None:
        """Take one sample, as the filter does."""
        bx, by, bz = self._accelerometer_bias
        bp, bq, br = self._gyro_bias
        p, q, r = rates[0] - bp, rates[1] - bq, rates[2] - br
        matrix = rotation(self._quaternion)
        self._quaternion = turned(self._quaternion, p * dt_s, q * dt_s, r * dt_s)
        x, y, z = at_the_middle(force[0] - bx, force[1] - by, force[2] - bz, p, q, r, dt_s)
        r0, r1, r2, r3, r4, r5, r6, r7, r8 = matrix  # written out: each lane does this with each sample
        n, e, d = r0 * x + r1 * y + r2 * z, r3 * x + r4 * y + r5 * z, r6 * x + r7 * y + r8 * z
        chord = math.hypot(matrix[0] - self._ahead[0], matrix[3] - self._ahead[1])
        self._turned_mps += chord * self._turn_sigma_mps2 * dt_s
        vn, ve, vd = self.velocity
        self.velocity = (vn + n * dt_s, ve + e * dt_s, vd + (d + self._gravity_mps2) * dt_s)


@dataclass(frozen=True, slots=True)
class _Sample:
    """Specific force (m/s²) and rates (rad/s) at the end of `dt_s`."""

    t_s: float
    force: Vector
    rates: Vector
    dt_s: float


@dataclass(frozen=True, slots=True)
class _Kept:
    t_s: float
    position: Vector
    velocity: Vector
    quaternion: Quaternion
    accelerometer_bias: Vector
    gyro_bias: Vector
    measured_off: MeasuredOff
    covariance: np.ndarray[Any, np.dtype[np.float64]]


class InertialMemory:
    """Call `sample` for each sample and `keep` now and then. Remembers samples and filter of the last seconds, and the
    lanes."""

    def __init__(self) -> None:
        self.lanes: list[Lane] = []
        self._kept: deque[_Kept] = deque()
        self._samples: deque[_Sample] = deque()

    def clear(self) -> None:
        """Forget all: the filter begins anew."""
        self.lanes.clear()
        self._kept.clear()
        self._samples.clear()

    def sample(self, t_s: float, force: Vector, rates: Vector, dt_s: float) -> None:
        """Take one sample."""
        samples = self._samples
        samples.append(_Sample(t_s, force, rates, dt_s))
        if samples[0].t_s < t_s - _KEPT_S:
            samples.popleft()
        for lane in self.lanes:
            lane.advance(force, rates, dt_s)

    def keep(self, t_s: float, filter_: ErrorStateFilter, swing: tuple[float, float] = (0.0, 0.0)) -> None:
        """Remember the filter, if half a second has passed, and begin a lane where one is due. `swing`: velocity of the
        sensor relative to the boat's origin, in NED."""
        kept, lanes = self._kept, self.lanes
        if kept and t_s - kept[-1].t_s < _KEPT_EVERY_S:
            return
        while kept and kept[0].t_s < t_s - _KEPT_S:
            kept.popleft()
        f = filter_
        kept.append(
            _Kept(
                t_s, f.position, f.velocity, f.quaternion, f.accelerometer_bias, f.gyro_bias, f.measured_off,
                f.covariance.copy(),
            )
        )  # fmt: skip
        if lanes and t_s - lanes[0].from_s >= _LANE_LIFE_S:
            del lanes[0]
        if not lanes or t_s - lanes[-1].from_s >= _LANE_EVERY_S:
            lanes.append(Lane(t_s, filter_, swing))

    def go_back(self, since_s: float, now_s: float, filter_: ErrorStateFilter) -> bool:
        """Take the filter back to before `since_s`, and on from there by the samples alone. False if it does not
        remember as far back; then nothing changes."""
        kept = self._kept
        if not kept or kept[0].t_s >= since_s:
            return False
        while kept[-1].t_s >= since_s:
            kept.pop()
        then = kept[-1]
        self.lanes[:] = [lane for lane in self.lanes if lane.from_s < since_s]
        filter_.position, filter_.velocity = then.position, then.velocity
        filter_.quaternion, filter_.rotation = then.quaternion, rotation(then.quaternion)
        filter_.accelerometer_bias, filter_.gyro_bias = then.accelerometer_bias, then.gyro_bias
        filter_.put_off(then.measured_off)
        filter_.carry_on([(s.force, s.rates, s.dt_s) for s in self._samples if s.t_s > then.t_s + 1e-9])
        filter_.covariance[:] = then.covariance
        passed_s = now_s - then.t_s
        growths = ((0, 1), _POSITION_MPS), ((3, 4), _VELOCITY_MPS2), ((8,), _HEADING_RADPS)
        for states, growth in growths:
            filter_.inflate(states, (growth * passed_s) ** 2)
        return True
