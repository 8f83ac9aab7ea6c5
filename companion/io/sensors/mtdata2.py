"""Xsens MTi inertial sensors: MTData2 messages over serial.

Source: Xsens, MT Low-Level Communication Protocol Documentation. A message is FA FF MID LEN DATA CS; LEN 255 is
followed by the length in two bytes; all bytes after FA add up to 0 modulo 256; numbers are big-endian. The identifier
of an attitude tells whether it is to NED, ENU (as the device comes) or NWU. Its axes are those of the boat: it is
mounted forward-right-down, or turned so by its own setting, which `configure` and `rotation_deg` write at the start.
"""

from __future__ import annotations

import math
import re
import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from operator import itemgetter
from typing import Any

from companion.config.devices import SensorConfig
from companion.core.ports import ByteStream
from companion.core.readings import Imu, MagneticField, Reading
from companion.core.tick import DeviceHealth
from companion.io.sensors.driver import StreamDriver
from companion.io.sensors.mtdata2_setup import ANSWERS, ERROR, SET_OUTPUT_ACK, error_text, mti_setup, rate_problem
from companion.io.sensors.own_yaw import OwnYaw
from companion.io.sensors.sample_clock import SampleClock
from companion.nav.lever_arms import Quaternion, multiply, quaternion_of

_MTDATA2 = 0x36
_PREAMBLE_BYTES = 3
_preamble = re.compile(b"\xfa\xff[\x36" + b"".join(b"\\x%02x" % number for number in ANSWERS) + b"]").search
_EXTENDED = 0xFF
_LONGEST = 2048  # of a message's data; the protocol's own limit
_KEPT_BYTES = 2 * _LONGEST

_PACKET_COUNTER = 0x1020
_SAMPLE_TIME_FINE = 0x1060  # ticks of 0.1 ms, wraps at 2³²
_QUATERNION = 0x2010
_EULER_ANGLES = 0x2030
_ACCELERATION = 0x4020
_RATE_OF_TURN = 0x8020
_MAGNETIC_FIELD = 0xC020
_STATUS_WORD = 0xE020

_GROUP_MASK = 0xFFF0  # the low nibble is precision (bits 0, 1) and frame (bits 2, 3)
_PRECISION_MASK, _FRAME_MASK = 0x3, 0xC
_NED, _ENU, _NWU = 0x4, 0x0, 0x8
_TO_NED: Mapping[int, Quaternion] = {  # half a turn about the bisector of north and east, and about north
    _ENU: (0.0, math.sqrt(0.5), math.sqrt(0.5), 0.0),
    _NWU: (0.0, 1.0, 0.0, 0.0),
}
_FLOAT_32, _FIXED_1220, _FIXED_1632, _FLOAT_64 = range(4)
_COUNTS: Mapping[int, int] = {_QUATERNION: 4, _EULER_ANGLES: 3, _ACCELERATION: 3, _RATE_OF_TURN: 3, _MAGNETIC_FIELD: 3}
_ATTITUDES = (_QUATERNION, _EULER_ANGLES)
_FLOATS: Mapping[int, struct.Struct] = {
    **{group | _FLOAT_32: struct.Struct(f">{count}f") for group, count in _COUNTS.items()},
    **{group | _FLOAT_64: struct.Struct(f">{count}d") for group, count in _COUNTS.items()},
}
_ANGLES = struct.Struct("<3f")
_header_at = struct.Struct(">HB").unpack_from
_word_at = struct.Struct(">I").unpack_from

_WHOLE = b"\xfa\xff\x36"  # begins a message with data
_BEFORE_ITEMS, _ITEM_HEAD, _WORD_BYTES = 4, 3, 4
_MOST_LAYOUTS = 8

_SELF_TEST_OK = 0x1
_CLIPPING = 0x00080000


