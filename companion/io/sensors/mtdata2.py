"""Xsens MTi inertial sensors: MTData2 messages over serial.

Source: Xsens, MT Low-Level Communication Protocol Documentation. A message is FA FF MID LEN DATA CS; LEN 255 is followed by the length
in two bytes; all bytes after FA add up to 0 modulo 256; numbers are big-endian. The device is configured for its NED output frame and
mounted forward-right-down, so its axes are the boat's.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Mapping

from companion.config import SensorConfig
from companion.core.angles import wrap_pi
from companion.core.ports import ByteStream
from companion.core.types import Heading, HeadingBy, Imu, MagneticField, Reading
from companion.io.sensors.driver import StreamDriver

_PREAMBLE = b"\xfa\xff\x36"  # with the identifier of MTData2: no other message is of interest
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
_PRECISION_MASK = 0x3
_FLOAT_32, _FIXED_1220, _FIXED_1632, _FLOAT_64 = range(4)
_COUNTS: Mapping[int, int] = {_QUATERNION: 4, _EULER_ANGLES: 3, _ACCELERATION: 3, _RATE_OF_TURN: 3, _MAGNETIC_FIELD: 3}
_FLOATS: Mapping[int, struct.Struct] = {
    **{group | _FLOAT_32: struct.Struct(f">{count}f") for group, count in _COUNTS.items()},
    **{group | _FLOAT_64: struct.Struct(f">{count}d") for group, count in _COUNTS.items()},
}
_header_at = struct.Struct(">HB").unpack_from
_word_at = struct.Struct(">I").unpack_from
_TICK_S = 1e-4
_TICKS_WRAP = 2**32

_HEADING_BY = {"none": None, "ahrs": None, "magnetic": HeadingBy.MAGNETIC, "true": HeadingBy.COMPASS}
_HEADING_PERIOD_S = 0.095  # its errors are slow: ten a second say all there is to know

_SELF_TEST_OK = 0x1
_CLIPPING = 0x00080000


class SampleClock:
    """The device's own sample times → vessel time, free of the jitter of arrival.

    In: sample time in ticks of 0.1 ms and the time of arrival; out: time of validity, never after arrival less `latency_s`. Remembers
    the smallest delay seen, which may grow by 2 parts in 10 000 of the time, so that crystals may differ; a jump of either clock by more
    than `jump_s` starts anew.
    """

    _DRIFT = 2e-4

    def __init__(self, latency_s: float, jump_s: float = 0.5) -> None:
        self._latency_s = latency_s
        self._jump_s = jump_s
        self._last_ticks: int | None = None
        self._device_s = 0.0
        self._offset_s = 0.0

    def time_s(self, ticks: int, arrival_s: float) -> float:
        """Time at which the sample was taken, in vessel time."""
        step_s = 0.0 if self._last_ticks is None else (ticks - self._last_ticks) % _TICKS_WRAP * _TICK_S
        first = self._last_ticks is None
        self._last_ticks = ticks
        self._device_s += step_s
        direct = arrival_s - self._latency_s - self._device_s
        offset = self._offset_s + self._DRIFT * step_s
        self._offset_s = direct if first or abs(direct - offset) > self._jump_s else min(direct, offset)
        return min(self._device_s + self._offset_s, arrival_s - self._latency_s)


class Mtdata2Sensor(StreamDriver):
    """MTData2 bytes → `Imu` readings, `MagneticField` readings where the device sends its field, and `Heading` readings by its own yaw
    where the configuration says what that is worth.

    Remembers the unfinished message, the relation of the device's clock to the vessel's, and when it last gave a heading. Messages without both acceleration and rate of turn give no reading, but count as valid: the health text then says what is missing.
    """

    messages = "MTData2 messages"

    def __init__(self, config: SensorConfig, stream: ByteStream) -> None:
        super().__init__(config, stream)
        self._buffer = bytearray()
        self._clock = SampleClock(config.latency_s)
        self._remark = ""
        self._heading_by = _HEADING_BY[config.heading]
        self._heading_s = -math.inf

    def _feed(self, arrival_s: float, data: bytes, readings: list[Reading]) -> None:
        buffer = self._buffer
        buffer += data
        at = 0
        while True:
            at = buffer.find(_PREAMBLE, done := at)
            if at < 0:
                at = max(done, len(buffer) - len(_PREAMBLE) + 1)
                break
            end = self._message_end(at)
            if end is None:
                at += 1
                self._bad += 1
                continue
            if end > len(buffer):
                break
            message = bytes(buffer[at:end])
            if sum(message) & 0xFF != _PREAMBLE[0]:
                at += 1
                self._bad += 1
                continue
            self._message(arrival_s, message, readings)
            at = end
        del buffer[:at]
        if len(buffer) > _KEPT_BYTES:
            del buffer[:-_KEPT_BYTES]

    def _message_end(self, at: int) -> int | None:
        """Where the message that begins at `at` ends, beyond the buffer if that is not known yet; None: it cannot be one."""
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

    def _message(self, arrival_s: float, message: bytes, readings: list[Reading]) -> None:
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
                    values[group] = numbers
            elif group == _SAMPLE_TIME_FINE and size == 4:
                (ticks,) = _word_at(message, at)
            elif group == _STATUS_WORD and size == 4:
                self._note_status(*_word_at(message, at))
            at += size
        self._count_valid(arrival_s)
        self._emit(arrival_s, ticks, values, readings)

    def _emit(self, arrival_s: float, ticks: int | None, values: Mapping[int, tuple[float, ...]], readings: list[Reading]) -> None:
        acceleration, rate = values.get(_ACCELERATION), values.get(_RATE_OF_TURN)
        t_s = arrival_s - self._config.latency_s if ticks is None else self._clock.time_s(ticks, arrival_s)
        if field := values.get(_MAGNETIC_FIELD):
            readings.append(MagneticField(t_s, self.name, *field))
        if acceleration is None or rate is None:
            return
        x, y, z = acceleration
        p, q, r = rate
        roll, pitch, yaw = _attitude(values)
        readings.append(Imu(t_s, self.name, x, y, z, p, q, r, roll, pitch, yaw))
        if self._heading_by is not None and yaw is not None and not 0.0 <= t_s - self._heading_s < _HEADING_PERIOD_S:
            self._heading_s = t_s
            readings.append(Heading(t_s, self.name, wrap_pi(yaw + self._config.heading_offset_rad), None, self._heading_by))

    def _note_status(self, word: int) -> None:
        if not word & _SELF_TEST_OK:
            self._remark = "self-test failed"
        elif word & _CLIPPING:
            self._remark = "a measurement is at the end of its range"
        else:
            self._remark = ""

    def _complaint(self, age_s: float | None) -> str:
        return super()._complaint(age_s) or self._remark


def _fixed_point(precision: int, count: int, raw: bytes) -> tuple[float, ...]:
    """The numbers of a data item in fixed point; none where its size is not what its identifier says."""
    if precision == _FIXED_1220 and len(raw) == 4 * count:
        return tuple(value / 2**20 for value in struct.unpack(f">{count}i", raw))
    if precision == _FIXED_1632 and len(raw) == 6 * count:  # 32 fraction bits first, then 16 integer bits
        return tuple(high + low / 2**32 for low, high in struct.iter_unpack(">Ih", raw))
    return ()


def _attitude(values: Mapping[int, tuple[float, ...]]) -> tuple[float | None, float | None, float | None]:
    """(roll, pitch, yaw) in radians from Euler angles in degrees or from the quaternion body → NED; Nones without either."""
    if euler := values.get(_EULER_ANGLES):
        return math.radians(euler[0]), math.radians(euler[1]), math.radians(euler[2])
    if quaternion := values.get(_QUATERNION):
        w, x, y, z = quaternion
        roll = math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y))
        pitch = math.asin(max(-1.0, min(1.0, 2.0 * (w * y - z * x))))
        return roll, pitch, math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    return None, None, None
