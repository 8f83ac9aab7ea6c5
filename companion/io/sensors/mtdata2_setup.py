"""Configuration of an Xsens MTi at the start: which data, how often, and how it is mounted.

Source: Xsens (Movella), MT Low-Level Communication Protocol Documentation, SetOutputConfiguration,
SetAlignmentRotation, Error; MTi User Manual, "Arbitrary alignment": v_object = R_OS · v_sensor for RotSensor.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping

from companion.config.devices import SensorConfig
from companion.io.sensors.setup import DeviceSetup, Step
from companion.nav.lever_arms import quaternion_of

GO_TO_CONFIG_ACK, SET_OUTPUT_ACK, SET_ALIGNMENT_ACK, GO_TO_MEASUREMENT_ACK, ERROR = 0x31, 0xC1, 0xED, 0x11, 0x42
ANSWERS = bytes((GO_TO_CONFIG_ACK, SET_OUTPUT_ACK, SET_ALIGNMENT_ACK, GO_TO_MEASUREMENT_ACK, ERROR))
_GO_TO_CONFIG, _SET_OUTPUT, _SET_ALIGNMENT, _GO_TO_MEASUREMENT = 0x30, 0xC0, 0xEC, 0x10
_ROT_SENSOR = 0
_PACKET_COUNTER, _SAMPLE_TIME_FINE, _QUATERNION_NED, _ACCELERATION, _RATE_OF_TURN = (
    0x1020,
    0x1060,
    0x2014,
    0x4020,
    0x8020,
)
_MAGNETIC_FIELD, _STATUS_WORD = 0xC020, 0xE020
_EVERY = 0xFFFF  # with every message
_FIELD_HZ = 50
_FASTEST_HZ = 2000
_ERRORS: Mapping[int, str] = {
    0x03: "invalid period",
    0x04: "invalid message",
    0x1E: "too much for its output at that rate",
    0x20: "invalid baud rate",
    0x21: "invalid parameter",
}


def mti_setup(config: SensorConfig) -> DeviceSetup:
    """The commands that configure a device as its row says."""
    rate_hz = min(max(round(config.rate_hz), 1), _FASTEST_HZ)  # 0 would be as fast as it can
    outputs = [(_PACKET_COUNTER, _EVERY), (_SAMPLE_TIME_FINE, _EVERY)]
    if config.heading != "ahrs":
        outputs.append((_QUATERNION_NED, rate_hz))
    outputs += [(_ACCELERATION, rate_hz), (_RATE_OF_TURN, rate_hz)]
    if config.heading == "ahrs":
        outputs.append((_MAGNETIC_FIELD, min(rate_hz, _FIELD_HZ)))
    outputs.append((_STATUS_WORD, _EVERY))
    steps = [
        Step("GoToConfig", message(_GO_TO_CONFIG), GO_TO_CONFIG_ACK),
        Step(
            "SetOutputConfiguration",
            message(_SET_OUTPUT, b"".join(struct.pack(">HH", *row) for row in outputs)),
            SET_OUTPUT_ACK,
        ),
    ]
    if config.rotation_rad is not None:
        data = struct.pack(">B4f", _ROT_SENSOR, *quaternion_of(*config.rotation_rad))
        steps.append(Step("SetAlignmentRotation", message(_SET_ALIGNMENT, data), SET_ALIGNMENT_ACK))
    steps.append(Step("GoToMeasurement", message(_GO_TO_MEASUREMENT), GO_TO_MEASUREMENT_ACK))
    return DeviceSetup(steps)


def message(number: int, data: bytes = b"") -> bytes:
    """One message to the device: FA FF MID LEN DATA CS."""
    body = bytes((0xFF, number, len(data))) + data
    return b"\xfa" + body + bytes((-sum(body) & 0xFF,))


def rate_problem(answer: bytes, asked_hz: float) -> str:
    """The rate that a SetOutputConfigurationAck really gives, where it differs from the one asked for; else empty."""
    for data_id, rate_hz in struct.iter_unpack(">HH", answer[: len(answer) // 4 * 4]):
        if data_id & 0xFFF0 == _ACCELERATION and rate_hz != round(asked_hz):
            return f"gives {rate_hz} Hz, not the {asked_hz:g} asked for"
    return ""


def error_text(data: bytes) -> str:
    """An Error message's data for people."""
    code = data[0] if data else 0
    return _ERRORS.get(code, f"error {code}")
