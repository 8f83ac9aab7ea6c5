"""A survey as QGroundControl draws it: transects with a picture every few metres. Where each was really taken, by the
camera's own pulses, against the plan and against the geotags."""

from __future__ import annotations

import csv
import itertools
import json
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.core.geodesy import LocalFrame
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.measure import Check, Point, receiver_error_m
from sitl.scenarios.rig import Conditions
from sitl.scenarios.scenario import Scenario, Settings, number

_MISSION = 0x04040000
_APART_M, _RUN_IN_M = 8.0, 8.0
_TIMEOUT_S = 900.0
_ABREAST_M = 2.0  # pictures within this of a transect's line belong to it
_ENDS_M = 0.5  # of the first and the last picture, which waypoints give


def transects(settings: Settings) -> list[tuple[Point, Point]]:
    """Begin and end of each, in the order sailed."""
    ends = (0.0, number(settings, "length"))
    count = int(number(settings, "transects"))
    return [((ends[i % 2], i * _APART_M), (ends[1 - i % 2], i * _APART_M)) for i in range(count)]


def plan(frame: LocalFrame, lines: Sequence[tuple[Point, Point]], spacing_m: float) -> list[Item]:
    """Run-in, entry, pictures on, exit, pictures off, and a turn beyond: as a survey of QGroundControl."""

    def at(point: Point) -> Item:
        return Item(mavlink.MAV_CMD_NAV_WAYPOINT, *frame.to_geodetic(*point), params=(0.0, 1.0, 0.0, math.nan))

    def pictures(every_m: float) -> Item:
        trigger = mavlink.MAV_CMD_DO_SET_CAM_TRIGG_DIST
        return Item(trigger, params=(every_m, 0.0, 1.0, 0.0), frame=mavlink.MAV_FRAME_MISSION)

    items: list[Item] = []
    for begin, end in lines:
        beyond_m = math.copysign(_RUN_IN_M, end[0] - begin[0])
        run_in, run_out = (begin[0] - beyond_m, begin[1]), (end[0] + beyond_m, end[1])
        items += [at(run_in), at(begin), pictures(spacing_m), at(end), pictures(0.0), at(run_out)]
    return items


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Upload the survey, sail it, and count what the boat tells."""
    home = gcs.rig.config.home
    items = plan(LocalFrame(home.lat_deg, home.lon_deg), transects(settings), number(settings, "spacing"))
    gcs.ready()
    gcs.upload(items)
    gcs.set_mode(_MISSION)
    gcs.arm()
    gcs.wait("the last waypoint", lambda: len(items) - 1 in gcs.reached, _TIMEOUT_S)
    gcs.sail(2.0)
    return {"texts": [text for text in gcs.texts if "pictures" in text]}


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Spacing along each transect and error of each geotag, by the true places of the camera's pulses."""
    spacing_m, length_m = number(settings, "spacing"), number(settings, "length")
    true, tagged = _places(folder / "pictures.csv"), _geotags(folder)
    spacings, first_m, last_m = [], [], []
    lines = transects(settings)
    for begin, end in lines:
        along = [_along(place, begin, end) for place in true]
        mine = [way_m for way_m, off_m in along if off_m < _ABREAST_M and -_ABREAST_M < way_m < length_m + _ABREAST_M]
        spacings += [b - a for a, b in itertools.pairwise(mine[:-1])]  # the last picture is that of the end
        first_m.append(abs(mine[0]) if mine else math.inf)
        last_m.append(abs(mine[-1] - length_m) if mine else math.inf)
    tag_errors = [math.dist(a, b) for a, b in zip(true, tagged, strict=False)]
    count, limit_m, slow_m = len(lines), number(settings, "limit"), receiver_error_m(settings["gnss"])
    expected = count * (int(length_m / spacing_m) + 2)
    metrics = {
        "pictures": float(len(true)),
        "expected": float(expected),
        "geotags": float(len(tagged)),
        "spacing_worst_m": max((abs(value - spacing_m) for value in spacings), default=math.inf),
        "spacing_mean_m": sum(spacings) / max(1, len(spacings)),
        "geotag_worst_m": max(tag_errors, default=math.inf),
        "entry_worst_m": max(first_m),
        "exit_worst_m": max(last_m),
    }
    checks = (
        Check("a pulse for each geotag", abs(metrics["pictures"] - metrics["geotags"]), 0.0, ""),
        Check("as many pictures as the plan gives, one more or less a transect", abs(len(true) - expected), count, ""),
        Check("spacing of the pictures", metrics["spacing_worst_m"], limit_m, "m"),
        Check("geotags against the truth", metrics["geotag_worst_m"], limit_m + slow_m, "m"),
        Check("first picture at the entry", metrics["entry_worst_m"], 1.0 + _ENDS_M + slow_m, "m"),
        Check("last picture at the exit", metrics["exit_worst_m"], 1.0 + _ENDS_M + slow_m, "m"),
    )
    return metrics, checks


def _along(place: Point, begin: Point, end: Point) -> tuple[float, float]:
    """(way from the begin of the transect, distance from its line)."""
    length_m = math.dist(begin, end)
    north, east = (end[0] - begin[0]) / length_m, (end[1] - begin[1]) / length_m
    to_north, to_east = place[0] - begin[0], place[1] - begin[1]
    return to_north * north + to_east * east, abs(to_east * north - to_north * east)


def _places(file: Path) -> list[Point]:
    with file.open(encoding="utf-8") as rows:
        return [(float(row["north_m"]), float(row["east_m"])) for row in csv.DictReader(rows)]


def _geotags(folder: Path) -> list[Point]:
    """Their places from home, which the log's manifest has."""
    home = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))["configuration"]["home"]
    frame = LocalFrame(home["lat_deg"], home["lon_deg"])
    with (folder / "geotags.csv").open(encoding="utf-8") as rows:
        return [frame.to_ned(float(row["lat_deg"]), float(row["lon_deg"])) for row in csv.DictReader(rows)]


def prepare(conditions: Conditions, settings: Settings) -> Conditions:
    """With a camera."""
    return replace(conditions, camera=True)


SCENARIO = Scenario(
    name="pictures",
    text="a survey with a picture every 2 m, by a camera on a relay",
    vessel="revolt",
    defaults={
        "transects": "4",
        "length": "30",
        "spacing": "2",
        "limit": "0.15",
        "wind": "2",
        "current": "",
        "gnss": "rtk",
        "waves": "",
        "path": "pchip",
    },
    sail=sail,
    measure=measure,
    prepare=prepare,
    lasts_s=440.0,
)
