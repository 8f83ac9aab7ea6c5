"""A lead boat is at rest 300 m away. The follower comes up to it, waits at its follow position, and follows when it
departs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

from companion.config.top_speed import top_speed_mps
from sitl.noise import stream
from sitl.scenarios import follow
from sitl.scenarios.convoy import Convoy
from sitl.scenarios.follow_measure import Chase
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.measure import Check
from sitl.scenarios.rig import Conditions
from sitl.scenarios.scenario import Scenario, Settings, number
from sitl.shared_sea import LeadBoatConfig

_THERE_M = 5.0  # distance beyond the gap that counts as arrived
_NEAR_M = 60.0
_TIMEOUT_S = 150.0  # for the way, at least
_SHARE, _TURN_S = 0.6, 30.0  # of the top speed, in the mean; to turn and get up its speed
_GATHERED_S = 20.0  # the boat has turned and got up its first speed


def prepare(conditions: Conditions, settings: Settings) -> Conditions:
    """The lead boat ahead. The seed draws both headings; the setting `heading` replaces the lead boat's."""
    draws = stream(conditions.seed, "approach")
    drawn, yaw = draws.uniform(-math.pi, math.pi), draws.uniform(-math.pi, math.pi)
    heading = math.radians(number(settings, "heading")) if settings["heading"] else drawn
    leader = LeadBoatConfig(
        "leader", settings["leader"], (number(settings, "distance"), 0.0, heading), None, settings["gnss"]
    )
    prepared = follow.prepare(conditions, settings)
    return replace(prepared, lead_boats=(leader,), start=(0.0, 0.0, yaw))


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Follow, wait while the lead boat is at rest, and follow it when it departs."""
    convoy = Convoy((gcs.rig,), settings)
    convoy.follow()
    begun_s = convoy.now_s
    slow_mps = _SHARE * top_speed_mps(gcs.rig.config)
    way_s = max(_TIMEOUT_S, number(settings, "distance") / slow_mps + _TURN_S)
    convoy.sail(number(settings, "wait") if settings["wait"] else way_s)
    asked = follow.begun(convoy)
    convoy.sail(follow.duration_s(settings))
    return {
        **asked,
        **follow.agility(convoy),
        "begun_s": begun_s,
        "way_s": way_s,
        "marks": [(asked["from_s"], "departs")],
        "plot_from_s": begun_s,
    }


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Metrics of the approach and the wait, and those of `follow` after the departure."""
    _, gap_m = follow.follow_position_of(settings)
    metrics = follow.figures(folder, Chase(folder, asked["from_s"]), asked, settings)
    coming = Chase(folder, asked["begun_s"])
    rest = coming.t < asked["from_s"]
    there = [
        float(t)
        for t, distance in zip(coming.t[rest], coming.distance[rest], strict=True)
        if distance <= gap_m + _THERE_M
    ]
    near = (coming.distance < _NEAR_M) & (coming.t <= (there[0] if there else asked["from_s"]))
    far = rest & (coming.t < asked["begun_s"] + 2.0 * _GATHERED_S) & (coming.distance > _NEAR_M)
    yaw = coming.yaw[near].tolist()
    turned = sum(abs(b - a) for a, b in pairwise(yaw)) - abs(yaw[-1] - yaw[0]) if yaw else math.nan
    waiting = rest & (coming.t >= (there[0] if there else math.inf))
    metrics |= {
        "nearest_m": float(coming.distance.min()),
        "circles": coming.circles(),
        "up_in_s": there[0] - asked["begun_s"] if there else math.inf,
        "first_speed_mps": float(coming.speed[(coming.t >= asked["begun_s"] + _GATHERED_S) & far].mean())
        if far.any()
        else math.nan,
        "swaying_deg": math.degrees(turned),  # changes of heading beyond the net one, within 60 m
        "waiting_from_m": float(coming.distance[waiting].min()) if waiting.any() else math.nan,
        "waiting_to_m": float(coming.distance[waiting].max()) if waiting.any() else math.nan,
        "following_share": follow.following_share(folder, asked["begun_s"]),
    }
    if settings["law"] == "thesis":
        return metrics, ()
    return metrics, [
        Check("up to the leader", metrics["up_in_s"], asked["way_s"], "s"),
        Check("waiting: farthest from the leader", metrics["waiting_to_m"], gap_m + follow.REST_SLACK_M, "m"),
        *follow.checks(metrics, asked, settings),
    ]


SCENARIO = Scenario(
    name="approach",
    text="up to a lead boat at rest 300 m away, wait for it, and follow when it departs",
    vessel="rescuerunner",
    defaults={**follow.DEFAULTS, "leader": "straight@8.2", "distance": "300", "heading": "", "wait": ""},
    sail=sail,
    measure=measure,
    plot=follow.draw,
    prepare=prepare,
    lasts_s=270.0,
)
