"""A reference in NED → the setpoint for dynamic positioning, in the reference's body axes."""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.core.angles import wrap_pi
from companion.core.setpoint import Point, PoseSetpoint, Progress


def pose_setpoint(
    pose: Sequence[float], velocity: Sequence[float], acceleration: Sequence[float], target: Sequence[float]
) -> PoseSetpoint:
    """The setpoint for `pose` (north_m, east_m, yaw_rad), with its first and second time derivatives, on the way to
    `target` (north_m, east_m, …).

    ν_d = Rᵀ η̇_d and ν̇_d = Rᵀ η̈_d − S(r) Rᵀ η̇_d, from d/dt(Rᵀ) = −S Rᵀ (the ReVolt thesis prints +S).
    """
    north, east, yaw = pose
    vn, ve, rate = velocity
    an, ae, turn = acceleration
    c, s = math.cos(yaw), math.sin(yaw)
    u, v = c * vn + s * ve, -s * vn + c * ve
    return PoseSetpoint(
        north_m=north,
        east_m=east,
        yaw_rad=wrap_pi(yaw),
        surge_mps=u,
        sway_mps=v,
        yaw_rate_radps=rate,
        surge_mps2=c * an + s * ae + rate * v,
        sway_mps2=-s * an + c * ae - rate * u,
        yaw_radps2=turn,
        progress=Progress(
            target=Point(target[0], target[1]),
            distance_to_go_m=math.hypot(target[0] - north, target[1] - east),
        ),
    )
