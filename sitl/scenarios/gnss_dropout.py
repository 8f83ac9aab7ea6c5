"""The receiver gives nothing for 2, 5 and 12 s, while the boat holds or sails along a square."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.core.geodesy import LocalFrame
from sitl.scenarios.ground_station import GroundStation, Item
from sitl.scenarios.measure import Check, estimate_errors, receiver_error_m
from sitl.scenarios.scenario import Scenario, ScenarioError, Settings, number

_MISSION = 0x04040000
_LIMITS_M = {2.0: 0.2, 5.0: 0.3, 12.0: 1.2}
_AFTER_S = 3.0
_SPIKE_MPS = 0.3
_PATIENCE_S = 20.0  # FS_POS_T, so that no failsafe ends the run
_SIDE_M = 40.0


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Hold or sail for `settle` seconds, in which the filter learns its biases, and let the receiver drop out three
    times, `pause` seconds apart."""
    settle_s, pause_s = number(settings, "settle"), number(settings, "pause")
    gcs.ready()
    gcs.set_parameter("FS_POS_T", _PATIENCE_S)
    if settings["while"] == "holding":
        gcs.hold_at_home(settle_s)
    elif settings["while"] == "sailing":
        _begin_square(gcs)
        gcs.sail(settle_s)
    else:
        raise ScenarioError(f"while={settings['while']}: holding or sailing")
    dropouts = []
    for duration_s in _LIMITS_M:
        from_s = gcs.rig.now_s
        gcs.rig.world.add_fault("gnss_lost", duration_s)
        dropouts.append((duration_s, from_s))
        gcs.sail(duration_s + (pause_s if len(dropouts) < len(_LIMITS_M) else _AFTER_S + 1.0))
    return {"dropouts": dropouts}


def _begin_square(gcs: GroundStation) -> None:
    home = gcs.rig.config.home
    frame = LocalFrame(home.lat_deg, home.lon_deg)
    corners = ((_SIDE_M, 0.0), (_SIDE_M, _SIDE_M), (0.0, _SIDE_M), (0.0, 0.0))
    gcs.upload([Item(mavlink.MAV_CMD_NAV_WAYPOINT, *frame.to_geodetic(*corner)) for corner in corners])
    gcs.set_mode(_MISSION)
    gcs.arm()


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """Errors of the estimate during and after each dropout."""
    metrics: dict[str, float] = {}
    checks: list[Check] = []
    for duration_s, from_s in asked["dropouts"]:
        end_s = from_s + duration_s
        errors = estimate_errors(folder, from_s, end_s + _AFTER_S)
        after = [error.speed_mps for error in errors if error.t_s > end_s]
        name = f"dropout_{duration_s:g}s"
        metrics[f"{name}_error_m"] = max(error.distance_m for error in errors)
        metrics[f"{name}_after_mps"] = max(after)
        limit_m = _LIMITS_M[duration_s] + receiver_error_m(settings["gnss"])
        text = f"estimate error, dropout of {duration_s:g} s"
        checks.append(Check(text, metrics[f"{name}_error_m"], limit_m, "m"))
        checks.append(Check(f"velocity error after {duration_s:g} s", metrics[f"{name}_after_mps"], _SPIKE_MPS, "m/s"))
    between_s = [(from_s - 10.0, from_s) for _, from_s in asked["dropouts"]]
    normal = [error.distance_m for span in between_s for error in estimate_errors(folder, *span)]
    metrics["normal_rms_m"] = math.sqrt(sum(distance * distance for distance in normal) / len(normal))
    return metrics, checks


SCENARIO = Scenario(
    name="gnss_dropout",
    text="dropouts of the receiver of 2, 5 and 12 s, judged by the error of the estimate",
    vessel="revolt",
    defaults={
        "wind": "2",
        "current": "",
        "gnss": "rtk",
        "waves": "",
        "model_error": "",
        "while": "holding",
        "settle": "60",
        "pause": "40",
    },
    sail=sail,
    measure=measure,
    lasts_s=165.0,
)
