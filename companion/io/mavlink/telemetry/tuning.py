"""Messages that tuning pages and plots ask for (SET_MESSAGE_INTERVAL): what is done, and what is asked for.

QGroundControl asks for ATTITUDE_QUATERNION with ATTITUDE_TARGET (yaw, yaw rate), and for LOCAL_POSITION_NED with
POSITION_TARGET_LOCAL_NED (velocity), each 100 times a second; it gets them once a tick.
"""

from __future__ import annotations

from typing import Any

from companion.core.setpoint import desired_motion
from companion.io.mavlink.telemetry.view import View
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.personas import Persona
from companion.nav.lever_arms import quaternion_of

_NO_ROLL_RATE, _NO_PITCH_RATE = 1, 2  # ATTITUDE_TARGET_TYPEMASK


def attitude_quaternion(view: View, persona: Persona) -> Any:
    """ATTITUDE_QUATERNION."""
    if view.tick is None:
        return None
    nav = view.tick.nav
    return mavlink.MAVLink_attitude_quaternion_message(
        view.boot_ms,
        *quaternion_of(nav.roll_rad, nav.pitch_rad, nav.yaw_rad),
        nav.roll_rate_radps,
        nav.pitch_rate_radps,
        nav.yaw_rate_radps,
    )


def attitude_target(view: View, persona: Persona) -> Any:
    """ATTITUDE_TARGET: heading, yaw rate, and the force ahead as a share of the boat's limit; None while no heading is
    asked for."""
    if view.tick is None:
        return None
    desired = desired_motion(view.tick.setpoint)
    if desired.yaw_rad is None:
        return None
    share = view.tick.wrench.surge_n / view.vessel.config.limits.surge_n
    return mavlink.MAVLink_attitude_target_message(
        view.boot_ms,
        _NO_ROLL_RATE | _NO_PITCH_RATE,
        quaternion_of(0.0, 0.0, desired.yaw_rad),
        0.0,
        0.0,
        desired.yaw_rate_radps,
        min(1.0, max(-1.0, share)),
    )
