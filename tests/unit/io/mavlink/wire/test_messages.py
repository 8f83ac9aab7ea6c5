from __future__ import annotations

import subprocess
import sys

import pytest
from pymavlink.dialects.v20 import common

from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.framer import Framer, frame, pack

# CRC_EXTRA as printed with MAVLink's own definitions: independent of how they are computed here
PRINTED = {
    "COMPONENT_METADATA": (397, 182),
    "AVAILABLE_MODES": (435, 134),
    "AVAILABLE_MODES_MONITOR": (437, 30),
    "CURRENT_MODE": (436, 193),
    "EVENT": (410, 160),
    "CURRENT_EVENT_SEQUENCE": (411, 106),
    "REQUEST_EVENT": (412, 33),
    "RESPONSE_EVENT_ERROR": (413, 77),
    "COMMAND_CANCEL": (80, 14),
    "BATTERY_INFO": (372, 26),
    "PROTOCOL_VERSION": (300, 217),
    "MISSION_COUNT": (44, 221),
    "MISSION_ACK": (47, 153),
    "MISSION_CURRENT": (42, 28),
    "TIMESYNC": (111, 34),
    "PARAM_ERROR": (345, 209),
    "FENCE_STATUS": (162, 189),
    "CAMERA_FEEDBACK": (180, 52),
    "COMPONENT_INFORMATION": (395, 0),
    "TIME_ESTIMATE_TO_TARGET": (380, 232),
}


@pytest.mark.parametrize("name", PRINTED)
def test_crc_extra_is_the_printed_one(name: str) -> None:
    number, crc_extra = PRINTED[name]
    cls = mavlink.MESSAGES[number]
    assert (cls.msgname, cls.id, cls.crc_extra) == (name, number, crc_extra)
    assert getattr(mavlink, f"MAVLink_{name.lower()}_message") is cls
    assert getattr(mavlink, f"MAVLINK_MSG_ID_{name}") == number


def test_the_same_machinery_rebuilds_the_classes_of_the_wheel() -> None:
    """Given the wheel's declarations it arrives at the wheel's wire layout and CRC_EXTRA."""
    compared = 0
    for cls in common.mavlink_map.values():
        lengths = dict(zip(cls.ordered_fieldnames, cls.array_lengths, strict=True))
        fields = [
            f"{kind}{f'[{lengths[name]}]' if lengths[name] else ''} {name}"
            for kind, name in zip(cls.fieldtypes, cls.fieldnames, strict=True)
        ]
        made = mavlink._message_class(cls.msgname, cls.id, ", ".join(fields))
        if made.crc_extra == cls.crc_extra:  # else the wheel has extensions, which its classes do not mark
            assert (made.ordered_fieldnames, made.orders, made.array_lengths) == (
                cls.ordered_fieldnames,
                cls.orders,
                cls.array_lengths,
            )
            assert made.unpacker.format == cls.unpacker.format
            compared += 1
    assert compared > 120


def test_extensions_may_be_left_out() -> None:
    short = mavlink.MAVLink_mission_current_message(7)
    assert (short.seq, short.total, short.mission_id) == (7, 0, 0)
    full = mavlink.MAVLink_mission_count_message(1, 2, 3, mission_type=1, opaque_id=0xDEADBEEF)
    (heard,) = Framer().feed(frame(pack(full), 0, 1, 1))
    assert (heard.target_system, heard.target_component, heard.count, heard.mission_type, heard.opaque_id) == (
        1,
        2,
        3,
        1,
        0xDEADBEEF,
    )


@pytest.mark.parametrize("arguments", [((), {}), ((1, 2, 3, 4), {}), ((1,), {"no_such_field": 1})])
def test_wrong_fields_are_refused(arguments: tuple[tuple[int, ...], dict[str, int]]) -> None:
    with pytest.raises(TypeError):
        mavlink.MAVLink_current_mode_message(*arguments[0], **arguments[1])


def test_texts_end_at_the_first_nul() -> None:
    message = mavlink.MAVLink_available_modes_message(1, 1, 0, 0x00010000, 0, b"Manual")
    assert message.mode_name == "Manual"
    (heard,) = Framer().feed(frame(pack(message), 0, 1, 1))
    assert heard.mode_name == "Manual"
    assert heard.custom_mode == 0x00010000


def test_arrays_come_back_whole() -> None:
    message = mavlink.MAVLink_event_message(1, 2, 3, 4, 5, 6, list(range(40)))
    (heard,) = Framer().feed(frame(pack(message), 0, 1, 1))
    assert list(heard.arguments) == list(range(40))


def test_importing_brings_no_link_layer_of_pymavlink() -> None:
    code = "import sys, companion.io.mavlink.wire.messages; assert 'pymavlink.mavutil' not in sys.modules"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
