"""A pure sway demand in Forces, to starboard and to port: how far the bow turns (ReVolt thesis 10.4.2).

The thesis moved the thrusters' places in its allocation until the bow stayed. `levers=file` allocates by the places in
the vessel's file, `levers=measured` by those where the plant has its thrusters.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.config.vessel import VesselConfig, find, load
from sitl.scenarios.boat import sideways
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.measure import Check, Track, between, read_truth
from sitl.scenarios.rig import Conditions
from sitl.scenarios.scenario import Scenario, ScenarioError, Settings, number

_FORCES = 0x00020000
_SETTLE_S = 30.0
_SHARE = 0.4  # of the boat's limit, where no force is given
_SIDES = {"starboard": 1.0, "port": -1.0}


def prepare(conditions: Conditions, settings: Settings) -> Conditions:
    """The allocation by the file's levers, or by the plant's. Raises ScenarioError for another word."""
    levers = settings["levers"]
    if levers not in ("file", "measured"):
        raise ScenarioError(f"levers={levers}: one of file, measured")
    if levers == "file":
        return conditions
    return replace(conditions, known=_measured(load(find(conditions.vessel)), conditions.plant))


def _measured(config: VesselConfig, plant: str | None) -> VesselConfig:
    """The vessel with its thrusters where that plant has them."""
    if config.sitl is None:
        return config
    places_m = config.sitl.plants[plant or config.sitl.plant].thruster_x_m
    if not places_m:
        return config
    thrusters = (replace(one, x_m=x_m) for one, x_m in zip(config.thrusters, places_m, strict=True))
    return replace(config, thrusters=tuple(thrusters))


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Demand the force to each side for `time` seconds, from rest at home."""
    limit_n = gcs.rig.config.limits.sway_n
    share = number(settings, "force") / limit_n if settings["force"] else _SHARE
    if not 0.0 < share <= 1.0:
        raise ScenarioError(
            f"force={settings['force']}: must be above 0, and at most {limit_n:g} N (limits.sway_n of this boat); "
            f"try --set force={0.5 * limit_n:.2g}"
        )
    spans: dict[str, tuple[float, float]] = {}
    gcs.hold_at_home(_SETTLE_S)
    home = gcs.rig.config.home
    for side, sign in _SIDES.items():
        _push(gcs, 0.0)  # sticks take control only from the middle
        gcs.set_mode(_FORCES)
        _push(gcs, 0.0)
        gcs.step()
        from_s = gcs.rig.now_s
        while gcs.rig.now_s < from_s + number(settings, "time"):
            _push(gcs, sign * share)
            gcs.step()
        spans[side] = (from_s, gcs.rig.now_s)
        gcs.set_mode(0x03040000)
        gcs.reposition(home.lat_deg, home.lon_deg, home.yaw_rad)
        gcs.sail(2.0 * _SETTLE_S)
    return {"spans": spans}


def _push(gcs: GroundStation, share: float) -> None:
    """Hold the stick for sway; the others are centred."""
    gcs.send(mavlink.MAVLink_manual_control_message(1, 0, round(1000.0 * share), 0, 0, 0))


def turned(track: Track) -> tuple[float, float]:
    """(turn of the bow in rad, way made sideways in m, both positive to starboard) of a track."""
    first, last = track[0], track[-1]
    north, east = last["north_m"] - first["north_m"], last["east_m"] - first["east_m"]
    yaw = first["yaw_rad"]
    return (
        math.remainder(last["yaw_rad"] - yaw, math.tau),
        east * math.cos(yaw) - north * math.sin(yaw),
    )


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """The turn for each metre sideways, positive where the bow turns towards the side of the demand, and its mean of
    both sides, from which a steady wind drops out."""
    truth = read_truth(folder)
    metrics: dict[str, float] = {}
    for side, sign in _SIDES.items():
        turn_rad, way_m = turned(between(truth, *asked["spans"][side]))
        metrics[f"way_{side}_m"] = sign * way_m
        metrics[f"turn_{side}_deg_per_m"] = math.degrees(turn_rad) / abs(way_m)
    metrics["turn_deg_per_m"] = 0.5 * (metrics["turn_starboard_deg_per_m"] - metrics["turn_port_deg_per_m"])
    return metrics, [Check(f"way to {side}", metrics[f"way_{side}_m"], 0.5, "m", at_least=True) for side in _SIDES]


SCENARIO = Scenario(
    name="sway_demand",
    text="a pure sway demand to each side in Forces: how far the bow turns (ReVolt thesis 10.4.2)",
    vessel="revolt",
    defaults={
        "force": "",
        "time": "20",
        "levers": "file",
        "wind": "",
        "current": "",
        "gnss": "rtk",
        "plant": "",
    },
    by_vessel={"revolt": {"force": "10"}},
    needs=(sideways,),
    sail=sail,
    measure=measure,
    prepare=prepare,
    lasts_s=260.0,
)
