"""The messages of the formats that a boat's devices speak, found in any bytes: each counted by its kind, if its check
sum holds.

NMEA 0183 and AIS: $ or !, fields, * and the exclusive or in two hexadecimal digits. Xsens: FA FF MID LEN DATA CS (MT
Low-Level Communication Protocol), MTData2 being MID 36. RTCM 3: D3, 6 bits of 0, 10 of length, the message, CRC-24Q
(RTCM 10403). u-blox: B5 62 class id length payload and two sums (u-blox interface description). MAVLink and the frames
of our own boards: by their decoders.
"""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Iterator
from enum import Enum
from functools import reduce
from operator import xor
from typing import Any, NamedTuple

from companion.core.microcontroller_frame import BoardStatus, FrameDecoder, Ident
from companion.io.mavlink.wire.framer import Framer, UnknownMessage
from companion.io.rtcm import crc24q

_NMEA = re.compile(rb"([$!])([A-Z][A-Z0-9]{2,9}),([ -#%-)+-~]{0,200})\*([0-9A-Fa-f]{2})")
_NMEA_KEPT = 220
_XSENS = re.compile(rb"\xfa\xff")
_MTDATA2, _EXTENDED = 0x36, 0xFF
_XSENS_ITEMS = {
    0x20: "attitude",
    0x40: "acceleration",
    0x50: "position",
    0x80: "rate of turn",
    0xC0: "magnetic field",
    0xD0: "velocity",
}
_RTCM = re.compile(rb"\xd3[\x00-\x03]")
_UBX = re.compile(rb"\xb5\x62")
_MOST_FAILED = 4  # a call
_BOARD_BYTES = 30  # of a status, about


class LineFormat(Enum):
    """A format that a line may carry, with its name for people."""

    NMEA = "NMEA 0183"
    AIS = "AIS"
    MTDATA2 = "MTData2"
    XSENS = "Xsens messages, but no MTData2"
    MAVLINK = "MAVLink"
    BOARD = "frames of a thruster board"
    RTCM = "RTCM 3"
    UBX = "u-blox binary"


class Found(NamedTuple):
    """A message: its format, its kind, its length in bytes, and for some formats the decoded message."""

    format: LineFormat
    kind: str
    length: int
    message: Any = None


class NmeaFinder:
    """Sentences of NMEA 0183 and AIS. `bad` counts the sentences with a wrong checksum."""

    def __init__(self) -> None:
        self.bad = 0
        self._rest = b""

    def feed(self, data: bytes) -> Iterator[Found]:
        """The messages that the next bytes complete."""
        buffer, done = self._rest + data, 0
        for match in _NMEA.finditer(buffer):
            done = match.end()
            if reduce(xor, match[0][1:-3]) != int(match[4], 16):
                self.bad += 1
            else:
                kind = match[2].decode("ascii")
                yield Found(LineFormat.AIS if match[1] == b"!" else LineFormat.NMEA, kind, len(match[0]))
        self._rest = buffer[max(done, len(buffer) - _NMEA_KEPT) :]


class BinaryFinder(ABC):
    """Messages that begin with two fixed bytes and give their length. Remembers an unfinished one. It stops searching
    bytes that begin many messages and hold none, so that such garbage costs little."""

    def __init__(self, start: re.Pattern[bytes]) -> None:
        self._start = start
        self._rest = b""

    def feed(self, data: bytes) -> Iterator[Found]:
        """The messages that the next bytes complete."""
        buffer, at, failed = self._rest + data, 0, 0
        while failed < _MOST_FAILED and (match := self._start.search(buffer, at)) is not None:
            at = match.start()
            length = self.length(buffer, at)
            if length is None or at + length > len(buffer):
                self._rest = buffer[at:]
                return
            found = self.judge(buffer[at : at + length])
            if found is None:
                at, failed = at + 1, failed + 1
            else:
                at += length
                yield found
        self._rest = buffer[max(at, len(buffer) - 1) :]

    @abstractmethod
    def length(self, buffer: bytes, at: int) -> int | None:
        """Length of the whole message that begins at `at`; None where too few of its bytes are there."""

    @abstractmethod
    def judge(self, message: bytes) -> Found | None:
        """The message, or None where its checksum does not hold."""


