"""Dock onto the vessel's own berth in wind: to the standoff point, alongside, and hold there.

In a sea, waves move the hull to and fro. Where keeping it from that takes more force than the boat pushes with, no law
keeps the fenders pressed all the time: then it is judged that each wave brings the boat back to them, and that it lies
there in the mean. A boat may also find the waves too strong for its push. Then it must say so and stand off, and it is
judged that the waves are, and that it stays clear of the berth.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

from companion.core.angles import wrap_pi
from sitl.berth import fender
from sitl.scenarios.boat import berth, sideways
from sitl.scenarios.ground_station import GroundStation, GroundStationTimeout
from sitl.scenarios.measure import Check, Track, between, means, read_truth, rms
from sitl.scenarios.scenario import Scenario, Settings
from sitl.sea import Sea

_DOCK = 0x06040000
_TIMEOUT_S = 360.0  # and what the way from the standoff point takes at the usual speed
_ALONGSIDE_MPS = 0.05
_HOLD_S = 32.0
_FREE_S = 40.0  # before the first touch, in which the waves' motion is measured: as long as it is judged
_WAVE_S = 2.0  # longer than the waves that move such a boat; slower motion is its own
_MOST_SIGMAS = 2.33  # one wave in a hundred asks for more, with the RMS force as sigma
_CORNERS = 2  # that a hull alongside presses into the fenders
_CLEAR_M = 1.0
_TOO_STRONG = 0.3  # least force of the waves for which a boat may stand off, over its limit: its weaker side, less wind


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Choose Dock and arm; wait until the boat announces that it is docked, or in a sea that the waves are too strong;
    then half a minute more."""
    config = gcs.rig.config
    dock = config.dock
    assert dock is not None
    gcs.ready()
    gcs.set_mode(_DOCK)
    gcs.arm()
    from_s = gcs.rig.now_s
    within_s = _TIMEOUT_S + dock.standoff_m / _ALONGSIDE_MPS
    ends = ("Docked", "Docking given up")
    gcs.wait("docked", lambda: any(text.startswith(ends) for text in gcs.texts), within_s)
    docked_s = gcs.rig.now_s
    sea = isinstance(gcs.rig.world.waves, Sea)
    given_up = next((text for text in gcs.texts if text.startswith("Docking given up")), "")
    if given_up and not (sea and "waves" in given_up):
        raise GroundStationTimeout(given_up)
    gcs.sail(_HOLD_S)
    return {
        "from_s": from_s, "docked_s": docked_s, "to_s": gcs.rig.now_s, "yaw_rad": dock.yaw_rad,
        "inertia_kg": config.hull.m22_kg, "sea": sea, "stands_off": bool(given_up), "most_n": config.limits.sway_n,
    }  # fmt: skip


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Speeds at contact, rebound, and how it holds against the berth; or how it stands off."""
    track = between(read_truth(folder), asked["from_s"], asked["to_s"])
    if asked["stands_off"]:
        return _off_the_berth(track, asked)
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
        Check("from docked to the last contact", _touched_s(held), 30.0, "s", at_least=True),
        *_kept(metrics, asked["inertia_kg"]),
    )


def _touched_s(held: Track) -> float:
    """Time from the first row to the last one with a contact; 0 without one."""
    return max((row["t_s"] - held[0]["t_s"] for row in held if row["contact_n"] > 0.0), default=0.0)


def _off_the_berth(track: Track, asked: dict[str, Any]) -> tuple[dict[str, float], Sequence[Check]]:
    """A boat that has found the waves too strong."""
    waited = between(track, asked["docked_s"] - _FREE_S)
    metrics = {
        **_waves(waited, asked["inertia_kg"]),
        "least_gap_m": min(row["contact_gap_m"] for row in track),
        "stood_off": 1.0,
        "time_s": asked["docked_s"] - asked["from_s"],
    }
    return metrics, (
        Check("force of the waves (rms)", metrics["wave_n"], _TOO_STRONG * asked["most_n"], "N", at_least=True),
        Check("least distance from the fenders", metrics["least_gap_m"], _CLEAR_M, "m", at_least=True),
    )  # fmt: skip


def _in_sea(free: Track, held: Track, inertia_kg: float) -> dict[str, float]:
    """The waves' motion before the first touch, the boat's own speed sideways at that touch, and how it lies against
    the fenders without that motion."""
    free = between(free, free[-1]["t_s"] - _FREE_S)
    width = _wave_rows(free)
    touched = [float(row["contact_n"] > 0.0) for row in held]
    return {
        **_waves(free, inertia_kg),
        "contact_own_mps": abs(means([row["sway_mps"] for row in free], width)[-1]),
        "touched_share": sum(share > 0.0 for share in means(touched, width)) / (len(touched) - width + 1),
        "held_gap_m": max(means([row["contact_gap_m"] for row in held], width)),
        "stood_off": 0.0,
    }


def _waves(free: Track, inertia_kg: float) -> dict[str, float]:
    """RMS of the waves' motion sideways, and of the force that would keep the hull from it."""
    width, step_s = _wave_rows(free), _step_s(free)
    speeds = [row["sway_mps"] for row in free]
    waves = [speed - mean for speed, mean in zip(speeds[width // 2 :], means(speeds, width), strict=False)]
    pushes = [inertia_kg * (b - a) / step_s for a, b in pairwise(waves)]
    return {"wave_mps": rms(waves), "wave_n": rms(pushes)}


def _step_s(track: Track) -> float:
    return float(track[-1]["t_s"] - track[0]["t_s"]) / (len(track) - 1)


def _wave_rows(track: Track) -> int:
    return round(_WAVE_S / _step_s(track))


def _fender_gain(inertia_kg: float) -> float:
    """Force between hull and fenders over the force that would keep the hull from the waves' motion, for waves at the
    fenders' own frequency: they are a spring and a damper, and a sea has waves of all frequencies near its own."""
    stiffness_npm, damping_nspm = fender(inertia_kg)
    damping = _CORNERS * damping_nspm / (2.0 * math.sqrt(_CORNERS * stiffness_npm * inertia_kg))
    return math.hypot(1.0, 2.0 * damping) / (2.0 * damping)


def _kept(metrics: dict[str, float], inertia_kg: float) -> tuple[Check, ...]:
    """What must hold of the time against the berth."""
    if _MOST_SIGMAS * _fender_gain(inertia_kg) * metrics.get("wave_n", 0.0) <= metrics["held_force_mean_n"]:
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
    needs=(sideways, berth),
    sail=sail,
    measure=measure,
    lasts_s=210.0,
)
