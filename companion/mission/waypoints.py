"""Text of `QGC WPL 110`: a mission as a table with one item per line, the first of which is home.

Twelve columns: number, current, frame, command, params 1 to 7 (5 and 6 are latitude and longitude), autocontinue. Home
is number 0, and DO_JUMP counts so too: item n of a vessel's list is number n + 1 here. The format has no fence, no
rally points and no speed. https://mavlink.io/en/file_formats/
"""

from __future__ import annotations

import math

from companion.mission.commands import Command
from companion.mission.plan import PlanItem
from companion.mission.plan_file import PlanFile, PlanFileError, PlanRow, to_item, to_row

_HEADER = "QGC WPL 110"
_COLUMNS = 12


def read(name: str, text: str) -> PlanFile:
    """The plan in a waypoint file. A home at 0, 0 counts as none. Raises PlanFileError with every bad line."""
    lines = text.removeprefix("\ufeff").splitlines()
    if not lines or lines[0].split() != _HEADER.split():
        raise PlanFileError([f"{name}:1: not a waypoint file; its first line must be “{_HEADER}”"])
    problems: list[str] = []
    home: tuple[float, float, float] | None = None
    items: list[PlanItem] = []
    number = 0
    for line_number, line in enumerate(lines[1:], start=2):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        parsed = _item(line.split(), number)
        if isinstance(parsed, str):
            problems.append(f"{name}:{line_number}: {parsed}")
        elif number == 0:
            at_zero = parsed.x == 0 and parsed.y == 0
            home = None if at_zero else (parsed.x / 1e7, parsed.y / 1e7, parsed.z)
        else:
            items.append(parsed)
        number += 1
    if problems:
        raise PlanFileError(problems)
    return PlanFile(tuple(items), home=home)


def write(name: str, plan: PlanFile) -> str:
    """The text of a waypoint file, without the cruise speed. Raises PlanFileError for a plan with a fence or rally
    points."""
    if plan.fence or plan.rally:
        raise PlanFileError([f"{name}: a waypoint file holds no fence and no rally points; write a .plan file"])
    lat, lon, altitude_m = plan.home or (0.0, 0.0, 0.0)
    home = PlanRow(Command.NAV_WAYPOINT, 0, (0.0, 0.0, 0.0, 0.0, lat, lon, altitude_m), current=1)
    rows = [home, *(_outgoing(to_row(item)) for item in plan.mission)]
    return "\n".join([_HEADER, *(_line(number, row) for number, row in enumerate(rows))]) + "\n"


def _item(fields: list[str], number: int) -> PlanItem | str:
    """The item of line `number`, or a text about what is wrong with it."""
    if len(fields) != _COLUMNS:
        return f"{len(fields)} columns; give {_COLUMNS}, separated by tabs"
    try:
        given, current, frame, command = (int(field) for field in fields[:4])
        params = tuple(float(field) for field in fields[4:11])
        autocontinue = int(fields[11])
    except ValueError as error:
        return f"not a number ({error}); correct it"
    if given != number:
        return f"numbered {given}; number the lines from 0 (home) without gaps, so this one {number}"
    if command == Command.DO_JUMP and number:
        if params[0] == 0:
            return "DO_JUMP to 0, which is home; give the number of an item, or use NAV_RETURN_TO_LAUNCH (20)"
        if not math.isfinite(params[0]):
            return f"DO_JUMP to {params[0]:g}; give the number of an item"
        params = (params[0] - 1, *params[1:])
    return to_item(max(0, number - 1), PlanRow(command, frame, params, autocontinue, current))


def _outgoing(row: PlanRow) -> PlanRow:
    if row.command != Command.DO_JUMP:
        return row
    return PlanRow(row.command, row.frame, (row.params[0] + 1, *row.params[1:]), row.autocontinue, row.current)


def _line(number: int, row: PlanRow) -> str:
    fields = [
        str(number),
        str(row.current),
        str(row.frame),
        str(int(row.command)),
        *(_text(value) for value in row.params),
    ]
    return "\t".join([*fields, str(row.autocontinue)])


def _text(value: float) -> str:
    """The shortest text that reads back as the same number."""
    return repr(value).removesuffix(".0")