class XsensFinder(BinaryFinder):
    """Messages of Xsens devices, MTData2 among them."""

    def __init__(self) -> None:
        super().__init__(_XSENS)

    def length(self, buffer: bytes, at: int) -> int | None:
        """See `BinaryFinder`."""
        if len(buffer) < at + 4:
            return None
        if buffer[at + 3] != _EXTENDED:
            return 5 + buffer[at + 3]
        return None if len(buffer) < at + 6 else 7 + min(2048, buffer[at + 4] << 8 | buffer[at + 5])

    def judge(self, message: bytes) -> Found | None:
        """See `BinaryFinder`. The kind is the list of measurements."""
        if sum(message[1:]) & 0xFF:
            return None
        if message[2] != _MTDATA2:
            return Found(LineFormat.XSENS, f"message {message[2]:02X}", len(message))
        names, at, end = [], 6 if message[3] == _EXTENDED else 4, len(message) - 1
        while at + 3 <= end:
            if (name := _XSENS_ITEMS.get(message[at])) is not None:
                names.append(name)
            at += 3 + message[at + 2]
        return Found(LineFormat.MTDATA2, ", ".join(names) or "no measurement", len(message))


class RtcmFinder(BinaryFinder):
    """Frames of RTCM 3."""

    def __init__(self) -> None:
        super().__init__(_RTCM)

    def length(self, buffer: bytes, at: int) -> int | None:
        """See `BinaryFinder`."""
        return None if len(buffer) < at + 3 else 6 + ((buffer[at + 1] & 3) << 8 | buffer[at + 2])

    def judge(self, message: bytes) -> Found | None:
        """See `BinaryFinder`. The kind is the message number."""
        if len(message) < 8 or crc24q(message) != 0:
            return None
        return Found(LineFormat.RTCM, str(message[3] << 4 | message[4] >> 4), len(message))


class UbxFinder(BinaryFinder):
    """Messages of u-blox receivers."""

    def __init__(self) -> None:
        super().__init__(_UBX)

    def length(self, buffer: bytes, at: int) -> int | None:
        """See `BinaryFinder`."""
        return None if len(buffer) < at + 6 else 8 + min(2048, int.from_bytes(buffer[at + 4 : at + 6], "little"))

    def judge(self, message: bytes) -> Found | None:
        """See `BinaryFinder`. The kind is class and id."""
        a = b = 0
        for byte in message[2:-2]:
            a = (a + byte) & 0xFF
            b = (b + a) & 0xFF
        if (a, b) != tuple(message[-2:]):
            return None
        return Found(LineFormat.UBX, f"{message[2]:02X} {message[3]:02X}", len(message))


class MavlinkFinder:
    """Messages of MAVLink 1 and 2, each with the decoded message."""

    def __init__(self) -> None:
        self._framer = Framer()

    def feed(self, data: bytes) -> Iterator[Found]:
        """The messages that the next bytes complete."""
        for message in self._framer.feed(data):
            if message.__class__ is not UnknownMessage:
                yield Found(LineFormat.MAVLINK, message.get_type(), len(message.get_msgbuf()), message)


class BoardFinder:
    """Frames that boards send. Commands do not count: only a companion sends those."""

    def __init__(self) -> None:
        self._decoder = FrameDecoder()

    def feed(self, data: bytes) -> Iterator[Found]:
        """The messages that the next bytes complete."""
        for message in self._decoder.feed(data):
            if isinstance(message, Ident | BoardStatus):
                yield Found(
                    LineFormat.BOARD, "identity" if isinstance(message, Ident) else "status", _BOARD_BYTES, message
                )
