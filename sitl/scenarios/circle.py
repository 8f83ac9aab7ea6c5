"""Orbiting a point in wind and current: how far the boat is from the circle, by the truth."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.core.geodesy import LocalFrame
from sitl.scenarios.boat import motor
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.measure import (
    Check,
    Track,
    between,
    distance_to,
    read_events,
    read_truth,
    receiver_error_m,
    rms,
)
from sitl.scenarios.scenario import Scenario, ScenarioError, Settings, number

_HOLD, _CIRCLE = 0x03040000, 0x01030000
_AWAY = 2.5  # radii from where the boat is to the centre
_SETTLE = 0.25  # turns before the measurement begins
_AFTER_S = 60.0
_SIGNS = {"cw": 1.0, "ccw": -1.0}


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Orbit a point by DO_ORBIT as QGroundControl sends it, until the last turn is done."""
    home = gcs.rig.config.home
    radius_m, turns = number(settings, "radius"), number(settings, "turns")
    if settings["direction"] not in _SIGNS:
        raise ScenarioError(f"direction={settings['direction']}: one of {', '.join(_SIGNS)}")
    centre = (_AWAY * radius_m, 0.0)
    lat_deg, lon_deg = LocalFrame(home.lat_deg, home.lon_deg).to_geodetic(*centre)
    speed_mps = number(settings, "speed") or math.nan
    gcs.ready()
    gcs.set_mode(_HOLD)
    gcs.arm()
    gcs.acks.clear()
    gcs.send(  # as QGroundControl sends it, with a number of turns
        mavlink.MAVLink_command_int_message(
            gcs.vessel, 1, mavlink.MAV_FRAME_GLOBAL, mavlink.MAV_CMD_DO_ORBIT, 0, 0,
            _SIGNS[settings["direction"]] * radius_m, speed_mps, 0.0, 2.0 * math.pi * turns,
            round(lat_deg * 1e7), round(lon_deg * 1e7), 0.0,
        )
    )  # fmt: skip
    gcs.wait("Circle", lambda: bool(gcs.last["HEARTBEAT"].custom_mode == _CIRCLE), 3.0)
    started_s = gcs.rig.now_s
    slowest_mps = 0.15 * gcs.rig.config.length_m
    timeout_s = (turns + 1.0) * 2.0 * math.pi * radius_m / slowest_mps + 200.0
    gcs.wait("the last turn", lambda: any("turns done" in text for text in gcs.texts), timeout_s)
    gcs.sail(_AFTER_S)
    return {"centre": centre, "started_s": started_s}


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Metrics and checks: distance from the circle over the last turns, turns made, and speed at the end."""
    radius_m, turns, sign = number(settings, "radius"), number(settings, "turns"), _SIGNS[settings["direction"]]
    done_s = next((said.t_s for said in read_events(folder) if said.name == "circle_done"), math.inf)
    truth = read_truth(folder)
    track = between(truth, asked["started_s"], done_s)
    errors = [distance_to(row, *asked["centre"]) - radius_m for row in track]
    swept = _swept_turns(track, asked["centre"], sign)
    steady = [error for error, at in zip(errors, swept, strict=True) if at >= swept[-1] - turns + _SETTLE]
    held = truth[-1]
    metrics = {
        "radius_rms_m": rms(steady),
        "radius_max_m": max(map(abs, steady)),
        "radius_mean_m": sum(steady) / len(steady),
        "cut_inside_m": -min(errors),
        "turns": swept[-1] - next(at for error, at in zip(errors, swept, strict=True) if error <= 0.15 * radius_m),
        "speed_mean_mps": _way_m(track) / (track[-1]["t_s"] - track[0]["t_s"]),
        "speed_at_end_mps": math.hypot(held["surge_mps"], held["sway_mps"]),
    }
    limit_m = 0.02 * radius_m + (0.15 if settings["gnss"] == "rtk" else 1.0)
    # The boat turns about where its receiver has the centre, and begins and ends by bearings from there.
    aside_turns = math.atan2(receiver_error_m(settings["gnss"]), radius_m) / (2.0 * math.pi)
    return metrics, (
        Check("off the circle, root mean square", metrics["radius_rms_m"], limit_m, "m"),
        Check("off the circle at most", metrics["radius_max_m"], 3.0 * limit_m, "m"),
        Check("turns made less those asked for", abs(metrics["turns"] - turns), 0.05 + aside_turns, ""),
        Check("inside the circle on the way in", metrics["cut_inside_m"], 3.0 * limit_m, "m"),
        Check("over ground at the end", metrics["speed_at_end_mps"], 0.4 * metrics["speed_mean_mps"], "m/s"),
    )


def _swept_turns(track: Track, centre: tuple[float, float], sign: float) -> list[float]:
    """Turns about the centre in the direction asked for, since the first row."""
    bearings = [math.atan2(row["east_m"] - centre[1], row["north_m"] - centre[0]) for row in track]
    steps = (sign * math.remainder(b - a, 2.0 * math.pi) for a, b in itertools.pairwise(bearings))
    return [angle / (2.0 * math.pi) for angle in itertools.accumulate(steps, initial=0.0)]


def _way_m(track: Track) -> float:
    return sum(distance_to(a, b["north_m"], b["east_m"]) for a, b in itertools.pairwise(track))


SCENARIO = Scenario(
    name="circle",
    text="an orbit by MAV_CMD_DO_ORBIT: distance from the circle, turns made, and Hold at the end",
    vessel="revolt",
    defaults={
        "radius": "12",
        "turns": "3",
        "direction": "cw",
        "speed": "",
        "wind": "",
        "current": "",
        "gnss": "rtk",
        "waves": "",
        "model_error": "",
        "plant": "",
    },
    by_vessel={
        "aboat": {"radius": "20", "gnss": "sbas"},
        "cybership2": {"radius": "4"},
        "rescuerunner": {"radius": "60", "gnss": "standalone"},
        "wamv16": {"radius": "25"},
    },
    needs=(motor,),
    sail=sail,
    measure=measure,
    lasts_s=480.0,
)
