"""The orientation filter at rest, at 16 headings around a circle, against the bearing between two receivers 35 m apart
(RescueRunner thesis 7.1.2).

The thesis laid the error of the filter, of the two receivers and of the aim by hand into one figure. Here the first two
stand apart as well; nobody aims.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from sitl.scenarios.follow_measure import columns
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.measure import Check, between, read_truth
from sitl.scenarios.rig import Conditions
from sitl.scenarios.scenario import Scenario, Settings
from sitl.shared_sea import LeadBoatConfig
from sitl.tow import TowLeg

_POINTS = 16
_APART_M = 35.0
_START_S, _TURN_S, _REST_S, _SAMPLE_S = 30.0, 5.0, 12.0, 5.0
_POINT_S = _TURN_S + _REST_S
_GRAVITY_MPS2 = 9.81
_MEAN_DEG = 3.74  # what the thesis measured, all errors together


def legs(settings: Settings) -> tuple[TowLeg, ...]:
    """At rest all the time; a sixteenth of a circle from point to point. At rest `sideways_g` is the rate of turn."""
    turn = TowLeg(_TURN_S, 0.0, math.tau / _POINTS / _TURN_S / _GRAVITY_MPS2)
    return (TowLeg(_START_S, 0.0), *(leg for _ in range(_POINTS) for leg in (turn, TowLeg(_REST_S, 0.0))))


def prepare(conditions: Conditions, settings: Settings) -> Conditions:
    """The other receiver on a boat at rest 35 m north. Its errors count, not its place."""
    other = LeadBoatConfig("leader", "straight@1", (_APART_M, 0.0, 0.0), None, settings["gnss"])
    return replace(conditions, lead_boats=(other,), start=(0.0, 0.0, 0.0))


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Let the boards be turned and sampled."""
    gcs.sail(sum(leg.duration_s for leg in legs(settings)))
    return {}


def _means(folder: Path, from_s: float, to_s: float) -> tuple[float, float]:
    """(heading error of the filter, error of the bearing to the other receiver) in rad, means between two times."""
    truth = between(read_truth(folder), from_s, to_s)
    ticks = columns(folder / "ticks.csv", "t_s", "north_m", "east_m", "yaw_rad")
    other = columns(folder / "leader.csv", "t_s", "north_m", "east_m", "fix_north_m", "fix_east_m")
    at, there = (
        (ticks["t_s"] >= from_s) & (ticks["t_s"] <= to_s),
        (other["t_s"] >= from_s) & (other["t_s"] <= to_s),
    )
    yaw = truth[-1]["yaw_rad"]
    north = (other["fix_north_m"] - other["north_m"])[there].mean() - (
        ticks["north_m"][at].mean() - statistics.fmean(row["north_m"] for row in truth)
    )
    east = (other["fix_east_m"] - other["east_m"])[there].mean() - (
        ticks["east_m"][at].mean() - statistics.fmean(row["east_m"] for row in truth)
    )
    across, along = east * math.cos(yaw) - north * math.sin(yaw), north * math.cos(yaw) + east * math.sin(yaw)
    heading = statistics.fmean(math.remainder(value - yaw, math.tau) for value in ticks["yaw_rad"][at])
    return heading, math.atan2(across, _APART_M + along)


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Mean and largest errors over the 16 headings: of the filter, of the receivers' bearing, and of their difference,
    which is what the thesis could see."""
    ends = [_START_S + (k + 1) * _POINT_S for k in range(_POINTS)]
    points = [_means(folder, end_s - _SAMPLE_S, end_s - 0.1) for end_s in ends]
    metrics: dict[str, float] = {}
    for name, errors in (
        ("filter", [heading for heading, _ in points]),
        ("bearing", [bearing for _, bearing in points]),
        ("seen", [heading - bearing for heading, bearing in points]),
    ):
        degrees = [abs(math.degrees(error)) for error in errors]
        metrics |= {f"{name}_mean_deg": statistics.fmean(degrees), f"{name}_max_deg": max(degrees)}
    return metrics, [Check("mean error of the filter", metrics["filter_mean_deg"], _MEAN_DEG, "deg")]


SCENARIO = Scenario(
    name="shore_compass",
    text="heading by a magnetometer at rest, at 16 headings, against two receivers 35 m apart",
    vessel="rescuerunner",
    defaults={"ahrs": "companion", "magnetometer": "", "gnss": "standalone", "wind": "", "waves": "0"},
    sail=sail,
    measure=measure,
    prepare=prepare,
    tow=legs,
    lasts_s=302.0,
)
