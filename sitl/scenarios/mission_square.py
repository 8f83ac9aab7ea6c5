"""A ground station uploads a 20 m square and the boat sails it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.core.geodesy import LocalFrame
from sitl.scenarios.measure import Check, Point, between, closest, cross_track_errors, read_truth, rms, sampled_path
from sitl.scenarios.scenario import Scenario, Settings
from sitl.scenarios.station import Item, Station

_SIDE_M = 20.0
_CORNERS: tuple[Point, ...] = ((_SIDE_M, 0.0), (_SIDE_M, _SIDE_M), (0.0, _SIDE_M), (0.0, 0.0))
_RADIUS_M = 1.5
_MISSION = 0x04040000
_TIMEOUT_S = 600.0


def sail(station: Station, settings: Settings) -> dict[str, Any]:
    home = station.rig.config.home
    frame = LocalFrame(home.lat_deg, home.lon_deg)
    items = [
        Item(mavlink.MAV_CMD_NAV_WAYPOINT, *frame.to_geodetic(*corner), params=(0.0, _RADIUS_M, 0.0, math.nan)) for corner in _CORNERS
    ]
    station.ready()
    station.upload(items)
    station.set_mode(_MISSION)
    station.arm()
    started_s = station.rig.now_s
    truth = station.rig.world.truth
    station.wait("the last waypoint", lambda: len(items) - 1 in station.reached, _TIMEOUT_S)
    finished_s = station.rig.now_s
    station.sail(10.0)
    return {
        "start": (truth.north_m, truth.east_m),
        "started_s": started_s,
        "finished_s": finished_s,
        "reached": list(station.reached),
    }


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    track = between(read_truth(folder), asked["started_s"], asked["finished_s"])
    path = sampled_path([asked["start"], *_CORNERS], settings["path"])
    errors = cross_track_errors(track, path)
    misses = [closest(track, corner) for corner in _CORNERS]
    metrics = {
        "cross_track_rms_m": rms(errors),
        "cross_track_max_m": max(errors),
        "worst_miss_m": max(misses),
        "time_s": asked["finished_s"] - asked["started_s"],
        "waypoints_reached": float(len(set(asked["reached"]))),
    }
    checks = (
        Check("every waypoint was announced as reached", metrics["waypoints_reached"], float(len(_CORNERS)), "", at_least=True),
        Check("every waypoint was passed inside its radius", metrics["worst_miss_m"], _RADIUS_M, "m"),
        Check("cross-track error RMS", metrics["cross_track_rms_m"], 0.5, "m"),
    )
    return metrics, checks


SCENARIO = Scenario(
    name="mission_square",
    text="a 20 m square uploaded and sailed by way of MAVLink",
    vessel="revolt",
    defaults={"wind": "2", "current": "", "gnss": "rtk", "waves": "", "model_error": "", "path": "pchip"},
    sail=sail,
    measure=measure,
)
