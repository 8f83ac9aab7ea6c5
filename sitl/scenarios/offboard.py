"""Offboard: another computer sends a position, velocities, and a body velocity with a yaw rate; then nothing."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.core.frames import body_to_ned
from sitl.scenarios.boat import motor
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.measure import Check, Track, between, read_estimates, read_truth
from sitl.scenarios.scenario import Scenario, Settings, number

OFFBOARD, HOLD = 0x00060000, 0x03040000
# masks as MAVSDK's offboard plugin sends them
POSITION, VELOCITY, VELOCITY_BODY = 0x9F8, 0x9C7, 0x5C7
_POINT = (6.0, 4.0, math.radians(60.0))
_NEW_COURSE_RAD = math.radians(60.0)  # course of the second velocity
_TURN_RADPS = math.radians(2.0)
_SETTLED_S = 15.0  # measured at the end of each part
_SILENCE_S = 1.0
_USUAL_SHARE = 0.6  # of WP_SPEED


def setpoint(frame: int, mask: int, x: float, y: float, yaw_rad: float, rate_radps: float = 0.0) -> Any:
    """SET_POSITION_TARGET_LOCAL_NED. (x, y) is the position or the velocity, as the mask says."""
    return mavlink.MAVLink_set_position_target_local_ned_message(
        0, 1, 1, frame, mask, x, y, 0.0, x, y, 0.0, 0.0, 0.0, 0.0, yaw_rad, rate_radps
    )


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Stream each kind of setpoint for `time` seconds (the position for 20 more), then fall silent as long."""
    speed = number(settings, "speed") or _USUAL_SHARE * gcs.parameter("WP_SPEED")
    time_s = number(settings, "time")
    legs = {
        "position": (time_s + 20.0, setpoint(1, POSITION, *_POINT)),
        "velocity": (time_s, setpoint(1, VELOCITY, speed * 0.6, speed * 0.8, math.atan2(0.8, 0.6))),
        "new_velocity": (time_s, setpoint(1, VELOCITY, *body_to_ned(speed, 0.0, _NEW_COURSE_RAD), _NEW_COURSE_RAD)),
        "body": (time_s, setpoint(8, VELOCITY_BODY, speed, 0.0, 0.0, _TURN_RADPS)),
    }
    gcs.ready()
    gcs.arm()
    asked: dict[str, Any] = {"speed": speed, "positions": gcs.rig.config.limits.sway_n > 0.0}
    for name, (duration_s, message) in legs.items():
        _stream(gcs, message, 0.5)
        if name == "position":
            gcs.set_mode(OFFBOARD)
        _stream(gcs, message, duration_s)
        asked[name] = gcs.rig.now_s
    gcs.wait("fallback to Hold", lambda: bool(gcs.last["HEARTBEAT"].custom_mode == HOLD), 5.0)
    asked["silence_s"] = gcs.rig.now_s - asked["body"]
    gcs.sail(time_s)
    return asked


