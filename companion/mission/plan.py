"""Plans as data: items exactly as a ground station sent them, and the three lists of a vessel.

Items are stored raw (integers and frame as received), so that a download equals the upload bit for bit; properties give
their meaning. Numbers are those of MAVLink (MAV_CMD, MAV_FRAME, MAV_MISSION_TYPE, MAV_MISSION_RESULT).
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import IntEnum

GLOBAL_FRAMES = frozenset({0, 3, 5, 6, 10, 11})  # MAV_FRAME; all the same for a boat, which ignores altitude


class PlanKind(IntEnum):
    """The three lists; the numbers are those of MAV_MISSION_TYPE."""

    MISSION = 0
    FENCE = 1
    RALLY = 2


class PlanResult(IntEnum):
    """Answer to an upload; the numbers are those of MAV_MISSION_RESULT."""

    ACCEPTED = 0
    ERROR = 1
    UNSUPPORTED_FRAME = 2
    UNSUPPORTED = 3
    NO_SPACE = 4
    INVALID = 5
    INVALID_PARAM1 = 6
    INVALID_PARAM2 = 7
    INVALID_PARAM3 = 8
    INVALID_PARAM4 = 9
    INVALID_PARAM5_X = 10
    INVALID_PARAM6_Y = 11
    INVALID_PARAM7 = 12
    INVALID_SEQUENCE = 13
    DENIED = 14
    OPERATION_CANCELLED = 15


def item_number(seq: int) -> int:
    """The number by which people know item `seq` of a list: the first is 1, in every text, table, picture and option.

    It is what QGroundControl writes on its map and `doJumpId` in its files, the line of a `.waypoints` file, and the
    sequence number on a link with the ardupilot persona, where 0 is home. On other links sequence numbers begin with 0.
    """
    return seq + 1


@dataclass(frozen=True, slots=True)
class PlanRefusal:
    """Why a plan is refused. `seq`: the item at fault, or None for the plan as a whole."""

    result: PlanResult
    text: str
    seq: int | None = None

    def __str__(self) -> str:
        """The reason, with the item's number before it."""
        return self.text if self.seq is None else f"item {item_number(self.seq)}: {self.text}"


class PlanRefused(Exception):
    """What the work before a plan comes into force has found (`Plans.prepare_by`)."""

    def __init__(self, refusal: PlanRefusal) -> None:
        super().__init__(str(refusal))
        self.refusal = refusal


@dataclass(frozen=True, slots=True)
class PlanItem:
    """One item, as in MISSION_ITEM_INT: parameters may be NaN; x, y are degrees·1e7 in a global frame, else raw."""

    seq: int
    command: int
    frame: int
    param1: float
    param2: float
    param3: float
    param4: float
    x: int
    y: int
    z: float
    autocontinue: int = 1
    current: int = 0

    @property
    def number(self) -> int:
        """Its number for people."""
        return item_number(self.seq)

    @property
    def lat_deg(self) -> float:
        """Latitude of an item in a global frame."""
        return self.x * 1e-7

    @property
    def lon_deg(self) -> float:
        """Longitude of an item in a global frame."""
        return self.y * 1e-7


Adopt = Callable[[], None]
Prepare = Callable[[Sequence[PlanItem]], Callable[[], Adopt]]
"""Long work that a new plan needs before it comes into force. `prepare(items)` returns the work, which may be done
beside the control thread. The work returns what puts its result in force."""


class Plans:
    """The mission, the fence and the rally points in force. A list is replaced as a whole or not at all."""

    def __init__(self) -> None:
        self._items: dict[PlanKind, tuple[PlanItem, ...]] = dict.fromkeys(PlanKind, ())
        self._ids: dict[PlanKind, int] = dict.fromkeys(PlanKind, 0)
        self._listeners: list[Callable[[PlanKind], None]] = []
        self._preparations: dict[PlanKind, list[Prepare]] = {}

    def items(self, kind: PlanKind) -> tuple[PlanItem, ...]:
        """The items of that list, in order."""
        return self._items[kind]

    def plan_id(self, kind: PlanKind) -> int:
        """A number that changes with the content; 0 for an empty list (MAVLink's opaque_id)."""
        return self._ids[kind]

    def prepare_by(self, kind: PlanKind, prepare: Prepare) -> None:
        """Let `prepare` do its work before a plan of that kind comes into force. The work may raise PlanRefused."""
        self._preparations.setdefault(kind, []).append(prepare)

    def prepared(self, kind: PlanKind, items: Sequence[PlanItem]) -> Callable[[], Adopt]:
        """The work to do on checked `items` before `replace`. Without it `replace` may take long."""
        works = [prepare(items) for prepare in self._preparations.get(kind, ())]

        def work() -> Adopt:
            adopts = [one() for one in works]

            def adopt() -> None:
                for one in adopts:
                    one()

            return adopt

        return work

    def replace(self, kind: PlanKind, items: Sequence[PlanItem], known_id: int | None = None) -> None:
        """Put checked `items` in force, and call the listeners (executor, fence) in the order in which they were added.
        `known_id`: their `plan_id`, where it is known already."""
        self._items[kind] = tuple(items)
        self._ids[kind] = plan_id(items) if known_id is None else known_id
        for listener in self._listeners:
            listener(kind)

    def on_change(self, listener: Callable[[PlanKind], None]) -> None:
        """Call `listener(kind)` after every replacement."""
        self._listeners.append(listener)


def plan_id(items: Sequence[PlanItem]) -> int:
    """A number other than 0 that changes with the content of `items`; 0 when there are none."""
    if not items:
        return 0
    crc = 0
    for item in items:
        crc = zlib.crc32(_content(item), crc)
    return crc or 1


def shared_items(one: Sequence[PlanItem], other: Sequence[PlanItem]) -> int:
    """How many items both begin with, bit for bit."""
    pairs = zip(one, other, strict=False)
    return next((n for n, (a, b) in enumerate(pairs) if _content(a) != _content(b)), min(len(one), len(other)))


def _content(i: PlanItem) -> bytes:
    return struct.pack("<HBffffiif", i.command, i.frame, i.param1, i.param2, i.param3, i.param4, i.x, i.y, i.z)
