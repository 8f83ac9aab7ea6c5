"""A 100 m square in a current: sailed, or said that it cannot be; never circled and never stuck in silence."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.core.geodesy import LocalFrame
from sitl.scenarios import track_plot
from sitl.scenarios.measure import (
    Check,
    Point,
    Said,
    along_path,
    between,
    closest,
    largest_turn_rad,
    longest_standstill_s,
    read_events,
    read_truth,
    rms,
    sampled_path,
    square,
)
from sitl.scenarios.scenario import Scenario, Settings, number
from sitl.scenarios.station import Item, Station

_RADIUS_M = 5.0
_MISSION = 0x04040000
_TIMEOUT_S = 4000.0
_AFTER_S = 30.0
_NO_WAY = "no_way"  # name of the event by which the boat says that it is stuck
_SAY_WITHIN_S = 60.0
_STEP_M = 0.8  # less than that in the time above is no way made
_BEFORE_S = 30.0
_SLOW_M = 1.0


def sail(station: Station, settings: Settings) -> dict[str, Any]:
    home = station.rig.config.home
    frame = LocalFrame(home.lat_deg, home.lon_deg)
    corners = square(number(settings, "side"))
    items = [Item(mavlink.MAV_CMD_NAV_WAYPOINT, *frame.to_geodetic(*corner), params=(0.0, _RADIUS_M, 0.0, math.nan)) for corner in corners]
    station.ready()
    station.upload(items)
    station.set_mode(_MISSION)
    station.arm()
    started_s = station.rig.now_s
    truth = station.rig.world.truth
    start = (truth.north_m, truth.east_m)

    def ended() -> bool:
        return len(items) - 1 in station.reached or any("no way made" in text for text in station.texts)

    station.wait("the last waypoint, or that it cannot be reached", ended, _TIMEOUT_S)
    finished_s = station.rig.now_s
    station.sail(_AFTER_S)
    return {
        "start": start,
        "corners": corners,
        "radius_m": _RADIUS_M,
        "started_s": started_s,
        "finished_s": finished_s,
        "vessel": station.rig.config.name,
        "length_m": station.rig.config.length_m,
        "beam_m": station.rig.config.beam_m,
    }


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    track = between(read_truth(folder), asked["started_s"], asked["finished_s"])
    corners: Sequence[Point] = asked["corners"]
    events = [said for said in read_events(folder) if asked["started_s"] <= said.t_s <= asked["finished_s"] + 1.0]
    passed_s = [said.t_s for said in events if said.name == "item_reached"]
    declared = next((said for said in events if said.name == _NO_WAY), None)
    path = sampled_path([asked["start"], *corners], settings["path"])
    stations = along_path(track, path)
    errors = [distance for _, distance in stations]
    reached = len(passed_s)
    metrics = {
        "waypoints_reached": float(reached),
        "declared_unable": float(declared is not None),
        "cross_track_rms_m": rms(errors),
        "cross_track_p95_m": sorted(errors)[int(0.95 * len(errors))],
        "cross_track_max_m": max(errors),
        "worst_miss_m": max((closest(track, corner) for corner in corners[:reached]), default=0.0),
        "largest_turn_deg": math.degrees(largest_turn_rad(track, passed_s)),
        "longest_standstill_s": longest_standstill_s([row["t_s"] for row in track], [s for s, _ in stations], _STEP_M),
        "time_s": asked["finished_s"] - asked["started_s"],
    }
    made_m = _made_before(declared, asked["started_s"], track, [s for s, _ in stations])
    return metrics, (
        Check("all waypoints reached, or said that they cannot be", reached + len(corners) * metrics["declared_unable"], len(corners), "", True),
        Check("every waypoint was passed near", metrics["worst_miss_m"], _RADIUS_M, "m"),
        Check("heading turned between two waypoints", metrics["largest_turn_deg"], 359.0, "deg"),
        Check("longest time without way and without a word", metrics["longest_standstill_s"], _SAY_WITHIN_S, "s"),
        Check(f"way made in the {_BEFORE_S:.0f} s before it was said that none is made", made_m, _SLOW_M, "m"),
    )


def _made_before(declared: Said | None, started_s: float, track: Sequence[dict[str, float]], along_m: Sequence[float]) -> float:
    if declared is None:
        return 0.0
    before_s = max(started_s, declared.t_s - _BEFORE_S)
    then = [s for row, s in zip(track, along_m, strict=True) if row["t_s"] <= before_s]
    return max(along_m) - max(then, default=0.0)


SCENARIO = Scenario(
    name="cross_current",
    text="a square in a current: sailed or declared impossible, never circled, never stuck in silence",
    vessel="revolt",
    defaults={"side": "100", "wind": "", "current": "0.4@90", "gnss": "rtk", "waves": "", "model_error": "", "path": "pchip", "law": "companion"},
    sail=sail,
    measure=measure,
    plot=track_plot.track,
)
