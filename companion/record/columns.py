"""Readings of one kind and source ↔ one message of the log, a column for each field.

A receiver's or sensor's samples of a tick stand together: the message is a table with one row a sample. Each column has
the narrowest form that gives every value back to the last bit:

    f  float32: the values are float32, as most devices send them
    s  float32 of numbers with few digits: the value is the shortest decimal (7 digits) of it
    d  float64
    q  sfixed64, a whole number; the smallest one is None
    u  only for the time: microseconds before the tick, sfixed32; otherwise `d`

`forms` names the columns with their letters, `x_mps2:f`. A column that its form cannot hold any more gets the next
wider one, with a new schema and channel; that happens in the first seconds of a run. None is NaN in a column of
numbers, and a single byte 0 in one of texts.
"""

from __future__ import annotations

import functools
import math
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from companion.core.readings import Reading
from companion.record.protobuf import Damaged, Field, MessageType, blob, head, parts_of, text
from companion.record.reading_codec import Codec, Column

TIME_AGE = "age_us"  # name of the time column in its form `u`
_NONE_TEXT = "\x00"
_LEAST_INT64 = -(2**63)
_WIDER = {"f": "s", "s": "d", "u": "d"}
_KINDS = {"f": "float", "s": "float", "d": "double", "q": "sfixed64", "u": "sfixed32"}
_CODES = {"f": "f", "s": "f", "d": "d", "q": "q", "u": "i"}
_SOURCE, _FIRST = 1, 2  # field numbers
_US = 1e6


@dataclass(frozen=True, slots=True)
class Layout:
    """The columns of a message: of each number its name and form, then names of the tuple or the texts."""

    kind: str
    names: tuple[str, ...]
    forms: str
    tuple_name: str | None
    texts: tuple[str, ...]

    @property
    def message(self) -> MessageType:
        """For the schema."""
        numbers = [
            Field(TIME_AGE if form == "u" else name, _FIRST + at, _KINDS[form], repeated=True)
            for at, (name, form) in enumerate(zip(self.names, self.forms, strict=True))
        ]
        last = _FIRST + len(numbers)
        if self.tuple_name is not None:
            numbers.append(Field(self.tuple_name, last, "double", repeated=True))
        numbers += [Field(name, last + at, "string", repeated=True) for at, name in enumerate(self.texts)]
        return MessageType(self.schema_name, (Field("source", _SOURCE, "string"), *numbers))

    @property
    def schema_name(self) -> str:
        """The message's name: the kind and its forms."""
        return f"{self.kind.capitalize()}_{self.forms}"

    @property
    def metadata(self) -> dict[str, str]:
        """What a reader of later versions needs to know, for the channel."""
        return {
            "kind": self.kind,
            "forms": ",".join(f"{name}:{form}" for name, form in zip(self.names, self.forms, strict=True)),
        }


class ColumnWriter:
    """The messages of one kind and source. `layout` may widen with each call of `message`."""

    def __init__(self, kind: str, source: str, codec: Codec) -> None:
        self._codec = codec
        self._source = text(_SOURCE, source)
        self._quick: dict[int, Packer] = {}  # by the number of readings; of the present layout
        forms = "".join("q" if column.code == "q" else "f" for column in codec.numbers)
        names = tuple(column.name for column in codec.numbers)
        self.layout = Layout(kind, names, "u" + forms[1:], codec.tuple_name, tuple(codec.texts))
        self.single = codec.tuple_name is not None  # one reading a message

    def message(self, readings: Sequence[Reading], tick_us: int) -> bytes:
        """The message of these readings. `tick_us`: the time of the tick, rounded, µs."""
        rows = list(map(self._codec.values, readings))
        if (packer := self._quick.get(len(rows))) is None:
            packer = self._quick[len(rows)] = Packer(self._source, self.layout.forms, len(rows))
        if (quick := narrowed(packer, rows, tick_us)) is None:
            quick = self._widened([list(map(_number, column)) for column in zip(*rows, strict=True)], tick_us)
        last = _FIRST + len(rows[0])
        parts = [quick]
        if self._codec.tuple_name is not None:
            numbers = getattr(readings[0], self._codec.tuple_name)
            parts.append(blob(last, struct.pack(f"<{len(numbers)}d", *numbers)))
        for at, name in enumerate(self._codec.texts):
            parts += [text(last + at, _text_of(getattr(reading, name))) for reading in readings]
        return b"".join(parts) if len(parts) > 1 else quick

    def _widened(self, columns: Sequence[Sequence[Any]], tick_us: int) -> bytes:
        """The source and the columns, each in the narrowest form that holds it; the layout becomes these forms."""
        forms = list(self.layout.forms)
        parts = [self._source]
        for at, column in enumerate(columns):
            while (data := _packed(forms[at], column, tick_us)) is None:
                forms[at] = _WIDER[forms[at]]
            parts.append(blob(_FIRST + at, data))
        if (wider := "".join(forms)) != self.layout.forms:
            layout = self.layout
            self.layout = Layout(layout.kind, layout.names, wider, layout.tuple_name, layout.texts)
            self._quick.clear()
        return b"".join(parts)


