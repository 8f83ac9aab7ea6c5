"""Hold from the fastest way through the water: the boat brakes as soon as it can, and holds about where it stops."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.config.vessel import VesselConfig
from companion.core.geodesy import LocalFrame
from sitl.scenarios.boat import all_astern_n, comes_back, fast_mps, leeway_mps, motor, way_to_rest_m
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.measure import Check, between, read_truth
from sitl.scenarios.scenario import Scenario, ScenarioError, Settings, number

_MISSION, _HOLD = 0x04040000, 0x03040000
_ALL_MPS = 25.0  # more than any boat does: the mission sails at its limit
_LEG_M = 5000.0
_SILENCE_S = 15.0
_REST_MPS = 0.3  # along the hull, over ground
_REACTION_S = 3.0  # to decide, and to reverse the thrust
_BRAKING_SHARE = 0.4  # of the thrust astern over the mass: the rest is wind, current and what propellers lose
_COASTING_SHARE = 4.0  # of the time for the same way at the speed before


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Sail north for `run` seconds, then Hold for `time` seconds more than the stop may take: asked for, or by the
    failsafe of a silent ground station."""
    by = settings["by"]
    if by not in ("hold", "silence"):
        raise ScenarioError(f"by={by}: one of hold, silence")
    home = LocalFrame(gcs.rig.config.home.lat_deg, gcs.rig.config.home.lon_deg)
    gcs.ready()
    gcs.set_parameter("NAV_DLL_ACT", 1.0)  # Hold
    gcs.upload([Item(mavlink.MAV_CMD_NAV_WAYPOINT, *home.to_geodetic(_LEG_M, 0.0))])
    gcs.set_mode(_MISSION)
    gcs.command(mavlink.MAV_CMD_DO_CHANGE_SPEED, 1.0, _ALL_MPS, -1.0)
    gcs.arm()
    gcs.sail(number(settings, "run"))
    if by == "hold":
        gcs.set_mode(_HOLD)
    else:
        gcs.heartbeats = False
        gcs.wait("Hold by failsafe", lambda: gcs.last["HEARTBEAT"].custom_mode == _HOLD, _SILENCE_S)
    from_s, speed_mps = gcs.rig.now_s, gcs.rig.world.truth.surge_mps
    way_m, time_s = _stop(gcs.rig.config, speed_mps)
    gcs.sail(time_s + number(settings, "time"))
    fast = fast_mps(gcs.rig.config, number(settings, "fast"))
    return {
        "from_s": from_s,
        "speed_mps": speed_mps,
        "way_m": way_m,
        "time_s": time_s,
        "fast_mps": fast,
        "config": gcs.rig.config,
    }


def _stop(config: VesselConfig, speed_mps: float) -> tuple[float, float]:
    """The longest way and time that the boat may take to rest: by a share of its thrust astern, or by coasting where it
    has none."""
    astern_n = all_astern_n(config)
    if astern_n <= 0.0:
        way_m = _REACTION_S * speed_mps + way_to_rest_m(config.hull, speed_mps, 0.0)
        return way_m, _COASTING_SHARE * way_m / max(_REST_MPS, speed_mps)
    braking_mps2 = _BRAKING_SHARE * astern_n / config.hull.m11_kg
    return _REACTION_S * speed_mps + speed_mps**2 / (2.0 * braking_mps2), _REACTION_S + speed_mps / braking_mps2


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Speed through the water before, way and time to rest, and how far the boat goes from there."""
    track = between(read_truth(folder), asked["from_s"])
    parameters = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))["parameters"]
    start = track[0]
    rest = next((row for row in track if _rests(row, asked["config"])), track[-1])
    after = between(track, rest["t_s"])
    metrics = {
        "speed_mps": asked["speed_mps"] - _stream_mps(start),
        "way_m": math.dist(_place(start), _place(rest)),
        "time_s": rest["t_s"] - start["t_s"],
        "moves_on_m": max(math.dist(_place(row), _place(rest)) for row in after),
    }
    checks = (
        Check("speed through the water before", metrics["speed_mps"], asked["fast_mps"], "m/s", at_least=True),
        Check("way to rest", metrics["way_m"], asked["way_m"], "m"),
        Check("time to rest", metrics["time_s"], asked["time_s"], "s"),
        Check("from the place of rest afterwards", metrics["moves_on_m"], parameters["DP_ALARM_R"], "m"),
    )
    return metrics, checks


def _rests(row: Mapping[str, float], config: VesselConfig) -> bool:
    """Whether the boat has no way of its own along its hull. Nothing but a turn stops one without way astern in a wind
    and a current that drive it ahead."""
    driven_mps = 0.0
    if comes_back(config):
        wind_ahead_mps = -row["wind_speed_mps"] * math.cos(row["wind_from_rad"] - row["yaw_rad"])
        driven_mps = leeway_mps(config, wind_ahead_mps) + max(0.0, _stream_mps(row))
    return -_REST_MPS <= row["surge_mps"] <= _REST_MPS + driven_mps


def _stream_mps(row: Mapping[str, float]) -> float:
    """The current along the hull."""
    return row["current_north_mps"] * math.cos(row["yaw_rad"]) + row["current_east_mps"] * math.sin(row["yaw_rad"])


def _place(row: Mapping[str, float]) -> tuple[float, float]:
    return row["north_m"], row["east_m"]


SCENARIO = Scenario(
    name="full_stop",
    text="Hold from full speed, commanded or by failsafe: the boat stops as soon as it can, and holds about there",
    vessel="otter",
    defaults={
        "by": "hold",
        "run": "45",
        "time": "90",
        "fast": "0.9",
        "wind": "3",
        "current": "",
        "gnss": "rtk",
        "waves": "",
        "model_error": "",
        "plant": "",
    },
    needs=(motor,),
    sail=sail,
    measure=measure,
    lasts_s=180.0,
)
