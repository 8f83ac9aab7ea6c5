"""Hold for endurance: accuracy against energy, with the circle of DP_ECON and with a free heading."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from companion.core.angles import wrap_pi
from sitl.scenarios.boat import sideways
from sitl.scenarios.four_corner import SETTLE_S
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.measure import Check, Track, between, read_truth, receiver_error_m
from sitl.scenarios.scenario import Scenario, ScenarioError, Settings, number

_FREE_TURN_S = 240.0  # a free heading has so long to find the weather
_HEADING_DEG = 10.0  # a held one stays within
_LEAST_CIRCLE_M = 0.5  # as far as a boat without DP_ECON is asked to stay
_PUSHES = 0.005  # of full force: less is no thrust


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Hold at home for the setting `time`, after settling."""
    free = settings["heading"] == "free"
    if not free and settings["heading"] != "held":
        raise ScenarioError(f"heading={settings['heading']}: held or free")
    home = gcs.rig.config.home
    gcs.ready()
    gcs.set_parameter("DP_ECON", number(settings, "econ"))
    gcs.set_parameter("DP_WEATHERVANE", float(free))
    gcs.set_parameter("ALLOC_ECON", float(number(settings, "econ") > 0.0 or free))
    gcs.set_mode(0x03040000)
    gcs.arm()
    gcs.reposition(home.lat_deg, home.lon_deg, math.nan if free else home.yaw_rad)
    gcs.sail(SETTLE_S + (_FREE_TURN_S if free else 0.0))
    from_s = gcs.rig.now_s
    gcs.sail(number(settings, "time"))
    return {"from_s": from_s, "to_s": gcs.rig.now_s, "config": gcs.rig.config}


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Accuracy, mean power, variation of thrust, and what wears the propellers, all by the truth."""
    from sitl.evaluate.figures import hold  # which imports the scenarios

    config, free, econ_m = asked["config"], settings["heading"] == "free", number(settings, "econ")
    track = between(read_truth(folder), asked["from_s"], asked["to_s"])
    found = {figure.name: figure.value for figure in hold(track, config, (0.0, 0.0), config.home.yaw_rad)}
    turned = [math.degrees(abs(wrap_pi(row["yaw_rad"] - config.home.yaw_rad))) for row in track]
    full_n = {thruster.name: max(thruster.max_n, -thruster.min_n) for thruster in config.thrusters}
    hours = (asked["to_s"] - asked["from_s"]) / 3600.0
    metrics = {
        "position_rms_m": found["position, RMS"],
        "radius_95_m": found["position, 95 %"],
        "radius_max_m": found["position, largest"],
        "heading_rms_deg": found["heading, RMS"],
        "heading_end_deg": math.degrees(track[-1]["yaw_rad"]) % 360.0,
        "power_percent": found["mean power"],
        "variation_percent_ps": found["thrust variation"],
        "reversals_1ph": sum(_reversals(track, f"{name}_force_n", most_n) for name, most_n in full_n.items()) / hours,
        "azimuth_turns_1ph": sum(
            _turns(track, f"{thruster.name}_azimuth_rad") for thruster in config.thrusters if thruster.turns
        )
        / hours,
    }
    circle_m = max(_LEAST_CIRCLE_M, econ_m) + receiver_error_m(settings["gnss"])
    heading = () if free else (Check("heading, largest", max(turned), _HEADING_DEG, "deg"),)
    return metrics, (Check("position, largest", metrics["radius_max_m"], circle_m, "m"), *heading)


def _reversals(track: Track, column: str, full_n: float) -> int:
    """How often the thrust changes its sign."""
    signs = [math.copysign(1.0, row[column]) for row in track if abs(row[column]) > _PUSHES * full_n]
    return sum(a != b for a, b in pairwise(signs))


def _turns(track: Track, column: str) -> float:
    """Whole turns that an azimuth travels."""
    return sum(abs(wrap_pi(b[column] - a[column])) for a, b in pairwise(track)) / math.tau


SCENARIO = Scenario(
    name="endurance",
    text="600 s of station keeping inside a circle (`econ`, m) or with a free heading, for accuracy against energy",
    vessel="revolt",
    defaults={
        "econ": "1",
        "heading": "held",
        "time": "600",
        "wind": "3",
        "current": "",
        "gnss": "rtk",
        "waves": "",
        "model_error": "",
    },
    by_vessel={"aboat": {"gnss": "rtk", "wind": "6", "current": "0.3"}},
    needs=(sideways,),
    sail=sail,
    measure=measure,
    lasts_s=630.0,
)
