"""Values of parameters on a px4 link: whole numbers travel as their bytes in the float field."""

from __future__ import annotations

import struct
from typing import Any

_REAL32 = 9


def decoded(message: Any) -> float:
    """The value of a PARAM_VALUE; a real one with the digits that a float of 32 bits has, so that 0.7 stays 0.7."""
    if message.param_type == _REAL32:
        return float(f"{message.param_value:.7g}")
    return float(struct.unpack("<i", struct.pack("<f", message.param_value))[0])


def encoded(kind: int, value: float) -> float:
    """`param_value` of a PARAM_SET of that type."""
    if kind == _REAL32:
        return value
    return float(struct.unpack("<f", struct.pack("<i", round(value)))[0])
