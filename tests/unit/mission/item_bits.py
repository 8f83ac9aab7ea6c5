"""Items of a mission to the last bit, with not-a-number where a parameter has none."""

from __future__ import annotations

import struct
from typing import Any


def bits(item: Any) -> bytes:
    return struct.pack(
        "<HBffffiifBB",
        item.command,
        item.frame,
        item.param1,
        item.param2,
        item.param3,
        item.param4,
        item.x,
        item.y,
        item.z,
        item.autocontinue,
        item.current,
    )
