"""SET_POSITION_TARGET_LOCAL_NED and SET_POSITION_TARGET_GLOBAL_INT as setpoints: what their masks and frames mean.

Frames as ArduPilot's Rover takes them, since clients send them so: in 8, 9 and 12 all counts from the boat along its
axes (MAVProxy's `guided forward`), in 7 the position from the boat along north and east. Heights are left out. A mask
whose FORCE bit is set where no acceleration is meant is none of forces: MAVProxy sends it.
"""

from __future__ import annotations

import math
from typing import Any

from companion.core.geodesy import LocalFrame
from companion.io.mavlink.commands.request import is_place
from companion.io.mavlink.wire import messages as mavlink
from companion.modes.parts.offboard_target import OffboardTarget

_X_Y = 0b11  # shifted by where position, velocity and acceleration begin
_VELOCITY_AT, _ACCELERATION_AT = 3, 6
_FORCE, _IGNORE_YAW, _IGNORE_RATE = 1 << 9, 1 << 10, 1 << 11
_LOCAL = {  # frame → (along the boat's axes, position from the boat)
    int(mavlink.MAV_FRAME_LOCAL_NED): (False, False),
    int(mavlink.MAV_FRAME_LOCAL_OFFSET_NED): (False, True),
    int(mavlink.MAV_FRAME_BODY_NED): (True, True),
    int(mavlink.MAV_FRAME_BODY_OFFSET_NED): (True, True),
    int(mavlink.MAV_FRAME_BODY_FRD): (True, True),
}
_GLOBAL = frozenset(
    {
        int(mavlink.MAV_FRAME_GLOBAL),
        int(mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT),
        int(mavlink.MAV_FRAME_GLOBAL_INT),
        int(mavlink.MAV_FRAME_GLOBAL_RELATIVE_ALT_INT),
        int(mavlink.MAV_FRAME_GLOBAL_TERRAIN_ALT_INT),
    }
)


def read_local(message: Any) -> OffboardTarget | str:
    """Of SET_POSITION_TARGET_LOCAL_NED; or why it is none."""
    axes = _LOCAL.get(message.coordinate_frame)
    if axes is None:
        return f"frame {message.coordinate_frame} is not a local one"
    return _target(message, (message.x, message.y), *axes)


def read_global(message: Any, frame: LocalFrame) -> OffboardTarget | str:
    """Of SET_POSITION_TARGET_GLOBAL_INT, in the local plane; or why it is none."""
    if message.coordinate_frame not in _GLOBAL:
        return f"frame {message.coordinate_frame} is not a global one"
    if message.type_mask & _X_Y == _X_Y:
        return _target(message, (0.0, 0.0), False, False)
    lat_deg, lon_deg = message.lat_int * 1e-7, message.lon_int * 1e-7
    if not is_place(lat_deg, lon_deg):
        return "no such place"
    return _target(message, frame.to_ned(lat_deg, lon_deg), False, False)


def _target(message: Any, place: tuple[float, float], body: bool, offset: bool) -> OffboardTarget | str:
    """The parts that the mask leaves. Half of a pair is none: who means the other half 0 says so."""
    mask = message.type_mask
    pairs: list[tuple[float, float] | None] = []
    for name, at, pair in (
        ("position", 0, place),
        ("velocity", _VELOCITY_AT, (message.vx, message.vy)),
        ("acceleration", _ACCELERATION_AT, (message.afx, message.afy)),
    ):
        ignored = mask >> at & _X_Y
        if ignored not in (0, _X_Y):
            return f"half of a {name}"
        if not ignored and not (math.isfinite(pair[0]) and math.isfinite(pair[1])):
            return f"a {name} that is not a number"
        pairs.append(None if ignored else pair)
    position, velocity, acceleration = pairs
    if mask & _FORCE and acceleration is not None:
        return "forces are not taken, accelerations are"
    turns, heads = not mask & _IGNORE_RATE, not mask & _IGNORE_YAW
    if (turns and not math.isfinite(message.yaw_rate)) or (heads and math.isinf(message.yaw)):
        return "a heading or yaw rate that is not a number"
    keeps = heads and math.isnan(message.yaw)
    if not (turns or heads or any(pair is not None for pair in pairs)):
        return "nothing is asked for"
    yaw_rad = message.yaw if heads and not keeps else None
    rate_radps = message.yaw_rate if turns and not heads else None
    return OffboardTarget(position, velocity, acceleration, yaw_rad, rate_radps, keeps, body, offset)
