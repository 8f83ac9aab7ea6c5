"""Rotations, and the lever arms from the boat's origin to its sensors.

Frames: NED; body x forward, y starboard, z down. Rotation matrices are body → NED as nine floats, row by row.
Source: Solà (2017), *Quaternion kinematics for the error-state Kalman filter*; ReVolt thesis, lever-arm compensation.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.config.devices import SensorConfig

Vector = tuple[float, float, float]
Matrix = tuple[float, float, float, float, float, float, float, float, float]
Quaternion = tuple[float, float, float, float]

ZERO: Vector = (0.0, 0.0, 0.0)


def rotate(matrix: Matrix, vector: Vector) -> Vector:
    """The body-axes `vector` in NED."""
    a, b, c, d, e, f, g, h, i = matrix
    x, y, z = vector
    return a * x + b * y + c * z, d * x + e * y + f * z, g * x + h * y + i * z


def cross(a: Vector, b: Vector) -> Vector:
    """Cross product a × b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def lever_arms(sensors: Sequence[SensorConfig]) -> dict[str, Vector]:
    """By name of each sensor: where it sits, from the boat's origin, m."""
    return {row.name: (row.x_m, row.y_m, row.z_m) for row in sensors}


def velocity_ned(matrix: Matrix, rates_radps: Vector, lever_m: Vector) -> Vector:
    """Velocity of the point at `lever_m` relative to the reference point, in NED m/s: R (ω × l)."""
    return rotate(matrix, cross(rates_radps, lever_m))


def centripetal_mps2(rates_radps: Vector, lever_m: Vector) -> Vector:
    """What a steady turn adds to the force felt at `lever_m`, beside that at the reference point: ω × (ω × l)."""
    return cross(rates_radps, cross(rates_radps, lever_m))


def relative(lever_m: Vector, reference_m: Vector) -> Vector:
    """The vector `lever_m` − `reference_m`: a lever arm from another point of the hull."""
    return lever_m[0] - reference_m[0], lever_m[1] - reference_m[1], lever_m[2] - reference_m[2]


def rotation(quaternion: Quaternion) -> Matrix:
    """The rotation matrix body → NED of a unit quaternion (w, x, y, z)."""
    w, x, y, z = quaternion
    xx, yy, zz, xy, xz, yz, wx, wy, wz = x * x, y * y, z * z, x * y, x * z, y * z, w * x, w * y, w * z
    return (
        1.0 - 2.0 * (yy + zz),
        2.0 * (xy - wz),
        2.0 * (xz + wy),
        2.0 * (xy + wz),
        1.0 - 2.0 * (xx + zz),
        2.0 * (yz - wx),
        2.0 * (xz - wy),
        2.0 * (yz + wx),
        1.0 - 2.0 * (xx + yy),
    )


def quaternion_of(roll_rad: float, pitch_rad: float, yaw_rad: float) -> Quaternion:
    """The unit quaternion (w, x, y, z) of Euler angles (z-y-x)."""
    cr, sr = math.cos(0.5 * roll_rad), math.sin(0.5 * roll_rad)
    cp, sp = math.cos(0.5 * pitch_rad), math.sin(0.5 * pitch_rad)
    cy, sy = math.cos(0.5 * yaw_rad), math.sin(0.5 * yaw_rad)
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )


def euler_of(matrix: Matrix) -> Vector:
    """(roll, pitch, yaw) in rad of a rotation matrix."""
    roll = math.atan2(matrix[7], matrix[8])
    pitch = -math.asin(max(-1.0, min(1.0, matrix[6])))
    return roll, pitch, math.atan2(matrix[3], matrix[0])


def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """Quaternion product a ⊗ b."""
    aw, ax, ay, az = a
    bw, bx, by, bz = b
    return (
        aw * bw - ax * bx - ay * by - az * bz,
        aw * bx + ax * bw + ay * bz - az * by,
        aw * by - ax * bz + ay * bw + az * bx,
        aw * bz + ax * by - ay * bx + az * bw,
    )


def exponential(x_rad: float, y_rad: float, z_rad: float) -> Quaternion:
    """The unit quaternion of a rotation vector."""
    angle = math.sqrt(x_rad * x_rad + y_rad * y_rad + z_rad * z_rad)
    if angle < 1e-9:
        return 1.0, 0.5 * x_rad, 0.5 * y_rad, 0.5 * z_rad
    s = math.sin(0.5 * angle) / angle
    return math.cos(0.5 * angle), s * x_rad, s * y_rad, s * z_rad


def turned(quaternion: Quaternion, x_rad: float, y_rad: float, z_rad: float) -> Quaternion:
    """The attitude after a small rotation in body axes, normalised: the product with its exponential, written out since
    each sample of an inertial sensor asks for several."""
    aw, ax, ay, az = quaternion
    angle = math.sqrt(x_rad * x_rad + y_rad * y_rad + z_rad * z_rad)
    if angle < 1e-9:
        bw, s = 1.0, 0.5
    else:
        bw, s = math.cos(0.5 * angle), math.sin(0.5 * angle) / angle
    bx, by, bz = s * x_rad, s * y_rad, s * z_rad
    w = aw * bw - ax * bx - ay * by - az * bz
    x = aw * bx + ax * bw + ay * bz - az * by
    y = aw * by - ax * bz + ay * bw + az * bx
    z = aw * bz + ax * by - ay * bx + az * bw
    scale = 1.5 - 0.5 * (w * w + x * x + y * y + z * z)  # one Newton step towards 1/|q|
    return w * scale, x * scale, y * scale, z * scale


def normal_gravity_mps2(lat_deg: float) -> float:
    """Gravity at sea level at a geodetic latitude: Somigliana's formula with the constants of WGS 84."""
    s2 = math.sin(math.radians(lat_deg)) ** 2
    return 9.7803253359 * (1.0 + 0.00193185265241 * s2) / math.sqrt(1.0 - 0.00669437999014 * s2)
