"""Detours around other vessels: where the boat will be along a way, how near it then comes to each vessel, and which
detours there are.

All vessels are circles; the others keep course and speed. A detour leaves the route at 45°, runs beside it and comes
back at 45°: an alteration that others can see (COLREG rule 8b). A fast boat leaves it at a smaller angle. The boat's
speed along a way changes with constant acceleration.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from companion.core.estimate import Contact

Place = tuple[float, float]
Floats = NDArray[np.float64]

STEP_S = 1.0
_WIDTHS = (0.5, 0.75, 1.0, 1.25, 1.6, 2.0, 3.0)  # times the room that passing side by side needs
_LENGTHS_M = (25.0, 40.0, 60.0, 85.0, 115.0, 150.0, 200.0, 260.0, 330.0)
_LEAST_S = 60.0  # of way, that the longest of them takes: a fast boat meets others further ahead
_REACH_SHARE = 0.8  # of the longest: a vessel that is met further ahead cannot be passed yet
_SHORTEST_SIDE_M = 5.0  # of the leg beside the route
_COST_OF_LENGTH = 0.1  # of a metre along the route, against a metre of extra way
_COST_OF_PORT_M = 10.0
_AHEAD_REACH = 10.0  # times the distance to keep: further ahead of a vessel, its track may be crossed
_LEG_S = 4.0  # of way, that the legs out and back take: a boat at 8 m/s overshot sharper ones by 10 m


@dataclass(frozen=True, slots=True)
class Detour:
    """Points from the boat to the place where it meets the route again, `length_m` further along the route. `side`: 1
    to starboard, −1 to port, 0 straight back to the route."""

    points: tuple[Place, ...]
    side: int
    length_m: float
    cost_m: float


@dataclass(frozen=True, slots=True)
class SpeedRamp:
    """Speed along a way: from `begin_mps` to `speed_mps` with constant acceleration."""

    begin_mps: float
    speed_mps: float
    acceleration_mps2: float


def first_part(way: Sequence[Place], length_m: float) -> list[Place]:
    """The points of the first `length_m` of a way."""
    points, left = [way[0]], length_m
    for a, b in pairwise(way):
        step = math.dist(a, b)
        if step >= left:
            share = left / step if step > 0.0 else 0.0
            points.append((a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])))
            break
        points.append(b)
        left -= step
    return points


def remainder(way: Sequence[Place], length_m: float) -> list[Place]:
    """The points of a way after its first `length_m`; at least its last point."""
    left = length_m
    for i, (a, b) in enumerate(pairwise(way)):
        step = math.dist(a, b)
        if step > left:
            share = left / step
            return [(a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])), *way[i + 1 :]]
        left -= step
    return [way[-1]]


def thinned(way: Sequence[Place], step_m: float) -> list[Place]:
    """The same way with fewer points, at least `step_m` apart except for the last."""
    points = [way[0]]
    for place in way[1:-1]:
        if math.dist(place, points[-1]) >= step_m:
            points.append(place)
    return [*points, way[-1]] if len(way) > 1 else points


def length_of(way: Sequence[Place]) -> float:
    """Length of a way in m."""
    return sum(math.dist(a, b) for a, b in pairwise(way))


def time_steps(duration_s: float) -> Floats:
    """Times from 0 to `duration_s` in steps of STEP_S, shape (n,)."""
    return np.arange(0.0, duration_s + STEP_S, STEP_S)


def places_along(way: Sequence[Place], ramp: SpeedRamp, t_s: Floats) -> Floats:
    """(north_m, east_m) along `way` at each time, shape (n, 2). At the end of the way the boat stays."""
    change = ramp.speed_mps - ramp.begin_mps
    until = abs(change) / ramp.acceleration_mps2
    early = np.minimum(t_s, until)
    s = (
        ramp.begin_mps * early
        + 0.5 * math.copysign(ramp.acceleration_mps2, change) * early * early
        + ramp.speed_mps * (t_s - early)
    )
    points = np.asarray(way, dtype=float)
    distances = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))))
    return np.column_stack([np.interp(s, distances, points[:, axis]) for axis in (0, 1)])


def clear_water(places: Floats, t_s: Floats, other: Contact, radius_m: float) -> Floats:
    """Distance between the circles of both vessels at each time in m, shape (n,); negative where they overlap.
    `radius_m`: of this boat."""
    north = places[:, 0] - (other.north_m + other.north_mps * t_s)
    east = places[:, 1] - (other.east_m + other.east_mps * t_s)
    gaps: Floats = np.hypot(north, east) - (radius_m + other.radius_m)
    return gaps


def least_clear_water(places: Floats, t_s: Floats, others: Sequence[Contact], radius_m: float) -> float:
    """The least `clear_water` over all times and all other vessels; infinite where there are none."""
    return float(_gaps(places, t_s, others, radius_m).min()) if others else math.inf


def shortfall_ms(places: Floats, t_s: Floats, others: Sequence[Contact], radius_m: float, keep_m: float) -> float:
    """How much `clear_water` is missing to `keep_m`, and for how long: its sum over all times, in m s. Of ways on which
    the others never come nearer than they are, it tells the one that leads away from them."""
    if not others:
        return 0.0
    return STEP_S * float(np.maximum(0.0, keep_m - _gaps(places, t_s, others, radius_m).min(axis=0)).sum())


def _gaps(places: Floats, t_s: Floats, others: Sequence[Contact], radius_m: float) -> Floats:
    """`clear_water` to each of the others, shape (others, n)."""
    fleet = np.array([(c.north_m, c.east_m, c.north_mps, c.east_mps, c.radius_m) for c in others])[:, :, None]
    north = places[:, 0] - (fleet[:, 0] + fleet[:, 2] * t_s)
    east = places[:, 1] - (fleet[:, 1] + fleet[:, 3] * t_s)
    gaps: Floats = np.sqrt(north * north + east * east) - fleet[:, 4] - radius_m
    return gaps


def crosses_ahead(places: Floats, t_s: Floats, other: Contact, reach_m: float) -> bool:
    """Whether the boat crosses the other vessel's track less than `reach_m` ahead of it."""
    speed = other.speed_mps
    if speed <= 0.0:
        return False
    c, s = other.north_mps / speed, other.east_mps / speed
    north = places[:, 0] - (other.north_m + other.north_mps * t_s)
    east = places[:, 1] - (other.east_m + other.east_mps * t_s)
    along, across = c * north + s * east, c * east - s * north
    changes = np.nonzero(across[1:] * across[:-1] <= 0.0)[0]
    return bool(np.any((along[changes] > 0.0) & (along[changes] < reach_m)))


