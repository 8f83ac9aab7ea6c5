"""From a place in a plan to the task there."""

from __future__ import annotations

import math

from companion.mission.commands import DESTINATIONS, Command, heading_rad, must_stay, stay_s
from companion.mission.cursor import Cursor
from companion.mission.plan import PlanItem
from companion.mission.tasks import Complete, Dock, ReturnHome, RoutePoint, Sail, Stay, Task, Turn, Wait

LONGEST_ROUTE = 200
LOOK_BEYOND = 16
_GOES_ON = (Command.NAV_RETURN_TO_LAUNCH, Command.NAV_LAND)


def task_at(cursor: Cursor, arrived: bool) -> Task:
    """What to do at `cursor`, which stands at a task or at the end. `arrived`: at the destination itself, so the stay remains."""
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
    if item.command == Command.NAV_LAND:
        return Dock(item.seq, item.lat_deg, item.lon_deg, heading_rad(item) or 0.0)
    return ReturnHome(item.seq)


def _sail(ahead: Cursor) -> Sail:
    """The points from here to the first at which the boat must come to rest; moves `ahead` along.

    A route ends early, without a stop, at its longest length and before a point that would follow itself; the next one goes on from there.
    Before the way home, or to a berth, it does not stop either.
    """
    route: list[RoutePoint] = []
    while (item := ahead.item) is not None and item.command in DESTINATIONS:
        if len(route) == LONGEST_ROUTE or (route and route[-1].seq == ahead.seq):
            return Sail(tuple(route), False, _beyond(ahead))
        route.append(_point(item, ahead))
        if must_stay(item):
            break
        ahead.advance()
    return Sail(tuple(route), stop=item is None or item.command not in _GOES_ON)


def _beyond(ahead: Cursor) -> tuple[RoutePoint, ...]:
    """What the next route begins with."""
    points: list[RoutePoint] = []
    while len(points) < LOOK_BEYOND and (item := ahead.item) is not None and item.command in DESTINATIONS:
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


def _wait(item: PlanItem) -> Wait:
    if item.param1 >= 0.0:
        return Wait(item.seq, item.param1)
    return Wait(item.seq, math.inf, (int(item.param2), int(item.param3), int(item.param4)))