@dataclass(frozen=True, slots=True)
class _Layout:
    """Where the numbers of a message stand, for the next one with the same items. `values` gives all values of a
    message, `heads` those that must be `expected`; `groups`: measurement, first value, the one past the last;
    `ticks`, `status`: of which value that is, or None."""

    values: Callable[[bytes], tuple[Any, ...]]
    heads: Callable[[tuple[Any, ...]], tuple[Any, ...]]
    expected: tuple[Any, ...]
    groups: tuple[tuple[int, int, int], ...]
    ticks: int | None
    status: int | None


class Mtdata2Sensor(StreamDriver):
    """MTData2 bytes → `Imu` readings, `MagneticField` readings where the device sends its field, and `Heading` readings
    from its own yaw where `heading` in the vessel's file allows it.

    Remembers the unfinished message and the relation of the device's clock to the vessel's. A message without both
    acceleration and rate of turn gives no `Imu` but counts as valid; where all are so, that is a fault.
    """

    messages = "MTData2 messages"

    def __init__(self, config: SensorConfig, stream: ByteStream) -> None:
        super().__init__(config, stream)
        self._buffer = bytearray()
        self._layouts: dict[int, _Layout | None] = {}  # by the length of the message; None: of no use
        self._clock = SampleClock(config.latency_s)
        self._remark = ""
        self._rate_remark = ""
        self._setup = mti_setup(config) if config.configure or config.rotation_rad is not None else None
        self._own_yaw = OwnYaw(config)

    def _feed(self, arrival_s: float, data: bytes, readings: list[Reading]) -> None:
        if not self._buffer and _is_whole(data):
            self._message(arrival_s, data, readings)
        else:
            self._search(arrival_s, data, readings)

    def _search(self, arrival_s: float, data: bytes, readings: list[Reading]) -> None:
        """Take bytes that may be parts of messages, and others between them."""
        buffer = self._buffer
        buffer += data
        at = 0
        while True:
            if (found := _preamble(buffer, at)) is None:
                at = max(at, len(buffer) - _PREAMBLE_BYTES + 1)
                break
            at = found.start()
            end = self._message_end(at)
            if end is None:
                at += 1
                self._bad += 1
                continue
            if end > len(buffer):
                break
            message = bytes(buffer[at:end])
            if sum(message) & 0xFF != message[0]:
                at += 1
                self._bad += 1
                continue
            if message[2] == _MTDATA2:
                self._message(arrival_s, message, readings)
            else:
                self._answer(arrival_s, message[2], message[4:-1])
            at = end
        del buffer[:at]
        if len(buffer) > _KEPT_BYTES:
            del buffer[:-_KEPT_BYTES]

    def _message_end(self, at: int) -> int | None:
        """Where the message that begins at `at` ends, beyond the buffer if that is not known yet; None: it cannot be
        one."""
        buffer = self._buffer
        if len(buffer) < at + 4:
            return len(buffer) + 1
        length = buffer[at + 3]
        if length != _EXTENDED:
            return at + 5 + length
        if len(buffer) < at + 6:
            return len(buffer) + 1
        length = buffer[at + 4] << 8 | buffer[at + 5]
        return at + 7 + length if length <= _LONGEST else None

    def _answer(self, arrival_s: float, number: int, data: bytes) -> None:
        """To a command of ours."""
        self._count_valid(arrival_s, "answer")
        setup = self._setup
        if setup is None:
            return
        if number == ERROR:
            setup.refused(error_text(data), arrival_s)
        elif setup.heard(number) and number == SET_OUTPUT_ACK:
            self._rate_remark = rate_problem(data, self._config.rate_hz)

    def _message(self, arrival_s: float, message: bytes, readings: list[Reading]) -> None:
        layout = self._layouts.get(len(message))
        if layout is not None:
            found = layout.values(message)
            if layout.heads(found) == layout.expected:
                self._quick(arrival_s, layout, found, readings)
                return
        elif len(message) not in self._layouts and len(self._layouts) < _MOST_LAYOUTS:
            self._layouts[len(message)] = _layout_of(message)
        self._items(arrival_s, message, readings)

    def _quick(self, arrival_s: float, layout: _Layout, found: tuple[Any, ...], readings: list[Reading]) -> None:
        """Take a message of a known layout."""
        values: dict[int, tuple[float, ...]] = {}
        for group, first, end in layout.groups:
            numbers = found[first:end]
            total: float = sum(numbers)
            if math.isfinite(total):  # it is not as soon as one of them is not
                values[group] = numbers
        if layout.status is not None:
            self._note_status(found[layout.status])
        self._count_valid(arrival_s)
        self._emit(arrival_s, None if layout.ticks is None else found[layout.ticks], values, readings)

    def _items(self, arrival_s: float, message: bytes, readings: list[Reading]) -> None:
        """Take a message item by item."""
        values: dict[int, tuple[float, ...]] = {}
        ticks: int | None = None
        at, end = (6 if message[3] == _EXTENDED else 4), len(message) - 1
        while at + 3 <= end:
            data_id, size = _header_at(message, at)
            at += 3
            if at + size > end:
                self._bad += 1
                return
            group, precision = data_id & _GROUP_MASK, data_id & _PRECISION_MASK
            if group in _COUNTS:
                unpacker = _FLOATS.get(group | precision)
                if unpacker is None:
                    numbers = _fixed_point(precision, _COUNTS[group], message[at : at + size])
                else:
                    numbers = unpacker.unpack_from(message, at) if size == unpacker.size else ()
                if numbers and math.isfinite(sum(numbers)):  # it is not as soon as one of them is not
                    values[_measurement(data_id)] = numbers
            elif group == _SAMPLE_TIME_FINE and size == 4:
                (ticks,) = _word_at(message, at)
            elif group == _STATUS_WORD and size == 4:
                self._note_status(*_word_at(message, at))
            at += size
        self._count_valid(arrival_s)
        self._emit(arrival_s, ticks, values, readings)

    def _emit(
        self, arrival_s: float, ticks: int | None, values: Mapping[int, tuple[float, ...]], readings: list[Reading]
    ) -> None:
        acceleration, rate = values.get(_ACCELERATION), values.get(_RATE_OF_TURN)
        t_s = arrival_s - self._config.latency_s
        if ticks is not None:
            direct_s, t_s = t_s, self._clock.time_s(ticks, arrival_s)
            self._pace.late(direct_s - t_s)
        if field := values.get(_MAGNETIC_FIELD):
            readings.append(MagneticField(t_s, self.name, *field))
        self._count_use(arrival_s, acceleration is not None and rate is not None)
        if acceleration is None or rate is None:
            return
        x, y, z = acceleration
        p, q, r = rate
        roll, pitch, yaw = _attitude(values)
        readings.append(Imu(t_s, self.name, x, y, z, p, q, r, roll, pitch, yaw))
        if (heading := self._own_yaw.heading(t_s, yaw)) is not None:
            readings.append(heading)

    def _note_status(self, word: int) -> None:
        if not word & _SELF_TEST_OK:
            self._remark = "self-test failed"
        elif word & _CLIPPING:
            self._remark = "a measurement is at the end of its range"
        else:
            self._remark = ""

    def _complaint(self, age_s: float | None) -> str:
        complaint = super()._complaint(age_s) or self._remark
        if complaint or not self._is_useless:
            return complaint
        return "sends no acceleration and rate of turn: configure = true, or MT Manager's output configuration"

    def health(self, now_s: float) -> DeviceHealth:
        """As every driver's, with a remark where the device gives another rate than was asked for."""
        health = super().health(now_s)
        return replace(health, text=f"{health.text}; {self._rate_remark}") if self._rate_remark else health


