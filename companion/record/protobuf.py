"""Protocol buffers as far as the log needs them: the encoding, and the descriptors by which others read it.

Source: Protocol Buffers documentation, "Encoding", and descriptor.proto. The messages are few and their fields fixed,
so that the boat needs neither a compiler nor the runtime library for them.
"""

from __future__ import annotations

import functools
import struct
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

_TYPES = {
    "double": 1, "float": 2, "uint32": 13, "bool": 8, "string": 9, "bytes": 12, "enum": 14, "sfixed32": 15,
    "sfixed64": 16, "int64": 3, "int32": 5,
}  # fmt: skip
_MESSAGE = 11
_OPTIONAL, _REPEATED = 1, 3
_WIDTHS = {"double": ("d", 1), "float": ("f", 5)}  # struct code, wire type
_BYTES = 2  # the wire type of texts, bytes, messages and packed numbers
_FIXED = {1: 8, 5: 4}
_SMALL = [bytes([number]) for number in range(128)]


@dataclass(frozen=True, slots=True)
class Field:
    """One field of a message. `kind`: a scalar type, or `.package.Message`; an enum is `enum:.package.Enum`."""

    name: str
    number: int
    kind: str
    repeated: bool = False


@dataclass(frozen=True, slots=True)
class MessageType:
    """A message and the enum in it, as (name, names of its values from 0)."""

    name: str
    fields: Sequence[Field]
    enum: tuple[str, Sequence[str]] | None = None


class Damaged(ValueError):
    """Bytes that are no message."""


def varint(number: int) -> bytes:
    """A whole number from 0."""
    if number < 0x80:
        return _SMALL[number]
    out = bytearray()
    while number > 0x7F:
        out.append(number & 0x7F | 0x80)
        number >>= 7
    out.append(number)
    return bytes(out)


def packed_varints(numbers: Sequence[int]) -> bytes:
    """Whole numbers from 0, one behind the other."""
    return bytes(numbers) if max(numbers, default=0) < 0x80 else b"".join(map(varint, numbers))


@functools.lru_cache(4096)
def tag(number: int, wire_type: int) -> bytes:
    """What stands before a field's value."""
    return varint(number << 3 | wire_type)


def blob(number: int, data: bytes) -> bytes:
    """A field of bytes, a message, or packed numbers."""
    return head(number, len(data)) + data


@functools.lru_cache(4096)
def head(number: int, size: int) -> bytes:
    """What stands before the bytes of a field that has so many."""
    return tag(number, _BYTES) + varint(size)


def text(number: int, value: str) -> bytes:
    """A field of text."""
    return blob(number, value.encode())


def whole(number: int, value: int) -> bytes:
    """A field of bool, enum or unsigned number; nothing for 0."""
    return tag(number, 0) + varint(value) if value else b""


class Row:
    """Packs many numeric fields of one message at once."""

    def __init__(self, fields: Sequence[Field]) -> None:
        codes, tags = "<", []
        for field in fields:
            code, wire_type = _WIDTHS[field.kind]
            before = tag(field.number, wire_type)
            codes += f"{len(before)}s{code}"
            tags.append(before)
        self._struct = struct.Struct(codes)
        self._template: list[bytes | float] = [part for before in tags for part in (before, 0.0)]

    def packed(self, values: Sequence[float]) -> bytes:
        """One value for each field."""
        parts = self._template
        parts[1::2] = values
        return self._struct.pack(*parts)


def parts_of(data: bytes) -> Iterator[tuple[int, int, bytes]]:
    """(number, whole number or 0, bytes) of each field of a message. Raises Damaged."""
    at, end = 0, len(data)
    while at < end:
        before, at = _varint_at(data, at)
        number, wire_type = before >> 3, before & 7
        if wire_type == 0:
            value, at = _varint_at(data, at)
            yield number, value, b""
            continue
        if wire_type == _BYTES:
            size, at = _varint_at(data, at)
        elif wire_type in _FIXED:
            size = _FIXED[wire_type]
        else:
            raise Damaged(f"wire type {wire_type}")
        if at + size > end:
            raise Damaged("cut off")
        yield number, 0, data[at : at + size]
        at += size


def varints(data: bytes) -> list[int]:
    """Packed whole numbers. Raises Damaged."""
    out, at = [], 0
    while at < len(data):
        value, at = _varint_at(data, at)
        out.append(value)
    return out


def _varint_at(data: bytes, at: int) -> tuple[int, int]:
    value = shift = 0
    while at < len(data):
        byte = data[at]
        value |= (byte & 0x7F) << shift
        at += 1
        if byte < 0x80:
            return value, at
        shift += 7
    raise Damaged("cut off")


# --- descriptors ---------------------------------------------------------------------------------------------------


def descriptor_set(files: Iterable[bytes]) -> bytes:
    """A FileDescriptorSet: what MCAP calls the schema data of protobuf."""
    return b"".join(blob(1, file) for file in files)


def descriptor_file(name: str, package: str, messages: Sequence[MessageType], imports: Sequence[str] = ()) -> bytes:
    """A FileDescriptorProto."""
    parts = [text(1, name), text(2, package), *(text(3, other) for other in imports)]
    parts += [blob(4, _message(message)) for message in messages]
    return b"".join([*parts, text(12, "proto3")])


def _message(message: MessageType) -> bytes:
    parts = [text(1, message.name), *(blob(2, _field(field)) for field in message.fields)]
    if message.enum is not None:
        name, values = message.enum
        rows = (blob(2, text(1, value) + tag(2, 0) + varint(number)) for number, value in enumerate(values))
        parts.append(blob(4, text(1, name) + b"".join(rows)))
    return b"".join(parts)


def _field(field: Field) -> bytes:
    kind, _, enum = field.kind.partition(":")
    parts = [text(1, field.name), whole(3, field.number), whole(4, _REPEATED if field.repeated else _OPTIONAL)]
    parts.append(whole(5, _MESSAGE if kind.startswith(".") else _TYPES[kind]))
    other = enum or (kind if kind.startswith(".") else "")
    return b"".join([*parts, text(6, other) if other else b""])
