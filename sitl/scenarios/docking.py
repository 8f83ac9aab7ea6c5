"""Dock onto the vessel's own berth in wind: to the standoff point, alongside, and hold there."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from companion.core.angles import wrap_pi
from sitl.scenarios.boat import sideways
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.measure import Check, between, read_truth
from sitl.scenarios.scenario import Scenario, Settings

_DOCK = 0x06040000
_TIMEOUT_S = 400.0
_HOLD_S = 32.0


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Choose Dock and arm; wait until the boat announces that it is docked, then half a minute more."""
    gcs.ready()
    gcs.set_mode(_DOCK)
    gcs.arm()
    from_s = gcs.rig.now_s
    gcs.wait("docked", lambda: any(text.startswith("Docked") for text in gcs.texts), _TIMEOUT_S)
    docked_s = gcs.rig.now_s
    gcs.sail(_HOLD_S)
    dock = gcs.rig.config.dock
    assert dock is not None
    return {"from_s": from_s, "docked_s": docked_s, "to_s": gcs.rig.now_s, "yaw_rad": dock.yaw_rad}


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Speeds at contact, rebound, and how it holds against the berth."""
    track = between(read_truth(folder), asked["from_s"], asked["to_s"])
    first = next((i for i, row in enumerate(track) if not math.isnan(row["contact_sway_mps"])), len(track) - 1)
    alongside = track[first:]
    held = between(track, asked["docked_s"])
    metrics = {
        "contact_surge_mps": max(abs(row["contact_surge_mps"]) for row in alongside),
        "contact_sway_mps": max(abs(row["contact_sway_mps"]) for row in alongside),
        "rebound_m": max(row["contact_gap_m"] for row in alongside),
        "held_share": sum(row["contact_n"] > 0.0 for row in held) / len(held),
        "held_force_mean_n": sum(row["contact_n"] for row in held) / len(held),
        "held_heading_max_deg": max(abs(math.degrees(wrap_pi(row["yaw_rad"] - asked["yaw_rad"]))) for row in held),
        "time_s": asked["docked_s"] - asked["from_s"],
    }
    checks = (
        Check("surge speed at contact", metrics["contact_surge_mps"], 0.08, "m/s"),
        Check("sway speed at contact", metrics["contact_sway_mps"], 0.08, "m/s"),
        Check("it does not bounce", metrics["rebound_m"], 0.05, "m"),
        Check("time held against the berth", held[-1]["t_s"] - held[0]["t_s"], 30.0, "s", at_least=True),
        Check("share of that time in contact", metrics["held_share"], 0.99, "", at_least=True),
    )
    return metrics, checks


SCENARIO = Scenario(
    name="docking",
    text="port side onto a berth at -40 degrees, in wind with gusts",
    vessel="revolt",
    defaults={"wind": "2", "current": "", "gnss": "rtk", "waves": "", "model_error": ""},
    needs=(sideways,),
    sail=sail,
    measure=measure,
    lasts_s=210.0,
)