class Packer:
    """Packs so many readings in one call, as long as the forms of their columns hold them.

    `heads`: the source, and what stands before each column. Remembers the values to be packed: of each column what
    stands before it, then its value of each reading. So a reading's values go into each `_stride`-th place.
    """

    def __init__(self, source: bytes, forms: str, count: int) -> None:
        heads = [head(_FIRST + at, count * struct.calcsize(_CODES[form])) for at, form in enumerate(forms)]
        self.heads, self.forms = (source, *heads), forms
        self._struct = _row_struct(source, heads, [f"{count}{_CODES[form]}" for form in forms])
        exact = {"f": "d", "s": "d"}
        self._exact = _row_struct(source, heads, [f"{count}{exact.get(form, _CODES[form])}" for form in forms])
        self._stride = count + 1
        self._values: list[Any] = [source, *(part for before in heads for part in (before, *(0.0,) * count))]
        self._aged = forms[0] == "u"
        self._times = self._places(0)
        self._whole = [self._places(at) for at, form in enumerate(forms) if form == "q"]
        self._narrow = "f" in forms or "s" in forms
        self._short = [self._places(at) for at, form in enumerate(forms) if form == "s"]

    def _places(self, column: int) -> slice:
        first = 2 + column * self._stride
        return slice(first, first + self._stride - 1)

    def packed(self, rows: Sequence[Sequence[Any]], tick_us: int) -> bytes | None:
        """The source and the columns; None where a form does not give its column back exactly."""
        values, stride = self._values, self._stride
        for at, row in enumerate(rows, 2):
            values[at::stride] = map(_number, row) if None in row else row
        for places in self._whole:
            values[places] = [_LEAST_INT64 if number != number else number for number in values[places]]
        if self._aged and not self._take_ages(tick_us):
            return None
        try:
            data = self._struct.pack(*values)
        except (OverflowError, struct.error):
            return None
        if not self._narrow:
            return data
        back = list(self._struct.unpack(data))
        for places in self._short:
            back[places] = map(_shortest, back[places])
        # NaN is not equal to itself, so that columns with it are compared by their bytes
        return data if back == values or self._exact.pack(*back) == self._exact.pack(*values) else None

    def _take_ages(self, tick_us: int) -> bool:
        """Turn the times into ages; False where these would not give them back."""
        times_s = self._values[self._times]
        try:
            ages = [tick_us - round(time_s * _US) for time_s in times_s]
        except (OverflowError, ValueError):
            return False
        self._values[self._times] = ages
        return [(tick_us - age) / _US for age in ages] == times_s


def _number(value: Any) -> Any:
    """NaN for None. Of any type, since compiled code makes floats of integers where float is written."""
    return math.nan if value is None else value


def narrowed(packer: Packer, rows: list[Sequence[Any]], tick_us: int) -> bytes | None:
    """As `Packer.packed`. It has a second form in C (`sitl.native.operations`)."""
    return packer.packed(rows, tick_us)


def _row_struct(source: bytes, heads: Sequence[bytes], codes: Sequence[str]) -> struct.Struct:
    parts = (f"{len(before)}s{code}" for before, code in zip(heads, codes, strict=True))
    return struct.Struct(f"<{len(source)}s{''.join(parts)}")


