"""Two followers of one lead boat, each with its own follow position, receiver and link: no hull comes near another."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from sitl.scenarios import follow
from sitl.scenarios.convoy import Convoy
from sitl.scenarios.follow_measure import Chase
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.measure import Check
from sitl.scenarios.scenario import Scenario, Settings

_SECOND = "second"
_SEED_STEP = 1000  # the second one has errors of its own
_APART_M = 8.0  # between the followers, which do not see each other


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Add the second follower; both follow the lead boat through its script."""
    first = gcs.rig
    bearing, distance_m = follow.follow_position_of(_of_second(settings))
    north_m, east_m, yaw_rad = first.conditions.lead_boats[0].start
    place = (
        north_m + distance_m * math.cos(yaw_rad + bearing),
        east_m + distance_m * math.sin(yaw_rad + bearing),
        yaw_rad,
    )
    parameters = {
        **first.conditions.parameters,
        "FLW_TGT_DST": distance_m,
        "FLW_TGT_FA": math.degrees(math.remainder(bearing, math.tau)),
        "MAV_SYS_ID": 2.0,
    }
    second = first.second_vessel(
        replace(first.conditions, seed=first.conditions.seed + _SEED_STEP, start=place, parameters=parameters), _SECOND
    )
    try:
        convoy = Convoy((first, second), settings)
        convoy.follow()
        convoy.sail(follow.REST_S)
        asked = follow.begun(convoy)
        convoy.sail(follow.duration_s(settings))
        asked |= follow.agility(convoy)
    finally:
        second.close()
    return {**asked, "others": [_SECOND]}


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Metrics of `follow` for each, and the distance between the followers."""
    import numpy as np

    chases = [Chase(each, asked["from_s"]) for each in (folder, folder / _SECOND)]
    metrics: dict[str, float] = {}
    checks: list[Check] = []
    for i, (each, chase, own) in enumerate(
        zip((folder, folder / _SECOND), chases, (settings, _of_second(settings)), strict=True), 1
    ):
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
    text="two boats follow one lead boat, each at its own follow position",
    vessel="rescuerunner",
    defaults={**follow.DEFAULTS, "second": "180@45"},
    sail=sail,
    measure=measure,
    plot=follow.draw,
    prepare=follow.prepare,
    lasts_s=180.0,
)
