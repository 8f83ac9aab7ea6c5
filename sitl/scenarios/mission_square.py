"""A ground station uploads a square and the boat sails it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.core.geodesy import LocalFrame
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.measure import Check, between, closest, cross_track_errors, read_truth, rms, sampled_path, square
from sitl.scenarios.scenario import Scenario, Settings, number

_RADIUS_SHARE = 0.075  # share of the side
_SIDE_M, _LIMIT_M = 20.0, 0.5
_MISSION = 0x04040000
_TIMEOUT_S = 600.0


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Upload the square, arm in Mission and wait for its last waypoint. Its usual side is so long that its waypoints
    have the radius that the boat's own file gives them."""
    home = gcs.rig.config.home
    frame = LocalFrame(home.lat_deg, home.lon_deg)
    usual_m = max(_SIDE_M, gcs.parameter("NAV_ACC_RAD") / _RADIUS_SHARE)
    side_m = number(settings, "side") if settings.get("side") else usual_m
    radius_m = number(settings, "radius") if settings.get("radius") else _RADIUS_SHARE * side_m
    items = [
        Item(mavlink.MAV_CMD_NAV_WAYPOINT, *frame.to_geodetic(*corner), params=(0.0, radius_m, 0.0, math.nan))
        for corner in square(side_m)
    ]
    gcs.ready()
    gcs.upload(items)
    gcs.set_mode(_MISSION)
    gcs.arm()
    started_s = gcs.rig.now_s
    truth = gcs.rig.world.truth
    gcs.wait("the last waypoint", lambda: len(items) - 1 in gcs.reached, _TIMEOUT_S)
    finished_s = gcs.rig.now_s
    gcs.sail(10.0)
    by_side_m = _LIMIT_M if settings.get("side") else _LIMIT_M * side_m / _SIDE_M
    return {
        "side_m": side_m,
        "radius_m": radius_m or _RADIUS_SHARE * side_m,
        "limit_m": number(settings, "limit") if settings.get("limit") else by_side_m,
        "start": (truth.north_m, truth.east_m),
        "started_s": started_s,
        "finished_s": finished_s,
        "reached": list(gcs.reached),
        "config": gcs.rig.config,
        "beats_m": gcs.parameter("SAIL_XTRACK") if gcs.rig.config.has_sail else 0.0,
    }


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Cross-track errors against scipy's curve, and how near each waypoint was passed."""
    from sitl.evaluate.figures import route_metrics  # which imports the scenarios

    track = between(read_truth(folder), asked["started_s"], asked["finished_s"])
    corners = square(asked["side_m"])
    waypoints = [asked["start"], *corners]
    path = sampled_path(waypoints, settings["path"])
    errors = cross_track_errors(track, path)
    misses = [closest(track, corner) for corner in corners]
    metrics = {
        "cross_track_rms_m": rms(errors),
        "cross_track_max_m": max(errors),
        "worst_miss_m": max(misses),
        "time_s": asked["finished_s"] - asked["started_s"],
        "waypoints_reached": float(len(set(asked["reached"]))),
        "speed_max_mps": max(math.hypot(row["surge_mps"], row["sway_mps"]) for row in track),
        **(route_metrics(track, asked["config"], waypoints) if settings["path"] == "linear" else {}),
    }
    limit_m = max(asked["limit_m"], asked["beats_m"])  # a sail beats within its corridor
    checks = (
        Check(
            "every waypoint was announced as reached",
            metrics["waypoints_reached"],
            float(len(corners)),
            "",
            at_least=True,
        ),
        Check("every waypoint was passed inside its radius", metrics["worst_miss_m"], asked["radius_m"], "m"),
        Check("cross-track error RMS", metrics["cross_track_rms_m"], limit_m, "m"),
    )
    return metrics, checks


SCENARIO = Scenario(
    name="mission_square",
    text="a square uploaded and sailed over MAVLink",
    vessel="revolt",
    defaults={
        "side": "",
        "radius": "",
        "limit": "",
        "wind": "2",
        "current": "",
        "gnss": "rtk",
        "waves": "",
        "model_error": "",
        "plant": "",
        "path": "pchip",
    },
    by_vessel={
        "rescuerunner": {"side": "150", "limit": "2.5", "gnss": "standalone", "wind": "5"},
        **{name: {"side": "20"} for name in ("blueboat", "heron", "sailbot", "wamv16")},
    },
    sail=sail,
    measure=measure,
    lasts_s=170.0,
)
