"""A route of a chart program (points in order) → mission items, and back."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from companion.mission.commands import DESTINATIONS, RULES, Command, Role, heading_rad, name_of, stay_s
from companion.mission.plan import PlanItem
from companion.mission.plan_file import PlanFile, PlanFileError, PlanRow, to_item

_GLOBAL_RELATIVE_ALT = 3
_MISSION = 2
_USUAL = -2.0  # DO_CHANGE_SPEED: back to the vessel's speed
_GROUND_SPEED = 1.0


@dataclass(frozen=True, slots=True)
class RouteFilePoint:
    """One point of a route. `radius_m`, `speed_mps` None: the vessel's own (the speed is for the leg to the point);
    `hold_s` None: for ever; `heading_deg` None: any."""

    lat_deg: float
    lon_deg: float
    radius_m: float | None = None
    speed_mps: float | None = None
    hold_s: float | None = 0.0
    heading_deg: float | None = None


def number(text: str | None, label: str, low: float, high: float, remedy: str) -> float | str:
    """The number in `text`, or a text about what is wrong with it."""
    if text is None:
        return f"no {label}; {remedy}"
    try:
        value = float(text)
    except ValueError:
        return f"{label} is {text[:40]!r}; {remedy}"
    return value if low <= value <= high else f"{label} is {value:g}; {remedy}"


def place_of(lat: str | None, lon: str | None) -> tuple[float, float] | str:
    """(lat_deg, lon_deg) of two texts, or a text about what is wrong with them."""
    lat_deg = number(lat, "latitude", -90.0, 90.0, "give −90 to 90 degrees")
    if isinstance(lat_deg, str):
        return lat_deg
    lon_deg = number(lon, "longitude", -180.0, 180.0, "give −180 to 180 degrees")
    return lon_deg if isinstance(lon_deg, str) else (lat_deg, lon_deg)


def to_plan(name: str, points: Sequence[RouteFilePoint]) -> PlanFile:
    """The mission of a route: one item for each point and one for each change of speed. Raises PlanFileError for no
    points or an invalid one."""
    if not points:
        raise PlanFileError([f"{name}: no points in it; draw a route and save it again"])
    items: list[PlanItem] = []
    speed_mps: float | None = None
    for point in points:
        rows: list[PlanRow] = []
        if point.speed_mps != speed_mps:
            speed_mps = point.speed_mps
            value = _USUAL if speed_mps is None else speed_mps
            rows.append(PlanRow(Command.DO_CHANGE_SPEED, _MISSION, (_GROUND_SPEED, value, -1.0, 0.0, 0.0, 0.0, 0.0)))
        rows.append(_row(point))
        for row in rows:
            item = to_item(len(items), row)
            if isinstance(item, str):
                raise PlanFileError([f"{name}: point at {point.lat_deg:g}, {point.lon_deg:g}: {item}"])
            items.append(item)
    return PlanFile(tuple(items))


def _row(point: RouteFilePoint) -> PlanRow:
    heading = math.nan if point.heading_deg is None else point.heading_deg or 360.0
    command = Command.NAV_LOITER_UNLIM if point.hold_s is None else Command.NAV_WAYPOINT
    first, second = (0.0, 0.0) if point.hold_s is None else (point.hold_s, point.radius_m or 0.0)
    return PlanRow(command, _GLOBAL_RELATIVE_ALT, (first, second, 0.0, heading, point.lat_deg, point.lon_deg, 0.0))


_DROPPED = (Role.IGNORED, Role.PAYLOAD)


def from_plan(name: str, plan: PlanFile, format_text: str, plain: bool = False) -> tuple[RouteFilePoint, ...]:
    """The points of a plan that is a route, without the items that do not move the boat (cameras).

    `plain`: the format holds positions only. Raises PlanFileError with every item that the format, named
    `format_text`, cannot hold.
    """
    problems = [f"{name}: the {what} has no place in {format_text}; write a .plan file" for what in _zones(plan)]
    points: list[RouteFilePoint] = []
    speed_mps: float | None = None
    for item in plan.mission:
        if item.command == Command.DO_CHANGE_SPEED:
            speed_mps = speed_mps if item.param2 == -1.0 else item.param2 if item.param2 > 0.0 else None
        elif item.command in DESTINATIONS:
            point = _point(item, speed_mps)
            points.append(point)
            if plain and point != RouteFilePoint(point.lat_deg, point.lon_deg):
                text = "its radius, speed, stay or heading has no place in"
                problems.append(f"{name}: item {item.number}: {text} {format_text}; write a .plan, .gpx or .json file")
        elif item.command not in RULES or RULES[item.command].role not in _DROPPED:
            problems.append(
                f"{name}: item {item.number}: {name_of(item.command)} has no place in {format_text}; write a .plan file"
            )
    if not points and not problems:
        problems.append(f"{name}: the plan has no waypoints to write")
    if problems:
        raise PlanFileError(problems)
    return tuple(points)


def _zones(plan: PlanFile) -> Iterator[str]:
    if plan.fence:
        yield "fence"
    if plan.rally:
        yield "list of rally points"


def _point(item: PlanItem, speed_mps: float | None) -> RouteFilePoint:
    radius_m = item.param2 if item.command == Command.NAV_WAYPOINT and item.param2 > 0.0 else None
    heading_deg = None if heading_rad(item) is None else item.param4
    return RouteFilePoint(item.x / 1e7, item.y / 1e7, radius_m, speed_mps, stay_s(item), heading_deg)
