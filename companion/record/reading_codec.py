"""The fields of each kind of reading, as its dataclass lays them down, and the lines of older logs' readings.csv. A new
kind needs no code here.

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
class Column:
    """One field: its struct code ("" for a text or a tuple of numbers), and its value from and to a number."""

    name: str
    kind: Any  # float, int, bool, str, an Enum, or tuple
    code: str
    optional: bool
    has_default: bool

    def value(self, number: Any) -> Any:
        """The field's value, of a float or an integer. Raises ValueError for a number that it cannot be."""
        if self.optional and math.isnan(number):
            return None
        if self.code == "q" or self.kind is float:
            return number
        if self.kind in (int, bool):
            return self.kind(number)
        return self.kind(int(number)) if issubclass(self.kind, IntEnum) else tuple(self.kind)[int(number)]


class Codec:
    """One kind of reading: `reading(source, data)` makes one of the values of its line.

    `numbers`, `tuple_name`, `texts`: its fields; `names`: all of them in the order of their values.
    """

    def __init__(self, kind: str, kind_type: type[Any]) -> None:
        """Raises TypeError for a field whose type has no place in a line."""
        hints = typing.get_type_hints(kind_type, include_extras=True)
        columns = [
            _column(kind_type, field.name, hints[field.name], field.default is not MISSING)
            for field in fields(kind_type)
            if field.name != "source"
        ]
        self.numbers = [column for column in columns if column.code]
        tuples = [column.name for column in columns if column.kind is tuple]
        self.texts = [column.name for column in columns if column.kind is str]
        if tuples and len(tuples) + len(self.texts) > 1:
            several = " and ".join((*tuples, *self.texts))
            raise TypeError(
                f"{kind_type.__name__}: a reading ends with one tuple of numbers or with texts, not {several}"
            )
        self.names = (*(column.name for column in self.numbers), *tuples, *self.texts)
        self._kind, self.kind_type = kind, kind_type
        self.tuple_name = tuples[0] if tuples else None
        self._format = struct.Struct("<" + "".join(column.code for column in self.numbers))
        names = [column.name for column in self.numbers]
        self._values_of = attrgetter(*names) if len(names) > 1 else _only(attrgetter(*names))
        self._places = _places(self.numbers)

    def reading(self, source: str, data: bytes) -> Reading:
        """The reading of a line. Raises ValueError for values that are not of this kind."""
        values = self._number_values(data)
        rest = data[self._format.size :]
        if self.tuple_name is not None:
            values[self.tuple_name] = floats(rest)
        for name in self.texts:
            values[name], rest = _text(rest)
        reading: Reading = self.kind_type(source=source, **values)
        return reading

    def _number_values(self, data: bytes) -> dict[str, Any]:
        """Fields that are numbers. Of a line that is too short the last ones keep their defaults."""
        columns = self.numbers
        if self.tuple_name is None and not self.texts:
            count, uneven = divmod(len(data), _VALUE_BYTES)
            late = columns[count:]
            if uneven or count > len(columns) or not all(column.has_default for column in late):
                raise ValueError(f"{count} values, {self._kind} has {len(columns)}")
            columns = columns[:count]
        numbers = struct.unpack_from("<" + "".join(column.code for column in columns), data)
        return {column.name: column.value(number) for column, number in zip(columns, numbers, strict=True)}

    def values(self, reading: Any) -> Sequence[Any]:
        """The numbers of a reading, in order, None where one is missing; an Enum by its place."""
        values: Sequence[Any] = self._values_of(reading)
        if not self._places:
            return values
        values = list(values)
        for at, place_of in self._places.items():
            values[at] = None if values[at] is None else place_of[values[at]]
        return values


def _only(value_of: Callable[[Any], Any]) -> Callable[[Any], tuple[Any]]:
    """The one value as a tuple."""
    return lambda reading: (value_of(reading),)


def floats(data: bytes) -> tuple[float, ...]:
    """All of `data` as little-endian float64. Raises struct.error where a part of one is left over."""
    return struct.unpack(f"<{len(data) // _VALUE_BYTES}d", data)


def _text(data: bytes) -> tuple[str | None, bytes]:
    """The first text of `data`, and what follows it."""
    if data[:1] == _NO_TEXT:
        return None, data[1:]
    text, end, rest = data.partition(_TEXT_END)
    if not end:
        raise ValueError("a text without its end")
    return text.decode(), rest


def _places(numbers: Sequence[Column]) -> dict[int, Mapping[Any, int]]:
    """For each field that is an Enum without numbers of its own: the place of each member."""
    return {
        at: {member: place for place, member in enumerate(column.kind)}
        for at, column in enumerate(numbers)
        if isinstance(column.kind, type) and issubclass(column.kind, Enum) and not issubclass(column.kind, IntEnum)
    }


def _column(owner: type[Any], name: str, hint: Any, has_default: bool) -> Column:
    optional = typing.get_origin(hint) in (types.UnionType, typing.Union)
    if optional:
        hint = next(part for part in typing.get_args(hint) if part is not type(None))
    if hint == Int64:
        return Column(name, int, "q", optional, has_default)
    if hint == tuple[float, ...]:
        return Column(name, tuple, "", optional, has_default)
    if hint is str:
        return Column(name, str, "", optional, has_default)
    if hint in (float, int, bool) or (isinstance(hint, type) and issubclass(hint, Enum)):
        return Column(name, hint, "d", optional, has_default)
    raise TypeError(f"{owner.__name__}.{name}: the log holds no {hint}")


CODECS: Mapping[str, Codec] = {kind: Codec(kind, kind_type) for kind, kind_type in KINDS.items()}
