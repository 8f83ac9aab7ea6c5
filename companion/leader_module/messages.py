"""The messages of a leader module: FOLLOW_TARGET of its own motion, HEARTBEAT, sticks."""

from __future__ import annotations

import math
from typing import Any

from companion.core.estimate import NavState
from companion.core.readings import LEADER_MODULE, FixType, ManualInput, Wish
from companion.io.mavlink.telemetry.view import degrees_e7
from companion.io.mavlink.wire import messages as mavlink

COMPONENT: int = mavlink.MAV_COMP_ID_ONBOARD_COMPUTER
_POSITION, _VELOCITY, _ATTITUDE = 1, 2, 8  # est_capabilities
_MASK_U64 = (1 << 64) - 1
_NOTHING = (0.0, 0.0, 0.0)
_FULL = 1000


def follow_target(nav: NavState, placed: bool, wish: Wish, presses: int, whole: bool) -> Any:
    """The lead boat at `nav.t_s`: NED velocity, attitude (zeros without a heading), body rates, and one sigma of
    position.

    `placed`: it has a fix; without one the position is 0, 0. `whole` False leaves the last fields, accuracy and
    capabilities, at zero. They are then not sent, which saves 13 bytes; the receiver keeps those of the last whole
    message.
    """
    can = (_POSITION | _VELOCITY if placed else 0) | (_ATTITUDE if nav.heading_valid else 0)
    return mavlink.MAVLink_follow_target_message(
        timestamp=max(0, round(nav.t_s * 1000.0)) & _MASK_U64,
        est_capabilities=can if whole else 0,
        lat=degrees_e7(nav.lat_deg) if placed else 0,
        lon=degrees_e7(nav.lon_deg) if placed else 0,
        alt=nav.altitude_m if placed else 0.0,
        vel=(nav.north_mps, nav.east_mps, 0.0) if placed else _NOTHING,
        acc=_NOTHING,
        attitude_q=_quaternion(nav.roll_rad, nav.pitch_rad, nav.yaw_rad) if nav.heading_valid else (*_NOTHING, 0.0),
        rates=(nav.roll_rate_radps, nav.pitch_rate_radps, nav.yaw_rate_radps),
        position_cov=(nav.position_accuracy_m, nav.position_accuracy_m, 0.0) if whole and placed else _NOTHING,
        custom_state=LEADER_MODULE | int(wish) | presses << 32 | int(nav.fix if placed else FixType.NONE) << 40,
    )


def heartbeat() -> Any:
    """Towards the follower: an onboard computer, not a vehicle."""
    return mavlink.MAVLink_heartbeat_message(
        mavlink.MAV_TYPE_ONBOARD_CONTROLLER, mavlink.MAV_AUTOPILOT_INVALID, 0, 0, mavlink.MAV_STATE_ACTIVE, 3
    )


def manual_control(sticks: ManualInput, target: int) -> Any:
    """x and z are both surge, since vessels differ in which they obey; y is sway, r yaw. A missing axis is centred."""
    surge, sway, yaw = (
        round(_FULL * min(1.0, max(-1.0, axis or 0.0))) for axis in (sticks.surge, sticks.sway, sticks.yaw)
    )
    return mavlink.MAVLink_manual_control_message(target, surge, sway, surge, yaw, 0)


def _quaternion(roll_rad: float, pitch_rad: float, yaw_rad: float) -> tuple[float, float, float, float]:
    """(w, x, y, z) of yaw, pitch, roll, in that order about the moving axes (NED to body)."""
    (cr, sr), (cp, sp), (cy, sy) = (
        (math.cos(0.5 * angle), math.sin(0.5 * angle)) for angle in (roll_rad, pitch_rad, yaw_rad)
    )
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )
