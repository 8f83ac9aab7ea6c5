"""A boat without a compass: the estimator finds the heading by the boat's motion, and Hold goes by that.

At rest for a while, when waves may be enough; then pushed ahead and astern in Manual until the heading is found; then
Hold.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.config.vessel import VesselConfig, find, load
from companion.core.angles import wrap_pi
from sitl.scenarios.follow_measure import columns
from sitl.scenarios.ground_station import GroundStation, GroundStationTimeout
from sitl.scenarios.measure import Check, between, read_truth, rms
from sitl.scenarios.rig import Conditions
from sitl.scenarios.scenario import Scenario, Settings, number

_MANUAL, _HOLD = 0x00010000, 0x03040000
_FOUND = ("Heading source: motion", "Heading source: course over ground")  # a fast boat steers by its course
_LOST = "Heading lost"
_PATIENCE_S = 120.0  # of pushing
_HEADING_DEG = 15.0  # as far as Hold may be misled
_HONEST_SIGMA = 3.0  # a heading that is lost, in calm water, is no failure where that is said in time


def without_compass(vessel: VesselConfig) -> VesselConfig:
    """The same vessel, with one antenna on each receiver and no compass."""
    return replace(vessel, sensors=tuple(replace(row, antennas=1, heading="none") for row in vessel.sensors))


def prepare(conditions: Conditions, settings: Settings) -> Conditions:
    """The vessel without its compass."""
    return replace(conditions, known=without_compass(load(find(conditions.vessel))))


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Rest, push where that was not enough, hold."""
    gcs.set_parameter("ARM_NEED_POS", 0.0)
    from_s = gcs.rig.now_s
    while gcs.rig.now_s < from_s + number(settings, "rest") and not found(gcs):
        gcs.step()
    pushed_s = gcs.rig.now_s
    gcs.set_mode(_MANUAL)
    _push(gcs, 0)
    gcs.step()
    gcs.arm()
    _push_to_and_fro(gcs, number(settings, "push"))
    found_s = gcs.rig.now_s
    gcs.set_mode(_HOLD)
    gcs.sail(number(settings, "hold"))
    return {
        "from_s": from_s,
        "pushed_s": found_s - pushed_s,
        "found_s": found_s,
        "lost": sum(text.startswith(_LOST) for text in gcs.texts),
    }


def found(gcs: GroundStation) -> bool:
    """Whether the boat has said by what it knows its heading now."""
    return any(text.startswith(_FOUND) for text in gcs.texts)


def _push_to_and_fro(gcs: GroundStation, push_s: float) -> None:
    """Push ahead and astern in turn until the heading is found."""
    begin_s = gcs.rig.now_s
    while not found(gcs):
        if gcs.rig.now_s > begin_s + _PATIENCE_S:
            raise GroundStationTimeout(f"no heading after {_PATIENCE_S:g} s; last texts: {gcs.texts[-3:]}")
        ahead = (gcs.rig.now_s - begin_s) % (2.0 * push_s) < push_s
        _push(gcs, 1000 if ahead else -1000)
        gcs.step()
    _push(gcs, 0)


def _push(gcs: GroundStation, surge: int) -> None:
    gcs.send(mavlink.MAVLink_manual_control_message(1, surge, 0, 0, 0, 0))


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """When the heading was found, how wrong it was then and while holding, also in sigmas, and how far Hold drifts."""
    truth = between(read_truth(folder), asked["found_s"])
    ticks = columns(folder / "ticks.csv", "t_s", "yaw_rad", "heading_accuracy_rad")
    known = {round(t_s, 3): k for k, t_s in enumerate(ticks["t_s"])}
    errors, sigmas = [], []
    for row in truth:
        k = known.get(round(row["t_s"], 3))
        if k is not None:
            errors.append(abs(math.degrees(wrap_pi(ticks["yaw_rad"][k] - row["yaw_rad"]))))
            sigmas.append(errors[-1] / math.degrees(ticks["heading_accuracy_rad"][k]))
    away = [math.hypot(row["north_m"] - truth[0]["north_m"], row["east_m"] - truth[0]["east_m"]) for row in truth]
    metrics = {
        "found_after_s": asked["found_s"] - asked["from_s"],
        "pushed_s": asked["pushed_s"],
        "first_error_deg": errors[0],
        "heading_rms_deg": rms(errors),
        "heading_max_deg": max(errors),
        "heading_max_sigma": max(sigmas),
        "away_max_m": max(away),
        "lost": float(asked["lost"]),
    }
    checks = (
        Check("largest error of heading while it holds", metrics["heading_max_deg"], _HEADING_DEG, "deg"),
        Check("the same in sigmas", metrics["heading_max_sigma"], _HONEST_SIGMA, ""),
    )
    return metrics, checks


SCENARIO = Scenario(
    name="no_compass",
    text="no compass: the heading is found by the boat's motion at rest or in pushes, and held by",
    vessel="revolt",
    defaults={
        "rest": "30",
        "push": "5",
        "hold": "120",
        "wind": "2",
        "current": "",
        "gnss": "rtk",
        "waves": "",
    },
    sail=sail,
    measure=measure,
    prepare=prepare,
    lasts_s=240.0,
)
