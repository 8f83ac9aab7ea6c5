"""The MAVLink dialect: pymavlink's `common`, plus the messages that its wheel lacks or has in an older, shorter form.

`MESSAGES` maps every known message id to its class. This module also has all names of `common` (classes, `MAV_CMD_…`,
`MAV_RESULT_…`), so it is imported in its place:

    from companion.io.mavlink.wire import messages as mavlink
    mavlink.MAVLink_available_modes_message(number_modes=1, mode_index=1, …)

Field lists are those of MAVLink's XML in declaration order: common.xml and standard.xml of July 2026, CONTROL_STATUS of
development.xml as first released and, as CONTROL_STATUS_OWNERS, as it is since April 2026; CAMERA_FEEDBACK,
EKF_STATUS_REPORT and MAG_CAL_PROGRESS of ardupilotmega.xml.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from fastcrc import crc16
from pymavlink.dialects.v20 import common

_FORMATS = {
    "char": ("s", 1),
    "uint8_t": ("B", 1),
    "int8_t": ("b", 1),
    "uint16_t": ("H", 2),
    "int16_t": ("h", 2),
    "uint32_t": ("I", 4),
    "int32_t": ("i", 4),
    "float": ("f", 4),
    "uint64_t": ("Q", 8),
    "int64_t": ("q", 8),
    "double": ("d", 8),
}

_ADDRESS = "uint8_t target_system, uint8_t target_component"
_ESC_TELEMETRY = (
    "uint8_t[4] temperature, uint16_t[4] voltage, uint16_t[4] current, uint16_t[4] totalcurrent, uint16_t[4] rpm, "
    "uint16_t[4] count"
)

# (name, id, fields; after "|" the MAVLink 2 extensions)
_SPECS = (
    (
        "MISSION_CURRENT",
        42,
        "uint16_t seq | uint16_t total, uint8_t mission_state, uint8_t mission_mode, uint32_t mission_id, "
        "uint32_t fence_id, uint32_t rally_points_id",
    ),
    ("MISSION_COUNT", 44, f"{_ADDRESS}, uint16_t count | uint8_t mission_type, uint32_t opaque_id"),
    ("MISSION_ACK", 47, f"{_ADDRESS}, uint8_t type | uint8_t mission_type, uint32_t opaque_id"),
    ("AUTOPILOT_VERSION_REQUEST", 183, _ADDRESS),  # of ArduPilot's dialect
    ("COMMAND_CANCEL", 80, f"{_ADDRESS}, uint16_t command"),
    ("TIMESYNC", 111, f"int64_t tc1, int64_t ts1 | {_ADDRESS}"),
    (
        "SERIAL_CONTROL",
        126,
        "uint8_t device, uint8_t flags, uint16_t timeout, uint32_t baudrate, uint8_t count, uint8_t[70] data | "
        f"{_ADDRESS}",
    ),
    (
        "FENCE_STATUS",
        162,
        "uint8_t breach_status, uint16_t breach_count, uint8_t breach_type, uint32_t breach_time | "
        "uint8_t breach_mitigation",
    ),
    (
        "MAG_CAL_PROGRESS",
        191,
        "uint8_t compass_id, uint8_t cal_mask, uint8_t cal_status, uint8_t attempt, uint8_t completion_pct, "
        "uint8_t[10] completion_mask, float direction_x, float direction_y, float direction_z",
    ),
    (
        "CAMERA_FEEDBACK",
        180,
        "uint64_t time_usec, uint8_t target_system, uint8_t cam_idx, uint16_t img_idx, int32_t lat, int32_t lng, "
        "float alt_msl, float alt_rel, float roll, float pitch, float yaw, float foc_len, uint8_t flags | "
        "uint16_t completed_captures",
    ),
    (  # of ArduPilot's dialect
        "EKF_STATUS_REPORT",
        193,
        "uint16_t flags, float velocity_variance, float pos_horiz_variance, float pos_vert_variance, "
        "float compass_variance, float terrain_alt_variance | float airspeed_variance",
    ),
    (
        "PROTOCOL_VERSION",
        300,
        "uint16_t version, uint16_t min_version, uint16_t max_version, uint8_t[8] spec_version_hash, "
        "uint8_t[8] library_version_hash",
    ),
    ("PARAM_ERROR", 345, f"{_ADDRESS}, char[16] param_id, int16_t param_index, uint8_t error"),
    (
        "BATTERY_INFO",
        372,
        "uint8_t id, uint8_t battery_function, uint8_t type, uint8_t state_of_health, uint8_t cells_in_series, "
        "uint16_t cycle_count, uint16_t weight, float discharge_minimum_voltage, float charging_minimum_voltage, "
        "float resting_minimum_voltage, float charging_maximum_voltage, float charging_maximum_current, "
        "float nominal_voltage, float discharge_maximum_current, float discharge_maximum_burst_current, "
        "float design_capacity, float full_charge_capacity, char[9] manufacture_date, char[32] serial_number, "
        "char[50] name",
    ),
    (
        "TIME_ESTIMATE_TO_TARGET",
        380,
        "int32_t safe_return, int32_t land, int32_t mission_next_item, int32_t mission_end, int32_t commanded_action",
    ),
    (
        "COMPONENT_INFORMATION",
        395,
        "uint32_t time_boot_ms, uint32_t general_metadata_file_crc, char[100] general_metadata_uri, "
        "uint32_t peripherals_metadata_file_crc, char[100] peripherals_metadata_uri",
    ),
    ("COMPONENT_METADATA", 397, "uint32_t time_boot_ms, uint32_t file_crc, char[100] uri"),
    (
        "EVENT",
        410,
        "uint8_t destination_component, uint8_t destination_system, uint32_t id, uint32_t event_time_boot_ms, "
        "uint16_t sequence, uint8_t log_levels, uint8_t[40] arguments",
    ),
    ("CURRENT_EVENT_SEQUENCE", 411, "uint16_t sequence, uint8_t flags"),
    ("REQUEST_EVENT", 412, f"{_ADDRESS}, uint16_t first_sequence, uint16_t last_sequence"),
    ("RESPONSE_EVENT_ERROR", 413, f"{_ADDRESS}, uint16_t sequence, uint16_t sequence_oldest_available, uint8_t reason"),
    (
        "AVAILABLE_MODES",
        435,
        "uint8_t number_modes, uint8_t mode_index, uint8_t standard_mode, uint32_t custom_mode, uint32_t properties, "
        "char[35] mode_name",
    ),
    ("CURRENT_MODE", 436, "uint8_t standard_mode, uint32_t custom_mode, uint32_t intended_custom_mode"),
    ("AVAILABLE_MODES_MONITOR", 437, "uint8_t seq"),
    ("CONTROL_STATUS", 512, "uint8_t sysid_in_control, uint8_t flags"),
    ("ESC_TELEMETRY_1_TO_4", 11030, _ESC_TELEMETRY),  # of ArduPilot's dialect, like the next three
    ("ESC_TELEMETRY_5_TO_8", 11031, _ESC_TELEMETRY),
    ("ESC_TELEMETRY_9_TO_12", 11032, _ESC_TELEMETRY),
    ("ESC_TELEMETRY_13_TO_16", 11040, _ESC_TELEMETRY),
)


@dataclass(frozen=True, slots=True)
class _Field:
    name: str
    type: str
    length: int  # number of array elements; 0: not an array
    extension: bool

    @property
    def format(self) -> str:
        """The field's format for `struct`."""
        return f"{self.length or ''}{_FORMATS[self.type][0]}"

    @property
    def is_text(self) -> bool:
        """Whether the field is a char array."""
        return self.type == "char" and self.length > 0


