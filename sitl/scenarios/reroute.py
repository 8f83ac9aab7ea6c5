"""The mission is replaced under way, four times. The setpoint never jumps, and the boat sails the last mission to its
end."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.core.angles import wrap_pi
from companion.core.geodesy import LocalFrame
from sitl.scenarios import track_plot
from sitl.scenarios.boat import motor
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.measure import Check, Point, between, closest, largest_turn_rad, read_truth, rms
from sitl.scenarios.positioning import read
from sitl.scenarios.scenario import Scenario, Settings

_RADIUS_M = 3.0
_MISSION = 0x04040000
_TIMEOUT_S = 900.0
_ROUTES: tuple[tuple[float, tuple[Point, ...]], ...] = (  # time until the next one is uploaded, waypoints
    (40.0, ((60.0, 0.0), (60.0, 60.0))),
    (30.0, ((40.0, 20.0), (60.0, 30.0))),  # around an obstacle
    (2.0, ((42.0, 22.0), (60.0, 34.0))),  # the same, corrected under way
    (30.0, ((44.0, 24.0), (60.0, 38.0))),
    (0.0, ((10.0, 20.0), (0.0, 0.0))),  # back home
)
_SLOW_MPS = 0.6  # these times are for a boat of that speed
_SLACK = 1.2
# What is no jump: for boats of that speed, and for faster ones by what they sail and brake in a tick, of a plan harder
# than by their drag. In a bend that is cut, the place abeam moves faster than the boat.
_STEP_M, _SPEED_STEP_MPS = 0.3, 0.1
_PACES, _BRAKING = 2.5, 1.5
_CORRECTING = 1.4  # times its yaw rate: how fast the heading of a plan, which PATH_YAW_RATE does not bound, comes to it


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Sail each route for its time, then upload the next; wait for the end of the last."""
    config = gcs.rig.config
    frame = LocalFrame(config.home.lat_deg, config.home.lon_deg)
    gcs.ready()
    _upload(gcs, frame, _ROUTES[0][1])
    gcs.set_mode(_MISSION)
    gcs.arm()
    started_s, replaced_s = gcs.rig.now_s, []
    truth = gcs.rig.world.truth
    start = (truth.north_m, truth.east_m)
    share = min(1.0, _SLOW_MPS / gcs.parameter("WP_SPEED"))
    for (duration_s, _), (_, points) in itertools.pairwise(_ROUTES):
        gcs.sail(share * duration_s)
        _upload(gcs, frame, points)
        replaced_s.append(gcs.rig.now_s)
        start = (truth.north_m, truth.east_m)
        gcs.reached.clear()
    gcs.wait("the end of the last route", lambda: len(_ROUTES[-1][1]) - 1 in gcs.reached, _TIMEOUT_S)
    return {
        "start": start,
        "corners": _ROUTES[-1][1],
        "radius_m": _RADIUS_M,
        "started_s": started_s,
        "replaced_s": replaced_s,
        "finished_s": gcs.rig.now_s,
        "rate_dps": gcs.parameter("PATH_YAW_RATE"),
        "planned": gcs.parameter("PATH_EFFORT") > 0.0 and gcs.rig.config.limits.sway_n > 0.0,
        "speed_mps": gcs.parameter("WP_SPEED"),
        "acceleration_mps2": gcs.parameter("PATH_ACC"),
        "coasts_mps2": config.hull.drag_n(gcs.parameter("WP_SPEED")) / config.hull.m11_kg,
        "vessel": config.name,
        "length_m": config.length_m,
        "beam_m": config.beam_m,
    }


def _upload(gcs: GroundStation, frame: LocalFrame, points: Sequence[Point]) -> None:
    waypoint = mavlink.MAV_CMD_NAV_WAYPOINT
    gcs.upload([Item(waypoint, *frame.to_geodetic(*point), params=(0.0, _RADIUS_M, 0.0, math.nan)) for point in points])


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Steps of the setpoint, turns of the boat, and how near the waypoints were passed."""
    ticks = [
        row
        for row in read(folder, asked["started_s"] + 1.0, asked["finished_s"] - 1.0).ticks
        if not math.isnan(row["desired_north_m"])
    ]
    pairs = [(a, b, b["t_s"] - a["t_s"]) for a, b in itertools.pairwise(ticks)]
    steps = [
        math.hypot(b["desired_north_m"] - a["desired_north_m"], b["desired_east_m"] - a["desired_east_m"])
        for a, b, _ in pairs
    ]
    turns = [abs(wrap_pi(b["desired_yaw_rad"] - a["desired_yaw_rad"])) for a, b, _ in pairs]
    speeds = [abs(b["desired_surge_mps"] - a["desired_surge_mps"]) for a, b, _ in pairs]
    period_s = sorted(dt for _, _, dt in pairs)[len(pairs) // 2]
    track = between(read_truth(folder), asked["started_s"], asked["finished_s"])
    errors = [abs(row["cross_track_error_m"]) for row in ticks if not math.isnan(row["cross_track_error_m"])]
    rates = [
        max(
            math.radians(asked["rate_dps"]),
            _CORRECTING * max(abs(a["desired_yaw_rate_radps"]), abs(b["desired_yaw_rate_radps"])) * asked["planned"],
        )
        for a, b, _ in pairs
    ]
    turn, rate = max(zip(turns, rates, strict=True), key=lambda pair: pair[0] / pair[1])
    most_turn_deg = _SLACK * math.degrees(rate) * period_s
    most_step_m = max(_STEP_M, _PACES * asked["speed_mps"] * period_s)
    brakes_mps2 = max(_SLACK * asked["acceleration_mps2"], asked["coasts_mps2"] * asked["planned"])
    most_speed_step_mps = max(_SPEED_STEP_MPS, _BRAKING * brakes_mps2 * period_s)
    metrics = {
        "desired_step_m": max(steps),
        "desired_turn_deg": math.degrees(turn),
        "desired_speed_step_mps": max(speeds),
        "cross_track_rms_m": rms(errors),
        "worst_miss_m": max(closest(between(track, asked["replaced_s"][-1]), corner) for corner in asked["corners"]),
        "largest_turn_deg": math.degrees(largest_turn_rad(track, asked["replaced_s"])),
        "time_s": asked["finished_s"] - asked["started_s"],
    }
    return metrics, (
        Check("step of the desired position in one tick", metrics["desired_step_m"], most_step_m, "m"),
        Check("step of the desired heading in one tick", metrics["desired_turn_deg"], most_turn_deg, "deg"),
        Check("step of the desired surge in one tick", metrics["desired_speed_step_mps"], most_speed_step_mps, "m/s"),
        Check("every waypoint of the last route was passed near", metrics["worst_miss_m"], _RADIUS_M, "m"),
        Check("heading turned between two routes", metrics["largest_turn_deg"], 359.0, "deg"),
    )


SCENARIO = Scenario(
    name="reroute",
    text="the mission is replaced under way four times; the setpoint never jumps",
    vessel="revolt",
    defaults={
        "wind": "2",
        "current": "",
        "gnss": "rtk",
        "waves": "",
        "model_error": "",
        "path": "pchip",
        "law": "companion",
    },
    needs=(motor,),
    sail=sail,
    measure=measure,
    plot=track_plot.draw,
    lasts_s=220.0,
)
