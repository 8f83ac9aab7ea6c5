"""Readings ↔ the values of their lines in readings.csv, as the dataclass of each kind lays down. A new kind needs no
code here.

The values of a line are the fields without `source`: the numbers in the order of the dataclass, then either its tuple
of numbers or its texts. A number is a little-endian float64, NaN for None; an `Int64` is a little-endian int64. An
IntEnum stands as its value, any other Enum as its place in the order of its members, a bool as 0 or 1. A text is UTF-8
that ends with a byte 1; None is a single byte 0.

A field that is added later goes to the end of its dataclass with a default: lines of older logs then stay readable.
"""

from __future__ import annotations

import math
import struct
import types
import typing
from collections.abc import Callable, Mapping, Sequence
from dataclasses import MISSING, dataclass, fields
from enum import Enum, IntEnum
from operator import attrgetter
from typing import Any

from companion.core.readings import KINDS, Int64, Reading

_TEXT_END, _NO_TEXT = b"\x01", b"\x00"
_VALUE_BYTES = 8


@dataclass(frozen=True, slots=True)
class _Column:
    """One field: its struct code ("" for a text or a tuple of numbers), and its value from and to a number."""

    name: str
    kind: Any  # float, int, bool, str, an Enum, or tuple
    code: str
    optional: bool
    has_default: bool

    def value(self, number: float) -> Any:
        """The field's value. Raises ValueError for a number that it cannot be."""
        if self.optional and math.isnan(number):
            return None
        if self.code == "q" or self.kind is float:
            return number
        if self.kind in (int, bool):
            return self.kind(number)
        return self.kind(int(number)) if issubclass(self.kind, IntEnum) else tuple(self.kind)[int(number)]


class Codec:
    """One kind of reading: `packed(reading)` → the values of its line; `reading(source, data)` → the reading again.

    `names`: the fields in the order of their values.
    """

    def __init__(self, kind: str, kind_type: type[Any]) -> None:
        """Raises TypeError for a field whose type has no place in a line."""
        hints = typing.get_type_hints(kind_type, include_extras=True)
        columns = [
            _column(kind_type, field.name, hints[field.name], field.default is not MISSING)
            for field in fields(kind_type)
            if field.name != "source"
        ]
        self._numbers = [column for column in columns if column.code]
        tuples = [column.name for column in columns if column.kind is tuple]
        self._texts = [column.name for column in columns if column.kind is str]
        if tuples and len(tuples) + len(self._texts) > 1:
            several = " and ".join((*tuples, *self._texts))
            raise TypeError(f"{kind_type.__name__}: a line ends with one tuple of numbers or with texts, not {several}")
        self.names = (*(column.name for column in self._numbers), *tuples, *self._texts)
        self._kind, self._kind_type = kind, kind_type
        self._tuple = tuples[0] if tuples else None
        self._format = struct.Struct("<" + "".join(column.code for column in self._numbers))
        self.packed = self._packer()

    def reading(self, source: str, data: bytes) -> Reading:
        """The reading of a line. Raises ValueError for values that are not of this kind."""
        values = self._number_values(data)
        rest = data[self._format.size :]
        if self._tuple is not None:
            values[self._tuple] = floats(rest)
        for name in self._texts:
            values[name], rest = _text(rest)
        reading: Reading = self._kind_type(source=source, **values)
        return reading

    def _number_values(self, data: bytes) -> dict[str, Any]:
        """Fields that are numbers. Of a line that is too short the last ones keep their defaults."""
        columns = self._numbers
        if self._tuple is None and not self._texts:
            count, uneven = divmod(len(data), _VALUE_BYTES)
            late = columns[count:]
            if uneven or count > len(columns) or not all(column.has_default for column in late):
                raise ValueError(f"{count} values, {self._kind} has {len(columns)}")
            columns = columns[:count]
        numbers = struct.unpack_from("<" + "".join(column.code for column in columns), data)
        return {column.name: column.value(number) for column, number in zip(columns, numbers, strict=True)}

    def _packer(self) -> Callable[[Any], bytes]:
        numbers, pack = self._number_getter(), self._format.pack
        texts = [attrgetter(name) for name in self._texts]
        rest_of = None if self._tuple is None else attrgetter(self._tuple)

        def packed(reading: Any) -> bytes:
            values = numbers(reading)
            data = pack(*values) if None not in values else pack(*(math.nan if v is None else v for v in values))
            if rest_of is not None:
                data += pack_floats(rest_of(reading))
            for text_of in texts:
                data += _packed_text(text_of(reading))
            return data

        return packed

    def _number_getter(self) -> Callable[[Any], Sequence[Any]]:
        """Reading → its numbers in order, those of an Enum by their place in it."""
        values_of = attrgetter(*(column.name for column in self._numbers), "source")  # two names or more: a tuple
        places: dict[int, Mapping[Any, int]] = {
            at: {member: place for place, member in enumerate(column.kind)}
            for at, column in enumerate(self._numbers)
            if isinstance(column.kind, type) and issubclass(column.kind, Enum) and not issubclass(column.kind, IntEnum)
        }
        if not places:
            return lambda reading: values_of(reading)[:-1]

        def numbers(reading: Any) -> list[Any]:
            values = list(values_of(reading)[:-1])
            for at, place_of in places.items():
                values[at] = None if values[at] is None else place_of[values[at]]
            return values

        return numbers


def pack_floats(numbers: Sequence[float | None]) -> bytes:
    """Numbers as little-endian float64, None as NaN."""
    return struct.pack(f"<{len(numbers)}d", *(math.nan if number is None else number for number in numbers))


def floats(data: bytes) -> tuple[float, ...]:
    """All of `data` as little-endian float64. Raises struct.error where a part of one is left over."""
    return struct.unpack(f"<{len(data) // _VALUE_BYTES}d", data)


def _packed_text(text: str | None) -> bytes:
    return _NO_TEXT if text is None else text.replace("\x00", "").replace("\x01", "").encode() + _TEXT_END


def _text(data: bytes) -> tuple[str | None, bytes]:
    """The first text of `data`, and what follows it."""
    if data[:1] == _NO_TEXT:
        return None, data[1:]
    text, end, rest = data.partition(_TEXT_END)
    if not end:
        raise ValueError("a text without its end")
    return text.decode(), rest


def _column(owner: type[Any], name: str, hint: Any, has_default: bool) -> _Column:
    optional = typing.get_origin(hint) in (types.UnionType, typing.Union)
    if optional:
        hint = next(part for part in typing.get_args(hint) if part is not type(None))
    if hint == Int64:
        return _Column(name, int, "q", optional, has_default)
    if hint == tuple[float, ...]:
        return _Column(name, tuple, "", optional, has_default)
    if hint is str:
        return _Column(name, str, "", optional, has_default)
    if hint in (float, int, bool) or (isinstance(hint, type) and issubclass(hint, Enum)):
        return _Column(name, hint, "d", optional, has_default)
    raise TypeError(f"{owner.__name__}.{name}: a line of readings.csv holds no {hint}")


CODECS: Mapping[str, Codec] = {kind: Codec(kind, kind_type) for kind, kind_type in KINDS.items()}
