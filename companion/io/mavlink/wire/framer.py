"""Bytes ↔ MAVLink messages.

`Framer` finds the frames in a stream of bytes. A frame counts only if its checksum holds. Where it does not, the search
goes on one byte further, so a stray start byte costs only itself. `pack` and `frame` are the way out: a message is
packed once, and framed for each endpoint with that endpoint's sequence number.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from operator import attrgetter, itemgetter
from typing import Any

from fastcrc import crc16

from companion.io.mavlink.wire.messages import MESSAGES

_MARKER_1, _MARKER_2 = 0xFE, 0xFD
_SIGNED = 0x01
_SIGNATURE_LENGTH = 13
# marker, length, incompatible flags, compatible flags, sequence, system, component, id low, id high
_HEADER_2 = struct.Struct("<BBBBBBBHB")
_HEADER_2_LENGTH, _HEADER_1_LENGTH = 10, 6
_CRC = struct.Struct("<H")
_mcrf4xx = crc16.mcrf4xx
_ZEROS = bytes(255)
# Largest payload of a MAVLink 1 frame for each id; -1 for unknown ids.
_SIZES_1 = [MESSAGES[number].unpacker.size if number in MESSAGES else -1 for number in range(256)]


def _ids_above(size: int) -> bytes:
    return b"".join(b"\\x%02x" % number for number in range(256) if _SIZES_1[number] > size)


# Finds where a frame may begin, by flags, length and id: in a flood of start bytes, Python code must not run for each.
_start = re.compile(
    rb"\xfd(?:.[\x00\x01]|.?\Z)|\xfe(?:[\x00-\x3f].{3}[%b]|[\x40-\xff].{3}[%b]|.{0,4}\Z)"
    % (_ids_above(-1), _ids_above(63)),
    re.DOTALL,
).search


# --- out -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Packed:
    """A message's payload as it goes on the wire, without trailing zeros, ready to be framed. `again`: the message
    before it in another form. It has the same sequence number, so that nobody who knows one form misses a packet."""

    id: int
    crc_extra: bytes
    payload: bytes
    again: bool = False


@cache
def _wire_values(cls: Any) -> Callable[[Any], tuple[Any, ...]]:
    """A function message → values in the order of its class's `unpacker`."""
    types = dict(zip(cls.fieldnames, cls.fieldtypes, strict=True))
    arrays = [
        types[name] != "char" and length > 0
        for name, length in zip(cls.ordered_fieldnames, cls.array_lengths, strict=True)
    ]
    names = [
        f"_{name}_raw" if types[name] == "char" and length else name
        for name, length in zip(cls.ordered_fieldnames, cls.array_lengths, strict=True)
    ]
    get: Callable[[Any], Any] = attrgetter(*names)  # a tuple, or the only value
    if len(names) == 1 and not arrays[0]:
        return lambda message: (get(message),)
    if not any(arrays):
        return get

    def flattened(message: Any) -> tuple[Any, ...]:
        flat: list[Any] = []
        for name, array in zip(names, arrays, strict=True):
            value = getattr(message, name)
            if array:
                flat.extend(value)
            else:
                flat.append(value)
        return tuple(flat)

    return flattened


def pack(message: Any) -> Packed:
    """Pack a message. Raises struct.error for a value that does not fit its field."""
    cls: Any = type(message)
    payload: bytes = cls.unpacker.pack(*_wire_values(cls)(message))
    if payload[-1] == 0:
        payload = payload.rstrip(b"\x00") or b"\x00"
    return Packed(cls.id, bytes((cls.crc_extra,)), payload, getattr(cls, "another_form", False))


def frame(packed: Packed, sequence: int, system: int, component: int) -> bytes:
    """One MAVLink 2 frame, unsigned."""
    number, payload = packed.id, packed.payload
    head = _HEADER_2.pack(_MARKER_2, len(payload), 0, 0, sequence, system, component, number & 0xFFFF, number >> 16)
    body = head + payload
    return body + _CRC.pack(_mcrf4xx(body[1:] + packed.crc_extra))


# --- in ------------------------------------------------------------------------------------------------------------


