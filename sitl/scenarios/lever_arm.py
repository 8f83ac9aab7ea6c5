"""A turn of 90° on the spot: a wrong antenna position would show as an error that turns with the hull."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from companion.core.angles import wrap_pi
from sitl.scenarios.boat import turning
from sitl.scenarios.ground_station import GroundStation
from sitl.scenarios.measure import Check, EstimateError, estimate_errors, receiver_error_m, rms
from sitl.scenarios.scenario import Scenario, Settings, number

_HEADING = 0x00070000
_TURN_RAD = math.pi / 2.0
_TURN_S = 50.0
_LIMIT_M = 0.02
_WHOLE_M = 0.05  # limit of the estimate's whole error, with the receiver's slow error
_CHANGES = 0.3  # share of the slow error that changes with the heading by chance: below √(1 − exp(−30 s / 150 s)), SBAS


def sail(gcs: GroundStation, settings: Settings) -> dict[str, Any]:
    """Hold at home and turn by 90°."""
    home = gcs.rig.config.home
    gcs.hold_at_home(number(settings, "settle"))
    from_s = gcs.rig.now_s
    gcs.sail(5.0)
    if gcs.rig.config.limits.sway_n > 0.0:
        gcs.reposition(home.lat_deg, home.lon_deg, home.yaw_rad + _TURN_RAD)
        gcs.sail(_TURN_S)
    else:
        _turn_by_stick(gcs)
    return {"from_s": from_s}


def _turn_by_stick(gcs: GroundStation) -> None:
    """Turn in mode Heading: in Hold a boat without sideways thrust lies with its bow in the weather."""
    to_rad = gcs.rig.world.truth.yaw_rad + _TURN_RAD
    _helm(gcs, 0.0)  # sticks take control only from the middle
    gcs.set_mode(_HEADING)
    _helm(gcs, 0.0)
    gcs.step()
    until_s = gcs.rig.now_s + _TURN_S
    while gcs.rig.now_s < until_s:
        _helm(gcs, wrap_pi(to_rad - gcs.rig.world.truth.yaw_rad))
        gcs.step()


def _helm(gcs: GroundStation, share: float) -> None:
    """Hold the yaw stick; the others are centred."""
    gcs.send(mavlink.MAVLink_manual_control_message(1, 0, 0, 0, round(1000.0 * min(1.0, max(-1.0, share))), 0))


def measure(folder: Path, asked: dict[str, Any], settings: Settings) -> tuple[dict[str, float], Sequence[Check]]:
    """The part of the estimate's error that turns with the hull, and the whole error."""
    errors = estimate_errors(folder, asked["from_s"])
    ahead, starboard = body_fixed(errors)
    distances = [error.distance_m for error in errors]
    steps = (wrap_pi(b.yaw_rad - a.yaw_rad) for a, b in itertools.pairwise(errors))
    yaws = [*itertools.accumulate(steps, initial=0.0)]
    turned = math.degrees(max(yaws) - min(yaws))
    metrics = {
        "lever_arm_error_m": math.hypot(ahead, starboard),
        "estimate_error_rms_m": rms(distances),
        "estimate_error_max_m": max(distances),
        "turned_deg": turned,
    }
    slow_m = receiver_error_m(settings["gnss"])
    checks = (
        Check("the boat has turned", turned, 85.0, "deg", at_least=True),
        Check("error that turns with the hull", metrics["lever_arm_error_m"], _LIMIT_M + _CHANGES * slow_m, "m"),
        Check("estimate error", metrics["estimate_error_max_m"], _WHOLE_M + slow_m, "m"),
    )
    return metrics, checks


def body_fixed(errors: Sequence[EstimateError]) -> tuple[float, float]:
    """(x, y) of the error that is fixed in the hull; another part, fixed in NED, is the receiver's slow error."""
    import numpy as np

    rows, values = [], []
    for error in errors:
        c, s = math.cos(error.yaw_rad), math.sin(error.yaw_rad)
        rows += [(1.0, 0.0, c, -s), (0.0, 1.0, s, c)]
        values += [error.north_m, error.east_m]
    solution, *_ = np.linalg.lstsq(np.array(rows), np.array(values), rcond=None)
    return float(solution[2]), float(solution[3])


SCENARIO = Scenario(
    name="lever_arm",
    text="a turn of 90° while holding, judged by the part of the estimate's error that turns with the hull",
    vessel="revolt",
    defaults={"wind": "2", "current": "", "gnss": "rtk", "waves": "", "model_error": "", "settle": "40"},
    needs=(turning,),
    sail=sail,
    measure=measure,
    lasts_s=100.0,
)
