"""A mission whose middle legs are sailed stern first: how well the boat keeps them, and where its bow points."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.core.geodesy import LocalFrame
from sitl.scenarios.boat import astern
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.measure import Check, Track, between, closest, read_truth, rms
from sitl.scenarios.scenario import Scenario, Settings, number

_MISSION = 0x04040000
_BOW_FIRST, _STERN_FIRST = 0.0, 1.0
_CORNER = 0.3  # share of a leg at each end, where the boat turns or stops


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Ahead to the first point, astern round two corners, and ahead again, until the mission is complete."""
    home, side_m = gcs.rig.config.home, number(settings, "side")
    frame = LocalFrame(home.lat_deg, home.lon_deg)
    points = ((side_m, 0.0), (0.0, 0.0), (0.0, side_m), (side_m, side_m), (side_m, 2.0 * side_m))

    def waypoint(point: tuple[float, float]) -> Item:
        return Item(mavlink.MAV_CMD_NAV_WAYPOINT, *frame.to_geodetic(*point), params=(0.0, 0.0, 0.0, math.nan))

    def reverse(way: float) -> Item:
        return Item(mavlink.MAV_CMD_DO_SET_REVERSE, 0.0, 0.0, params=(way, 0.0, 0.0, 0.0))

    gcs.ready()
    gcs.upload(
        [
            waypoint(points[0]),
            reverse(_STERN_FIRST),
            *(waypoint(point) for point in points[1:4]),
            reverse(_BOW_FIRST),
            waypoint(points[4]),
        ]
    )
    gcs.set_mode(_MISSION)
    gcs.arm()
    started_s = gcs.rig.now_s
    gcs.wait("stern first", lambda: "Mission: stern first" in gcs.texts, 60.0 + 4.0 * side_m)
    astern_s = gcs.rig.now_s
    gcs.wait("bow first", lambda: "Mission: bow first" in gcs.texts, 120.0 + 12.0 * side_m)
    ahead_s = gcs.rig.now_s
    gcs.wait("its end", lambda: "Mission complete" in gcs.texts, 60.0 + 6.0 * side_m)
    return {"points": points, "started_s": started_s, "astern_s": astern_s, "ahead_s": ahead_s, "texts": [*gcs.texts]}


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Off the legs and off their course, by the truth, on the middle of each leg that is sailed stern first."""
    truth, points = read_truth(folder), asked["points"]
    track = between(truth, asked["astern_s"], asked["ahead_s"])
    legs = list(itertools.pairwise(points[:4]))
    rows = [(row, leg) for leg in legs for row in _on(track, leg)]
    off = [_off_m(row, leg) for row, leg in rows]
    course = [_astern_rad(row, leg) for row, leg in rows]
    last = _on(between(truth, asked["ahead_s"]), (points[3], points[4]))
    metrics = {
        "cross_track_rms_m": rms(off),
        "cross_track_max_m": max(map(abs, off)),
        "stern_off_course_rms_deg": math.degrees(rms(course)),
        "stern_off_course_max_deg": math.degrees(max(map(abs, course))),
        "speed_astern_mps": -sum(row["surge_mps"] for row, _ in rows) / len(rows),
        "speed_ahead_mps": sum(row["surge_mps"] for row in last) / max(1, len(last)),
        "miss_max_m": max(closest(track, point) for point in points[1:4]),
        "time_s": truth[-1]["t_s"] - asked["started_s"],
        "distrusted": float(sum("not used" in text for text in asked["texts"])),
    }
    limit_m = 0.5 if settings["gnss"] == "rtk" else 2.0
    limit_deg = 60.0 if settings["wind"] or settings["current"] else 20.0  # the crab angle is one of them
    return metrics, (
        Check("off the legs astern, root mean square", metrics["cross_track_rms_m"], limit_m, "m"),
        Check("stern off the course, root mean square", metrics["stern_off_course_rms_deg"], limit_deg, "deg"),
        Check("speed astern", metrics["speed_astern_mps"], 0.1, "m/s", at_least=True),
        Check("speed ahead after it", metrics["speed_ahead_mps"], 0.1, "m/s", at_least=True),
        Check("missed waypoints astern by at most", metrics["miss_max_m"], 2.0 + limit_m, "m"),
        Check("senses that were not believed", metrics["distrusted"], 0.0, ""),
    )


_Leg = tuple[tuple[float, float], tuple[float, float]]


def _along(row: dict[str, float], leg: _Leg) -> tuple[float, float]:
    """(share of the way along the leg, distance to starboard of it in m)."""
    (north, east), (to_north, to_east) = leg
    length_m = math.dist(*leg)
    dn, de = (to_north - north) / length_m, (to_east - east) / length_m
    rn, re = row["north_m"] - north, row["east_m"] - east
    return (rn * dn + re * de) / length_m, re * dn - rn * de


def _on(track: Track, leg: _Leg) -> list[dict[str, float]]:
    """The rows on the middle of a leg."""
    near_m = 0.3 * math.dist(*leg)
    found = ((row, _along(row, leg)) for row in track)
    return [row for row, (share, off_m) in found if _CORNER < share < 1.0 - _CORNER and abs(off_m) < near_m]


def _off_m(row: dict[str, float], leg: _Leg) -> float:
    return _along(row, leg)[1]


def _astern_rad(row: dict[str, float], leg: _Leg) -> float:
    """How far the stern points off the leg's course."""
    (north, east), (to_north, to_east) = leg
    course_rad = math.atan2(to_east - east, to_north - north)
    return math.remainder(row["yaw_rad"] + math.pi - course_rad, 2.0 * math.pi)


SCENARIO = Scenario(
    name="stern_first",
    text="a mission with legs sailed stern first (DO_SET_REVERSE): cross-track error, heading, speed astern",
    vessel="aboat",
    defaults={"side": "30", "wind": "", "current": "", "gnss": "rtk", "waves": "", "model_error": "", "plant": ""},
    by_vessel={"cybership2": {"side": "10"}, "wamv16": {"side": "50"}},
    needs=(astern,),
    sail=sail,
    measure=measure,
    lasts_s=300.0,
)
