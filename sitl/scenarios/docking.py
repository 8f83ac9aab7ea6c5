"""Dock onto the vessel's own berth in wind: to the standoff point, alongside, and hold there.

In a sea, waves move the hull to and fro. Where keeping it from that takes more force than the boat pushes with, no law
keeps the fenders pressed all the time: then it is judged that each wave brings the boat back to them, and that it lies
there in the mean.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from companion.core.angles import wrap_pi
from sitl.scenarios.boat import sideways
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.measure import Check, Track, between, means, read_truth, rms
from sitl.scenarios.scenario import Scenario, Settings
from sitl.sea import Sea

_DOCK = 0x06040000
_TIMEOUT_S = 400.0
_HOLD_S = 32.0
_FREE_S = 20.0  # before the first touch, in which the waves' motion is measured
_WAVE_S = 2.0  # longer than the waves that move such a boat; slower motion is its own
_MOST_SIGMAS = 2.33  # one wave in a hundred asks for more, with the RMS force as sigma


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
    inertia_kg = gcs.rig.config.hull.m22_kg
    sea = isinstance(gcs.rig.world.waves, Sea)
    return {
        "from_s": from_s, "docked_s": docked_s, "to_s": gcs.rig.now_s, "yaw_rad": dock.yaw_rad,
        "inertia_kg": inertia_kg, "sea": sea,
    }  # fmt: skip


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
    if asked["sea"]:
        metrics |= _in_sea(track[:first], held, asked["inertia_kg"])
    return metrics, (
        Check("surge speed at contact", metrics["contact_surge_mps"], 0.08, "m/s"),
        Check("sway speed at contact", metrics["contact_sway_mps"], 0.08, "m/s"),
        Check("it does not bounce", metrics["rebound_m"], 0.05, "m"),
        Check("time held against the berth", held[-1]["t_s"] - held[0]["t_s"], 30.0, "s", at_least=True),
        *_kept(metrics),
    )


def _in_sea(free: Track, held: Track, inertia_kg: float) -> dict[str, float]:
    """RMS of the waves' motion sideways before the first touch, the force that would keep the hull from it, the
    boat's own speed sideways at that touch, and how it lies against the fenders without that motion."""
    free = between(free, free[-1]["t_s"] - _FREE_S)
    step_s = (free[-1]["t_s"] - free[0]["t_s"]) / (len(free) - 1)
    width = round(_WAVE_S / step_s)
    speeds = [row["sway_mps"] for row in free]
    slow = means(speeds, width)
    waves = [speed - mean for speed, mean in zip(speeds[width // 2 :], slow, strict=False)]
    pushes = [inertia_kg * (b - a) / step_s for a, b in pairwise(waves)]
    touched = [float(row["contact_n"] > 0.0) for row in held]
    return {
        "contact_own_mps": abs(slow[-1]),
        "wave_mps": rms(waves),
        "wave_n": rms(pushes),
        "touched_share": sum(share > 0.0 for share in means(touched, width)) / (len(touched) - width + 1),
        "held_gap_m": max(means([row["contact_gap_m"] for row in held], width)),
    }


def _kept(metrics: dict[str, float]) -> tuple[Check, ...]:
    """What must hold of the time against the berth."""
    if _MOST_SIGMAS * metrics.get("wave_n", 0.0) <= metrics["held_force_mean_n"]:
        return (Check("share of that time in contact", metrics["held_share"], 0.99, "", at_least=True),)
    return (
        Check(f"share of all {_WAVE_S:g} s with a contact", metrics["touched_share"], 0.99, "", at_least=True),
        Check(f"gap to the fenders, mean of {_WAVE_S:g} s, largest", metrics["held_gap_m"], 0.005, "m"),
    )


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
