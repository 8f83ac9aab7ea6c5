"""A plan as the one file that ArduPilot's clients fetch (`mission.dat`): a header, and the items as MISSION_ITEM_INT lays them on the wire."""

from __future__ import annotations

import struct
from collections.abc import Sequence

from companion.core.types import Home
from companion.io.mavlink.dialects import Dialect
from companion.io.mavlink.mission_codec import home_item, with_jump_moved
from companion.mission.plan import PlanItem, PlanKind

_HEADER = struct.Struct("<HHHHH")  # magic, kind of plan, options, first item, number of items
_ITEM = struct.Struct("<ffffiifHHBBBBBB")
_MAGIC = 0x763D


def plan_data(kind: PlanKind, items: Sequence[PlanItem], home: Home | None, dialect: Dialect, system: int, component: int) -> bytes:
    """The list as that dialect numbers it: with home at item 0 where it has that."""
    if kind is PlanKind.MISSION and dialect.home_is_item_zero and items:
        items = [home_item(home), *(with_jump_moved(item, 1) for item in items)]
    rows = [
        _ITEM.pack(
            i.param1, i.param2, i.param3, i.param4, i.x, i.y, i.z, seq, i.command, system, component, i.frame, i.current, i.autocontinue, kind
        )
        for seq, i in enumerate(items)
    ]  # fmt: skip
    return _HEADER.pack(_MAGIC, kind, 0, 0, len(rows)) + b"".join(rows)
