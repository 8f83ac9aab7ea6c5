"""Messages about pictures: CAMERA_TRIGGER and CAMERA_FEEDBACK."""

from __future__ import annotations

import math
from typing import Any

from companion.core.payload import Shot
from companion.core.tick import Tick
from companion.io.mavlink.telemetry.view import degrees_e7
from companion.io.mavlink.wire import messages as mavlink

_NOT_CONFIRMED = 4  # CAMERA_FEEDBACK_OPENLOOP: the camera was triggered, and does not say whether it took the picture


def camera_trigger(shot: Shot, tick: Tick) -> Any:
    """CAMERA_TRIGGER: the number of the picture among those of all cameras."""
    return mavlink.MAVLink_camera_trigger_message(_unix_us(tick), shot.count & 0xFFFFFFFF)


def camera_feedback(shot: Shot, tick: Tick, system: int) -> Any | None:
    """CAMERA_FEEDBACK: where the picture was taken; None without a position. Altitude above home as the second one."""
    if not math.isfinite(shot.lat_deg + shot.lon_deg):
        return None
    home = tick.status.home
    return mavlink.MAVLink_camera_feedback_message(
        _unix_us(tick),
        system,
        shot.camera - 1,
        shot.number & 0xFFFF,
        degrees_e7(shot.lat_deg),
        degrees_e7(shot.lon_deg),
        shot.altitude_m,
        shot.altitude_m - (shot.altitude_m if home is None else home.altitude_m),
        math.degrees(shot.roll_rad),
        math.degrees(shot.pitch_rad),
        math.degrees(shot.yaw_rad) % 360.0,
        0.0,
        _NOT_CONFIRMED,
        shot.number & 0xFFFF,
    )


def _unix_us(tick: Tick) -> int:
    return max(0, (tick.nav.time_unix_ns or tick.time_unix_ns) // 1000)