def _is_whole(data: bytes) -> bool:
    """Whether this is one message with data, and nothing else."""
    if data[:_PREAMBLE_BYTES] != _WHOLE or len(data) <= _BEFORE_ITEMS or data[_PREAMBLE_BYTES] == _EXTENDED:
        return False
    return len(data) == data[_PREAMBLE_BYTES] + _BEFORE_ITEMS + 1 and sum(data) & 0xFF == data[0]


def _layout_of(message: bytes) -> _Layout | None:
    """The layout of a message; None for one that is left to the slow way: long, in fixed point, or damaged."""
    items = _items_of(message)
    form, count, heads = f">{_BEFORE_ITEMS}s", 1, [0]
    groups: dict[int, tuple[int, int, int]] = {}
    numbers: dict[int, int] = {}  # places of whole numbers
    for data_id, size in items:
        heads.append(count)
        form, count, group = f"{form}{_ITEM_HEAD}s", count + 1, data_id & _GROUP_MASK
        floats = _FLOATS.get(data_id & (_GROUP_MASK | _PRECISION_MASK))
        if floats is not None and floats.size == size and group not in groups:
            groups[group] = _measurement(data_id), count, count + _COUNTS[group]
            form, count = form + floats.format[1:], count + _COUNTS[group]
        elif group in _COUNTS:
            return None
        elif group in (_SAMPLE_TIME_FINE, _STATUS_WORD) and size == _WORD_BYTES:
            numbers[group] = count
            form, count = f"{form}I", count + 1
        else:
            form = f"{form}{size}x"
    if not items:
        return None
    values, heads_of = struct.Struct(f"{form}x").unpack, itemgetter(*heads)
    ticks, status = numbers.get(_SAMPLE_TIME_FINE), numbers.get(_STATUS_WORD)
    return _Layout(values, heads_of, heads_of(values(message)), tuple(groups.values()), ticks, status)


