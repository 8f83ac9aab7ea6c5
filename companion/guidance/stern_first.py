"""Sailing stern first: the boat as seen from its stern, and back.

A law for motion ahead sees a boat that is turned round, whose stern is its bow. What it asks for is then turned back,
so that every law sails stern first as it sails ahead.
"""

from __future__ import annotations

import math
from dataclasses import replace

from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.core.setpoint import PathSetpoint


def turned(nav: NavState) -> NavState:
    """The boat's motion with its stern as bow. Velocities over ground and the turn stay."""
    return replace(nav, yaw_rad=wrap_pi(nav.yaw_rad + math.pi), surge_mps=-nav.surge_mps, sway_mps=-nav.sway_mps)


def turned_back(setpoint: PathSetpoint) -> PathSetpoint:
    """The setpoint for the boat itself, of one for the boat that is `turned`."""
    return replace(
        setpoint,
        yaw_rad=wrap_pi(setpoint.yaw_rad + math.pi),
        surge_mps=-setpoint.surge_mps,
        sway_mps=-setpoint.sway_mps,
        surge_mps2=-setpoint.surge_mps2,
        sway_mps2=-setpoint.sway_mps2,
        ahead=tuple(replace(pose, yaw_rad=wrap_pi(pose.yaw_rad + math.pi)) for pose in setpoint.ahead),
    )