def _fields(text: str) -> Iterator[_Field]:
    for extension, part in enumerate(text.split("|")):
        for declaration in part.split(","):
            found = re.fullmatch(r"(\w+)(?:\[(\d+)\])? (\w+)", declaration.strip())
            assert found is not None, declaration
            yield _Field(found[3], found[1], int(found[2] or 0), bool(extension))


def _wire_order(fields: list[_Field]) -> list[_Field]:
    """The fields in wire order: widest types first, equals as declared; then the extensions as declared."""
    base = [field for field in fields if not field.extension]
    base.sort(key=lambda field: -_FORMATS[field.type][1])
    return base + [field for field in fields if field.extension]


def _crc_extra(name: str, wire: list[_Field]) -> int:
    """The checksum of the message's definition (MAVLink guide, "CRC_EXTRA Calculation")."""
    data = f"{name} ".encode()
    for field in wire:
        if not field.extension:
            data += f"{field.type} {field.name} ".encode() + (bytes([field.length]) if field.length else b"")
    crc = crc16.mcrf4xx(data)
    return (crc & 0xFF) ^ (crc >> 8)


def _constructor(cls_name: str, fields: list[_Field]) -> Any:
    """`__init__` as pymavlink generates it: fields in declaration order, extensions may be left out."""
    defaults: dict[str, Any] = {f.name: ([0] * f.length if f.length else 0) for f in fields if f.extension}
    names = tuple(field.name for field in fields)
    texts = frozenset(field.name for field in fields if field.is_text)

    def __init__(self: Any, *values: Any, **named: Any) -> None:
        common.MAVLink_message.__init__(self, self.id, self.msgname)
        self._fieldnames = list(names)
        given = {**defaults, **dict(zip(names, values, strict=False)), **named}
        if len(given) != len(names) or len(values) > len(names):
            raise TypeError(f"{cls_name} takes {', '.join(names)}")
        for name in names:
            value = given[name]
            if name in texts:
                setattr(self, f"_{name}_raw", value)
                value = value.split(b"\x00", 1)[0].decode("ascii", errors="replace")
            setattr(self, name, value)

    return __init__


