"""SBUS of RC receivers (Futaba, FrSky, Radiomaster and others): 100000 baud, 8E2, inverted.

25 bytes every 7 or 14 ms: 0x0F, 16 channels of 11 bits, flags, 0x00 (SBUS2: 0x04, 0x14, 0x24, 0x34). Flags: 0x04 the
radio has lost a frame and the channels are those before, 0x08 failsafe.

There is no checksum. So frames count from the tenth in a row without a fault, and each channel is the median of the
last three. A channel that jumps away for one frame is a fault. So one spoilt byte moves no stick and throws no switch,
and a bad line is a lost transmitter.

Source: no maker publishes it; bolderflight/sbus and PX4 (src/lib/rc/sbus.cpp) agree on the frame, Betaflight gives the
scale of the channels (Futaba's centre is 1520 µs).
"""

from __future__ import annotations

from companion.config.devices import SensorConfig
from companion.core.ports import ByteStream
from companion.core.readings import Reading
from companion.io.sensors.rc_stream import CHANNEL_BYTES, RcStream, unpacked

_HEADER, _LENGTH = 0x0F, 25
_ENDS = frozenset({0x00, 0x04, 0x14, 0x24, 0x34})
_FRAME_LOST, _FAILSAFE, _UNUSED_FLAGS = 0x04, 0x08, 0xF0
_IN_A_ROW = 3
_PROVEN = 10  # frames without a fault, after which a line is trusted
_JUMP = 100  # steps, 62 µs; no stick goes there and back within two frames
_KEPT_BYTES = _LENGTH * (_IN_A_ROW + 1)

Frame = tuple[tuple[int, ...], int]
"""Channels and flags."""


class SbusReceiver(RcStream):
    """Bytes → `RcInput`. Remembers the last bytes, and up to three frames in a row, and how many came without a
    fault."""

    messages = "SBUS frames"

    def __init__(self, config: SensorConfig, stream: ByteStream) -> None:
        super().__init__(config, stream)
        self._buffer = b""
        self._row: list[Frame] = []
        self._clean = 0

    def _nonsense(self) -> str:
        return (
            self._overheard.guess
            or "SBUS is inverted: does the port or an inverter turn it? and :100000?parity=even&stopbits=2"
        )

    def _feed(self, arrival_s: float, data: bytes, readings: list[Reading]) -> None:
        self._buffer += data
        while len(self._buffer) >= _LENGTH * (1 if self._row else _IN_A_ROW):
            frame = _frame(self._buffer)
            if frame is None or (not self._row and not _follows(self._buffer)):
                self._bad += bool(self._row)
                self._row.clear()
                self._clean = 0
                self._buffer = self._buffer[1:]
                continue
            self._buffer = self._buffer[_LENGTH:]
            self._hear(frame, arrival_s)
        self._buffer = self._buffer[-_KEPT_BYTES:]

    def _hear(self, frame: Frame, arrival_s: float) -> None:
        self._row = [*self._row, frame][-_IN_A_ROW:]
        self._clean += 1
        if len(self._row) == _IN_A_ROW and _jumps(*(each[0] for each in self._row)):
            self._bad += 1
            self._clean = 0
        if self._clean < _PROVEN:
            return
        self._count_valid(arrival_s)
        flags = [each[1] for each in self._row]
        failsafe = _most(flags, _FAILSAFE)
        if failsafe or not _most(flags, _FRAME_LOST):  # lost frames repeat old channels: silence
            middle = [sorted(values)[_IN_A_ROW // 2] for values in zip(*(each[0] for each in self._row), strict=True)]
            self._take(arrival_s, middle, failsafe)


def _frame(data: bytes) -> Frame | None:
    """The frame at the beginning of `data`, if one is there."""
    flags = data[_LENGTH - 2]
    if data[0] != _HEADER or data[_LENGTH - 1] not in _ENDS or flags & _UNUSED_FLAGS:
        return None
    return unpacked(data[1 : 1 + CHANNEL_BYTES]), flags


def _follows(data: bytes) -> bool:
    """Whether frames follow the first one."""
    return all(_frame(data[n * _LENGTH :]) is not None for n in range(1, _IN_A_ROW))


def _jumps(first: tuple[int, ...], middle: tuple[int, ...], last: tuple[int, ...]) -> bool:
    """Whether a channel is far from where it was before and after."""
    return any(not min(a, c) - _JUMP <= b <= max(a, c) + _JUMP for a, b, c in zip(first, middle, last, strict=True))


def _most(flags: list[int], bit: int) -> bool:
    return sum(bool(each & bit) for each in flags) > _IN_A_ROW // 2