class ColumnReader:
    """The readings of the messages of one channel."""

    def __init__(self, codec: Codec, metadata: dict[str, str]) -> None:
        """Raises ValueError for columns that this version does not know."""
        self._codec = codec
        known = {column.name: column for column in codec.numbers}
        self._columns: list[tuple[Column | None, str]] = []
        for part in metadata["forms"].split(","):
            name, _, form = part.partition(":")
            if form not in _CODES:
                raise ValueError(f"{name} has the unknown form {form!r}")
            self._columns.append((known.get(name), form))
        self._last = _FIRST + len(self._columns)

    def readings(self, data: bytes, tick_us: int) -> Iterator[Reading]:
        """The rows of a message. Raises Damaged, ValueError, TypeError, struct.error, UnicodeDecodeError."""
        source, columns, texts = "", {}, {name: list[str]() for name in self._codec.texts}
        numbers: tuple[float, ...] = ()
        for number, _, value in parts_of(data):
            if number == _SOURCE:
                source = value.decode()
            elif number < self._last:
                column, form = self._columns[number - _FIRST]
                if column is not None:
                    columns[column.name] = _unpacked(form, column, value, tick_us)
            elif self._codec.tuple_name is not None:
                numbers = struct.unpack(f"<{len(value) // 8}d", value)
            else:
                texts[self._codec.texts[number - self._last]].append(value.decode())
        yield from self._rows(source, columns, texts, numbers)

    def _rows(
        self, source: str, columns: dict[str, list[Any]], texts: dict[str, list[str]], numbers: tuple[float, ...]
    ) -> Iterator[Reading]:
        for name, said in texts.items():
            columns[name] = [None if value == _NONE_TEXT else value for value in said]
        names = list(columns)
        if not columns or len({len(column) for column in columns.values()}) != 1:
            raise Damaged("columns of different length")
        more = {} if self._codec.tuple_name is None else {self._codec.tuple_name: numbers}
        for row in zip(*columns.values(), strict=True):
            yield self._codec.kind_type(source=source, **dict(zip(names, row, strict=True)), **more)


def _packed(form: str, column: Sequence[Any], tick_us: int) -> bytes | None:
    """The column's bytes; None where this form does not give them back exactly."""
    narrow, exact = _structs(_CODES[form], len(column))
    if form == "d":
        return exact.pack(*column)
    if form == "q":
        return narrow.pack(*(_LEAST_INT64 if value != value else value for value in column))
    try:
        if form == "u":
            ages = [tick_us - round(value * _US) for value in column]
            back: Sequence[float] = [(tick_us - age) / _US for age in ages]
            data = narrow.pack(*ages)
        else:
            data = narrow.pack(*column)
            back = narrow.unpack(data)
            if form == "s":
                back = [_shortest(value) for value in back]
    except (OverflowError, ValueError, struct.error):
        return None
    return data if exact.pack(*back) == exact.pack(*column) else None


@functools.lru_cache(256)
def _structs(code: str, count: int) -> tuple[struct.Struct, struct.Struct]:
    return struct.Struct(f"<{count}{code}"), struct.Struct(f"<{count}d")


def _unpacked(form: str, column: Column, data: bytes, tick_us: int) -> list[Any]:
    code = _CODES[form]
    values: Sequence[Any] = struct.unpack(f"<{len(data) // struct.calcsize(code)}{code}", data)
    if form == "u":
        return [(tick_us - age) / _US for age in values]
    if form == "q":
        return [None if value == _LEAST_INT64 else value for value in values]
    if form == "s":
        values = [_shortest(value) for value in values]
    if column.kind is float and not column.optional:
        return list(values)
    return [column.value(value) for value in values]


def _shortest(value: float) -> float:
    return float(f"{value:.7g}")


def _text_of(value: str | None) -> str:
    return _NONE_TEXT if value is None else value.replace("\x00", "")


def tick_us_of(t_s: float) -> int:
    """The time of a tick as the columns count from it."""
    return round(t_s * _US) if math.isfinite(t_s) else 0
