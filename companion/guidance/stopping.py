"""Time and place in which the boat comes to rest within its acceleration limits."""

from __future__ import annotations

import math

from companion.core.estimate import NavState
from companion.core.frames import body_to_ned
from companion.params.store import Parameters

SMOOTHING_S = 1.5  # window of the reference's moving average, and so its lag
BRAKE_SHARE = 0.85  # share of the acceleration limits that braking uses; the rest is for corrections
_CREEP_SHARE = 0.1  # of WP_SPEED


def creep_mps(parameters: Parameters) -> float:
    """Lowest speed of approach: slower, a boat never reaches the end of its way."""
    return _CREEP_SHARE * parameters["WP_SPEED"]


def stopping_time_s(surge_mps: float, sway_mps: float, yaw_rate_radps: float, parameters: Parameters) -> float:
    """Time in which all three axes come to rest together; the slowest one brakes at BRAKE_SHARE of its DP_ACC_*
    limit."""
    return max(
        abs(surge_mps) / (BRAKE_SHARE * parameters["DP_ACC_SURGE"]),
        abs(sway_mps) / (BRAKE_SHARE * parameters["DP_ACC_SWAY"]),
        abs(yaw_rate_radps) / (BRAKE_SHARE * math.radians(parameters["DP_ACC_YAW"])),
    )


def stopping_point(nav: NavState, parameters: Parameters) -> tuple[float, float]:
    """(north_m, east_m) where the boat comes to rest if it brakes from its velocity over ground as the reference
    does."""
    half = 0.5 * (SMOOTHING_S + stopping_time_s(nav.surge_mps, nav.sway_mps, 0.0, parameters))
    north_mps, east_mps = body_to_ned(nav.surge_mps, nav.sway_mps, nav.yaw_rad)
    return nav.north_m + north_mps * half, nav.east_m + east_mps * half
