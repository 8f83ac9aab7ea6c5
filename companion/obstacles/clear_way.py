"""How far the boat can go straight ahead before it is too near to something."""

from __future__ import annotations

import math

import numpy as np

from companion.config.reversing import turns_in_place
from companion.config.vessel import VesselConfig
from companion.obstacles.occupancy import Floats
from companion.params.store import Parameters

GRAZE_M = 0.3  # by which a way that is already sailed may come nearer than planned
STOP_SHARE = 0.3  # of CP_DIST, beside `reach_m`: the boat stops that far from an obstacle


def reach_m(config: VesselConfig) -> float:
    """From the middle of the boat to what of it may come near: a corner of the hull, where it turns in place; the bow,
    where it goes on as it turns, for which it keeps room (`RoomToHold`)."""
    across_m = config.beam_m if turns_in_place(config.thrusters) else 0.0
    return 0.5 * math.hypot(config.length_m, across_m)


def stop_m(parameters: Parameters) -> float:
    """Water between `reach_m` and an obstacle at which the boat stops."""
    return STOP_SHARE * max(0.0, parameters["CP_DIST"])


def clear_way_m(here: tuple[float, float], along: tuple[float, float], circles: Floats, keep_m: float) -> float:
    """Way in m from `here` in the direction of the unit vector `along` (north, east) until the place is `keep_m` from
    one of the circles (north_m, east_m, radius_m); infinite where that never happens, 0 where it is nearer already and
    the way leads on towards it."""
    if not len(circles):
        return math.inf
    keep = keep_m + circles[:, 2]
    north, east = circles[:, 0] - here[0], circles[:, 1] - here[1]
    ahead = north * along[0] + east * along[1]
    beside = np.abs(along[0] * east - along[1] * north)
    meets = (ahead > 0.0) & (beside < keep)
    if not meets.any():
        return math.inf
    ways = ahead[meets] - np.sqrt(keep[meets] ** 2 - beside[meets] ** 2)
    return max(0.0, float(ways.min()))
