"""OBSTACLE_DISTANCE and DISTANCE_SENSOR as readings (MAVLink common.xml). A sensor on a port of its own and a computer
on a link send the same."""

from __future__ import annotations

import math
from typing import Any

from companion.core.readings import Depth, Ranges, Reading
from companion.io.mavlink.wire import messages as mavlink

OBSTACLE_DISTANCE: int = mavlink.MAVLINK_MSG_ID_OBSTACLE_DISTANCE
DISTANCE_SENSOR: int = mavlink.MAVLINK_MSG_ID_DISTANCE_SENSOR
_BODY_FRAMES = (mavlink.MAV_FRAME_BODY_FRD, mavlink.MAV_FRAME_BODY_NED, mavlink.MAV_FRAME_BODY_OFFSET_NED)
_UNKNOWN = 0xFFFF
_NO_SIGNAL = 1  # signal_quality of a distance that is none; 0 is not told
_FORWARD, _LAST_YAW = mavlink.MAV_SENSOR_ROTATION_NONE, mavlink.MAV_SENSOR_ROTATION_YAW_315
_DOWN = mavlink.MAV_SENSOR_ROTATION_PITCH_270
_EIGHTH_RAD = math.radians(45.0)
_BEAM_RAD = math.radians(5.0)  # width of a sensor that does not say it
_NARROWEST_DEG = 0.01  # a sector; what is narrower is no measure of a device, and would divide the circle endlessly
_MOST_TURN_DEG = 720.0
_CM = 0.01


def ranges_of(
    message: Any, source: str, t_s: float, offset_rad: float = 0.0, x_m: float = 0.0, y_m: float = 0.0
) -> Ranges | None:
    """The sectors of an OBSTACLE_DISTANCE; None where it is of no use. `offset_rad`: how the sensor is turned in the
    boat; `x_m`, `y_m`: where it sits."""
    step_deg = message.increment_f if message.increment_f else float(message.increment)
    if not (_NARROWEST_DEG <= abs(step_deg) <= 90.0 and abs(message.angle_offset) <= _MOST_TURN_DEG):
        return None
    count = min(len(message.distances), int(360.0 / abs(step_deg) + 1e-6))
    distances = [_distance_m(cm, message.max_distance) for cm in message.distances[:count]]
    first_deg = message.angle_offset
    if step_deg < 0.0:
        first_deg, step_deg, distances = first_deg + step_deg * (count - 1), -step_deg, distances[::-1]
    in_body = message.frame in _BODY_FRAMES
    return Ranges(
        t_s,
        source,
        math.radians(first_deg) + (offset_rad if in_body else 0.0),
        math.radians(step_deg),
        message.min_distance * _CM,
        message.max_distance * _CM,
        not in_body,
        x_m,
        y_m,
        tuple(distances),
    )


def reading_of(
    message: Any, source: str, t_s: float, offset_rad: float = 0.0, x_m: float = 0.0, y_m: float = 0.0
) -> Reading | None:
    """What a DISTANCE_SENSOR measures: one sector around, or the depth below; None for other directions. One that sees
    nothing tells its max_distance: the message has no other value for that."""
    turn, signal = int(message.orientation), message.signal_quality != _NO_SIGNAL
    if turn == _DOWN:
        least_cm = max(1, message.min_distance)  # 0: many sounders say so that they find no bottom
        measured = signal and least_cm <= message.current_distance < message.max_distance
        depth_m = message.current_distance * _CM
        return Depth(t_s, source, depth_m, None, message.max_distance * _CM) if measured else None
    if not _FORWARD <= turn <= _LAST_YAW:
        return None
    told = math.radians(_NARROWEST_DEG) <= message.horizontal_fov < math.pi
    width = message.horizontal_fov if told else _BEAM_RAD
    first = _EIGHTH_RAD * turn + offset_rad
    least_m, most_m = message.min_distance * _CM, message.max_distance * _CM
    distance_m = _distance_m(message.current_distance, message.max_distance - 1) if signal else math.nan
    return Ranges(t_s, source, first, width, least_m, most_m, False, x_m, y_m, (distance_m,))


def _distance_m(cm: int, most_cm: int) -> float:
    """NaN where it is not known, infinite where nothing is in reach (beyond `most_cm`)."""
    if cm == _UNKNOWN:
        return math.nan
    return math.inf if cm > most_cm else cm * _CM