def _items_of(message: bytes) -> list[tuple[int, int]]:
    """(identifier, size) of each item; none where they do not fill the message, or its length stands in two bytes."""
    items: list[tuple[int, int]] = []
    at, end = _BEFORE_ITEMS, len(message) - 1
    while message[3] != _EXTENDED and at + _ITEM_HEAD <= end:
        data_id, size = _header_at(message, at)
        items.append((data_id, size))
        at += _ITEM_HEAD + size
    return items if at == end else []


def _fixed_point(precision: int, count: int, raw: bytes) -> tuple[float, ...]:
    """The numbers of a data item in fixed point; none where its size is not what its identifier says."""
    if precision == _FIXED_1220 and len(raw) == 4 * count:
        return tuple(value / 2**20 for value in struct.unpack(f">{count}i", raw))
    if precision == _FIXED_1632 and len(raw) == 6 * count:  # 32 fraction bits first, then 16 integer bits
        return tuple(high + low / 2**32 for low, high in struct.iter_unpack(">Ih", raw))
    return ()


def _measurement(data_id: int) -> int:
    """The group of an identifier; with the frame, where it is an attitude."""
    group = data_id & _GROUP_MASK
    return data_id & (_GROUP_MASK | _FRAME_MASK) if group in _ATTITUDES else group


def _attitude(values: Mapping[int, tuple[float, ...]]) -> tuple[float | None, float | None, float | None]:
    """(roll, pitch, yaw) in radians from Euler angles in degrees or from the quaternion body → NED, ENU or NWU; Nones
    without either. They have the digits of float32, as the device's own numbers do, which halves their place in the
    log."""
    if euler := values.get(_EULER_ANGLES | _NED):
        return _digits_of_float32(math.radians(euler[0]), math.radians(euler[1]), math.radians(euler[2]))
    if quaternion := values.get(_QUATERNION | _NED):
        w, x, y, z = quaternion
        return _angles_of((w, x, y, z))
    for frame, turn in _TO_NED.items():
        if euler := values.get(_EULER_ANGLES | frame):
            roll, pitch, yaw = map(math.radians, euler)
            return _angles_of(multiply(turn, quaternion_of(roll, pitch, yaw)))
        if quaternion := values.get(_QUATERNION | frame):
            w, x, y, z = quaternion
            return _angles_of(multiply(turn, (w, x, y, z)))
    return None, None, None


def _angles_of(quaternion: Quaternion) -> tuple[float, float, float]:
    w, x, y, z = quaternion
    roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
    pitch = math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x))))
    return _digits_of_float32(roll, pitch, math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)))


def _digits_of_float32(roll: float, pitch: float, yaw: float) -> tuple[float, float, float]:
    return _ANGLES.unpack(_ANGLES.pack(roll, pitch, yaw))
