"""How fast the boat may go so that it stops inside the fence."""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.core.types import NavState
from companion.guidance.fence_area import FenceArea
from companion.params import Parameters

_CREEP_MPS = 0.05  # at which the boat may still near the line from where it should stand
_CREEP_SHARE = 0.5  # of the way from there to the fence
_SLOW_MPS = 0.1  # below it the course over ground says little, and the demand says where the boat will go
_LAG = 1.5  # times 1/PATH_BW_SURGE: from the demand for less speed to the boat's obeying
_SIGMAS = 2.0


@dataclass(frozen=True, slots=True)
class SpeedLimit:
    """Highest speed over ground in the direction in which the boat goes, and the braking that keeps to it as the line comes nearer."""

    speed_mps: float
    braking_mps2: float = 0.0


NO_LIMIT = SpeedLimit(math.inf)


@dataclass(frozen=True, slots=True)
class FenceAreas:
    """`fence`: where the boat may be; `stopping`: where its middle may stand, half a boat's length further in; `keeping`: where plans
    may lead, further in by FENCE_MARGIN."""

    fence: FenceArea
    stopping: FenceArea
    keeping: FenceArea


def speed_to_stop_in(way_m: float, deceleration_mps2: float, lag_s: float) -> float:
    """Speed from which the boat stops within `way_m`: v t + v²/2a = way."""
    if math.isinf(way_m):
        return math.inf
    a, t = deceleration_mps2, lag_s
    return a * (math.sqrt(t * t + 2.0 * max(0.0, way_m) / a) - t)


def speed_limit(areas: FenceAreas, nav: NavState, demand: tuple[float, float], parameters: Parameters) -> SpeedLimit:
    """`demand`: where the setpoint sends the boat, in NED, of any length.

    Braking straight on along the course over ground at PATH_ACC must end where the boat may stand, less twice the position's accuracy.
    Between there and the fence the boat may creep outwards, ever slower, and move along; outside the fence it may only come back. A demand
    against the course is braking itself, and counts by where it leads.
    """
    size = math.hypot(*demand)
    north, east = nav.north_mps, nav.east_mps
    if size > 0.0:
        pull_n, pull_e = demand[0] / size, demand[1] / size
        if north * pull_n + east * pull_e <= 0.0:
            north, east = pull_n, pull_e
        elif math.hypot(north, east) < _SLOW_MPS:
            north, east = north + _SLOW_MPS * pull_n, east + _SLOW_MPS * pull_e
    speed = math.hypot(north, east)
    if speed < 1.0e-6:
        return NO_LIMIT
    north, east = north / speed, east / speed
    reserve_m = _SIGMAS * nav.position_accuracy_m
    edge = areas.stopping.margin(nav.north_m, nav.east_m)
    if edge.distance_m > reserve_m:
        deceleration, lag = parameters["PATH_ACC"], _LAG / parameters["PATH_BW_SURGE"]
        way_m = areas.stopping.way_to_line_m(nav.north_m, nav.east_m, north, east) - reserve_m
        limit = speed_to_stop_in(way_m, deceleration, lag)
        if limit > _CREEP_MPS:
            return SpeedLimit(limit, deceleration * limit / (deceleration * lag + limit) if math.isfinite(limit) else 0.0)
        return SpeedLimit(_CREEP_MPS)
    near = areas.fence.margin(nav.north_m, nav.east_m)
    if near.distance_m <= 0.0:
        inwards = (demand[0] * near.north + demand[1] * near.east) > 0.0 or size == 0.0
        return NO_LIMIT if inwards else SpeedLimit(0.0)
    closing = north * near.north + east * near.east
    if closing <= 0.0:
        return NO_LIMIT
    room_m = near.distance_m - edge.distance_m  # all of it belongs to the hull; half of it is left to creep in
    share = 1.0 - (reserve_m - edge.distance_m) / max(1.0e-6, _CREEP_SHARE * room_m)
    return SpeedLimit(_CREEP_MPS * max(0.0, share) / closing)


def fitted_speed_mps(areas: FenceAreas, nav: NavState, stopping_way_m: float, lag_s: float) -> float:
    """Speed from which a stop planned over `stopping_way_m` from the present speed, its first part the lag, would end inside; the present
    speed where it does."""
    speed = math.hypot(nav.north_mps, nav.east_mps)
    if speed < _SLOW_MPS or not areas.fence.contains(nav.north_m, nav.east_m):
        return speed
    north, east = nav.north_mps / speed, nav.east_mps / speed
    if areas.stopping.contains(nav.north_m, nav.east_m):
        way_m = areas.stopping.way_to_line_m(nav.north_m, nav.east_m, north, east) - _SIGMAS * nav.position_accuracy_m - lag_s * speed
    else:
        near = areas.fence.margin(nav.north_m, nav.east_m)
        way_m = 0.0 if north * near.north + east * near.east > 0.0 else math.inf
    if way_m >= stopping_way_m:
        return speed
    deceleration = speed * speed / (2.0 * max(0.05, stopping_way_m - lag_s * speed))
    return min(speed, speed_to_stop_in(way_m, deceleration, lag_s))
