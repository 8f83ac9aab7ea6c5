"""The content of a plan file of any format, its error, and the conversion of items."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from companion.mission.plan import GLOBAL_FRAMES, PlanItem

_LARGEST_FLOAT32 = 3.4028234663852886e38
_INT32 = 2**31 - 1


@dataclass(frozen=True, slots=True)
class PlanFile:
    """Mission, fence and rally points. `home` (lat_deg, lon_deg, altitude_m) and the cruise speed are those of the
    plan, for estimates."""

    mission: tuple[PlanItem, ...]
    fence: tuple[PlanItem, ...] = ()
    rally: tuple[PlanItem, ...] = ()
    home: tuple[float, float, float] | None = None
    cruise_speed_mps: float | None = None


class PlanFileError(Exception):
    """A plan file cannot be read or written. `problems`: one line for each, with file, line or item, and remedy."""

    def __init__(self, problems: Sequence[str]) -> None:
        super().__init__("\n".join(problems))
        self.problems = list(problems)


@dataclass(frozen=True, slots=True)
class PlanRow:
    """An item as files hold it: `params` 1…7; 5 and 6 are degrees in a global frame, plain numbers in another."""

    command: int
    frame: int
    params: tuple[float, ...]
    autocontinue: int = 1
    current: int = 0


def to_item(seq: int, row: PlanRow) -> PlanItem | str:
    """The item, or a text about what is wrong with it. NaN in params 5 and 6 becomes 0 (they have no meaning then); the
    resolution is 1e-7°."""
    if not 0 <= row.command <= 0xFFFF or not 0 <= row.frame <= 0xFF:
        return f"command {row.command} in frame {row.frame}; give a MAV_CMD and a MAV_FRAME number"
    for number, value in enumerate(row.params, start=1):
        if abs(value) > _LARGEST_FLOAT32 and not math.isinf(value):
            return f"param{number} is {value:g}; give a number that fits 32 bits"
    x, y = (0.0 if math.isnan(value) else value for value in row.params[4:6])
    if row.frame in GLOBAL_FRAMES:
        if not abs(x) <= 90.0:
            return f"latitude (param5) is {x:g}; give −90 to 90 degrees"
        if not abs(y) <= 180.0:
            return f"longitude (param6) is {y:g}; give −180 to 180 degrees"
        x, y = x * 1e7, y * 1e7
    elif not (abs(x) <= _INT32 and abs(y) <= _INT32):
        return f"params 5 and 6 are {x:g} and {y:g}; give numbers that fit 32 bits"
    p1, p2, p3, p4, z = *row.params[:4], row.params[6]
    return PlanItem(seq, row.command, row.frame, p1, p2, p3, p4, round(x), round(y), z, row.autocontinue, row.current)


def to_row(item: PlanItem) -> PlanRow:
    """The inverse of `to_item`, to the last digit."""
    x, y = (item.x / 1e7, item.y / 1e7) if item.frame in GLOBAL_FRAMES else (float(item.x), float(item.y))
    params = (item.param1, item.param2, item.param3, item.param4, x, y, item.z)
    return PlanRow(item.command, item.frame, params, item.autocontinue, item.current)
