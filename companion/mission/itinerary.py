"""A place in a plan → the task there."""

from __future__ import annotations

import math

from companion.mission.commands import DESTINATIONS, PLACES, Command, heading_rad, must_stay, stay_s
from companion.mission.cursor import Cursor
from companion.mission.plan import PlanItem
from companion.mission.tasks import (
    Complete,
    Dock,
    Orbit,
    ReturnHome,
    RoutePoint,
    Sail,
    SeaTrial,
    Stay,
    Task,
    Turn,
    Wait,
)

LONGEST_ROUTE = 40  # a longer one would take too long to lay in one tick
LOOK_BEYOND = 16
_GOES_ON = (Command.NAV_RETURN_TO_LAUNCH, Command.NAV_LAND, Command.NAV_LOITER_TURNS)


def task_at(cursor: Cursor, arrived: bool) -> Task:
    """The task at `cursor`, which is at a task item or at the end. `arrived`: the boat is at the destination, so its
    stay remains."""
    item = cursor.item
    if item is None:
        return Complete()
    if item.command in DESTINATIONS:
        return _stay(item) if arrived else _sail(cursor.copy())
    if item.command == Command.NAV_DELAY:
        return _wait(item)
    if item.command == Command.CONDITION_YAW:
        angle_rad = math.radians(item.param1 if item.param4 else math.remainder(item.param1, 360.0))
        return Turn(item.seq, angle_rad, bool(item.param4), int(item.param3))
    if item.command == Command.NAV_LOITER_TURNS:
        return _orbit(item, cursor.copy())
    if item.command == Command.USER_5:
        return SeaTrial(item.seq, item.param1 if item.param1 > 0.0 else None)
    if item.command == Command.NAV_LAND:
        return Dock(item.seq, item.lat_deg, item.lon_deg, heading_rad(item))
    return ReturnHome(item.seq)


def _sail(ahead: Cursor) -> Sail:
    """The points up to the first at which the boat must come to rest; advances `ahead`.

    A route ends early, without a stop, at its greatest length, and before a point that would follow itself; the next
    route continues there. It does not stop before the way home, a berth or an orbit either, unless it is sailed stern
    first. Where the boat changes between bow first and stern first, it comes to rest.
    """
    route: list[RoutePoint] = []
    astern = ahead.astern
    while (item := ahead.item) is not None and item.command in DESTINATIONS:
        if route and ahead.astern is not astern:
            return Sail(tuple(route), True, astern=astern)
        if len(route) == LONGEST_ROUTE or (route and route[-1].seq == ahead.seq):
            return Sail(tuple(route), False, _beyond(ahead), astern)
        route.append(_point(item, ahead))
        if must_stay(item):
            break
        ahead.advance()
    return Sail(tuple(route), astern or item is None or item.command not in _GOES_ON, astern=astern)


def _beyond(ahead: Cursor) -> tuple[RoutePoint, ...]:
    """The first points of the next route."""
    points: list[RoutePoint] = []
    astern = ahead.astern
    while len(points) < LOOK_BEYOND and (item := ahead.item) is not None and item.command in DESTINATIONS:
        if ahead.astern is not astern:
            break
        points.append(_point(item, ahead))
        if must_stay(item):
            break
        ahead.advance()
    return tuple(points)


def _point(item: PlanItem, at: Cursor) -> RoutePoint:
    radius_m = item.param2 if item.command == Command.NAV_WAYPOINT and item.param2 > 0.0 else None
    return RoutePoint(at.seq, item.lat_deg, item.lon_deg, radius_m, at.leg_speed_mps, heading_rad(item), at.surveying)


def _stay(item: PlanItem) -> Stay:
    return Stay(item.seq, item.lat_deg, item.lon_deg, heading_rad(item), stay_s(item))


def _orbit(item: PlanItem, at: Cursor) -> Orbit:
    """Params: turns; 1 to leave only towards the next item; radius, negative counter-clockwise. The boat always leaves
    straight to the next item, whatever param 4 asks of a craft that follows the line between two centres."""
    speed_mps, leave_to = at.leg_speed_mps, None
    at.advance()
    if item.param2 == 1.0 and at.item is not None and at.item.command in PLACES:
        leave_to = (at.item.lat_deg, at.item.lon_deg)
    given = math.isfinite(item.param3) and item.param3 != 0.0
    radius_m, clockwise = (abs(item.param3), item.param3 > 0.0) if given else (None, None)
    return Orbit(item.seq, item.lat_deg, item.lon_deg, radius_m, clockwise, item.param1, speed_mps, leave_to)


def _wait(item: PlanItem) -> Wait:
    if item.param1 >= 0.0:
        return Wait(item.seq, item.param1)
    return Wait(item.seq, math.inf, (int(item.param2), int(item.param3), int(item.param4)))
