"""A lead boat lies still 300 m away; the follower comes up to its station, waits there, and follows when the lead boat departs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

from sitl.noise import stream
from sitl.scenarios import follow
from sitl.scenarios.company import Company
from sitl.scenarios.follow_measure import Chase
from sitl.scenarios.measure import Check
from sitl.scenarios.rig import Conditions
from sitl.scenarios.scenario import Scenario, Settings, number
from sitl.scenarios.station import Station
from sitl.waters import OtherBoat

_THERE_M = 5.0  # beyond the gap: come up
_NEAR_M = 60.0
_TIMEOUT_S = 150.0


def prepare(conditions: Conditions, settings: Settings) -> Conditions:
    """The lead boat ahead, its heading and the follower's by the seed unless `heading` says the former."""
    draws = stream(conditions.seed, "approach")
    drawn, yaw = draws.uniform(-math.pi, math.pi), draws.uniform(-math.pi, math.pi)
    heading = math.radians(number(settings, "heading")) if settings["heading"] else drawn
    leader = OtherBoat("leader", settings["leader"], (number(settings, "distance"), 0.0, heading), None, settings["gnss"])
    prepared = follow.prepare(conditions, settings)
    return replace(prepared, others=(leader,), start=(0.0, 0.0, yaw))


def sail(station: Station, settings: Settings) -> dict[str, Any]:
    company = Company((station.rig,), settings)
    company.follow()
    begun_s = company.now_s
    company.sail(number(settings, "wait"))
    asked = follow.begun(company)
    company.sail(follow.duration_s(settings))
    return {**asked, "begun_s": begun_s, "marks": [(asked["from_s"], "departs")], "plot_from_s": begun_s}


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    _, gap_m = follow.station_of(settings)
    metrics = follow.figures(folder, Chase(folder, asked["from_s"]), asked, settings)
    coming = Chase(folder, asked["begun_s"])
    rest = coming.t < asked["from_s"]
    there = [float(t) for t, distance in zip(coming.t[rest], coming.distance[rest], strict=True) if distance <= gap_m + _THERE_M]
    near = (coming.distance < _NEAR_M) & (coming.t <= (there[0] if there else asked["from_s"]))
    yaw = coming.yaw[near].tolist()
    turned = sum(abs(b - a) for a, b in pairwise(yaw)) - abs(yaw[-1] - yaw[0]) if yaw else math.nan
    waiting = rest & (coming.t >= (there[0] if there else math.inf))
    metrics |= {
        "nearest_m": float(coming.distance.min()),
        "circles": coming.circles(),
        "up_in_s": there[0] - asked["begun_s"] if there else math.inf,
        "swaying_deg": math.degrees(turned),  # heading to and fro within 60 m
        "waiting_from_m": float(coming.distance[waiting].min()) if waiting.any() else math.nan,
        "waiting_to_m": float(coming.distance[waiting].max()) if waiting.any() else math.nan,
        "following_share": follow.following_share(folder, asked["begun_s"]),
    }
    if settings["law"] == "thesis":
        return metrics, ()
    return metrics, [
        Check("up to the leader", metrics["up_in_s"], _TIMEOUT_S, "s"),
        Check("waiting: farthest from the leader", metrics["waiting_to_m"], gap_m + follow.REST_SLACK_M, "m"),
        *follow.checks(metrics, asked, settings),
    ]


SCENARIO = Scenario(
    name="approach",
    text="up to a lead boat at rest 300 m away, wait for it, and follow when it departs",
    vessel="rescuerunner",
    defaults={**follow.DEFAULTS, "leader": "straight@8.2", "distance": "300", "heading": "", "wait": "150"},
    sail=sail,
    measure=measure,
    plot=follow.draw,
    prepare=prepare,
)
