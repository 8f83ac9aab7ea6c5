"""The speed limit at which the boat still stops inside the fence."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from companion.core.estimate import NavState
from companion.params.store import Parameters

if TYPE_CHECKING:
    from companion.fence.area import FenceArea, Margin
    from companion.fence.areas import FenceAreas

Place = tuple[float, float]

_CREEP_MPS = 0.05  # allowed up to the edge of the stopping area, however inaccurate the position is
_CREEP_LAGS = 4.0  # time constant of the way to that edge, in delays of the speed: from 4 on none is overshot
_SLOW_MPS = 0.1  # below it the course over ground is uncertain, and the demand tells where the boat will go
_LAG = 1.5  # times 1/PATH_BW_SURGE: delay of the boat's speed behind its demand
_ASIDE_COS = 0.7  # of the angle between the course and the way to the nearest line: beyond it both count
_INSIDE_M = 1.0e-3  # a place so far beyond an edge is surely inside
_STRAIGHT_OUT = 0.05  # share of the way along the line, below which the boat goes straight out
SIGMAS = 2.0
"""Of the position, that are kept to spare."""


@dataclass(frozen=True, slots=True)
class SpeedLimit:
    """Highest speed over ground along `way` (a unit vector, NED), and the deceleration that keeps to it as the line
    comes nearer."""

    speed_mps: float
    braking_mps2: float = 0.0
    way: tuple[float, float] = (0.0, 0.0)


NO_LIMIT = SpeedLimit(math.inf)


def speed_to_stop_in(way_m: float, deceleration_mps2: float, lag_s: float) -> float:
    """Speed from which the boat stops within `way_m`: v t + v²/2a = way, with lag t and deceleration a."""
    if math.isinf(way_m):
        return math.inf
    a, t = deceleration_mps2, lag_s
    return a * (math.sqrt(t * t + 2.0 * max(0.0, way_m) / a) - t)


def speed_limit(areas: FenceAreas, nav: NavState, demand: tuple[float, float], parameters: Parameters) -> SpeedLimit:
    """The limit for a boat that the setpoint sends in the direction of `demand` (NED, of any length).

    Inside the stopping area, braking at PATH_ACC straight along the course over ground must end in there, with twice
    the position's accuracy to spare. Nearer to its edge the boat may creep outwards, ever slower, and beyond it move
    along the line or inwards, as fast as it still stops inside of the line that comes next. Outside the fence it may
    only come back. A demand against the course is braking; then the direction of the demand counts.
    """
    way = direction(nav, demand)
    if way is None:
        return NO_LIMIT
    reserve_m = SIGMAS * nav.position_accuracy_m
    edge = areas.stopping.margin(nav.north_m, nav.east_m)
    if edge.distance_m > reserve_m:
        way_m = areas.stopping.way_to_line_m(nav.north_m, nav.east_m, *way)
        return _stopping(way_m - reserve_m, way, edge.distance_m, parameters)
    creep = _creep_mps(edge.distance_m, parameters)
    near = areas.fence.margin(nav.north_m, nav.east_m)
    if near.distance_m <= 0.0:
        inwards = (demand[0] * near.north + demand[1] * near.east) > 0.0 or math.hypot(*demand) == 0.0
        return NO_LIMIT if inwards else SpeedLimit(0.0, way=way)
    next_line = _next_line(areas.stopping, nav, way, (edge.distance_m, near), parameters)
    closing = way[0] * near.north + way[1] * near.east
    return min(SpeedLimit(creep / closing, way=way), next_line, key=_speed) if closing > 0.0 else next_line


def _next_line(
    stopping: FenceArea, nav: NavState, way: Place, nearest: tuple[float, Margin], parameters: Parameters
) -> SpeedLimit:
    """The limit of a boat that lies too near to one line, by what else lies on its way."""
    reserve_m = SIGMAS * nav.position_accuracy_m
    way_m, share = way_to_next_line_m(stopping, (nav.north_m, nav.east_m), way, nearest, reserve_m)
    if share < _STRAIGHT_OUT:
        return NO_LIMIT
    found = _stopping(way_m - reserve_m, way, nearest[0], parameters)
    return SpeedLimit(found.speed_mps / share, found.braking_mps2 / share, way)


def way_to_next_line_m(
    area: FenceArea, place: Place, way: Place, nearest: tuple[float, Margin], reserve_m: float
) -> tuple[float, float]:
    """How far a boat that is not `reserve_m` inside an area may go beside the line there, until the edge that comes
    next, and the share of its way that leads along: what of it leads out over that line does not count. As from a place
    so far in that this line leaves it free. 0 where it is beyond the edge of another line too, and goes on out.
    `nearest`: distance to the edge of the area, and the margin to the line itself."""
    edge_m, near = nearest
    beyond_m = max(0.0, -edge_m) + _INSIDE_M
    closing = max(0.0, way[0] * near.north + way[1] * near.east)
    along = way[0] - closing * near.north, way[1] - closing * near.east
    share = max(1.0e-9, math.hypot(*along))
    course = along[0] / share, along[1] / share
    begin = _inwards(place, near, beyond_m)
    if not area.contains(*begin):
        back = area.margin(*begin)
        return (math.inf if course[0] * back.north + course[1] * back.east >= 0.0 else 0.0), share
    wide_m = area.way_to_line_m(*begin, -near.north, -near.east)
    begin = _inwards(begin, near, min(max(0.0, reserve_m - edge_m - beyond_m), 0.5 * wide_m))
    return area.way_to_line_m(*begin, *course), share


def _inwards(place: Place, near: Margin, by_m: float) -> Place:
    return place[0] - by_m * near.north, place[1] - by_m * near.east


def _speed(limit: SpeedLimit) -> float:
    return limit.speed_mps


def closing_limits(
    areas: FenceAreas,
    nav: NavState,
    demand: tuple[float, float],
    way: tuple[float, float],
    parameters: Parameters,
) -> list[SpeedLimit]:
    """The limit towards the nearest line, where a boat goes along it on `way` while its demand pushes it aside, out: a
    light boat turns its course within a moment. None in other cases, and none outside the fence."""
    edge = areas.stopping.margin(nav.north_m, nav.east_m)
    out = edge if edge.distance_m > 0.0 else areas.fence.margin(nav.north_m, nav.east_m)
    outwards = demand[0] * out.north + demand[1] * out.east > 0.0
    if out.distance_m <= 0.0 or not outwards or way[0] * out.north + way[1] * out.east > _ASIDE_COS:
        return []
    way_m = edge.distance_m - SIGMAS * nav.position_accuracy_m
    return [_stopping(way_m, (out.north, out.east), edge.distance_m, parameters)]


def _stopping(way_m: float, way: tuple[float, float], edge_m: float, parameters: Parameters) -> SpeedLimit:
    """From which the boat stops within `way_m` along `way`; no less than it may creep, `edge_m` from the edge."""
    deceleration, lag = parameters["PATH_ACC"], _lag_s(parameters)
    limit, creep = speed_to_stop_in(way_m, deceleration, lag), _creep_mps(edge_m, parameters)
    if limit <= creep:
        return SpeedLimit(creep, way=way)
    braking = deceleration * limit / (deceleration * lag + limit) if math.isfinite(limit) else 0.0
    return SpeedLimit(limit, braking, way)


def _lag_s(parameters: Parameters) -> float:
    return _LAG / parameters["PATH_BW_SURGE"]


def _creep_mps(edge_m: float, parameters: Parameters) -> float:
    return min(_CREEP_MPS, max(0.0, edge_m) / (_CREEP_LAGS * _lag_s(parameters)))


def direction(nav: NavState, demand: tuple[float, float]) -> tuple[float, float] | None:
    """Unit vector (north, east) in which the boat goes, or will go by its demand; None at rest without a demand."""
    size = math.hypot(*demand)
    north, east = nav.north_mps, nav.east_mps
    if size > 0.0:
        pull_n, pull_e = demand[0] / size, demand[1] / size
        if north * pull_n + east * pull_e <= 0.0:
            north, east = pull_n, pull_e
        elif math.hypot(north, east) < _SLOW_MPS:
            north, east = north + _SLOW_MPS * pull_n, east + _SLOW_MPS * pull_e
    speed = math.hypot(north, east)
    return None if speed < 1.0e-6 else (north / speed, east / speed)


def fitted_speed_mps(areas: FenceAreas, nav: NavState, stopping_way_m: float, lag_s: float) -> float:
    """Speed from which a gentle stop would end inside the fence; the present speed where it does.

    `stopping_way_m`: the way that the stop takes from the present speed. `lag_s`: its first part, without braking.
    """
    speed = math.hypot(nav.north_mps, nav.east_mps)
    if speed < _SLOW_MPS or not areas.fence.contains(nav.north_m, nav.east_m):
        return speed
    north, east = nav.north_mps / speed, nav.east_mps / speed
    if areas.stopping.contains(nav.north_m, nav.east_m):
        way_m = (
            areas.stopping.way_to_line_m(nav.north_m, nav.east_m, north, east)
            - SIGMAS * nav.position_accuracy_m
            - lag_s * speed
        )
    else:
        near = areas.fence.margin(nav.north_m, nav.east_m)
        way_m = 0.0 if north * near.north + east * near.east > 0.0 else math.inf
    if way_m >= stopping_way_m:
        return speed
    deceleration = speed * speed / (2.0 * max(0.05, stopping_way_m - lag_s * speed))
    return min(speed, speed_to_stop_in(way_m, deceleration, lag_s))
