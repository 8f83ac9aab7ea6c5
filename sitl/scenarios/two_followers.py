"""Two followers of one lead boat, each with its own station, receiver and link: no hull comes near another."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from sitl.scenarios import follow
from sitl.scenarios.company import Company
from sitl.scenarios.follow_measure import Chase
from sitl.scenarios.measure import Check
from sitl.scenarios.scenario import Scenario, Settings
from sitl.scenarios.station import Station

_SECOND = "second"
_SEED_STEP = 1000  # the second one's errors are its own
_APART_M = 8.0  # between followers, who know nothing of each other


def sail(station: Station, settings: Settings) -> dict[str, Any]:
    first = station.rig
    bearing, distance_m = follow.station_of(_of_second(settings))
    north_m, east_m, yaw_rad = first.conditions.others[0].start
    place = north_m + distance_m * math.cos(yaw_rad + bearing), east_m + distance_m * math.sin(yaw_rad + bearing), yaw_rad
    parameters = {**first.conditions.parameters, "FLW_TGT_DST": distance_m, "FLW_TGT_FA": math.degrees(math.remainder(bearing, math.tau)), "MAV_SYS_ID": 2.0}
    second = first.beside(replace(first.conditions, seed=first.conditions.seed + _SEED_STEP, start=place, parameters=parameters), _SECOND)
    try:
        company = Company((first, second), settings)
        company.follow()
        company.sail(follow.REST_S)
        asked = follow.begun(company)
        company.sail(follow.duration_s(settings))
    finally:
        second.close()
    return {**asked, "others": [_SECOND]}


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    import numpy as np

    chases = [Chase(each, asked["from_s"]) for each in (folder, folder / _SECOND)]
    metrics: dict[str, float] = {}
    checks: list[Check] = []
    for i, (each, chase, own) in enumerate(zip((folder, folder / _SECOND), chases, (settings, _of_second(settings)), strict=True), 1):
        found = follow.figures(each, chase, asked, own)
        metrics |= {f"follower_{i}_{name}": value for name, value in found.items()}
        checks += [replace(check, name=f"follower {i}: {check.name}") for check in follow.checks(found, asked, own)]
    a, b = chases
    between = np.hypot(a.north - np.interp(a.t, b.t, b.north), a.east - np.interp(a.t, b.t, b.east))
    metrics["followers_apart_m"] = float(between.min())
    checks.append(Check("distance between the followers", metrics["followers_apart_m"], _APART_M, "m", at_least=True))
    return metrics, () if settings["law"] == "thesis" else checks


def _of_second(settings: Settings) -> Settings:
    return {**settings, "station": settings["second"]}


SCENARIO = Scenario(
    name="two_followers",
    text="two boats follow one lead boat, each at its own station",
    vessel="rescuerunner",
    defaults={**follow.DEFAULTS, "second": "180@45"},
    sail=sail,
    measure=measure,
    plot=follow.draw,
    prepare=follow.prepare,
)