def _message_class(name: str, number: int, text: str, another_form: bool = False) -> Any:
    """A message class as pymavlink generates it. `another_form`: of a message that is sent just before it."""
    fields = list(_fields(text))
    wire = _wire_order(fields)
    cls_name = f"MAVLink_{name.lower()}_message"
    body: dict[str, Any] = {
        "id": number,
        "msgname": name,
        "fieldnames": [field.name for field in fields],
        "ordered_fieldnames": [field.name for field in wire],
        "fieldtypes": [field.type for field in fields],
        "fielddisplays_by_name": {},
        "fieldenums_by_name": {},
        "fieldunits_by_name": {},
        "native_format": bytearray(("<" + "".join("c" if f.is_text else _FORMATS[f.type][0] for f in wire)).encode()),
        "orders": [wire.index(field) for field in fields],
        "lengths": [1 if field.is_text else max(1, field.length) for field in wire],
        "array_lengths": [field.length for field in wire],
        "crc_extra": _crc_extra(name, wire),
        "unpacker": struct.Struct("<" + "".join(field.format for field in wire)),
        "instance_field": None,
        "instance_offset": -1,
        "another_form": another_form,
        "__init__": _constructor(cls_name, fields),
        "__doc__": f"{name} #{number}: {text}",
    }
    return type(cls_name, (common.MAVLink_message,), body)


CONTROL_STATUS_OWNERS: Any = _message_class(
    "CONTROL_STATUS", 512, "uint8_t flags, uint8_t gcs_main, uint8_t[10] gcs_secondary", another_form=True
)
"""CONTROL_STATUS with another checksum, for ground stations that know this form and not the one in MESSAGES."""
_OWN: dict[int, Any] = {number: _message_class(name, number, text) for name, number, text in _SPECS}
_OWN_NAMES: dict[str, Any] = {cls.__name__: cls for cls in _OWN.values()}
_OWN_NAMES.update({f"MAVLINK_MSG_ID_{cls.msgname}": number for number, cls in _OWN.items()})

MESSAGES: dict[int, Any] = {**common.mavlink_map, **_OWN}
"""Message id → class, for every message that is known."""


def __getattr__(name: str) -> Any:
    """A name of this module's own classes, else of `common`. It is cached, so each name is looked up once."""
    value = _OWN_NAMES[name] if name in _OWN_NAMES else getattr(common, name)
    globals()[name] = value
    return value
