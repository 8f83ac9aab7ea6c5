"""Jumps within a mission: to an item by its number (DO_JUMP), or to a mark (DO_JUMP_TAG, JUMP_TAG).

A mark keeps its meaning when items before it are added or removed. Source: MAVLink's common.xml.
"""

from __future__ import annotations

from collections.abc import Sequence

from companion.mission.commands import Command
from companion.mission.plan import PlanItem, PlanRefusal, PlanResult, item_number

ENDLESS = -1
JUMPS = frozenset({Command.DO_JUMP, Command.DO_JUMP_TAG})


def is_endless(item: PlanItem) -> bool:
    """Whether it jumps each time that the mission comes to it."""
    return item.command in JUMPS and item.param2 == ENDLESS


def marked(items: Sequence[PlanItem], tag: float) -> int | None:
    """Place of the mark with that number; None where there is none."""
    return next((i for i, item in enumerate(items) if item.command == Command.JUMP_TAG and item.param1 == tag), None)


def target_of(items: Sequence[PlanItem], jump: PlanItem) -> int | None:
    """Place in `items` that a jump leads to; None where there is none."""
    if jump.command == Command.DO_JUMP_TAG:
        return marked(items, jump.param1)
    return int(jump.param1) if 0 <= jump.param1 < len(items) else None


def check_marks(items: Sequence[PlanItem]) -> PlanRefusal | None:
    """Why marks, or jumps to them, cannot be: one that stands twice, or a jump to none."""
    places: dict[float, int] = {}
    for item in items:
        if item.command == Command.JUMP_TAG:
            before = places.setdefault(item.param1, item.seq)
            if before != item.seq:
                text = f"JUMP_TAG {item.param1:g} is item {item_number(before)} too; give each mark its own number"
                return PlanRefusal(PlanResult.INVALID_PARAM1, text, item.seq)
    for item in items:
        if item.command == Command.DO_JUMP_TAG and item.param1 not in places:
            text = f"DO_JUMP_TAG to mark {item.param1:g}, which no JUMP_TAG has; add one"
            return PlanRefusal(PlanResult.INVALID_PARAM1, text, item.seq)
    return None
