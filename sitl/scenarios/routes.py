"""The routes of the ÅBOAT thesis (Storbacka 2021, 6.1), by length, count and character: it prints no coordinates.

North and east in metres from the boat's start, which heads north. `mission_files/aboat_*.plan` are the same, off
Ruissalo.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from sitl.scenarios.measure import Point


@dataclass(frozen=True, slots=True)
class ThesisRoute:
    """`path`: the curve that the thesis used."""

    text: str
    path: str
    points: tuple[Point, ...]

    @property
    def length_m(self) -> float:
        """From the first waypoint to the last."""
        return sum(math.dist(a, b) for a, b in itertools.pairwise(self.points))


def _legs(begin: Point, length_m: float, courses_deg: Sequence[float]) -> tuple[Point, ...]:
    """Waypoints after legs of equal length, `length_m` in all."""
    points, step = [begin], length_m / len(courses_deg)
    for course in courses_deg:
        north, east = points[-1]
        points.append((north + step * math.cos(math.radians(course)), east + step * math.sin(math.radians(course))))
    return tuple(points)


ROUTES: Mapping[str, ThesisRoute] = {
    "1": ThesisRoute(
        "5 waypoints, turns of 90°", "linear", ((15.0, 0.0), (55.0, 0.0), (55.0, 40.0), (95.0, 40.0), (95.0, 0.0))
    ),
    "2": ThesisRoute(
        "5 waypoints, turns of 130° to 150°",
        "linear",
        ((15.0, 0.0), (60.0, 10.0), (25.0, 35.0), (75.0, 45.0), (35.0, 75.0)),
    ),
    "3": ThesisRoute("308 m, 6 waypoints", "pchip", _legs((15.0, 0.0), 308.0, (20.0, 60.0, 95.0, 140.0, 170.0))),
    "4": ThesisRoute(
        "500 m, 11 waypoints",
        "pchip",
        _legs((15.0, 0.0), 500.0, (20.0, 50.0, 85.0, 120.0, 90.0, 45.0, 85.0, 130.0, 175.0, 210.0)),
    ),
    "island": ThesisRoute(
        "6 waypoints, narrow passages",
        "pchip",
        ((15.0, 0.0), (115.0, 5.0), (130.0, 20.0), (130.0, 120.0), (145.0, 135.0), (245.0, 140.0)),
    ),
}


def transects(count: int, length_m: float, spacing_m: float) -> tuple[Point, ...]:
    """A survey's lines, north and south in turn, each `spacing_m` east of the last."""
    points: list[Point] = []
    for i in range(count):
        ends = [(10.0, i * spacing_m), (10.0 + length_m, i * spacing_m)]
        points += ends if i % 2 == 0 else ends[::-1]
    return tuple(points)
