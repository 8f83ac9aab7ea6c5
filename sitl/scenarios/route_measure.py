"""How well a route was sailed, from truth.csv, against scipy's curve through its waypoints."""

from __future__ import annotations

import itertools
import math
from bisect import bisect_left
from collections.abc import Sequence
from dataclasses import dataclass

from companion.core.angles import wrap_pi
from sitl.scenarios.measure import Point, Track, distance_to, sampled_path

_STEP_M = 0.05
_REACH_M = 20.0  # arc length that is searched for the next nearest point


@dataclass(frozen=True, slots=True)
class RouteTrack:
    """One value for each row of truth: cross-track error (positive: starboard of the path), arc length, heading without
    wraps."""

    error_m: tuple[float, ...]
    s_m: tuple[float, ...]
    yaw_rad: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class SampledPath:
    """A path as dense points: arc length, course without wraps, and the arc length at each waypoint."""

    points: Sequence[Point]
    s_m: Sequence[float]
    course_rad: Sequence[float]
    waypoint_s_m: Sequence[float]


def line(waypoints: Sequence[Point], kind: str) -> SampledPath:
    """The curve of that kind through all waypoints."""
    points = sampled_path(waypoints, kind, _STEP_M)
    s = [0.0]
    for a, b in itertools.pairwise(points):
        s.append(s[-1] + math.dist(a, b))
    courses = [math.atan2(b[1] - a[1], b[0] - a[0]) for a, b in itertools.pairwise(points)]
    course = unwrapped([*courses, courses[-1]])
    stations, low = [0.0], 0
    for waypoint in waypoints[1:]:
        high = bisect_left(s, s[low] + 3.0 * math.dist(waypoints[len(stations) - 1], waypoint)) or len(s)
        low = min(range(low, min(high, len(points))), key=lambda i: math.dist(points[i], waypoint))
        stations.append(s[low])
    return SampledPath(points, s, course, stations)


def follow(track: Track, path: SampledPath) -> RouteTrack:
    """The track relative to the path. The nearest point is searched near the last one, so that other branches do not
    count."""
    import numpy as np

    points = np.array(path.points)
    errors, along = [], []
    near, reach = 0, round(_REACH_M / _STEP_M)
    for row in track:
        low = max(0, near - reach // 4)
        off = points[low : near + reach] - (row["north_m"], row["east_m"])
        near = low + int(np.argmin(np.einsum("ij,ij->i", off, off)))
        north, east = row["north_m"] - path.points[near][0], row["east_m"] - path.points[near][1]
        side = east * math.cos(path.course_rad[near]) - north * math.sin(path.course_rad[near])
        errors.append(math.copysign(math.hypot(north, east), side))
        along.append(path.s_m[near])
    return RouteTrack(tuple(errors), tuple(along), tuple(unwrapped([row["yaw_rad"] for row in track])))


def unwrapped(angles: Sequence[float]) -> list[float]:
    """The same angles without jumps."""
    result = [angles[0]]
    for angle in angles[1:]:
        result.append(result[-1] + wrap_pi(angle - result[-1]))
    return result


def reached_rows(track: Track, waypoints: Sequence[Point], radius_m: float) -> list[int]:
    """Row at which each waypoint was first within the radius, in order; ends at the first that never was."""
    rows: list[int] = []
    begin = 0
    for north, east in waypoints:
        row = next((i for i in range(begin, len(track)) if distance_to(track[i], north, east) <= radius_m), None)
        if row is None:
            break
        rows.append(row)
        begin = row
    return rows


def most_turn_rad(sailed: RouteTrack, path: SampledPath, rows: Sequence[int]) -> float:
    """The largest span of the heading between two waypoints, less that of the path; also after the last one reached."""
    worst = 0.0
    marks = [0, *rows, len(sailed.yaw_rad) - 1]
    for first, last in itertools.pairwise(marks):
        yaw = sailed.yaw_rad[first : last + 1]
        low, high = (
            bisect_left(path.s_m, s - 1.0e-9)
            for s in (min(sailed.s_m[first : last + 1]), max(sailed.s_m[first : last + 1]))
        )
        course = path.course_rad[low : high + 1]
        worst = max(worst, (max(yaw) - min(yaw)) - (max(course) - min(course)))
    return worst


def percentile(values: Sequence[float], share: float) -> float:
    """The value below which that share of the values lies."""
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]
