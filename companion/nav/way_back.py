"""What the boat has done since some moment of the last seconds, by the inertial sensor: a measurement that comes late
is of a boat that was elsewhere, at another velocity and heading, and no straight line leads there.

Forces are summed in the axes of a frame that the gyro alone carries, as they are felt: so what the filter learns of
tilt and bias meanwhile holds for the past, too (preintegration: Lupton & Sukkarieh 2012, *Visual-inertial-aided
navigation for high-dynamic motion*).
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import deque
from typing import NamedTuple

from companion.core.angles import wrap_pi
from companion.nav.error_state import ErrorStateFilter, at_the_middle
from companion.nav.lever_arms import ZERO, Matrix, Quaternion, Vector, relative, rotate, rotation, turned, velocity_ned

LONGEST_S = 1.1  # later measurements are of no use: a filter that begins by them does not find its attitude
_GAP_S = 0.5  # between two samples: nobody knows what was in between


class _Then(NamedTuple):
    """`gained`, `gone`: force, summed over time once and twice, in the gyro's frame, to which `rotation` leads."""

    t_s: float
    gained: Vector
    gone: Vector
    rotation: Matrix
    rates: Vector


class Since(NamedTuple):
    """How far a point of the hull has gone since then (m), and by what its velocity (m/s) and the heading (rad) have
    changed, in NED."""

    north_m: float
    east_m: float
    north_mps: float
    east_mps: float
    turned_rad: float


NOTHING = Since(0.0, 0.0, 0.0, 0.0, 0.0)
_IDENTITY: Quaternion = (1.0, 0.0, 0.0, 0.0)


class WayBack:
    """Call `take` for each sample, then ask what was done `since`. Remembers the sums of the last seconds."""

    def __init__(self) -> None:
        self._then: deque[_Then] = deque()
        self._frame = _IDENTITY

    def clear(self) -> None:
        """Forget all: it is another sensor, or it was silent."""
        self._then.clear()
        self._frame = _IDENTITY

    def take(self, t_s: float, force: Vector, rates: Vector, dt_s: float) -> None:
        """Take a sample: specific force (m/s²) and rates (rad/s) without the gyro's bias, in body axes."""
        if dt_s > _GAP_S:
            self.clear()
        if not self._then:
            self._then.append(_Then(t_s, ZERO, ZERO, rotation(_IDENTITY), rates))
            return
        (_, (x, y, z), (north, east, down), matrix, _) = self._then[-1]
        fx, fy, fz = rotate(matrix, at_the_middle(*force, *rates, dt_s))
        half = 0.5 * dt_s
        gone = north + dt_s * (x + half * fx), east + dt_s * (y + half * fy), down + dt_s * (z + half * fz)
        gained = x + dt_s * fx, y + dt_s * fy, z + dt_s * fz
        self._frame = turned(self._frame, rates[0] * dt_s, rates[1] * dt_s, rates[2] * dt_s)
        self._then.append(_Then(t_s, gained, gone, rotation(self._frame), rates))
        while self._then[0].t_s < t_s - LONGEST_S - 0.1:
            self._then.popleft()

    def since(self, t_s: float, filter_: ErrorStateFilter, arm: Vector) -> Since:
        """Of the point `arm` from the sensor in body axes; `filter_` is as of the last sample. From a moment before
        what is remembered the boat has come straight."""
        if not self._then:
            return NOTHING
        now = self._then[-1]
        found = bisect_left(self._then, t_s, key=lambda then: then.t_s)
        then = self._then[min(found, len(self._then) - 1)]
        lag_s, early_s, r = now.t_s - then.t_s, then.t_s - t_s, filter_.rotation
        before = _product(r, _product(_transposed(now.rotation), then.rotation))  # as the filter has it now
        felt = rotate(r, _turned_back(now.rotation, relative(now.gained, then.gained)))
        way = relative(relative(now.gone, then.gone), _times(now.gained, lag_s))
        bent = rotate(r, _turned_back(now.rotation, way))
        bias = _times(_mean(rotate(r, filter_.accelerometer_bias), rotate(before, filter_.accelerometer_bias)), lag_s)
        velocity, past, here = filter_.velocity, rotate(before, arm), rotate(r, arm)
        swing = relative(velocity_ned(r, filter_.rates, arm), velocity_ned(before, then.rates, arm))
        gained_n, gained_e = felt[0] - bias[0], felt[1] - bias[1]
        half_s = 0.5 * lag_s
        return Since(
            bent[0] + half_s * bias[0] + (lag_s + early_s) * velocity[0] - early_s * gained_n + here[0] - past[0],
            bent[1] + half_s * bias[1] + (lag_s + early_s) * velocity[1] - early_s * gained_e + here[1] - past[1],
            gained_n + swing[0] + early_s * filter_.gaining[0],
            gained_e + swing[1] + early_s * filter_.gaining[1],
            wrap_pi(math.atan2(r[3], r[0]) - math.atan2(before[3], before[0])) + early_s * filter_.turn_radps,
        )


def _times(vector: Vector, factor: float) -> Vector:
    return vector[0] * factor, vector[1] * factor, vector[2] * factor


def _mean(first: Vector, second: Vector) -> Vector:
    return 0.5 * (first[0] + second[0]), 0.5 * (first[1] + second[1]), 0.5 * (first[2] + second[2])


def _turned_back(matrix: Matrix, vector: Vector) -> Vector:
    """Rᵀ v."""
    return rotate(_transposed(matrix), vector)


def _transposed(m: Matrix) -> Matrix:
    return m[0], m[3], m[6], m[1], m[4], m[7], m[2], m[5], m[8]


def _product(a: Matrix, b: Matrix) -> Matrix:
    """a b, written out: each measurement asks for two."""
    a0, a1, a2, a3, a4, a5, a6, a7, a8 = a
    b0, b1, b2, b3, b4, b5, b6, b7, b8 = b
    return (
        a0 * b0 + a1 * b3 + a2 * b6,
        a0 * b1 + a1 * b4 + a2 * b7,
        a0 * b2 + a1 * b5 + a2 * b8,
        a3 * b0 + a4 * b3 + a5 * b6,
        a3 * b1 + a4 * b4 + a5 * b7,
        a3 * b2 + a4 * b5 + a5 * b8,
        a6 * b0 + a7 * b3 + a8 * b6,
        a6 * b1 + a7 * b4 + a8 * b7,
        a6 * b2 + a7 * b5 + a8 * b8,
    )