def _stream(gcs: GroundStation, message: Any, duration_s: float) -> None:
    end_s = gcs.rig.now_s + duration_s
    while gcs.rig.now_s < end_s - 1e-9:
        gcs.send(message)
        gcs.step()


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Errors of each setpoint, and the time until the boat falls back to Hold."""
    truth, known = read_truth(folder), read_estimates(folder)
    speed = asked["speed"]
    at_point = _last(known, asked["position"])
    standing = _last(truth, truth[-1]["t_s"])
    ground = [
        _over_ground(truth, asked[name], course, speed)
        for name, course in (("velocity", math.atan2(0.8, 0.6)), ("new_velocity", _NEW_COURSE_RAD))
    ]
    body = _last(truth, asked["body"])
    metrics = {
        "position_max_m": max(math.hypot(row["north_m"] - _POINT[0], row["east_m"] - _POINT[1]) for row in at_point),
        "heading_max_deg": max(
            abs(math.degrees(math.remainder(row["yaw_rad"] - _POINT[2], math.tau))) for row in at_point
        ),
        "speed_error_mps": max(part[0] for part in ground),
        "cross_track_max_m": max(part[1] for part in ground),
        "surge_error_mps": abs(_mean(body, "surge_mps") - speed),
        "turn_error_dps": abs(math.degrees(_mean(body, "yaw_rate_radps") - _TURN_RADPS)),
        "silence_s": asked["silence_s"],
        "speed_at_end_mps": max(math.hypot(row["surge_mps"], row["sway_mps"]) for row in standing),
    }
    rtk = settings["gnss"] == "rtk"
    # a receiver without corrections errs by some cm/s for many seconds; gusts by a share of the speed
    most_mps = 0.03 if rtk else 0.05 + 0.02 * speed
    checks = (
        *_standing(folder, metrics, asked["positions"], rtk),
        Check("mean velocity over ground less the setpoint", metrics["speed_error_mps"], most_mps, "m/s"),
        Check("off a straight line", metrics["cross_track_max_m"], 0.3 if rtk else 1.0, "m"),
        Check("mean speed ahead, less the setpoint", metrics["surge_error_mps"], most_mps, "m/s"),
        Check("mean rate of turn, less the setpoint", metrics["turn_error_dps"], 0.2, "deg/s"),
        Check("from the last setpoint to Hold", metrics["silence_s"], _SILENCE_S, "s"),
    )
    return metrics, checks


def _standing(folder: Path, metrics: dict[str, float], positions: bool, rtk: bool) -> Sequence[Check]:
    """Checks at rest. A boat without sideways thrust keeps inside its watch circle, at any heading."""
    if not positions:
        circle_m = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))["parameters"]["DP_WATCH_R"]
        return (Check("inside the watch circle, as the boat knows it", metrics["position_max_m"], circle_m, "m"),)
    return (
        Check("at the point, as the boat knows it", metrics["position_max_m"], 0.15 if rtk else 0.5, "m"),
        Check("heading there, as the boat knows it", metrics["heading_max_deg"], 3.0, "deg"),
        Check("at the end it stands", metrics["speed_at_end_mps"], 0.1 if rtk else 0.2, "m/s"),
    )


def _last(track: Track, end_s: float) -> Track:
    return between(track, end_s - _SETTLED_S, end_s)


def _mean(track: Track, name: str) -> float:
    return sum(row[name] for row in track) / len(track)


def _over_ground(truth: Track, end_s: float, course_rad: float, speed_mps: float) -> tuple[float, float]:
    """(error of the mean velocity, largest distance from the straight line through the mean position on the demanded
    course)."""
    rows = _last(truth, end_s)
    took_s = rows[-1]["t_s"] - rows[0]["t_s"]
    north, east = ((rows[-1][name] - rows[0][name]) / took_s for name in ("north_m", "east_m"))
    error = math.hypot(north - speed_mps * math.cos(course_rad), east - speed_mps * math.sin(course_rad))
    across = [row["east_m"] * math.cos(course_rad) - row["north_m"] * math.sin(course_rad) for row in rows]
    middle = sum(across) / len(across)
    return error, max(abs(value - middle) for value in across)


SCENARIO = Scenario(
    name="offboard",
    text="another computer steers: a point, two velocities, a body velocity with a yaw rate, then silence",
    vessel="revolt",
    defaults={
        "speed": "",
        "time": "60",
        "wind": "",
        "current": "",
        "gnss": "rtk",
        "waves": "",
        "model_error": "",
        "plant": "",
    },
    by_vessel={
        "revolt": {"speed": "0.4"},
        "aboat": {"speed": "0.8", "gnss": "sbas"},
        "rescuerunner": {"speed": "5", "gnss": "standalone"},
        "cybership2": {"speed": "0.12"},
    },
    needs=(motor,),
    sail=sail,
    measure=measure,
)
