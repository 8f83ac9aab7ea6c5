"""A boat under sail: a triangle whose first leg is dead against the wind, then Hold at its last point."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.config.vessel import VesselConfig
from companion.core.geodesy import LocalFrame
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.measure import Check, Point, between, closest, distance_to, read_truth
from sitl.scenarios.rig import Conditions
from sitl.scenarios.scenario import Scenario, ScenarioError, Settings, number

_MISSION = 0x04040000
_TIMEOUT_S = 2400.0
_RADIUS_M = 4.0
_SETTLE_S = 30.0  # until the boat sails about its hold point
_TACK_RAD = math.radians(10.0)  # off the wind on the other side: the boat has gone about


def under_sail(config: VesselConfig) -> str | None:
    """It must have a sail."""
    if config.has_sail:
        return None
    return "it needs a sail, and this boat has none"


def prepare(conditions: Conditions, settings: Settings) -> Conditions:
    """Unchanged. Raises ScenarioError where Hold would end before it is judged."""
    if number(settings, "hold") <= _SETTLE_S:
        raise ScenarioError(f"hold={settings['hold']}: must be above {_SETTLE_S:g}, the time before Hold is judged")
    return conditions


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Upload the triangle, and a fence either side of its first leg where `fence` is set; arm in Mission, wait for the
    last waypoint, and hold for `hold` seconds."""
    home = gcs.rig.config.home
    frame = LocalFrame(home.lat_deg, home.lon_deg)
    from_rad, leg_m = gcs.rig.world.wind.mean_from_rad, number(settings, "leg")
    corners = [_placed(point, from_rad) for point in ((leg_m, 0.0), (0.5 * leg_m, 0.8 * leg_m), (0.0, 0.0))]
    gcs.ready()
    fence = _fence(number(settings, "fence"), leg_m, from_rad) if settings["fence"] else []
    if fence:
        vertex = mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION
        items = [Item(vertex, *frame.to_geodetic(*point), params=(float(len(fence)), 0, 0, 0)) for point in fence]
        gcs.upload(items, mavlink.MAV_MISSION_TYPE_FENCE)
    gcs.upload(
        [
            Item(mavlink.MAV_CMD_NAV_WAYPOINT, *frame.to_geodetic(*corner), params=(0.0, _RADIUS_M, 0.0, math.nan))
            for corner in corners
        ]
    )
    gcs.set_mode(_MISSION)
    gcs.arm()
    times_s = [gcs.rig.now_s]
    for i in range(len(corners)):
        gcs.wait(f"waypoint {i + 1}", lambda i=i: i in gcs.reached, _TIMEOUT_S)  # type: ignore[misc]
        times_s.append(gcs.rig.now_s)
    gcs.sail(number(settings, "hold"))
    return {"corners": corners, "times_s": times_s, "from_rad": from_rad, "leg_m": leg_m}


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Times, tacks and speed made good against the wind; how near each waypoint was passed, and the distance from the
    hold point."""
    track, times_s = read_truth(folder), asked["times_s"]
    beat = between(track, times_s[0], times_s[1])
    held = between(track, times_s[-1] + _SETTLE_S)
    point = _hold_point(folder, times_s[-1] + _SETTLE_S)
    off_m = sorted(distance_to(row, *point) for row in held)
    parameters = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))["parameters"]
    metrics = {
        "time_s": times_s[-1] - times_s[0],
        "beat_s": times_s[1] - times_s[0],
        "made_good_mps": asked["leg_m"] / (times_s[1] - times_s[0]),
        "tacks": float(_tacks([row["yaw_rad"] - row["wind_from_rad"] for row in beat])),
        "worst_miss_m": max(
            closest(between(track, *span), corner)
            for span, corner in zip(pairwise(times_s), asked["corners"], strict=True)
        ),
        "speed_max_mps": max(row["surge_mps"] for row in track),
        "hold_off_median_m": off_m[len(off_m) // 2] if off_m else 0.0,
        "hold_off_95_m": off_m[int(0.95 * len(off_m))] if off_m else 0.0,
        "hold_off_max_m": off_m[-1] if off_m else 0.0,
    }
    checks = [
        Check("every waypoint was passed as near as it must be", metrics["worst_miss_m"], 1.5 * _RADIUS_M, "m"),
        Check("the boat beat against the wind: tacks", metrics["tacks"], 2.0, "", at_least=True),
        Check("inside the watch circle 95 % of the time", metrics["hold_off_95_m"], parameters["DP_WATCH_R"], "m"),
        Check("inside the alarm circle", metrics["hold_off_max_m"], parameters["DP_ALARM_R"], "m"),
    ]
    if settings["fence"]:
        metrics["fence_margin_m"] = min(number(settings, "fence") + _aside_m(row, asked["from_rad"]) for row in beat)
        checks.append(Check("inside the fence on the beat", metrics["fence_margin_m"], 0.0, "m", at_least=True))
    return metrics, checks


def _placed(point: Point, from_rad: float) -> Point:
    """A point by its distances against the wind and to the right of it, as north and east."""
    up_m, right_m = point
    c, s = math.cos(from_rad), math.sin(from_rad)
    return up_m * c - right_m * s, up_m * s + right_m * c


def _aside_m(row: dict[str, float], from_rad: float) -> float:
    """Distance to the right of the line against the wind through home."""
    return row["east_m"] * math.cos(from_rad) - row["north_m"] * math.sin(from_rad)


def _fence(aside_m: float, leg_m: float, from_rad: float) -> list[Point]:
    """A fence `aside_m` to the left of the first leg and wide open to its right."""
    low_m, high_m = -0.5 * leg_m, 1.5 * leg_m
    corners = ((low_m, -aside_m), (high_m, -aside_m), (high_m, high_m), (low_m, high_m))
    return [_placed(point, from_rad) for point in corners]


def _tacks(offs_rad: Sequence[float]) -> int:
    """How often the bow changes the side of the wind."""
    sides = [math.copysign(1.0, off) for raw in offs_rad if abs(off := math.remainder(raw, math.tau)) > _TACK_RAD]
    return sum(a != b for a, b in pairwise(sides))


def _hold_point(folder: Path, after_s: float) -> Point:
    """The hold point of the companion, from its log."""
    with (folder / "ticks.csv").open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            if float(row["t_s"]) > after_s and row["desired_north_m"]:
                return float(row["desired_north_m"]), float(row["desired_east_m"])
    return 0.0, 0.0


SCENARIO = Scenario(
    name="sail_triangle",
    text="a triangle under sail, its first leg dead against the wind, then Hold",
    vessel="sailbot",
    defaults={
        "leg": "100",
        "hold": "300",
        "fence": "",
        "wind": "5",
        "current": "",
        "gnss": "rtk",
        "waves": "",
        "model_error": "",
        "plant": "",
    },
    sail=sail,
    measure=measure,
    prepare=prepare,
    needs=(under_sail,),
    lasts_s=620.0,
)
