"""What holds of the AHRS whatever its sensors say."""

from __future__ import annotations

import math

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from companion.baselines.ahrs import ThesisAhrs
from companion.nav.ahrs import Ahrs
from companion.nav.lever_arms import quaternion_of, rotation

_PART = st.tuples(*(st.floats(-30.0, 30.0) for _ in range(3)))
_RATE = st.tuples(*(st.floats(-6.0, 6.0) for _ in range(3)))
_STEP = st.tuples(_PART, _RATE, _PART, st.floats(-20.0, 20.0), st.floats(0.001, 0.3), st.booleans(), st.booleans())


def _started(ahrs: Ahrs | ThesisAhrs, declination_rad: float = 0.0) -> float:
    for k in range(110):
        ahrs.sample(0.01 * k, (0.0, 0.0, -9.81), (0.0, 0.0, 0.0))
        ahrs.magnetic(0.01 * k, (0.4, 0.0, 0.9), declination_rad)
    return 1.09


def _matrix(upper: list[float]) -> np.ndarray:
    matrix = np.zeros((6, 6))
    matrix[np.triu_indices(6)] = upper
    return matrix + np.triu(matrix, 1).T


@given(st.lists(_STEP, min_size=1, max_size=60))
@settings(deadline=None, derandomize=True, max_examples=60)
def test_the_quaternion_stays_one_and_the_covariance_positive(steps: list) -> None:  # type: ignore[type-arg]
    for ahrs in (Ahrs(9.81), ThesisAhrs(9.81)):
        t_s = _started(ahrs)
        for force, rates, field, speed, dt, magnetic, velocity in steps:
            t_s += dt
            ahrs.sample(t_s, force, rates)
            if magnetic:
                ahrs.magnetic(t_s, field, 0.1)
            if velocity:
                ahrs.velocity(t_s, speed, -speed, 0.06)
            assert abs(math.hypot(*ahrs.quaternion) - 1.0) < 1e-9
            if isinstance(ahrs, Ahrs):
                matrix = _matrix(ahrs.covariance)
                values = np.linalg.eigvalsh(matrix)
                assert values[0] > -1e-12 * values[-1]


@given(st.floats(-math.pi, math.pi))
@settings(deadline=None, derandomize=True, max_examples=30)
def test_where_north_is_does_not_matter(yaw_rad: float) -> None:
    """Same sensors on board, same motion, the world turned: magnetic north and velocities by an angle, then so is the
    heading and nothing else."""
    ends = []
    for begin in (0.0, yaw_rad):
        ahrs = Ahrs(9.81)
        t_s = _started(ahrs, begin)
        for k in range(1, 301):
            t_s += 0.01
            ahrs.sample(t_s, (0.5 * math.sin(0.05 * k), 1.0, -9.8), (0.1 * math.cos(0.1 * k), 0.05, 0.3))
            yaw = 0.003 * k
            if k % 5 == 0:
                field = np.array(rotation(quaternion_of(0.0, 0.0, yaw))).reshape(3, 3).T @ [0.4, 0.01, 0.9]
                ahrs.magnetic(t_s, tuple(field.tolist()), begin)
            if k % 10 == 0:
                ahrs.velocity(t_s, 3.0 * math.cos(begin + yaw), 3.0 * math.sin(begin + yaw), 0.06)
        ends.append((ahrs.attitude, ahrs.yaw_sigma_rad))
    (first, sigma), (second, other) = ends
    assert (
        abs(math.remainder(second[2] - first[2] - yaw_rad, 2 * math.pi)) < 5e-3
    )  # of second order: axes are weighed in one after the other
    assert max(abs(a - b) for a, b in zip(first[:2], second[:2], strict=True)) < 5e-3
    assert abs(sigma - other) < 1e-2 * sigma
