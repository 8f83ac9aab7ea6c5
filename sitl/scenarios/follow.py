"""A lead boat sails a script; the follower keeps its station, in its wake if that is astern."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from sitl.leader_script import script
from sitl.scenarios.company import Company
from sitl.scenarios.follow_measure import WAKE_M, Chase, modes, rms, variation_1ps
from sitl.scenarios.measure import Check
from sitl.scenarios.rig import Conditions
from sitl.scenarios.scenario import Scenario, ScenarioError, Settings, number
from sitl.scenarios.station import Station
from sitl.waters import OtherBoat

SETTLE_S = 40.0  # after the leader has departed
NEAREST_M = 12.0
_REST_S = 3.0
_LEAST_S, _AFTER_S = 120.0, 45.0

DEFAULTS = {
    "leader": "thesis@8.2",
    "gap": "20",
    "station": "",
    "kind": "module",
    "latency": "0.03",
    "loss": "",
    "law": "companion",
    "gnss": "standalone",
    "wind": "4",
    "waves": "",
    "current": "",
    "model_error": "",
    "plant": "",
}


def station_of(settings: Settings) -> tuple[float, float]:
    """(bearing in the leader's frame in rad, distance in m): `station=BEARING_DEG@M`, or right astern at `gap`. Raises ScenarioError."""
    text = settings.get("station", "")
    if not text:
        return math.pi, number(settings, "gap")
    bearing, at, distance = text.partition("@")
    try:
        return math.radians(float(bearing)), float(distance) if at else number(settings, "gap")
    except ValueError as error:
        raise ScenarioError(f"station={text}: write BEARING_DEG@M, as 180@20") from error


def prepare(conditions: Conditions, settings: Settings) -> Conditions:
    """The follower at home, the lead boat at rest ahead of it where its station asks for, heading north."""
    bearing, distance_m = station_of(settings)
    leader = OtherBoat("leader", settings["leader"], (-distance_m * math.cos(bearing), -distance_m * math.sin(bearing), 0.0), None, settings["gnss"])
    station = {"FLW_TGT_DST": distance_m, "FLW_TGT_FA": math.degrees(math.remainder(bearing, math.tau))}
    return replace(conditions, others=(leader,), start=(0.0, 0.0, 0.0), parameters={**conditions.parameters, **station})


def sail(station: Station, settings: Settings) -> dict[str, Any]:
    company = Company((station.rig,), settings)
    company.follow()
    company.sail(_REST_S)
    asked = begun(company)
    company.sail(max(_LEAST_S, script(settings["leader"])[-1].at_s + _AFTER_S))
    return asked


def begun(company: Company) -> dict[str, Any]:
    """The leader departs; what measuring needs to know."""
    config = company.escorts[0].rig.config
    company.boat.depart(company.now_s)
    jet = config.thrusters[0] if config.thrusters[0].kind == "jet" else None
    return {
        "vessel": config.name,
        "from_s": company.now_s,
        "nozzle": jet.name if jet is not None else "",
        "full_rad": jet.azimuth_max_rad if jet is not None else math.nan,
    }


def figures(folder: Path, chase: Chase, asked: dict[str, Any], settings: Settings) -> dict[str, float]:
    """Of a station astern, from 40 s after the leader's departure until it goes astern."""
    _, gap_m = station_of(settings)
    judged = (chase.t >= asked["from_s"] + SETTLE_S) & (chase.t < chase.ahead_until_s)
    moving = judged & (chase.leader_speed > 1.0)
    straight, bend = moving & chase.on_straight, moving & chase.in_bend
    error, known = chase.gap_m - gap_m, chase.known_gap_m - gap_m
    swing = chase.yaw - chase.along[2]
    metrics = {
        "in_wake_share": float((abs(chase.off_m[moving]) <= WAKE_M).mean()),
        "off_rms_m": rms(chase.off_m[moving]),
        "off_max_m": float(abs(chase.off_m[moving]).max()),
        "known_off_rms_m": rms(chase.known_off_m[moving]),
        "gap_straight_rms_m": rms(error[straight]),
        "gap_bend_rms_m": rms(error[bend]),
        "gap_bend_max_m": float(abs(error[bend]).max()) if bend.any() else math.nan,
        "known_gap_straight_rms_m": rms(known[straight]),
        "known_gap_bend_rms_m": rms(known[bend]),
        "recovery_max_s": max(chase.recovery_s(gap_m), default=math.nan),
        "nearest_m": float(chase.distance.min()),
        "circles": chase.circles(),
        "swing_straight_rms_deg": math.degrees(rms(swing[straight])),
        "following_share": following_share(folder, asked["from_s"]),
    }
    if asked["nozzle"]:
        metrics["nozzle_variation_1ps"] = variation_1ps(folder, asked["nozzle"], asked["full_rad"], asked["from_s"] + SETTLE_S)
    return metrics


def following_share(folder: Path, from_s: float) -> float:
    """Of the ticks, in Follow."""
    words = [mode for t_s, mode in modes(folder) if t_s >= from_s]
    return sum(mode == "Follow" for mode in words) / len(words)


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    chase = Chase(folder, asked["from_s"])
    metrics = figures(folder, chase, asked, settings)
    return metrics, ()


SCENARIO = Scenario(
    name="follow",
    text="a lead boat followed through its script (straight, thesis, slalom, uturn, stop, reverse, lively), at a gap or a station",
    vessel="rescuerunner",
    defaults=DEFAULTS,
    sail=sail,
    measure=measure,
    prepare=prepare,
)
