"""Plan items on the wire, as messages and as ArduPilot's file, and in the plan.

In the plan, item 0 is the first one, as with the px4 persona. A persona whose item 0 is home numbers all items one
higher on the wire, targets of DO_JUMP included. Source: MAVLink guide, "Mission Protocol".
"""

from __future__ import annotations

import math
import struct
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from companion.core.decision import Home
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.personas import Persona
from companion.mission.plan import GLOBAL_FRAMES, PlanItem, PlanKind, PlanRefusal, PlanResult

NAV_WAYPOINT = 16
DO_JUMP = 177
_UNKNOWN = 2**31 - 1  # in MISSION_ITEM_INT's x and y: what would be NaN in a float
_UNITS_PER_DEGREE = 1e7
_FILE_HEADER = struct.Struct("<HHHHH")  # magic, kind of plan, options, first item, number of items
_FILE_ITEM = struct.Struct("<ffffiifHHBBBBBB")
_FILE_MAGIC = 0x763D


def item_from_int(message: Any, seq: int) -> PlanItem:
    """The item of a MISSION_ITEM_INT, unchanged, with its number in the plan."""
    return PlanItem(
        seq,
        message.command,
        message.frame,
        message.param1,
        message.param2,
        message.param3,
        message.param4,
        message.x,
        message.y,
        message.z,
        message.autocontinue,
        message.current,
    )


def item_from_float(message: Any, seq: int) -> PlanItem | PlanRefusal:
    """The item of a MISSION_ITEM, its degrees as integers; or the refusal where x or y is out of range."""
    scale = _UNITS_PER_DEGREE if message.frame in GLOBAL_FRAMES else 1.0
    x, y = _whole(message.x * scale), _whole(message.y * scale)
    if x is None:
        return PlanRefusal(PlanResult.INVALID_PARAM5_X, "latitude (x) is out of range", seq)
    if y is None:
        return PlanRefusal(PlanResult.INVALID_PARAM6_Y, "longitude (y) is out of range", seq)
    return PlanItem(
        seq,
        message.command,
        message.frame,
        message.param1,
        message.param2,
        message.param3,
        message.param4,
        x,
        y,
        message.z,
        message.autocontinue,
        message.current,
    )


def item_message(item: PlanItem, seq: int, system: int, component: int, kind: PlanKind, as_float: bool) -> Any:
    """MISSION_ITEM_INT bit for bit, or MISSION_ITEM with degrees if `as_float`. `seq`: number on the wire; `system`,
    `component`: of the client."""
    params = (item.param1, item.param2, item.param3, item.param4)
    head = (system, component, seq, item.frame, item.command, item.current, item.autocontinue)
    if not as_float:
        return mavlink.MAVLink_mission_item_int_message(*head, *params, item.x, item.y, item.z, kind)
    scale = _UNITS_PER_DEGREE if item.frame in GLOBAL_FRAMES else 1.0
    x, y = (math.nan if value == _UNKNOWN else value / scale for value in (item.x, item.y))
    return mavlink.MAVLink_mission_item_message(*head, *params, x, y, item.z, kind)


def home_item(home: Home | None) -> PlanItem:
    """Home as item 0, for a persona that has it there; zeros while home is not known."""
    if home is None:
        return PlanItem(0, NAV_WAYPOINT, 0, 0.0, 0.0, 0.0, 0.0, 0, 0, 0.0)
    x, y = round(home.lat_deg * _UNITS_PER_DEGREE), round(home.lon_deg * _UNITS_PER_DEGREE)
    return PlanItem(0, NAV_WAYPOINT, 0, 0.0, 0.0, 0.0, 0.0, x, y, home.altitude_m)


def with_jump_moved(item: PlanItem, places: int) -> PlanItem:
    """The item; the target of a DO_JUMP is increased by `places`."""
    if item.command != DO_JUMP or places == 0:
        return item
    return replace(item, param1=item.param1 + places)


def plan_data(
    kind: PlanKind, items: Sequence[PlanItem], home: Home | None, persona: Persona, system: int, component: int
) -> bytes:
    """A plan as the file that ArduPilot's clients fetch (`mission.dat`): a header, and the items as MISSION_ITEM_INT
    has them, numbered as that persona does."""
    if kind is PlanKind.MISSION and persona.home_is_item_zero and items:
        items = [home_item(home), *(with_jump_moved(item, 1) for item in items)]
    rows = []
    for seq, item in enumerate(items):
        values = (item.param1, item.param2, item.param3, item.param4, item.x, item.y, item.z)
        tail = (system, component, item.frame, item.current, item.autocontinue, kind)
        rows.append(_FILE_ITEM.pack(*values, seq, item.command, *tail))
    return _FILE_HEADER.pack(_FILE_MAGIC, kind, 0, 0, len(rows)) + b"".join(rows)


def _whole(value: float) -> int | None:
    """The value as an int32, _UNKNOWN for NaN; None where it does not fit."""
    if math.isnan(value):
        return _UNKNOWN
    return round(value) if -(2.0**31) <= value <= 2.0**31 - 1.0 else None
