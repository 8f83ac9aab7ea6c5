"""The motion along planned poses, and the wrench that the hull needs for it."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

from companion.config.hull import HullConfig
from companion.control.model import force_for
from companion.core.actuation import Wrench
from companion.core.angles import wrap_pi
from companion.core.frames import ned_to_body
from companion.core.setpoint import PATH_STEP_S, PlannedPose


@dataclass(frozen=True, slots=True)
class PlannedSteps:
    """A plan at each step: headings, courses over ground, velocities through the water in body axes (m/s, m/s, rad/s),
    and the wrenches that they need (N, N, Nm)."""

    yaw_rad: list[float]
    course_rad: list[float]
    velocity: list[tuple[float, float, float]]
    wrench: list[tuple[float, float, float]]


def planned_steps(hull: HullConfig, ahead: Sequence[PlannedPose], water: tuple[float, float]) -> PlannedSteps:
    """By differences of the poses, which are PATH_STEP_S apart; so there is one velocity fewer than poses, and one
    wrench fewer than velocities. `water`: (north, east) velocity of the current in m/s."""
    velocity: list[tuple[float, float, float]] = []
    courses = []
    for a, b in itertools.pairwise(ahead):
        north, east = (b.north_m - a.north_m) / PATH_STEP_S, (b.east_m - a.east_m) / PATH_STEP_S
        turn = wrap_pi(b.yaw_rad - a.yaw_rad)
        x, y = ned_to_body(north - water[0], east - water[1], a.yaw_rad + 0.5 * turn)
        velocity.append((x, y, turn / PATH_STEP_S))
        courses.append(math.atan2(east, north))
    wrenches = []
    for (u, v, r), (later_u, later_v, later_r) in itertools.pairwise(velocity):
        rise = (later_u - u) / PATH_STEP_S, (later_v - v) / PATH_STEP_S, (later_r - r) / PATH_STEP_S
        needed: Wrench = force_for(hull, u, v, r, *rise)
        wrenches.append((needed.surge_n, needed.sway_n, needed.yaw_nm))
    return PlannedSteps([pose.yaw_rad for pose in ahead], courses, velocity, wrenches)
