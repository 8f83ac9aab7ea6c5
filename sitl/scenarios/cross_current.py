"""A 100 m square in a current: the boat sails it or announces that it cannot. It never circles and never stands in
silence."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.core.geodesy import LocalFrame
from sitl.scenarios import track_plot
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.measure import (
    Check,
    EventRow,
    Point,
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

_RADIUS_M = 5.0
_MISSION = 0x04040000
_TIMEOUT_S = 4000.0
_AFTER_S = 30.0
_NO_HEADWAY = "no_headway"  # event that announces it
_SAY_WITHIN_S = 60.0
_STEP_M = 0.8  # less way than this in _SAY_WITHIN_S is a standstill
_BEFORE_S = 30.0
_SLOW_M = 1.0


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Sail the square until its end, or until the boat announces that it makes no headway."""
    home = gcs.rig.config.home
    frame = LocalFrame(home.lat_deg, home.lon_deg)
    corners = square(number(settings, "side"))
    items = [
        Item(mavlink.MAV_CMD_NAV_WAYPOINT, *frame.to_geodetic(*corner), params=(0.0, _RADIUS_M, 0.0, math.nan))
        for corner in corners
    ]
    gcs.ready()
    gcs.upload(items)
    gcs.set_mode(_MISSION)
    gcs.arm()
    started_s = gcs.rig.now_s
    truth = gcs.rig.world.truth
    start = (truth.north_m, truth.east_m)

    def ended() -> bool:
        return len(items) - 1 in gcs.reached or any("no headway" in text for text in gcs.texts)

    gcs.wait("the last waypoint, or that it cannot be reached", ended, _TIMEOUT_S)
    finished_s = gcs.rig.now_s
    gcs.sail(_AFTER_S)
    return {
        "start": start,
        "corners": corners,
        "radius_m": _RADIUS_M,
        "started_s": started_s,
        "finished_s": finished_s,
        "vessel": gcs.rig.config.name,
        "length_m": gcs.rig.config.length_m,
        "beam_m": gcs.rig.config.beam_m,
    }


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Cross-track errors, turns, standstills, and whether an announcement was right."""
    track = between(read_truth(folder), asked["started_s"], asked["finished_s"])
    corners: Sequence[Point] = asked["corners"]
    events = [event for event in read_events(folder) if asked["started_s"] <= event.t_s <= asked["finished_s"] + 1.0]
    passed_s = [event.t_s for event in events if event.name == "item_reached"]
    declared = next((event for event in events if event.name == _NO_HEADWAY), None)
    path = sampled_path([asked["start"], *corners], settings["path"])
    along = along_path(track, path)
    errors = [distance for _, distance in along]
    reached = len(passed_s)
    metrics = {
        "waypoints_reached": float(reached),
        "declared_unable": float(declared is not None),
        "cross_track_rms_m": rms(errors),
        "cross_track_p95_m": sorted(errors)[int(0.95 * len(errors))],
        "cross_track_max_m": max(errors),
        "worst_miss_m": max((closest(track, corner) for corner in corners[:reached]), default=0.0),
        "largest_turn_deg": math.degrees(largest_turn_rad(track, passed_s)),
        "longest_standstill_s": longest_standstill_s([row["t_s"] for row in track], [s for s, _ in along], _STEP_M),
        "time_s": asked["finished_s"] - asked["started_s"],
    }
    made_m = _made_before(declared, asked["started_s"], track, [s for s, _ in along])
    return metrics, (
        Check(
            "all waypoints reached, or announced that they cannot be",
            reached + len(corners) * metrics["declared_unable"],
            len(corners),
            "",
            True,
        ),
        Check("every waypoint was passed near", metrics["worst_miss_m"], _RADIUS_M, "m"),
        Check("heading turned between two waypoints", metrics["largest_turn_deg"], 359.0, "deg"),
        Check(
            "longest time without way and without an announcement", metrics["longest_standstill_s"], _SAY_WITHIN_S, "s"
        ),
        Check(f"way made in the {_BEFORE_S:.0f} s before the announcement that none is made", made_m, _SLOW_M, "m"),
    )


def _made_before(
    declared: EventRow | None, started_s: float, track: Sequence[dict[str, float]], along_m: Sequence[float]
) -> float:
    """Way made along the path in the time before the announcement, in metres; 0 without one."""
    if declared is None:
        return 0.0
    before_s = max(started_s, declared.t_s - _BEFORE_S)
    then = [s for row, s in zip(track, along_m, strict=True) if row["t_s"] <= before_s]
    return max(along_m) - max(then, default=0.0)


SCENARIO = Scenario(
    name="cross_current",
    text="a square in a current: sailed, or announced as impossible; no circles, no silent standstill",
    vessel="revolt",
    defaults={
        "side": "100",
        "wind": "",
        "current": "0.4@90",
        "gnss": "rtk",
        "waves": "",
        "model_error": "",
        "path": "pchip",
        "law": "companion",
    },
    sail=sail,
    measure=measure,
    plot=track_plot.draw,
    lasts_s=730.0,
)