def stretch(speed_mps: float) -> float:
    """How many times longer than those of a slow boat the detours of a fast one are."""
    return max(1.0, _LEAST_S * speed_mps / _LENGTHS_M[-1])


def reach_m(speed_mps: float) -> float:
    """How far ahead along the route a detour leads past another vessel."""
    return _REACH_SHARE * stretch(speed_mps) * _LENGTHS_M[-1]


def detours(
    here: Place, route: Sequence[Place], room_m: float, sides: Sequence[int], speed_mps: float = 0.0
) -> Iterator[Detour]:
    """Detours from `here` around vessels that need `room_m` beside the route, and back to it; the cheapest first.
    `sides`: allowed ones; `speed_mps`: along the route. Detours longer than the route are left out."""
    longest, times = length_of(route), stretch(speed_mps)
    found: list[Detour] = []
    for length_m in (times * one for one in _LENGTHS_M):
        if length_m > longest:
            break
        end = first_part(route, length_m)[-1]
        chord = math.dist(here, end)
        if chord < 1.0:
            continue
        along_cost_m = _COST_OF_LENGTH * length_m / times
        found.append(Detour((here, end), 0, length_m, along_cost_m))
        north, east = (end[0] - here[0]) / chord, (end[1] - here[1]) / chord
        for width in (share * room_m for share in _WIDTHS):
            along = max(width, _LEG_S * speed_mps)
            if chord < 2.0 * along + _SHORTEST_SIDE_M:
                break
            growth = 2.0 * (math.hypot(along, width) - along)
            for side in sides:
                across = (-side * east * width, side * north * width)
                out = (here[0] + along * north + across[0], here[1] + along * east + across[1])
                back = (end[0] - along * north + across[0], end[1] - along * east + across[1])
                cost = growth + along_cost_m + (_COST_OF_PORT_M if side < 0 else 0.0)
                found.append(Detour((here, out, back, end), side, length_m, cost))
    yield from sorted(found, key=lambda detour: detour.cost_m)


def astern_reach_m(keep_m: float) -> float:
    """How far ahead of a vessel with right of way its track must not be crossed, in m."""
    return _AHEAD_REACH * keep_m