class UnknownMessage:
    """A frame whose message id is unknown, so its checksum cannot be verified. Same methods as a pymavlink message."""

    __slots__ = ("_component", "_msgbuf", "_number", "_sequence", "_system")

    def __init__(self, number: int, system: int, component: int, data: bytes, sequence: int = 0) -> None:
        self._number, self._sequence = number, sequence
        self._system, self._component, self._msgbuf = system, component, data

    def get_msgId(self) -> int:
        """Message id."""
        return self._number

    def get_srcSystem(self) -> int:
        """System id of the sender."""
        return self._system

    def get_srcComponent(self) -> int:
        """Component id of the sender."""
        return self._component

    def get_seq(self) -> int:
        """Sequence number, 0…255."""
        return self._sequence

    def get_msgbuf(self) -> bytes:
        """The whole frame."""
        return self._msgbuf

    def get_type(self) -> str:
        """A name for logs."""
        return f"UNKNOWN_{self._number}"


@cache
def _reader(number: int) -> tuple[bytes, int, Callable[[bytes], Any]]:
    """(crc_extra, payload size, function payload → message) for a known id."""
    cls = MESSAGES[number]
    unpack, size = cls.unpacker.unpack, cls.unpacker.size
    orders, lengths = cls.orders, cls.lengths
    offsets = [sum(lengths[:i]) for i in range(len(lengths))]
    plain = sum(lengths) == len(lengths) and "char" not in cls.fieldtypes
    if plain and orders == sorted(orders):
        return bytes((cls.crc_extra,)), size, lambda payload: cls(*unpack(payload))
    if plain:
        declared = itemgetter(*orders)
        return bytes((cls.crc_extra,)), size, lambda payload: cls(*declared(unpack(payload)))

    def read(payload: bytes) -> Any:
        wire = unpack(payload)
        values: list[Any] = []
        for order in orders:
            value, length = wire[offsets[order]], lengths[order]
            if isinstance(value, bytes):
                values.append(value.rstrip(b"\x00"))
            else:
                values.append(value if length == 1 else list(wire[offsets[order] : offsets[order] + length]))
        return cls(*values)

    return bytes((cls.crc_extra,)), size, read


_GARBAGE = -1  # no frame begins here
_INCOMPLETE = 0  # a frame may begin here, but its end has not come yet


class Framer:
    """`feed(data)` → the messages that are complete. Remembers an unfinished frame (at most 280 bytes) and counts.

    `received`, `unknown`: frames of known and unknown ids. `garbage`: bytes that belonged to no frame.
    """

    def __init__(self) -> None:
        self._rest = b""
        self.received = 0
        self.unknown = 0
        self.garbage = 0

    @property
    def pending(self) -> bool:
        """Whether an unfinished frame waits for its end."""
        return bool(self._rest)

    def feed(self, data: bytes) -> list[Any]:
        """Messages that are now complete, in order; `UnknownMessage` for unknown ids."""
        return self._scan(self._rest + data if self._rest else data, False)

    def flush(self) -> list[Any]:
        """Messages in what is unfinished, when no more bytes will follow: at the end of a datagram, or when a line has
        gone silent."""
        return self._scan(self._rest, True) if self._rest else []

    def _scan(self, buffer: bytes, last: bool) -> list[Any]:
        """All messages in `buffer`; an unfinished frame is kept for later unless this is the `last` of it."""
        messages: list[Any] = []
        position = 0
        known = -1  # begin of the known frame found inside a supposed one: nothing before it is searched twice
        while (found := _start(buffer, position)) is not None:
            start = found.start()
            self.garbage += start - position
            position = start
            length, message = _frame_at(buffer, start)
            if length > 0 and message.__class__ is UnknownMessage:
                if start >= known:
                    known = _known_inside(buffer, start + 1, start + length, last)
                length = _unless_false(length, start, known)
            if length == _INCOMPLETE and not last:
                self._rest = buffer[start:]
                return messages
            if length > 0:
                position += length
                messages.append(message)
                self._count(message)
            else:
                position += 1
                self.garbage += 1
        self.garbage += len(buffer) - position
        self._rest = b""
        return messages

    def _count(self, message: Any) -> None:
        if message.__class__ is UnknownMessage:
            self.unknown += 1
        else:
            self.received += 1


