"""The messages of log.mcap other than readings: those of a tick, and those that Foxglove knows.

Sources: foxglove-sdk, schemas `foxglove.LocationFix`, `PoseInFrame`, `FrameTransform`, `Log`. As viewers expect, the
frame `map` is x east, y north, z up around home, and `boat` is x ahead, y to port, z up. Positions are rounded to a
tenth of a millimetre: `/tick` has them exactly.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator, Sequence

from mcap.records import Channel, McapRecord, Schema
from mcap.well_known import MessageEncoding, SchemaEncoding

from companion.core.tick import Tick
from companion.record.protobuf import (
    Field,
    MessageType,
    Row,
    blob,
    descriptor_file,
    descriptor_set,
    tag,
    text,
    varint,
    whole,
)
from companion.record.recorded import TICK_COLUMNS

TICK, PARAMETER, PACKET, HEALTH, LOG, POSITION, POSE, TRANSFORM = range(1, 9)  # channels, and their schemas
FIRST_FREE = 20
MODE, FAILSAFES, ORDER, THROTTLE, AZIMUTH, FORCE, SET_THROTTLE, SET_AZIMUTH = range(1, 9)  # fields of Tick
FIRST_VALUE = 16
_MORE = (
    "position_accuracy_m", "heading_accuracy_rad", "cross_track_error_m", "mission_seq", "load", "position_valid",
    "heading_valid", "fix", "satellites", "roll_rad", "pitch_rad", "battery_v", "battery_a", "battery_remaining",
    "wind_speed_mps", "wind_from_rad", "current_north_mps", "current_east_mps",
)  # fmt: skip
_TICK_FIELDS = [Field(name, FIRST_VALUE + at, "double") for at, name in enumerate(TICK_COLUMNS)]
_MORE_FIELDS = [Field(name, FIRST_VALUE + len(TICK_COLUMNS) + at, "float") for at, name in enumerate(_MORE)]
TICK_ROW, TICK_MORE = Row(_TICK_FIELDS), Row(_MORE_FIELDS)

_MESSAGES = {
    TICK: MessageType(
        "Tick",
        (
            Field("mode", MODE, "string"),
            Field("failsafes", FAILSAFES, "string"),
            Field("order", ORDER, "uint32", repeated=True),
            Field("throttle", THROTTLE, "float", repeated=True),
            Field("azimuth_rad", AZIMUTH, "float", repeated=True),
            Field("force_n", FORCE, "float", repeated=True),
            Field("setpoint_throttle", SET_THROTTLE, "double", repeated=True),
            Field("setpoint_azimuth_rad", SET_AZIMUTH, "double", repeated=True),
            *_TICK_FIELDS,
            *_MORE_FIELDS,
        ),
    ),
    PARAMETER: MessageType("Parameter", (Field("name", 1, "string"), Field("value", 2, "double"))),
    PACKET: MessageType(
        "MavlinkPacket",
        (
            Field("t_s", 1, "double"),
            Field("persona", 2, "string"),
            Field("endpoint", 3, "string"),
            Field("data", 4, "bytes"),
        ),
    ),
    HEALTH: MessageType(
        "DeviceHealth", (Field("name", 1, "string"), Field("ok", 2, "bool"), Field("text", 3, "string"))
    ),
}
_STAMP = "google/protobuf/timestamp.proto"
_TIMESTAMP = MessageType("Timestamp", (Field("seconds", 1, "int64"), Field("nanos", 2, "int32")))
_STAMP_FILE = descriptor_file(_STAMP, "google.protobuf", [_TIMESTAMP])
_STAMP_KIND = ".google.protobuf.Timestamp"
_XYZ = tuple(Field(name, at, "double") for at, name in enumerate("xyz", start=1))
_VECTOR = MessageType("Vector3", _XYZ)
_QUATERNION = MessageType("Quaternion", (*_XYZ, Field("w", 4, "double")))
_POSE_TYPE = MessageType(
    "Pose", (Field("position", 1, ".foxglove.Vector3"), Field("orientation", 2, ".foxglove.Quaternion"))
)
_FOXGLOVE = {
    LOG: [
        MessageType(
            "Log",
            (
                Field("timestamp", 1, _STAMP_KIND),
                Field("level", 2, "enum:.foxglove.Log.Level"),
                Field("message", 3, "string"),
                Field("name", 4, "string"),
            ),
            ("Level", ("UNKNOWN", "DEBUG", "INFO", "WARNING", "ERROR", "FATAL")),
        )
    ],
    POSITION: [
        MessageType(
            "LocationFix",
            (
                Field("latitude", 1, "double"),
                Field("longitude", 2, "double"),
                Field("altitude", 3, "double"),
                Field("position_covariance", 4, "double", repeated=True),
                Field("position_covariance_type", 5, "enum:.foxglove.LocationFix.PositionCovarianceType"),
                Field("timestamp", 6, _STAMP_KIND),
                Field("frame_id", 7, "string"),
            ),
            ("PositionCovarianceType", ("UNKNOWN", "APPROXIMATED", "DIAGONAL_KNOWN", "KNOWN")),
        )
    ],
    POSE: [
        MessageType(
            "PoseInFrame",
            (
                Field("timestamp", 1, _STAMP_KIND),
                Field("frame_id", 2, "string"),
                Field("pose", 3, ".foxglove.Pose"),
            ),
        ),
        _POSE_TYPE,
        _VECTOR,
        _QUATERNION,
    ],
    TRANSFORM: [
        MessageType(
            "FrameTransform",
            (
                Field("timestamp", 1, _STAMP_KIND),
                Field("parent_frame_id", 2, "string"),
                Field("child_frame_id", 3, "string"),
                Field("translation", 4, ".foxglove.Vector3"),
                Field("rotation", 5, ".foxglove.Quaternion"),
            ),
        ),
        _VECTOR,
        _QUATERNION,
    ],
}
_TOPICS = {
    TICK: "/tick",
    PARAMETER: "/parameter",
    PACKET: "/packet",
    HEALTH: "/health",
    LOG: "/log",
    POSITION: "/position",
    POSE: "/pose",
    TRANSFORM: "/tf",
}
_APPROXIMATED = whole(5, 1)
_IN_MAP_2, _IN_MAP_7, _BOAT_3 = text(2, "map"), text(7, "map"), text(3, "boat")
_THREE = Row([Field("", number, "double") for number in range(1, 4)])
_FOUR = Row([Field("", number, "double") for number in range(1, 5)])
_ROUNDING = 1.5 * 2.0**52  # added and subtracted again, it rounds to whole numbers; a part of it, to parts of one
# fewer digits compress better; NaN and infinity stay what they are, and what is too large is merely rounded less well
_DEGREES, _METRES, _TURNS = _ROUNDING / 2.0**30, _ROUNDING / 2.0**14, _ROUNDING / 2.0**20
_SQUARE_METRES, _SHOWN = _ROUNDING / 2.0**24, _ROUNDING / 2.0**14
_COVARIANCE = struct.Struct("<9d")


def _fixed_records() -> list[McapRecord]:
    records: list[McapRecord] = []
    for number, topic in _TOPICS.items():
        if number in _MESSAGES:
            name = f"usv.{_MESSAGES[number].name}"
            files = [descriptor_file(f"usv/{_MESSAGES[number].name}.proto", "usv", [_MESSAGES[number]])]
        else:
            messages = _FOXGLOVE[number]
            name = f"foxglove.{messages[0].name}"
            files = [_STAMP_FILE, descriptor_file(f"foxglove/{messages[0].name}.proto", "foxglove", messages, [_STAMP])]
        records.append(Schema(number, descriptor_set(files), SchemaEncoding.Protobuf, name))
        records.append(Channel(number, topic, MessageEncoding.Protobuf, {}, number))
    return records


FIXED_RECORDS = _fixed_records()


def or_nan(value: float | None) -> float:
    """NaN for None."""
    return math.nan if value is None else value


def more_values(tick: Tick) -> Sequence[float]:
    """The values of a tick that a replay does not need: _MORE_FIELDS."""
    nav, status, battery = tick.nav, tick.status, tick.inputs.battery
    volts, amperes, left = (
        (math.nan, math.nan, math.nan)
        if battery is None
        else (battery.voltage_v, or_nan(battery.current_a), or_nan(battery.remaining))
    )
    values = (
        nav.position_accuracy_m, nav.heading_accuracy_rad, or_nan(tick.setpoint.progress.cross_track_error_m),
        status.mission.seq, tick.load, nav.position_valid, nav.heading_valid, int(nav.fix), or_nan(nav.satellites),
        nav.roll_rad, nav.pitch_rad, volts, amperes, left, or_nan(nav.wind_speed_mps), or_nan(nav.wind_from_rad),
        or_nan(nav.current_north_mps), or_nan(nav.current_east_mps),
    )  # fmt: skip
    return rounded(values)


def rounded(values: Sequence[float]) -> Sequence[float]:
    """Values that people look at: to 0.0001, so that they compress."""
    return [value + _SHOWN - _SHOWN for value in values]


def stamp(number: int, unix_ns: int) -> bytes:
    """A field that is a google.protobuf.Timestamp."""
    seconds, nanos = divmod(max(0, unix_ns), 1_000_000_000)
    return blob(number, tag(1, 0) + varint(seconds) + whole(2, nanos))


def views(tick: Tick) -> Iterator[tuple[int, bytes]]:
    """(channel, message) of the boat's place for viewers."""
    nav, when = tick.nav, stamp(1, tick.time_unix_ns)
    variance = _stepped(nav.position_accuracy_m**2, _SQUARE_METRES)
    covariance = _COVARIANCE.pack(variance, 0.0, 0.0, 0.0, variance, 0.0, 0.0, 0.0, 0.0)
    fix = (_stepped(nav.lat_deg, _DEGREES), _stepped(nav.lon_deg, _DEGREES), _stepped(nav.altitude_m, _METRES))
    yield (
        POSITION,
        _THREE.packed(fix) + blob(4, covariance) + _APPROXIMATED + stamp(6, tick.time_unix_ns) + _IN_MAP_7,
    )
    place = _THREE.packed((_stepped(nav.east_m, _METRES), _stepped(nav.north_m, _METRES), 0.0))
    half = 0.5 * (0.5 * math.pi - nav.yaw_rad)
    turn = _FOUR.packed((0.0, 0.0, _stepped(math.sin(half), _TURNS), _stepped(math.cos(half), _TURNS)))
    yield POSE, when + _IN_MAP_2 + blob(3, blob(1, place) + blob(2, turn))
    yield TRANSFORM, when + _IN_MAP_2 + _BOAT_3 + blob(4, place) + blob(5, turn)


def _stepped(value: float, adder: float) -> float:
    return value + adder - adder
