"""The ground station falls silent while the boat is out on its mission: it returns by RTL, inside its fence, and holds
at home."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.config.top_speed import top_speed_mps
from companion.core.geodesy import LocalFrame
from sitl.scenarios.boat import holds_by_drifting
from sitl.scenarios.follow_measure import modes
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.measure import Check, between, distance_to, read_truth
from sitl.scenarios.obstacles import hull_of
from sitl.scenarios.scenario import Scenario, Settings, number

_MISSION = 0x04040000
_ROOM_M = 12.0  # of the fence beside the route
_CHECKED_SHARE = 0.3  # of the top speed: mean on the way home
_BESIDE_S, _AT_HOME_S = 60.0, 30.0
_RTL_S = 1.0  # at least
_SPARE_M = 5.0  # of the fence beside what plans keep from it
_FENCE_LENGTHS = 4.0  # least room of the fence, in lengths of the boat


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """A leg to the north of `out` metres, of which half is sailed with a ground station."""
    out_m = number(settings, "out")
    config = gcs.rig.config
    home = LocalFrame(config.home.lat_deg, config.home.lon_deg)
    gcs.ready()
    kept_m = 0.5 * config.length_m + gcs.parameter("FENCE_MARGIN")
    room_m = max(_ROOM_M, _FENCE_LENGTHS * config.length_m, kept_m + _SPARE_M)
    sides = ((out_m + room_m, -room_m), (out_m + room_m, room_m), (-room_m, room_m), (-room_m, -room_m))
    vertex, frame = mavlink.MAV_CMD_NAV_FENCE_POLYGON_VERTEX_INCLUSION, mavlink.MAV_FRAME_GLOBAL
    fence = [Item(vertex, *home.to_geodetic(*side), params=(4.0, 0.0, 0.0, 0.0), frame=frame) for side in sides]
    gcs.upload(fence, mavlink.MAV_MISSION_TYPE_FENCE)
    gcs.set_parameter("NAV_DLL_ACT", 2.0)  # RTL
    gcs.upload([Item(mavlink.MAV_CMD_NAV_WAYPOINT, *home.to_geodetic(out_m, 0.0))])
    gcs.set_mode(_MISSION)
    gcs.arm()
    slow_mps = _CHECKED_SHARE * top_speed_mps(config)
    gcs.wait("half the way", lambda: gcs.rig.world.truth.north_m > 0.5 * out_m, _BESIDE_S + out_m / slow_mps)
    gcs.heartbeats = False
    silent_s = gcs.rig.now_s
    gcs.sail(_BESIDE_S + _AT_HOME_S + out_m / slow_mps)
    near_m = 2.0 * config.length_m
    if holds_by_drifting(config):
        near_m = max(near_m, gcs.parameter("DP_WATCH_R"))
    return {
        "silent_s": silent_s,
        "to_s": gcs.rig.now_s,
        "near_m": near_m,
        "fence_m": (out_m + room_m, room_m),
        "hull_m": (config.length_m, config.beam_m),
    }


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Where it is in the last half minute, when it was there first, and how near its hull came to the fence."""
    track = between(read_truth(folder), asked["silent_s"])
    near_m = asked["near_m"]
    last = between(track, asked["to_s"] - _AT_HOME_S)
    there_s = next((row["t_s"] for row in track if distance_to(row, 0.0, 0.0) <= near_m), math.inf)
    metrics = {
        "home_in_s": there_s - asked["silent_s"],
        "farthest_at_end_m": max(distance_to(row, 0.0, 0.0) for row in last),
        "inside_fence_m": min(_inside_m(row, asked) for row in track),
        "rtl_s": sum(mode == "RTL" for t_s, mode in modes(folder) if t_s >= asked["silent_s"])
        * (asked["to_s"] - asked["silent_s"])
        / len(track),
    }
    return metrics, (
        Check("from home in the last half minute", metrics["farthest_at_end_m"], near_m, "m"),
        Check("the hull stays inside the fence", metrics["inside_fence_m"], 0.0, "m", at_least=True),
        Check("time in RTL", metrics["rtl_s"], _RTL_S, "s", at_least=True),
    )


def _inside_m(row: dict[str, float], asked: dict[str, Any]) -> float:
    """How far inside the fence the hull is."""
    north_m, aside_m = map(float, asked["fence_m"])
    return min(
        min(north_m - north, north + aside_m, aside_m - abs(east)) for north, east in hull_of(row, *asked["hull_m"])
    )


SCENARIO = Scenario(
    name="homecoming",
    text="the ground station falls silent on the way out: RTL, inside the fence, and Hold at home",
    vessel="revolt",
    defaults={"out": "60", "wind": "3", "current": "", "gnss": "rtk", "waves": "", "model_error": "", "plant": ""},
    by_vessel={"rescuerunner": {"out": "300", "gnss": "standalone"}},
    sail=sail,
    measure=measure,
    lasts_s=320.0,
)
"""The failsafe is NAV_DLL_ACT, which is set to RTL: its usual action differs from boat to boat."""
