"""Where the boat comes to rest if it slows down within its own limits."""

from __future__ import annotations

import math

from companion.core.frames import body_to_ned
from companion.core.types import NavState
from companion.params import Parameters

SMOOTHING_S = 1.5  # over which the reference smooths its acceleration, and so the time by which it lags
BRAKE_SHARE = 0.85  # share of the acceleration limits that braking counts on; the rest is for corrections


def stopping_time_s(surge_mps: float, sway_mps: float, yaw_rate_radps: float, parameters: Parameters) -> float:
    """Time in which all three axes come to rest together, the slowest one braking at BRAKE_SHARE of its limit."""
    return max(
        abs(surge_mps) / (BRAKE_SHARE * parameters["DP_ACC_SURGE"]),
        abs(sway_mps) / (BRAKE_SHARE * parameters["DP_ACC_SWAY"]),
        abs(yaw_rate_radps) / (BRAKE_SHARE * math.radians(parameters["DP_ACC_YAW"])),
    )


def stopping_point(nav: NavState, parameters: Parameters) -> tuple[float, float]:
    """(north_m, east_m) where the boat rests after braking straight on from its present velocity over ground, as the reference does."""
    half = 0.5 * (SMOOTHING_S + stopping_time_s(nav.surge_mps, nav.sway_mps, 0.0, parameters))
    north_mps, east_mps = body_to_ned(nav.surge_mps, nav.sway_mps, nav.yaw_rad)
    return nav.north_m + north_mps * half, nav.east_m + east_mps * half
