"""The orientation filter of the RescueRunner thesis (Hallhagen & Persson 2016, section 3.6), in NED, with its sign
errors corrected.

A Kalman filter on the four numbers of the quaternion: q ← (I + ½ S(ω) T) q, then normalised; P likewise, with noise
through ½ S̄(q) T. The accelerometer gives the vertical while ‖a‖ ≈ g. The magnetometer corrects yaw only: it is rotated
back by the tilt part of q, its vertical component is dropped, and it is normalised. There is no gyro bias and no model
of the boat's own acceleration: in turns and in rough sea the filter loses its tilt, and with it the heading. The 4×4
matrices are numpy arrays: written out in floats they cost as much.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from companion.nav.lever_arms import (
    ZERO,
    Matrix,
    Quaternion,
    Vector,
    euler_of,
    multiply,
    quaternion_of,
    rotate,
    rotation,
)

_LONGEST_STEP_S = 0.1
_GYRO_SIGMA_RADPS = 0.01
_FORCE_SIGMA_MPS2 = 0.5
_FIELD_SIGMA = 0.05  # of a field of length 1
_GATE_SHARE = 0.05  # ‖a‖ ≈ g: the thesis does not say how near
_START_SIGMA = 0.1


class ThesisAhrs:
    """Same interface as `nav.ahrs.Ahrs`; velocities are ignored. Remembers quaternion, covariance, the yaw correction
    and the last specific force, from which it starts."""

    gyro_bias: Vector = ZERO

    def __init__(self, gravity_mps2: float) -> None:
        self._gravity_mps2 = gravity_mps2
        self.running = False
        self.quaternion: Quaternion = (1.0, 0.0, 0.0, 0.0)
        self.rotation: Matrix = rotation(self.quaternion)
        self.rates: Vector = ZERO
        self._covariance = np.eye(4) * _START_SIGMA**2
        self._turned_rad = 0.0
        self._force: Vector | None = None
        self._t_s = -math.inf

    @property
    def attitude(self) -> Vector:
        """(roll, pitch, yaw) in rad; yaw is not wrapped."""
        roll, pitch, yaw = euler_of(self.rotation)
        return roll, pitch, yaw + self._turned_rad

    @property
    def yaw_sigma_rad(self) -> float:
        """One sigma of yaw: that of δψ = 2 (q0 δq3 − q3 δq0), for small tilt; π before the start."""
        w, _, _, z = self.quaternion
        p = self._covariance
        return (
            2.0 * math.sqrt(max(float(w * w * p[3, 3] + z * z * p[0, 0] - 2.0 * w * z * p[0, 3]), 0.0))
            if self.running
            else math.pi
        )

    def sample(self, t_s: float, force: Vector, rates: Vector) -> None:
        """As `Ahrs.sample`."""
        dt = min(t_s - self._t_s, _LONGEST_STEP_S)
        if dt <= 0.0:
            return
        self._t_s, self._force, self.rates = t_s, force, rates
        if not self.running:
            return
        p, q, r = (0.5 * dt * rate for rate in rates)
        step = np.array([[1.0, -p, -q, -r], [p, 1.0, r, -q], [q, -r, 1.0, p], [r, q, -p, 1.0]])
        w, x, y, z = self.quaternion
        spread = 0.5 * dt * _GYRO_SIGMA_RADPS * np.array([[-x, -y, -z], [w, -z, y], [z, w, -x], [-y, x, w]])
        self._covariance = step @ self._covariance @ step.T + spread @ spread.T
        self._normalise(step @ np.array(self.quaternion))
        if abs(math.hypot(*force) - self._gravity_mps2) <= _GATE_SHARE * self._gravity_mps2:
            self._level(force)

    def _level(self, force: Vector) -> None:
        """Correct the tilt by the specific force: y = Qᵀ(q) (0, 0, −g)."""
        w, x, y, z = self.quaternion
        g = -self._gravity_mps2
        expected = g * np.array([2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)])
        h = 2.0 * g * np.array([[-y, z, -w, x], [x, w, z, y], [0.0, -2.0 * x, -2.0 * y, 0.0]])
        self._fuse(np.array(force) - expected, h, _FORCE_SIGMA_MPS2)

    def magnetic(self, t_s: float, field: Vector, declination_rad: float) -> None:
        """As `Ahrs.magnetic`: y′ = Qᵀ(q_yaw) m, both horizontal and of length 1."""
        if not self.running:
            self._start(field, declination_rad)
            return
        yaw = euler_of(self.rotation)[2]
        w, z = math.cos(0.5 * yaw), math.sin(0.5 * yaw)
        tilt = multiply((w, 0.0, 0.0, -z), self.quaternion)
        ahead, aside, _ = rotate(rotation(tilt), field)
        length = math.hypot(ahead, aside)
        if length <= 0.0:
            return
        north, east = math.cos(declination_rad), math.sin(declination_rad)
        c, s = w * w - z * z, 2.0 * w * z
        innovation = np.array([ahead / length - c * north - s * east, aside / length + s * north - c * east])
        # Jacobian with respect to q_yaw = (q0, 0, 0, q3)
        h = 2.0 * np.array(
            [
                [w * north + z * east, 0.0, 0.0, -z * north + w * east],
                [-z * north + w * east, 0.0, 0.0, -w * north - z * east],
            ]
        )
        before = self.rotation
        self._fuse(innovation, h, _FIELD_SIGMA)
        self._keep_tilt(before)

    def _keep_tilt(self, before: Matrix) -> None:
        """Restore roll and pitch: the magnetometer changes the heading alone."""
        roll, pitch, _ = euler_of(before)
        self._normalise(np.array(quaternion_of(roll, pitch, euler_of(self.rotation)[2])))

    def velocity(self, t_s: float, north_mps: float, east_mps: float, sigma_mps: float, lever_m: Vector = ZERO) -> None:
        """Ignored: this filter uses no velocity."""

    def turn(self, angle_rad: float) -> None:
        """Add a correction to yaw, outside the filter: ψ = ψ_q + ψ_corr."""
        self._turned_rad += angle_rad

    def _fuse(self, innovation: Any, h: Any, sigma: float) -> None:
        p = self._covariance
        s = h @ p @ h.T + sigma * sigma * np.eye(len(innovation))
        gain = np.linalg.solve(s, h @ p).T
        p = p - gain @ s @ gain.T
        self._covariance = 0.5 * (p + p.T)
        self._normalise(np.array(self.quaternion) + gain @ innovation)

    def _normalise(self, q: Any) -> None:
        w, x, y, z = (q / math.sqrt(float(q @ q))).tolist()
        self.quaternion = (w, x, y, z)
        self.rotation = rotation(self.quaternion)

    def _start(self, field: Vector, declination_rad: float) -> None:
        if self._force is None:
            return
        x, y, z = self._force
        roll, pitch = math.atan2(-y, -z), math.atan2(x, math.hypot(y, z))
        north, east, _ = rotate(rotation(quaternion_of(roll, pitch, 0.0)), field)
        self._normalise(np.array(quaternion_of(roll, pitch, declination_rad - math.atan2(east, north))))
        self.running = True
