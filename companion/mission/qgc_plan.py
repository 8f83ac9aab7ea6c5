"""Text of QGroundControl's `.plan`: mission, fence and rally points as JSON.

Surveys and corridor scans are read as the plain items that QGroundControl stores with them; they are never written. Of
structure scans and landing patterns it stores none.
https://docs.qgroundcontrol.com/master/en/qgc-dev-guide/file_formats/plan.html
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from dataclasses import replace
from typing import Any

from companion.mission.commands import PLACES, Command
from companion.mission.plan import PlanItem
from companion.mission.plan_file import PlanFile, PlanFileError, PlanRow, to_item, to_row
from companion.mission.qgc_zones import FencePart, fence_rows, fence_text, point, rally_rows, rally_text

_FILE_FRAMES = {5: 0, 6: 3, 11: 10}  # the file has only the float variants of these frames
_STORED = ("survey", "CorridorScan")  # complex items that stand in the file with their plain items
_PX4 = 12
_SURFACE_BOAT = 11


def read(name: str, text: str) -> PlanFile:
    """The plan in a `.plan` text. null among parameters is NaN; DO_JUMP's doJumpId becomes the item's number. Raises
    PlanFileError with every problem."""
    try:
        content = json.loads(text.removeprefix("\ufeff"), parse_constant=_no_constant, parse_int=_whole_number)
    except (ValueError, RecursionError) as error:
        where = (
            f"{name}:{error.lineno}:{error.colno}: {error.msg}"
            if isinstance(error, json.JSONDecodeError)
            else f"{name}: {error}"
        )
        raise PlanFileError([f"{where}; save the plan again, or correct the JSON"]) from error
    if (
        not isinstance(content, dict)
        or content.get("fileType") != "Plan"
        or not isinstance(content.get("mission"), dict)
    ):
        raise PlanFileError([f'{name}: not a QGroundControl plan; it needs "fileType": "Plan" and an object "mission"'])
    problems: list[str] = []
    mission = content["mission"]
    plan = PlanFile(
        _mission(mission.get("items"), problems),
        _zones("geoFence", fence_rows(_object(content, "geoFence"), problems), problems),
        _zones("rallyPoints", rally_rows(_object(content, "rallyPoints"), problems), problems),
        _home(mission.get("plannedHomePosition"), problems),
        _speed(mission.get("cruiseSpeed"), problems),
    )
    if problems:
        raise PlanFileError([f"{name}: {problem}" for problem in problems])
    return plan


def write(name: str, plan: PlanFile) -> str:
    """The text of a `.plan` file. Without a home, the first destination takes its place. Raises PlanFileError for a
    fence that the format cannot hold."""
    problems: list[str] = []
    mission: dict[str, Any] = {
        "version": 2,
        "firmwareType": _PX4,
        "vehicleType": _SURFACE_BOAT,
        "globalPlanAltitudeMode": 1,
        "plannedHomePosition": list(plan.home or _first_destination(plan.mission)),
        "items": [_simple_item(item) for item in plan.mission],
    }
    if plan.cruise_speed_mps is not None:
        mission |= {"cruiseSpeed": plan.cruise_speed_mps, "hoverSpeed": plan.cruise_speed_mps}
    content = {
        "fileType": "Plan",
        "version": 1,
        "groundStation": "QGroundControl",
        "mission": mission,
        "geoFence": fence_text(plan.fence, problems),
        "rallyPoints": rally_text(plan.rally),
    }
    if problems:
        raise PlanFileError([f"{name}: {problem}" for problem in problems])
    return json.dumps(content, indent=2, allow_nan=False) + "\n"


def _no_constant(text: str) -> float:
    raise ValueError(f"{text} is no JSON; write null for a parameter that is not given")


def _whole_number(text: str) -> int | float:
    """A whole number; one with 20 digits or more becomes a float, which the check of its field refuses if too
    large."""
    return int(text) if len(text) < 20 else float(text)


def _object(content: dict[str, Any], key: str) -> dict[str, Any]:
    """The object at `key`; empty if there is none, as in older files without fence and rally points."""
    value = content.get(key)
    return value if isinstance(value, dict) else {}


# --- mission -------------------------------------------------------------------------------------------------------


def _mission(items: Any, problems: list[str]) -> tuple[PlanItem, ...]:
    if not isinstance(items, list):
        problems.append('mission: no list "items"; save the plan again')
        return ()
    flat = list(_flatten(items, problems))
    numbers: dict[float, int] = {}
    for nested in (False, True):  # of two equal ids, that of the plan's own item counts before that of a survey
        for seq, (_, raw, inside) in enumerate(flat):
            if inside is nested:
                jump_id = raw.get("doJumpId")
                numbers.setdefault(jump_id if isinstance(jump_id, int) else seq + 1, seq)
    result: list[PlanItem] = []
    for seq, (place, raw, _) in enumerate(flat):
        row = _row(raw)
        if isinstance(row, PlanRow) and row.command == Command.DO_JUMP:
            row = _aimed(row, numbers)
        item = row if isinstance(row, str) else to_item(seq, row)
        if isinstance(item, str):
            problems.append(f"{place}: {item}")
        else:
            result.append(item)
    return tuple(result)


def _flatten(items: list[Any], problems: list[str]) -> Iterator[tuple[str, dict[str, Any], bool]]:
    """(place for people, the item's object, whether it comes from a complex item), in order."""
    number = 0
    for raw in items:
        number += 1
        place = f"mission item {number}"
        if not isinstance(raw, dict):
            problems.append(f"{place}: not an object; remove it")
        elif raw.get("type") != "ComplexItem":
            yield place, raw, False
        else:
            kind = raw.get("complexItemType", "complex item")
            transect = raw.get("TransectStyleComplexItem")
            parts = transect.get("Items") if isinstance(transect, dict) else None
            if not isinstance(parts, list) or not parts:
                remedy = (
                    "open the plan in QGroundControl and save it again"
                    if kind in _STORED
                    else "a .plan file never holds them: upload it from QGroundControl, or remove it"
                )
                problems.append(f"{place}: {kind} without its items; {remedy}")
                continue
            for part_number, part in enumerate(parts):
                place = f"mission item {number + part_number} ({kind})"
                if isinstance(part, dict):
                    yield place, part, True
                else:
                    problems.append(f"{place}: not an object; remove it")
            number += len(parts) - 1


def _row(raw: dict[str, Any]) -> PlanRow | str:
    command, frame, params = raw.get("command"), raw.get("frame", 3), raw.get("params")
    if not isinstance(command, int) or not isinstance(frame, int):
        return f"command {command!r} in frame {frame!r}; give whole numbers"
    if (
        not isinstance(params, list)
        or len(params) != 7
        or not all(value is None or _is_number(value) for value in params)
    ):
        return f"params are {params!r}; give a list of 7 numbers or null"
    values = tuple(math.nan if value is None else float(value) for value in params)
    return PlanRow(command, frame, values, autocontinue=int(raw.get("autoContinue", True) is not False))


def _aimed(row: PlanRow, numbers: dict[float, int]) -> PlanRow | str:
    """The DO_JUMP with the item number of its target instead of the target's doJumpId; or what is wrong with it."""
    target = numbers.get(row.params[0])
    if target is None:
        return f"DO_JUMP to doJumpId {row.params[0]:g}, which no item has; choose its target again"
    return replace(row, params=(float(target), *row.params[1:]))


def _simple_item(item: PlanItem) -> dict[str, Any]:
    row = to_row(item)
    params = [None if not math.isfinite(value) else value for value in row.params]
    if row.command == Command.DO_JUMP:
        params[0] = row.params[0] + 1
    return {
        "type": "SimpleItem",
        "command": int(row.command),
        "frame": _FILE_FRAMES.get(row.frame, row.frame),
        "params": params,
        "autoContinue": bool(row.autocontinue),
        "doJumpId": item.seq + 1,
    }


def _first_destination(items: tuple[PlanItem, ...]) -> tuple[float, float, float]:
    return next(((item.x / 1e7, item.y / 1e7, 0.0) for item in items if item.command in PLACES), (0.0, 0.0, 0.0))


def _home(value: Any, problems: list[str]) -> tuple[float, float, float] | None:
    if value is None:
        return None
    home = point(value)
    if home is None:
        problems.append(f"mission: plannedHomePosition is {value!r}; give [latitude, longitude, altitude]")
    return home


def _speed(value: Any, problems: list[str]) -> float | None:
    if value is None:
        return None
    if not _is_number(value) or not 0.0 < value < math.inf:
        problems.append(f"mission: cruiseSpeed is {value!r}; give a speed above 0 m/s")
        return None
    return float(value)


def _zones(place: str, parts: Iterator[FencePart], problems: list[str]) -> tuple[PlanItem, ...]:
    result: list[PlanItem] = []
    for where, row in parts:
        item = to_item(len(result), row)
        if isinstance(item, str):
            problems.append(f"{place}: {where}: {item}")
        else:
            result.append(item)
    return tuple(result)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