def _unless_false(length: int, start: int, known: int) -> int:
    """Length of a frame of unknown id at `start`, given where a known frame begins inside it (see `_known_inside`):
    _GARBAGE where there is one, _INCOMPLETE where that is not certain yet."""
    if known == _INCOMPLETE:
        return _INCOMPLETE
    return _GARBAGE if known != _GARBAGE and known < start + length else length


def _frame_at(buffer: bytes, start: int) -> tuple[int, Any]:
    """The frame that begins at `start`: (its length, message), or (_GARBAGE or _INCOMPLETE, None)."""
    if buffer[start] == _MARKER_1:
        return _frame_1_at(buffer, start)
    if len(buffer) < start + _HEADER_2_LENGTH:
        known_bad = len(buffer) > start + 2 and buffer[start + 2] & ~_SIGNED
        return (_GARBAGE if known_bad else _INCOMPLETE), None
    _, length, incompatible, _, sequence, system, component, low, high = _HEADER_2.unpack_from(buffer, start)
    if incompatible & ~_SIGNED:
        return _GARBAGE, None
    payload_end = start + _HEADER_2_LENGTH + length
    total = _HEADER_2_LENGTH + length + 2 + (_SIGNATURE_LENGTH if incompatible else 0)
    if len(buffer) < start + total:
        return _INCOMPLETE, None
    return _finish(
        buffer, start, start + _HEADER_2_LENGTH, payload_end, total, (low | high << 16, sequence, system, component)
    )


def _frame_1_at(buffer: bytes, start: int) -> tuple[int, Any]:
    """As `_frame_at`, for MAVLink 1."""
    if len(buffer) < start + _HEADER_1_LENGTH:
        return _INCOMPLETE, None
    length, sequence, system, component, number = buffer[start + 1 : start + _HEADER_1_LENGTH]
    if length > _SIZES_1[number]:
        return _GARBAGE, None
    payload_end = start + _HEADER_1_LENGTH + length
    total = _HEADER_1_LENGTH + length + 2
    if len(buffer) < start + total:
        return _INCOMPLETE, None
    return _finish(buffer, start, start + _HEADER_1_LENGTH, payload_end, total, (number, sequence, system, component))


def _finish(
    buffer: bytes, start: int, payload_start: int, payload_end: int, total: int, header: tuple[int, int, int, int]
) -> tuple[int, Any]:
    """Verify the checksum of a whole frame and read it. `header`: id, sequence, system, component."""
    number, sequence, system, component = header
    if number not in MESSAGES:
        return total, UnknownMessage(number, system, component, buffer[start : start + total], sequence)
    crc_extra, size, read = _reader(number)
    crc = buffer[payload_end] | buffer[payload_end + 1] << 8
    if _mcrf4xx(buffer[start + 1 : payload_end] + crc_extra) != crc:
        return _GARBAGE, None
    payload = buffer[payload_start:payload_end]
    if len(payload) != size:
        payload = payload[:size] if len(payload) > size else payload + _ZEROS[: size - len(payload)]
    message = read(payload)
    head = message._header
    head.seq, head.srcSystem, head.srcComponent = sequence, system, component
    message._msgbuf = buffer[start : start + total]
    return total, message


def _known_inside(buffer: bytes, start: int, end: int, last: bool) -> int:
    """Where in [start, end) a frame of a known id begins; _INCOMPLETE: perhaps somewhere; _GARBAGE: nowhere.

    The checksum of an unknown frame cannot be verified, so a stray start byte may look like one. A valid frame inside
    it shows that it is none.
    """
    position = start
    while (found := _start(buffer, position, end)) is not None:
        position = found.start()
        if _could_be_known(buffer, position):
            length, _ = _frame_at(buffer, position)
            if length > 0:
                return position
            if length == _INCOMPLETE and not last:
                return _INCOMPLETE
        position += 1
    return _GARBAGE


def _could_be_known(buffer: bytes, start: int) -> bool:
    """Whether a frame at `start` would have a known id, as far as its header has come."""
    if buffer[start] == _MARKER_1 or len(buffer) < start + _HEADER_2_LENGTH:
        return True
    return buffer[start + 7] | buffer[start + 8] << 8 | buffer[start + 9] << 16 in MESSAGES
