"""Hold with a boat that has neither sideways thrust nor way astern: inside its watch circle, without circling."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from sitl.scenarios.boat import drifting
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.measure import Check, between, distance_to, read_truth
from sitl.scenarios.scenario import Scenario, Settings, number

_HOLD = 0x03040000
_RUNNING_N = 20.0
_WANDER_M = 4.0  # error of a receiver without corrections, which the boat cannot know
_MOST_TURNS = 2.0  # whole turns of the bow, with their sign
_MOST_RUNNING = 0.4


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Hold for the setting `time`."""
    gcs.ready()
    gcs.set_mode(_HOLD)
    gcs.arm()
    from_s = gcs.rig.now_s
    gcs.sail(number(settings, "time"))
    return {"from_s": from_s, "name": gcs.rig.config.thrusters[0].name}


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Distance from the hold point, turns of the bow, and share of the time with thrust."""
    track = between(read_truth(folder), asked["from_s"])
    circle_m = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))["parameters"]["DP_WATCH_R"]
    turned = sum(math.remainder(b["yaw_rad"] - a["yaw_rad"], math.tau) for a, b in pairwise(track))
    force = f"{asked['name']}_force_n"
    metrics = {
        "distance_max_m": max(distance_to(row, 0.0, 0.0) for row in track),
        "turns": abs(turned) / math.tau,
        "running_share": sum(abs(row[force]) > _RUNNING_N for row in track) / len(track),
        "speed_max_mps": max(math.hypot(row["surge_mps"], row["sway_mps"]) for row in track),
    }
    checks = (
        Check(
            "inside the watch circle",
            metrics["distance_max_m"],
            circle_m + (_WANDER_M if settings["gnss"] == "standalone" else 0.0),
            "m",
        ),
        Check("no circling: whole turns of the bow", metrics["turns"], _MOST_TURNS, ""),
        Check("drifting most of the time: share with thrust", metrics["running_share"], _MOST_RUNNING, ""),
    )
    return metrics, checks


SCENARIO = Scenario(
    name="watch_circle",
    text="Hold with a boat that has neither sideways thrust nor way astern",
    vessel="rescuerunner",
    defaults={
        "time": "300",
        "wind": "6",
        "current": "",
        "gnss": "standalone",
        "waves": "",
        "model_error": "",
        "plant": "",
    },
    needs=(drifting,),
    sail=sail,
    measure=measure,
)
