"""Hold in gusts and a current, for boats that cannot push themselves sideways; any boat may be set
beside them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from sitl.scenarios.boat import holds_by_drifting
from sitl.scenarios.four_corner import SETTLE_S, thrusters_of
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.measure import Check, distance_to
from sitl.scenarios.positioning import energy, read
from sitl.scenarios.scenario import Scenario, Settings, number

_LEAST_RADIUS_M = 3.0
_LENGTHS = 1.5
_MOST_TURNS = 1.0
_MOST_REVERSALS_1PMIN = 12.0


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Hold at home for the setting `time`, after settling."""
    gcs.hold_at_home(SETTLE_S)
    from_s = gcs.rig.now_s
    gcs.sail(number(settings, "time"))
    config = gcs.rig.config
    return {
        "from_s": from_s,
        "to_s": gcs.rig.now_s,
        "thrusters": thrusters_of(config),
        "length_m": config.length_m,
        "circles_m": _circles_m(gcs),
    }


def _circles_m(gcs: GroundStation) -> tuple[float, float]:
    """Within what it holds 95 % of the time, and always."""
    config = gcs.rig.config
    if holds_by_drifting(config):
        return gcs.parameter("DP_WATCH_R"), gcs.parameter("DP_ALARM_R")
    radius_m = max(_LEAST_RADIUS_M, _LENGTHS * config.length_m)
    return radius_m, 2.0 * radius_m


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Radius that holds 95 % of the time, thrust, turns of the bow, and how often thrust changes its sign."""
    sailed = read(folder, asked["from_s"], asked["to_s"])
    track, thrusters = sailed.truth, asked["thrusters"]
    distances = sorted(distance_to(row, 0.0, 0.0) for row in track)
    forces = [[row[f"{thruster.name}_force_n"] for thruster in thrusters] for row in track]
    turned = sum(math.remainder(b["yaw_rad"] - a["yaw_rad"], math.tau) for a, b in pairwise(track))
    used_n = [sum(map(abs, row)) for row in forces]
    full_n = sum(thruster.full_n for thruster in thrusters)
    minutes = (asked["to_s"] - asked["from_s"]) / 60.0
    metrics = {
        "radius_95_m": distances[int(0.95 * len(distances))],
        "radius_max_m": distances[-1],
        "distance_rms_m": math.sqrt(sum(d * d for d in distances) / len(distances)),
        "thrust_mean_n": sum(used_n) / len(used_n),
        "thrust_share": sum(used_n) / len(used_n) / full_n,
        "energy_full_power_s": energy(sailed, thrusters)[-1],
        "turns": abs(turned) / math.tau,
        "reversals_1pmin": _reversals(forces, full_n) / minutes,
    }
    radius_m, most_m = asked["circles_m"]
    return metrics, (
        Check("95 % of the time within", metrics["radius_95_m"], radius_m, "m"),
        Check("never further off", metrics["radius_max_m"], most_m, "m"),
        Check("no circling: whole turns of the bow", metrics["turns"], _MOST_TURNS, ""),
        Check("no limit cycle: reversals of thrust", metrics["reversals_1pmin"], _MOST_REVERSALS_1PMIN, "1/min"),
    )


def _reversals(forces: Sequence[Sequence[float]], full_n: float) -> float:
    """How often the sum of thrust ahead changes from a tenth of full to a tenth of full the other way."""
    sign, count = 0, 0
    for row in forces:
        total = sum(row)
        if abs(total) > 0.1 * full_n:
            now = 1 if total > 0.0 else -1
            count += sign not in (0, now)
            sign = now
    return float(count)


SCENARIO = Scenario(
    name="bow_hold",
    text="600 s of Hold in gusts of 6 m/s and a current, with a boat that cannot push itself sideways",
    vessel="otter",
    defaults={
        "time": "600",
        "wind": "6",
        "current": "0.3",
        "gnss": "rtk",
        "waves": "",
        "model_error": "",
        "plant": "",
        "keeping": "bow",
    },
    sail=sail,
    measure=measure,
    lasts_s=630.0,
)
