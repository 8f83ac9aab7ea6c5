"""The fence and the rally points in QGroundControl's `.plan`."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

from companion.mission.commands import CIRCLES, POLYGONS, Command
from companion.mission.plan import PlanItem
from companion.mission.plan_file import PlanRow

_GLOBAL, _GLOBAL_RELATIVE_ALT = 0, 3
FencePart = tuple[str, PlanRow]
"""(place in the file, for people; item)"""


def point(value: Any) -> tuple[float, float, float] | None:
    """(lat_deg, lon_deg, altitude_m) of a list [latitude, longitude] or [latitude, longitude, altitude]; None for
    anything else."""
    if not isinstance(value, list) or len(value) not in (2, 3):
        return None
    if not all(
        isinstance(number, int | float) and not isinstance(number, bool) and math.isfinite(number) for number in value
    ):
        return None
    lat, lon, altitude_m = (*value, 0.0)[:3]
    if not (abs(lat) <= 90.0 and abs(lon) <= 180.0):
        return None
    return float(lat), float(lon), float(altitude_m)


def fence_rows(fence: dict[str, Any], problems: list[str]) -> Iterator[FencePart]:
    """The items of a `geoFence` object in QGroundControl's order: polygons, circles, return point. Appends what is
    wrong to `problems`."""
    yield from _polygon_rows(fence, problems)
    yield from _circle_rows(fence, problems)
    if fence.get("breachReturn") is not None:
        back = point(fence["breachReturn"])
        if back is None:
            problems.append(
                f"geoFence: breachReturn is {fence['breachReturn']!r}; give [latitude, longitude, altitude]"
            )
        else:
            yield "breachReturn", PlanRow(Command.FENCE_RETURN_POINT, _GLOBAL_RELATIVE_ALT, (0.0, 0.0, 0.0, 0.0, *back))


def _polygon_rows(fence: dict[str, Any], problems: list[str]) -> Iterator[FencePart]:
    for number, polygon in enumerate(_list(fence, "polygons"), start=1):
        place = f"polygon {number}"
        vertices = [point(value) for value in _list(polygon, "polygon")]
        if not vertices or None in vertices:
            problems.append(f"geoFence: {place}: no list of [latitude, longitude] pairs; draw it again")
            continue
        command = Command.FENCE_POLYGON_INCLUSION if polygon.get("inclusion", True) else Command.FENCE_POLYGON_EXCLUSION
        for vertex in vertices:
            if vertex is not None:
                yield place, PlanRow(command, _GLOBAL, (float(len(vertices)), 0.0, 0.0, 0.0, *vertex))


def _circle_rows(fence: dict[str, Any], problems: list[str]) -> Iterator[FencePart]:
    for number, entry in enumerate(_list(fence, "circles"), start=1):
        place = f"circle {number}"
        circle = entry.get("circle") if isinstance(entry, dict) else None
        centre = point(circle.get("center")) if isinstance(circle, dict) else None
        radius_m = circle.get("radius") if isinstance(circle, dict) else None
        if centre is None or not isinstance(radius_m, int | float):
            problems.append(f"geoFence: {place}: needs center [latitude, longitude] and radius; draw it again")
            continue
        command = Command.FENCE_CIRCLE_INCLUSION if entry.get("inclusion", True) else Command.FENCE_CIRCLE_EXCLUSION
        yield place, PlanRow(command, _GLOBAL, (float(radius_m), 0.0, 0.0, 0.0, *centre))


def rally_rows(rally: dict[str, Any], problems: list[str]) -> Iterator[FencePart]:
    """The items of a `rallyPoints` object, in order. Appends what is wrong to `problems`."""
    for number, value in enumerate(_list(rally, "points"), start=1):
        place = point(value)
        if place is None:
            problems.append(f"rallyPoints: point {number} is {value!r}; give [latitude, longitude, altitude]")
        else:
            yield f"point {number}", PlanRow(Command.RALLY_POINT, _GLOBAL_RELATIVE_ALT, (0.0, 0.0, 0.0, 0.0, *place))


def fence_text(fence: Sequence[PlanItem], problems: list[str]) -> dict[str, Any]:
    """The object `geoFence` of a fence. Appends a problem for each item of an inclusion group other than 0, which it
    cannot hold."""
    polygons: list[dict[str, Any]] = []
    circles: list[dict[str, Any]] = []
    result: dict[str, Any] = {"version": 2, "polygons": polygons, "circles": circles}
    left = 0  # vertices still to come in the present polygon
    for item in fence:
        place = [item.x / 1e7, item.y / 1e7]
        if item.command in POLYGONS | CIRCLES and item.param2 != 0.0:
            problems.append(
                f"fence item {item.number}: a .plan file cannot hold inclusion group {item.param2:g}; use group 0"
            )
        if item.command in POLYGONS:
            if left <= 0:
                left = int(item.param1)
                polygons.append(
                    {"version": 1, "inclusion": item.command == Command.FENCE_POLYGON_INCLUSION, "polygon": []}
                )
            polygons[-1]["polygon"].append(place)
            left -= 1
        elif item.command in CIRCLES:
            inclusion = item.command == Command.FENCE_CIRCLE_INCLUSION
            circles.append({"version": 1, "inclusion": inclusion, "circle": {"center": place, "radius": item.param1}})
        else:
            result["breachReturn"] = [*place, _finite(item.z)]
    return result


def rally_text(rally: Sequence[PlanItem]) -> dict[str, Any]:
    """The object `rallyPoints` of rally items."""
    return {"version": 2, "points": [[item.x / 1e7, item.y / 1e7, _finite(item.z)] for item in rally]}


def _finite(altitude_m: float) -> float:
    return altitude_m if math.isfinite(altitude_m) else 0.0


def _list(content: Any, key: str) -> list[Any]:
    value = content.get(key) if isinstance(content, dict) else None
    return value if isinstance(value, list) else []
