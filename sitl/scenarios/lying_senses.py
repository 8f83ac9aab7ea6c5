"""A sensor begins to lie while the boat holds: how soon that is found, and how far the boat has moved by then and
while it lies."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from companion.core.angles import wrap_pi
from sitl.lie_table import LIES
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.measure import Check, between, distance_to, read_estimates, read_truth, receiver_error_m
from sitl.scenarios.scenario import Scenario, ScenarioError, Settings, number

FOUND = "sense_distrusted"
_SETTLE_S = 60.0
_NEVER_S = 999.0
_FOUND_S = {  # of lies with a promise
    "gnss_frozen": 2.0, "position_frozen": 3.0, "gnss_jump": 1.0, "heading_turned": 1.0, "heading_creep": 4.0,
    "imu_repeats": 0.5, "position_creep": 3.0, "gnss_spoof": 3.0, "gnss_pull": 10.0,
}  # fmt: skip
PROMISED = tuple(_FOUND_S)
_MOVED_M = {"gnss_frozen": 0.3, "position_frozen": 0.3}  # by the time that it is found
_KEPT_M = {"gnss_jump": 0.5, "position_frozen": 0.5, "position_creep": 0.5, "heading_turned": 0.5, "heading_creep": 0.5}
_HEADING_DEG = {"heading_turned": 10.0, "heading_creep": 10.0}  # error of the estimate


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Hold at home; then the lie, for `watch` seconds."""
    _name_of(settings)
    settle(gcs)
    return lie(gcs, settings)


def settle(gcs: GroundStation) -> None:
    """Hold at home."""
    gcs.hold_at_home(_SETTLE_S)


def lie(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """The lie, for `watch` seconds. Returns what `measure` needs to know."""
    name = _name_of(settings)
    from_s = gcs.rig.now_s
    gcs.rig.world.add_fault(settings["lie"])
    gcs.sail(number(settings, "watch"))
    bow_first = gcs.rig.config.limits.sway_n <= 0.0
    return {
        "from_s": from_s,
        "to_s": gcs.rig.now_s,
        "lie": name,
        "holds_within_m": gcs.parameter("DP_WATCH_R") if bow_first else receiver_error_m(settings["gnss"]),
    }


def _name_of(settings: Settings) -> str:
    name = settings["lie"].partition("=")[0].partition(":")[0]
    if name not in LIES:
        raise ScenarioError(f"lie={settings['lie']}: no such lie; there is {', '.join(LIES)}")
    return name


def found_s(folder: Path, from_s: float = -math.inf) -> list[tuple[float, str]]:
    """(time, text) of each sensor that was found to lie since then."""
    with (folder / "events.csv").open(encoding="utf-8", newline="") as file:
        rows = [(float(row["t_s"]), row["text"]) for row in csv.DictReader(file) if row["name"] == FOUND]
    return [(t_s, text) for t_s, text in rows if t_s >= from_s]


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Time until it is found, distance from home, error of the heading."""
    from_s, name = asked["from_s"], asked["lie"]
    track = between(read_truth(folder), from_s, asked["to_s"])
    found = found_s(folder, from_s)
    by_then_s = found[0][0] if found else asked["to_s"]
    metrics = {
        "found_s": round(by_then_s - from_s, 3) if found else _NEVER_S,
        "found_last_s": round(found[-1][0] - from_s, 3) if found else _NEVER_S,
        "moved_m": max(distance_to(row, 0.0, 0.0) for row in track if row["t_s"] <= by_then_s),
        "kept_m": max(distance_to(row, 0.0, 0.0) for row in track),
        "heading_error_deg": _heading_error_deg(folder, from_s),
    }
    limits = (
        ("found after", "found_s", _FOUND_S, "s"),
        ("moved by then", "moved_m", _MOVED_M, "m"),
        ("largest distance while it lies", "kept_m", _KEPT_M, "m"),
        ("largest error of the heading", "heading_error_deg", _HEADING_DEG, "deg"),
    )
    return metrics, [
        Check(text, metrics[key], table[name] + (asked["holds_within_m"] if unit == "m" else 0.0), unit)
        for text, key, table, unit in limits
        if name in table
    ]


def _heading_error_deg(folder: Path, from_s: float) -> float:
    """Largest error of the estimated heading since then."""
    pairs = zip(read_estimates(folder), read_truth(folder), strict=True)
    return max(
        abs(math.degrees(wrap_pi(estimate["yaw_rad"] - true["yaw_rad"])))
        for estimate, true in pairs
        if true["t_s"] >= from_s
    )


SCENARIO = Scenario(
    name="lying_senses",
    text="a sensor lies while the boat holds: how soon it is found, how far the boat moves",
    vessel="revolt",
    defaults={
        "lie": "gnss_jump=50",
        "watch": "60",
        "wind": "3",
        "current": "",
        "gnss": "rtk",
        "waves": "",
        "model_error": "",
        "plant": "",
    },
    sail=sail,
    measure=measure,
    lasts_s=120.0,
)
