"""Station keeping with heading, after a go-to to the point."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from companion.core.angles import wrap_pi
from sitl.scenarios.boat import sideways
from sitl.scenarios.ground_station import BACK_S, GroundStation
from sitl.scenarios.measure import Check, between, distance_to, read_truth, receiver_error_m, rms
from sitl.scenarios.scenario import Scenario, Settings, number

_SETTLE_S = 30.0
_LIMIT_M = 0.15


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Hold at home with the heading of the start. A command sets the point, so that the metrics include errors of the
    estimate."""
    gcs.hold_at_home(_SETTLE_S, BACK_S)
    from_s = gcs.rig.now_s
    gcs.sail(number(settings, "time"))
    return {"from_s": from_s, "to_s": gcs.rig.now_s, "yaw_rad": gcs.rig.config.home.yaw_rad}


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Position and heading errors from what the command asked for."""
    track = between(read_truth(folder), asked["from_s"], asked["to_s"])
    distances = [distance_to(row, 0.0, 0.0) for row in track]
    headings = [math.degrees(wrap_pi(row["yaw_rad"] - asked["yaw_rad"])) for row in track]
    metrics = {
        "position_rms_m": rms(distances),
        "position_max_m": max(distances),
        "heading_rms_deg": rms(headings),
        "heading_max_deg": max(abs(heading) for heading in headings),
    }
    limit_m = _LIMIT_M + receiver_error_m(settings["gnss"])
    checks = (
        Check("position RMS", metrics["position_rms_m"], limit_m, "m"),
        Check("heading RMS", metrics["heading_rms_deg"], 2.0, "deg"),
    )
    return metrics, checks


SCENARIO = Scenario(
    name="hold",
    text="station keeping with heading, in wind with gusts",
    vessel="revolt",
    defaults={"time": "300", "wind": "2", "current": "", "gnss": "rtk", "waves": "", "model_error": "", "plant": ""},
    by_vessel={"aboat": {"gnss": "sbas"}},
    needs=(sideways,),
    sail=sail,
    measure=measure,
)
