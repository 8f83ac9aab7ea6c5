"""Figures of IMO MSC.137(76) from a Trial's log: turning circle, zig-zag, stopping. Tracks are through the water: the
current that was found is taken away."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from companion.analysis.log_reader import read_table
from companion.analysis.trial_log import Ran

Array = NDArray[np.float64]
_COLUMNS = ("t_s", "north_m", "east_m", "yaw_rad", "surge_mps", "sway_mps")
_MOMENT = "demanded_yaw_nm"  # logs of before have none
_TURNS_RAD = math.radians(5.0)  # change of heading from which the boat turns
_SAME = 0.05  # share by which a moment that is held may differ


@dataclass(frozen=True, slots=True)
class Figure:
    """One figure: what, its value and unit. `lengths`: the value in lengths of the boat, for distances."""

    name: str
    value: float
    unit: str
    lengths: float | None = None


def figures(
    folder: Path, ran: Sequence[Ran], length_m: float, current_mps: tuple[float, float], warnings: list[str]
) -> tuple[Figure, ...]:
    """All figures that the manoeuvres give. `current_mps`: towards north and east. Raises LogError, OSError."""
    table = read_table(folder / "ticks.csv", _COLUMNS, warnings, (_MOMENT,))
    track = {name: np.array(column) for name, column in table.items()}
    since_s = track["t_s"] - track["t_s"][0]
    track["north_m"] = track["north_m"] - current_mps[0] * since_s
    track["east_m"] = track["east_m"] - current_mps[1] * since_s
    c, s = np.cos(track["yaw_rad"]), np.sin(track["yaw_rad"])
    track["water_mps"] = track["surge_mps"] - (c * current_mps[0] + s * current_mps[1])
    found: list[Figure] = []
    for one in ran:
        rows = (track["t_s"] >= one.from_s) & (track["t_s"] < one.to_s)
        part = {name: column[rows] for name, column in track.items()}
        if len(part["t_s"]) < 10:
            continue
        if one.name.startswith("turning circle"):
            found += _turning(one.name, part, length_m)
        elif one.name.startswith("zig-zag"):
            found += _zig_zag(one.name, part)
        elif one.name == "stopping":
            found += _stopping(part, length_m)
    return tuple(found)


def _turning(name: str, part: Mapping[str, Array], length_m: float) -> list[Figure]:
    yaw = np.unwrap(part["yaw_rad"])
    turns = np.flatnonzero(np.abs(yaw - yaw[0]) > _TURNS_RAD)
    if not len(turns):
        return []
    i = _executed(part[_MOMENT], int(turns[0]))
    turned = np.abs(yaw - yaw[i])
    c, s = math.cos(yaw[i]), math.sin(yaw[i])
    north, east = part["north_m"] - part["north_m"][i], part["east_m"] - part["east_m"][i]
    ahead, aside = c * north + s * east, np.abs(c * east - s * north)
    found = []
    quarter, half = (np.flatnonzero(turned >= math.radians(angle)) for angle in (90.0, 180.0))
    if len(quarter):
        found += [
            Figure(f"{name}: advance", float(ahead[quarter[0]]), "m", float(ahead[quarter[0]]) / length_m),
            Figure(f"{name}: transfer", float(aside[quarter[0]]), "m", float(aside[quarter[0]]) / length_m),
        ]
    if len(half):
        found.append(Figure(f"{name}: tactical diameter", float(aside[half[0]]), "m", float(aside[half[0]]) / length_m))
    return found


def _executed(moment_nm: Array, turning: int) -> int:
    """The row from which on the moment is that of the row `turning`; that row itself where the log does not tell."""
    moment = moment_nm[turning]
    others = np.flatnonzero(~(np.abs(moment_nm[:turning] - moment) <= _SAME * abs(moment)))
    return int(others[-1]) + 1 if len(others) else 0


def _zig_zag(name: str, part: Mapping[str, Array]) -> list[Figure]:
    angle = math.radians(float(name.rsplit("/", 1)[1]))
    yaw = np.unwrap(part["yaw_rad"])
    off = yaw - yaw[0]
    found = []
    side, from_row = 1.0, 0
    for order in ("first", "second"):
        executes = np.flatnonzero(side * off[from_row:] >= angle)
        if not len(executes):
            break
        i = from_row + int(executes[0])
        back = np.flatnonzero(-side * off[i:] >= angle)
        end = i + int(back[0]) if len(back) else len(off)
        over = math.degrees(float((side * off[i:end]).max()) - angle)
        found.append(Figure(f"{name}: {order} overshoot", over, "deg"))
        side, from_row = -side, i
    return found


def _stopping(part: Mapping[str, Array], length_m: float) -> list[Figure]:
    speed = part["water_mps"]
    fastest = int(np.argmax(speed))
    way = np.hypot(np.diff(part["north_m"][fastest:]), np.diff(part["east_m"][fastest:]))
    distance = float(way.sum())
    return [
        Figure("speed before stopping", float(speed[fastest]), "m/s"),
        Figure("stopping distance", distance, "m", distance / length_m),
    ]
