"""The settings of an emulated MTi, and its answers to the commands that change them.

Source: MT Low-Level Communication Protocol. FA FF MID LEN DATA CS; an acknowledgement has the command's number plus
one. Settings are accepted in the configuration state only, in which nothing is measured. RotSensor (parameter 0)
rotates from sensor axes to the axes of the object: v_object = R_OS v_sensor.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]

_GO_TO_MEASUREMENT, _GO_TO_CONFIG, _SET_OUTPUT, _SET_ALIGNMENT, _ERROR = 0x10, 0x30, 0xC0, 0xEC, 0x42
_INVALID_MESSAGE, _INVALID_PARAMETER = 4, 0x21
_EVERY = 0xFFFF
_IDENTITY: Quaternion = (1.0, 0.0, 0.0, 0.0)
KNOWN = frozenset({0x1020, 0x1060, 0x2014, 0x4020, 0x8020, 0xC020, 0xE020})


class XsensSettings:
    """Bytes of the host → answers. Remembers the state, the outputs and their rates, and the rotation.

    `mounting_rad`: roll, pitch and yaw of the device in the boat. `outputs`: identifier → one in how many samples; None
    as delivered.
    """

    def __init__(self, mounting_rad: Vector | None, fastest_hz: float) -> None:
        self._mounting = _IDENTITY if mounting_rad is None else _from_euler(*mounting_rad)
        self._alignment = _IDENTITY
        self._fastest_hz = fastest_hz
        self._buffer = b""
        self.measuring = True
        self.outputs: dict[int, int] | None = None

    def hear(self, data: bytes) -> bytes:
        """The answers to the host's bytes."""
        self._buffer += data
        return b"".join(self._answer(number, content) for number, content in self._messages())

    def _messages(self) -> Iterator[tuple[int, bytes]]:
        while (at := self._buffer.find(b"\xfa\xff")) >= 0:
            buffer = self._buffer = self._buffer[at:]
            if len(buffer) < 4 or len(buffer) < (size := 5 + buffer[3]):
                return
            if sum(buffer[1:size]) & 0xFF:
                self._buffer = buffer[1:]
                continue
            self._buffer = buffer[size:]
            yield buffer[2], buffer[4 : size - 1]

    def _answer(self, number: int, content: bytes) -> bytes:
        if number == _GO_TO_CONFIG:
            self.measuring = False
        elif number == _GO_TO_MEASUREMENT:
            self.measuring = True
        elif self.measuring or number not in (_SET_OUTPUT, _SET_ALIGNMENT):
            return _message(_ERROR, bytes((_INVALID_MESSAGE,)))
        elif number == _SET_OUTPUT:
            return self._set_output(content)
        else:
            return self._set_alignment(content)
        return _message(number + 1)

    def _set_output(self, content: bytes) -> bytes:
        rows = list(struct.iter_unpack(">HH", content)) if len(content) % 4 == 0 else []
        if not rows or any(data_id not in KNOWN or rate_hz == 0 for data_id, rate_hz in rows):
            return _message(_ERROR, bytes((_INVALID_PARAMETER,)))
        self.outputs = {data_id: 1 if hz == _EVERY else max(1, round(self._fastest_hz / hz)) for data_id, hz in rows}
        given = [(i, _EVERY if hz == _EVERY else round(self._fastest_hz / self.outputs[i])) for i, hz in rows]
        return _message(_SET_OUTPUT + 1, b"".join(struct.pack(">HH", *row) for row in given))

    def _set_alignment(self, content: bytes) -> bytes:
        if len(content) != 17 or content[0] != 0:
            return _message(_ERROR, bytes((_INVALID_PARAMETER,)))
        q = struct.unpack_from(">4f", content, 1)
        length = math.sqrt(sum(part * part for part in q))
        if not 0.99 < length < 1.01:
            return _message(_ERROR, bytes((_INVALID_PARAMETER,)))
        self._alignment = (q[0] / length, q[1] / length, q[2] / length, q[3] / length)
        return _message(_SET_ALIGNMENT + 1)

    def turned(self, vector: Vector) -> Vector:
        """A vector in body axes as the device reports it: in its own axes, rotated by RotSensor."""
        return _rotate(self._alignment, _rotate(_inverse(self._mounting), vector))

    def attitude(self, boat: Quaternion) -> Quaternion:
        """The attitude that the device reports while the boat has `boat` (body → NED)."""
        return _times(_times(boat, self._mounting), _inverse(self._alignment))


def _message(number: int, data: bytes = b"") -> bytes:
    body = bytes((0xFF, number, len(data))) + data
    return b"\xfa" + body + bytes((-sum(body) & 0xFF,))


def _times(a: Quaternion, b: Quaternion) -> Quaternion:
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


def _inverse(q: Quaternion) -> Quaternion:
    return q[0], -q[1], -q[2], -q[3]


def _rotate(q: Quaternion, v: Vector) -> Vector:
    _, x, y, z = _times(_times(q, (0.0, *v)), _inverse(q))
    return x, y, z


def _from_euler(roll: float, pitch: float, yaw: float) -> Quaternion:
    """Rotation by yaw, then pitch, then roll about the new axes."""
    about_z = (math.cos(0.5 * yaw), 0.0, 0.0, math.sin(0.5 * yaw))
    about_y = (math.cos(0.5 * pitch), 0.0, math.sin(0.5 * pitch), 0.0)
    about_x = (math.cos(0.5 * roll), math.sin(0.5 * roll), 0.0, 0.0)
    return _times(_times(about_z, about_y), about_x)
