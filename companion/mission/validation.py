"""Checks of missions, fences and rally points before a vessel accepts them.

Each refusal names the item and the remedy, and has the MAV_MISSION_RESULT that a ground station shows.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from companion.core.geodesy import distance_and_bearing
from companion.mission.auxiliary import UNSET_INT
from companion.mission.commands import (
    CIRCLES,
    POLYGONS,
    RELAYS,
    RULES,
    SERVOS,
    TASKS,
    Command,
    Rule,
    is_no_circle,
    name_of,
)
from companion.mission.jumps import check_marks, is_endless, target_of
from companion.mission.plan import GLOBAL_FRAMES, PlanItem, PlanKind, PlanRefusal, PlanResult, item_number
from companion.mission.polygon import MOST_VERTICES, find_crossing

CAPACITY = 10_000
"""Most items in one list; a larger MISSION_COUNT is refused with NO_SPACE."""

_NEAR_ZERO_M = 1000.0  # of latitude 0, longitude 0: a boat that lives there means it
_LAT_LIMIT = 900_000_000
_LON_LIMIT = 1_800_000_000
_PARAM_RESULTS = (
    PlanResult.INVALID_PARAM1,
    PlanResult.INVALID_PARAM2,
    PlanResult.INVALID_PARAM3,
    PlanResult.INVALID_PARAM4,
)
_KIND_NAMES = {PlanKind.MISSION: "the mission", PlanKind.FENCE: "the fence", PlanKind.RALLY: "the rally points"}


def check_item(kind: PlanKind, item: PlanItem) -> PlanRefusal | None:
    """Why `item` by itself cannot be part of such a list; None if it can. The altitude is not checked. It takes about a
    microsecond."""
    rule = RULES.get(item.command)
    if rule is None or rule.kind is not kind:
        return _unknown(kind, item, rule)
    if is_no_circle(item):
        return None
    if rule.position and (refusal := _check_position(item)) is not None:
        return refusal
    for allowed in rule.ranges:
        number = allowed.number
        value = (
            item.param1 if number == 1 else item.param2 if number == 2 else item.param3 if number == 3 else item.param4
        )
        if not allowed.allows(value):
            return _refuse(
                item, _PARAM_RESULTS[number - 1], f"{allowed.label} (param{number}) is {value:g}; {allowed.remedy}"
            )
    more = _MORE.get(item.command)
    return None if more is None else more(item)


def check_plan(
    kind: PlanKind,
    items: Sequence[PlanItem],
    servos: int | None = None,
    relays: int | None = None,
    least_radius_m: float = 0.0,
    takes_off: bool = True,
    home: tuple[float, float] | None = None,
    no_astern: str | None = None,
) -> PlanRefusal | None:
    """Why `items`, each of which has passed `check_item`, cannot be in force together; None if they can, or for an
    empty list.

    `servos`, `relays`: number of the boat's outputs; None: do not check them. `least_radius_m`: of the smallest circle
    that the boat can sail. `takes_off`: whether a take-off is taken, as what is done already (COM_TAKEOFF_OK).
    `home`: (lat_deg, lon_deg), if known. `no_astern`: why the boat cannot sail stern first; None: it can.
    """
    if len(items) > CAPACITY:
        return PlanRefusal(
            PlanResult.NO_SPACE, f"{len(items)} items are too many: {_KIND_NAMES[kind]} can hold {CAPACITY}"
        )
    for i, item in enumerate(items):
        if item.seq != i:
            return PlanRefusal(
                PlanResult.INVALID_SEQUENCE,
                f"it carries sequence number {item.seq}; number them without gaps",
                i,
            )
    if (refusal := _check_zero(items, home)) is not None:
        return refusal
    if kind is PlanKind.MISSION:
        cannot = _check_ability(items, takes_off, no_astern) or _check_outputs(items, servos, relays)
        return cannot or _check_orbits(items, least_radius_m) or _check_mission(items)
    if kind is PlanKind.FENCE:
        return _check_fence(items)
    return None


def _check_zero(items: Sequence[PlanItem], home: tuple[float, float] | None) -> PlanRefusal | None:
    """Latitude 0, longitude 0 is what programs send that have no place, unless the boat lives there."""
    if home is not None and distance_and_bearing(0.0, 0.0, *home)[0] <= _NEAR_ZERO_M:
        return None
    for item in items:
        here = item.command == Command.DO_SET_HOME and item.param1 != 0.0
        rule = RULES.get(item.command)
        placed = rule is not None and (rule.position or item.command == Command.DO_SET_HOME)
        if placed and not here and (item.x, item.y) == (0, 0) and not is_no_circle(item):
            return _refuse(item, PlanResult.INVALID_PARAM5_X, "is at latitude 0, longitude 0; give it a place")
    return None


def _refuse(item: PlanItem, result: PlanResult, text: str) -> PlanRefusal:
    return PlanRefusal(result, f"{name_of(item.command)} {text}", item.seq)


def _unknown(kind: PlanKind, item: PlanItem, rule: Rule | None) -> PlanRefusal:
    if rule is None:
        return _refuse(item, PlanResult.UNSUPPORTED, "is not supported; remove it")
    return _refuse(
        item, PlanResult.UNSUPPORTED, f"belongs to {_KIND_NAMES[rule.kind]}, not to {_KIND_NAMES[kind]}; remove it"
    )


# --- one item ------------------------------------------------------------------------------------------------------


def _check_position(item: PlanItem) -> PlanRefusal | None:
    if item.frame not in GLOBAL_FRAMES:
        text = f"is in frame {item.frame}; give latitude and longitude in a global frame (0, 3, 5, 6, 10 or 11)"
        return _refuse(item, PlanResult.UNSUPPORTED_FRAME, text)
    if not -_LAT_LIMIT <= item.x <= _LAT_LIMIT:
        return _refuse(item, PlanResult.INVALID_PARAM5_X, f"latitude is {item.lat_deg:.7f}; give −90 to 90 degrees")
    if not -_LON_LIMIT <= item.y <= _LON_LIMIT:
        return _refuse(item, PlanResult.INVALID_PARAM6_Y, f"longitude is {item.lon_deg:.7f}; give −180 to 180 degrees")
    return None


def _check_delay(item: PlanItem) -> PlanRefusal | None:
    """With param1 −1 the item needs a time of day with at least one field."""
    if item.param1 >= 0.0:
        return None
    fields = ((2, "hour", item.param2, 23), (3, "minute", item.param3, 59), (4, "second", item.param4, 59))
    for number, label, value, highest in fields:
        if not (-1.0 <= value <= highest and value == int(value)):
            return _refuse(
                item,
                _PARAM_RESULTS[number - 1],
                f"{label} (param{number}) is {value:g}; give 0 to {highest}, or −1 for any",
            )
    if item.param2 == item.param3 == item.param4 == -1.0:
        return _refuse(
            item,
            PlanResult.INVALID_PARAM2,
            "has no time to wait for; give a delay in param1, or hour, minute and second (UTC)",
        )
    return None


def _check_home(item: PlanItem) -> PlanRefusal | None:
    return _check_position(item) if item.param1 == 0.0 else None


def _check_actuators(item: PlanItem) -> PlanRefusal | None:
    """A mission item can set actuators 1 to 4 only: its fields for 5 and 6 are integers."""
    if item.x not in UNSET_INT or item.y not in UNSET_INT:
        result, number = (
            (PlanResult.INVALID_PARAM5_X, 5) if item.x not in UNSET_INT else (PlanResult.INVALID_PARAM6_Y, 6)
        )
        return _refuse(item, result, f"sets actuator {number}; in a mission use 1 to 4")
    if item.z == item.z and item.z != 0.0:
        return _refuse(
            item, PlanResult.INVALID_PARAM7, f"is for set {item.z:g} of actuators (param7); there is set 0 only"
        )
    return None


_MORE: dict[int, Callable[[PlanItem], PlanRefusal | None]] = {
    Command.NAV_DELAY: _check_delay,
    Command.DO_SET_HOME: _check_home,
    Command.DO_SET_ACTUATOR: _check_actuators,
}


# --- a mission -----------------------------------------------------------------------------------------------------


def _check_ability(items: Sequence[PlanItem], takes_off: bool, no_astern: str | None) -> PlanRefusal | None:
    """Whether the boat takes a take-off, and sails stern first, where the items ask for that."""
    for item in items:
        if item.command == Command.NAV_TAKEOFF and not takes_off:
            return _refuse(item, PlanResult.UNSUPPORTED, "is not for a boat (COM_TAKEOFF_OK); remove it")
        if item.command == Command.DO_SET_REVERSE and item.param1 == 1.0 and no_astern is not None:
            return _refuse(item, PlanResult.INVALID_PARAM1, f"1 is stern first, but {no_astern}; remove it")
    return None


def _check_outputs(items: Sequence[PlanItem], servos: int | None, relays: int | None) -> PlanRefusal | None:
    """Whether the boat has the outputs that the items use. Servos count from 1, relays from 0."""
    for item in items:
        if servos is not None and item.command in SERVOS and item.param1 > servos:
            return _no_output(item, 1, f"there is no servo output {item.param1:g}: {_numbers(servos, 1)}")
        if relays is not None and item.command in RELAYS and item.param1 >= relays:
            return _no_output(item, 1, f"there is no relay {item.param1:g}: {_numbers(relays, 0)}")
        if servos is not None and item.command == Command.DO_SET_ACTUATOR:
            values = (item.param1, item.param2, item.param3, item.param4)
            number = next((n for n, value in enumerate(values, start=1) if n > servos and value == value), None)
            if number is not None:
                return _no_output(item, number, f"there is no servo output {number}: {_numbers(servos, 1)}")
    return None


def _no_output(item: PlanItem, number: int, text: str) -> PlanRefusal:
    return PlanRefusal(_PARAM_RESULTS[number - 1], f"{name_of(item.command)}: {text}", item.seq)


def _numbers(count: int, first: int) -> str:
    return "this boat has none" if count == 0 else f"this boat has {first} to {first + count - 1}"


def _check_orbits(items: Sequence[PlanItem], least_radius_m: float) -> PlanRefusal | None:
    for item in items:
        if item.command == Command.NAV_LOITER_TURNS and 0.0 < abs(item.param3) < least_radius_m:
            text = f"radius (param3) is {item.param3:g} m; this boat needs {least_radius_m:.1f} m or more"
            return _refuse(item, PlanResult.INVALID_PARAM3, text)
    return None


def _check_mission(items: Sequence[PlanItem]) -> PlanRefusal | None:
    if (refusal := check_marks(items)) is not None:
        return refusal
    for jump in (item for item in items if item.command == Command.DO_JUMP):
        if not 0 <= jump.param1 < len(items):
            target = jump.param1 + 1
            text = f"DO_JUMP to item {target:g}, but the plan has {len(items)} items; jump to one of them"
            return PlanRefusal(PlanResult.INVALID_PARAM1, text, jump.seq)
        if jump.param1 == jump.seq:
            return PlanRefusal(
                PlanResult.INVALID_PARAM1,
                "DO_JUMP to itself; jump to another item",
                jump.seq,
            )
    if any(map(is_endless, items)) and (refusal := _check_loops(items)) is not None:
        return refusal
    if items and not any(item.command in TASKS for item in items):
        return PlanRefusal(PlanResult.INVALID, "the mission has nothing to do; add a waypoint")
    return None


def _check_loops(items: Sequence[PlanItem]) -> PlanRefusal | None:
    """Finds an endless loop without a task: follows the way after all counted jumps are used up, from each item
    once."""
    settled = [item.command in TASKS for item in items]
    targets = {item.seq: target_of(items, item) or 0 for item in items if is_endless(item)}
    for start in range(len(items)):
        way: set[int] = set()
        seq = start
        while seq < len(items) and not settled[seq]:
            if seq in way:
                jump = _jump_ahead(items, seq)
                target = item_number(targets[jump])
                name = name_of(items[jump].command)
                text = f"{name} to item {target} for ever, with nothing to do in between; add a waypoint to the loop"
                return PlanRefusal(PlanResult.INVALID_PARAM1, text, jump)
            way.add(seq)
            seq = targets.get(seq, seq + 1)
        for passed in way:
            settled[passed] = True
    return None


def _jump_ahead(items: Sequence[PlanItem], seq: int) -> int:
    """Number of the first endless jump at `seq` or after it."""
    while not is_endless(items[seq]):
        seq += 1
    return seq


# --- a fence -------------------------------------------------------------------------------------------------------


def _check_fence(items: Sequence[PlanItem]) -> PlanRefusal | None:
    return_point: int | None = None
    at = 0
    while at < len(items):
        item = items[at]
        if item.command in POLYGONS:
            if (refusal := _check_polygon(items, at)) is not None:
                return refusal
            at += int(item.param1)
            continue
        if item.command not in CIRCLES:
            if return_point is not None:
                text = f"a second return point, after item {item_number(return_point)}; keep one of them"
                return PlanRefusal(PlanResult.INVALID, text, at)
            return_point = at
        at += 1
    return None


def _check_polygon(items: Sequence[PlanItem], first: int) -> PlanRefusal | None:
    """Check the polygon that begins at item `first`: all its vertices are there and equal, and no sides cross."""
    head = items[first]
    if not head.param1 >= 3:
        return PlanRefusal(
            PlanResult.INVALID_PARAM1, f"a polygon of {head.param1:g} vertices; it needs 3 or more", first
        )
    if head.param1 > MOST_VERTICES:
        text = f"a polygon of {head.param1:g} vertices; draw it with {MOST_VERTICES} or fewer"
        return PlanRefusal(PlanResult.NO_SPACE, text, first)
    count = int(head.param1)
    vertices = items[first : first + count]
    for vertex in vertices:
        if (refusal := _check_vertex(vertex, head, count)) is not None:
            return refusal
    if len(vertices) < count:
        text = (
            f"the polygon that begins here has {len(vertices)} of its {count} vertices; "
            "send the rest, or correct param1"
        )
        return PlanRefusal(PlanResult.INVALID_PARAM1, text, first)
    crossing = find_crossing([(vertex.x, vertex.y) for vertex in vertices])
    if crossing is not None:
        sides = " and ".join(f"{item_number(first + i)}–{item_number(first + (i + 1) % count)}" for i in crossing)
        text = f"the polygon crosses itself, sides {sides}; put its vertices in order around the area"
        return PlanRefusal(PlanResult.INVALID, text, first + crossing[0])
    return None


def _check_vertex(vertex: PlanItem, head: PlanItem, count: int) -> PlanRefusal | None:
    """Check that `vertex` belongs to the polygon of `count` vertices that begins with `head`."""
    named = f"in the polygon of {count} vertices that begins at item {head.number}"
    if vertex.command != head.command:
        text = f"{named} stands {name_of(vertex.command)}; send its vertices one after the other"
        return PlanRefusal(PlanResult.INVALID, text, vertex.seq)
    if vertex.param1 != head.param1:
        text = f"{named} a vertex says {vertex.param1:g}; give each vertex the same count (param1)"
        return PlanRefusal(PlanResult.INVALID_PARAM1, text, vertex.seq)
    if vertex.param2 != head.param2:
        text = f"{named} a vertex is of group {vertex.param2:g}; give each vertex the same group (param2)"
        return PlanRefusal(PlanResult.INVALID_PARAM2, text, vertex.seq)
    return None
