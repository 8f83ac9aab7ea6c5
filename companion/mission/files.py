"""Plan files by suffix: those of ground stations (`.plan`, `.waypoints`) and routes of chart programs (`.gpx`, `.xml`,
…).

These functions convert text to data and back; the caller opens the files. A new format is one file with `read` and
`write`, and one row here.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import PurePath
from typing import NamedTuple

from companion.mission import gpx, openseamap, qgc_plan, waypoints
from companion.mission.plan_file import PlanFile, PlanFileError

__all__ = ["FORMATS", "LONGEST_TEXT", "Format", "PlanFile", "PlanFileError", "read", "write"]

LONGEST_TEXT = 16_000_000
"""Characters. The longest mission that a vessel accepts needs a quarter of this."""


class Format(NamedTuple):
    """A file format: its name for people, `read(name, text)` and `write(name, plan)`; both raise PlanFileError."""

    text: str
    read: Callable[[str, str], PlanFile]
    write: Callable[[str, PlanFile], str]


FORMATS: dict[str, Format] = {
    ".plan": Format("QGroundControl plan", qgc_plan.read, qgc_plan.write),
    ".waypoints": Format("QGC WPL 110", waypoints.read, waypoints.write),
    ".gpx": Format("GPX route", gpx.read, gpx.write),
    ".xml": Format("OpenSeaMap trip planner, GML", openseamap.read_markup, openseamap.write_gml),
    ".gml": Format("OpenSeaMap trip planner, GML", openseamap.read_markup, openseamap.write_gml),
    ".kml": Format("OpenSeaMap trip planner, KML", openseamap.read_markup, openseamap.write_kml),
    ".json": Format("route as JSON", openseamap.read_json_route, openseamap.write_json),
}


def read(name: str, text: str) -> PlanFile:
    """The plan in `text`, in the format of the suffix of `name`. Raises PlanFileError with all problems."""
    if len(text) > LONGEST_TEXT:
        raise PlanFileError([f"{name}: {len(text)} characters; a plan file has at most {LONGEST_TEXT}"])
    return _format(name).read(name, text)


def write(name: str, plan: PlanFile) -> str:
    """The text of `plan` in the format of the suffix of `name`. Raises PlanFileError for what the format cannot
    hold."""
    return _format(name).write(name, plan)


def _format(name: str) -> Format:
    suffix = PurePath(name).suffix.lower()
    if suffix not in FORMATS:
        raise PlanFileError([f"{name}: unknown kind of plan file; use one of {', '.join(FORMATS)}"])
    return FORMATS[suffix]
