"""Plan items in messages: as they travel, and as they are kept.

A plan is kept as the px4 dialect sends it: item 0 is the first of the list. A dialect whose item 0 is home counts everything one
higher on the wire, the targets of DO_JUMP included. Source: MAVLink guide, "Mission Protocol".
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from companion.core.types import Home
from companion.io.mavlink import messages as mavlink
from companion.mission.plan import GLOBAL_FRAMES, PlanItem, PlanKind, PlanRefusal, PlanResult

NAV_WAYPOINT = 16
DO_JUMP = 177
_UNKNOWN = 2**31 - 1  # what MISSION_ITEM_INT carries in x, y where a float would be NaN
_UNITS_PER_DEGREE = 1e7


def item_from_int(message: Any, seq: int) -> PlanItem:
    """MISSION_ITEM_INT as it is, under the number that it has in the list."""
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
    """MISSION_ITEM with its degrees made into integers, or why x or y has no place in one."""
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
    """The item under the number that it has on the wire: bit for bit, or with degrees where a client asked for those."""
    params = (item.param1, item.param2, item.param3, item.param4)
    head = (system, component, seq, item.frame, item.command, item.current, item.autocontinue)
    if not as_float:
        return mavlink.MAVLink_mission_item_int_message(*head, *params, item.x, item.y, item.z, kind)
    scale = _UNITS_PER_DEGREE if item.frame in GLOBAL_FRAMES else 1.0
    x, y = (math.nan if value == _UNKNOWN else value / scale for value in (item.x, item.y))
    return mavlink.MAVLink_mission_item_message(*head, *params, x, y, item.z, kind)


def home_item(home: Home | None) -> PlanItem:
    """Home as item 0 of a dialect that puts it there; zeros while it is not known."""
    if home is None:
        return PlanItem(0, NAV_WAYPOINT, 0, 0.0, 0.0, 0.0, 0.0, 0, 0, 0.0)
    x, y = round(home.lat_deg * _UNITS_PER_DEGREE), round(home.lon_deg * _UNITS_PER_DEGREE)
    return PlanItem(0, NAV_WAYPOINT, 0, 0.0, 0.0, 0.0, 0.0, x, y, home.altitude_m)


def with_jump_moved(item: PlanItem, places: int) -> PlanItem:
    """The item with the target of a DO_JUMP counted `places` further."""
    if item.command != DO_JUMP or places == 0:
        return item
    return replace(item, param1=item.param1 + places)


def _whole(value: float) -> int | None:
    if math.isnan(value):
        return _UNKNOWN
    return round(value) if -(2.0**31) <= value <= 2.0**31 - 1.0 else None
