"""Ways around other vessels: where the boat will be along a way, how near it then comes to each, and the shortest way that keeps clear.

All vessels are circles; the others keep course and speed. A way around leaves the route at 45°, runs beside it and comes back at 45°: an alteration
that others can see (rule 8b). The boat runs along it at its speed over ground, gaining and losing speed with one acceleration.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from companion.core.types import Contact

Place = tuple[float, float]
Floats = NDArray[np.float64]

STEP_S = 1.0
_WIDTHS = (0.5, 0.75, 1.0, 1.25, 1.6, 2.0, 3.0)  # times the room that a pass side by side needs
_LENGTHS_M = (25.0, 40.0, 60.0, 85.0, 115.0, 150.0, 200.0, 260.0, 330.0)
_SHORTEST_SIDE_M = 5.0  # of the part beside the route
_COST_OF_LENGTH = 0.1  # of a metre along the route, against a metre of detour
_COST_OF_PORT_M = 10.0
_AHEAD_REACH = 10.0  # times the distance to keep: further ahead of a vessel its way may be crossed
_GROWTH = 2.0 * (math.sqrt(2.0) - 1.0)  # of the way, for each metre of width


@dataclass(frozen=True, slots=True)
class Detour:
    """Points from the boat to where the route is met again, `length_m` further along it. `side`: 1 to starboard, −1 to port, 0 straight back."""

    points: tuple[Place, ...]
    side: int
    length_m: float
    cost_m: float


@dataclass(frozen=True, slots=True)
class Pace:
    """How the boat runs along a way: from `begin_mps` to `speed_mps`."""

    begin_mps: float
    speed_mps: float
    acceleration_mps2: float


def cut(way: Sequence[Place], length_m: float) -> list[Place]:
    """The first `length_m` of a way."""
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


def rest(way: Sequence[Place], length_m: float) -> list[Place]:
    """What follows the first `length_m` of a way; its last point at least."""
    left = length_m
    for i, (a, b) in enumerate(pairwise(way)):
        step = math.dist(a, b)
        if step > left:
            share = left / step
            return [(a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1])), *way[i + 1 :]]
        left -= step
    return [way[-1]]


def thinned(way: Sequence[Place], step_m: float) -> list[Place]:
    """The same way by fewer points, at least `step_m` apart but for the last."""
    points = [way[0]]
    for place in way[1:-1]:
        if math.dist(place, points[-1]) >= step_m:
            points.append(place)
    return [*points, way[-1]] if len(way) > 1 else points


def length_of(way: Sequence[Place]) -> float:
    return sum(math.dist(a, b) for a, b in pairwise(way))


def times(duration_s: float) -> Floats:
    return np.arange(0.0, duration_s + STEP_S, STEP_S)


def travel(way: Sequence[Place], pace: Pace, t_s: Floats) -> Floats:
    """(north_m, east_m) along `way` at each time, shape (n, 2); at its end the boat stays."""
    change = pace.speed_mps - pace.begin_mps
    until = abs(change) / pace.acceleration_mps2
    early = np.minimum(t_s, until)
    s = pace.begin_mps * early + 0.5 * math.copysign(pace.acceleration_mps2, change) * early * early + pace.speed_mps * (t_s - early)
    points = np.asarray(way, dtype=float)
    stations = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(points, axis=0).T))))
    return np.column_stack([np.interp(s, stations, points[:, axis]) for axis in (0, 1)])


def clear_water(places: Floats, t_s: Floats, other: Contact, radius_m: float) -> Floats:
    """Between the circles at each time, in m; negative where they overlap. `radius_m`: of this boat."""
    north = places[:, 0] - (other.north_m + other.north_mps * t_s)
    east = places[:, 1] - (other.east_m + other.east_mps * t_s)
    gaps: Floats = np.hypot(north, east) - (radius_m + other.radius_m)
    return gaps


def least_clear_water(places: Floats, t_s: Floats, others: Sequence[Contact], radius_m: float) -> float:
    """The least of `clear_water` over all times and all of `others`; infinite where there are none."""
    if not others:
        return math.inf
    fleet = np.array([(c.north_m, c.east_m, c.north_mps, c.east_mps, c.radius_m) for c in others])[:, :, None]
    north = places[:, 0] - (fleet[:, 0] + fleet[:, 2] * t_s)
    east = places[:, 1] - (fleet[:, 1] + fleet[:, 3] * t_s)
    return float((np.sqrt(north * north + east * east) - fleet[:, 4]).min()) - radius_m


def crosses_ahead(places: Floats, t_s: Floats, other: Contact, reach_m: float) -> bool:
    """Whether the boat comes from one side of the other to its other side less than `reach_m` ahead of it."""
    speed = other.speed_mps
    if speed <= 0.0:
        return False
    c, s = other.north_mps / speed, other.east_mps / speed
    north = places[:, 0] - (other.north_m + other.north_mps * t_s)
    east = places[:, 1] - (other.east_m + other.east_mps * t_s)
    along, across = c * north + s * east, c * east - s * north
    changes = np.nonzero(across[1:] * across[:-1] <= 0.0)[0]
    return bool(np.any((along[changes] > 0.0) & (along[changes] < reach_m)))


def detours(here: Place, route: Sequence[Place], room_m: float, sides: Sequence[int]) -> Iterator[Detour]:
    """Ways from `here` around something that needs `room_m` beside it, back to `route`, the cheapest first. None that the route is too
    short for."""
    longest = length_of(route)
    found: list[Detour] = []
    for length_m in _LENGTHS_M:
        if length_m > longest:
            break
        end = cut(route, length_m)[-1]
        chord = math.dist(here, end)
        if chord < 1.0:
            continue
        found.append(Detour((here, end), 0, length_m, _COST_OF_LENGTH * length_m))
        north, east = (end[0] - here[0]) / chord, (end[1] - here[1]) / chord
        for width in (share * room_m for share in _WIDTHS):
            if chord < 2.0 * width + _SHORTEST_SIDE_M:
                break
            for side in sides:
                across = (-side * east * width, side * north * width)
                out = (here[0] + width * north + across[0], here[1] + width * east + across[1])
                back = (end[0] - width * north + across[0], end[1] - width * east + across[1])
                cost = _GROWTH * width + _COST_OF_LENGTH * length_m + (_COST_OF_PORT_M if side < 0 else 0.0)
                found.append(Detour((here, out, back, end), side, length_m, cost))
    yield from sorted(found, key=lambda detour: detour.cost_m)


def astern_reach_m(keep_m: float) -> float:
    """How far ahead of a vessel that is given way to its way must not be crossed."""
    return _AHEAD_REACH * keep_m
