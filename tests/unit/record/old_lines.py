"""Lines of readings.csv as older versions wrote them, for the tests that read them."""

from __future__ import annotations

import binascii
import math
import struct
from collections.abc import Mapping, Sequence
from typing import Any

from companion.core.actuation import ThrusterFeedback
from companion.core.readings import KINDS
from companion.core.tick import Tick
from companion.record.reading_codec import CODECS, Codec
from companion.record.recorded import thruster_values, tick_values

_KIND_OF = {kind_type: kind for kind, kind_type in KINDS.items()}


_LATER: Mapping[type, tuple[str, ...]] = {ThrusterFeedback: ("current_a",)}  # which the first logs do not have


def packed(codec: Codec, reading: Any) -> bytes:
    """The values of a line, before base64."""
    parts = [
        struct.pack(f"<{column.code}", math.nan if value is None else value)
        for column, value in zip(codec.numbers, codec.values(reading), strict=True)
        if column.name not in _LATER.get(type(reading), ()) or getattr(reading, column.name) is not None
    ]
    if codec.tuple_name is not None:
        parts.append(_floats(getattr(reading, codec.tuple_name)))
    for name in codec.texts:
        value = getattr(reading, name)
        parts.append(b"\x00" if value is None else value.encode() + b"\x01")
    return b"".join(parts)


def lines(tick: Tick) -> bytes:
    """A tick with its readings."""
    out = [
        _line(_KIND_OF[type(reading)], reading.source, packed(CODECS[_KIND_OF[type(reading)]], reading))
        for reading in tick.readings
    ]
    throttles, azimuths = thruster_values(tick)
    pairs = [value for pair in zip(throttles, azimuths, strict=True) for value in pair]
    return b"".join([*out, _line("tick", "", _floats((*tick_values(tick), *pairs)))])


def parameter(name: str, value: float) -> bytes:
    """A parameter that changed."""
    return _line("parameter", name, struct.pack("<d", value))


def _line(kind: str, source: str, data: bytes) -> bytes:
    return f"{kind},{source},".encode() + binascii.b2a_base64(data)


def _floats(values: Sequence[float | None]) -> bytes:
    return struct.pack(f"<{len(values)}d", *(math.nan if value is None else value for value in values))
