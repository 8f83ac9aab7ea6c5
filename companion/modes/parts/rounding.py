"""Legs of a route that lead round the fence or obstacles: points added between the waypoints."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from companion.fence.allowed import Place, Way
from companion.guidance.waypoint import Waypoint

_HORIZON_M = 400.0  # of the route that is led round; the rest is looked at when the boat comes there


@dataclass(frozen=True, slots=True)
class Rounded:
    """Waypoints with those added. `own[i]`: how many of the route's own are passed once the first i + 1 are. `beside`:
    the route's own that cannot be reached, by index, with the distance in m at which they are passed instead."""

    waypoints: tuple[Waypoint, ...]
    own: tuple[int, ...]
    beside: tuple[tuple[int, float], ...] = ()

    @property
    def added(self) -> int:
        """How many points were added."""
        return len(self.waypoints) - (self.own[-1] if self.own else 0)

    def own_index(self, index: int) -> int:
        """To which of the route's own waypoints the leg to waypoint `index` leads."""
        return self.own[index - 1] if index else 0

    def passed(self, count: int) -> int:
        """How many of the route's own waypoints are passed when `count` of all are."""
        return 0 if count == 0 else self.own[count - 1]


def unchanged(waypoints: Sequence[Waypoint]) -> Rounded:
    """A route without points added."""
    return Rounded(tuple(waypoints), tuple(range(1, len(waypoints) + 1)))


def rounded(
    waypoints: Sequence[Waypoint],
    here: Place,
    clear: Callable[[Place, Place], bool],
    find: Callable[[Place, Place], Way | None],
    horizon_m: float = _HORIZON_M,
) -> Rounded | int:
    """The route from `here` with each leg led round what it would cross; or the index of the first waypoint to which
    there is no way.

    `clear(a, b)`: whether the straight line is open; `find(a, b)`: a way where it is not. Such a way may end beside a
    waypoint that cannot be reached; not beside the last one.
    """
    found: list[Waypoint] = []
    own: list[int] = []
    beside: list[tuple[int, float]] = []
    place, length_m = here, 0.0
    for i, waypoint in enumerate(waypoints):
        end = (waypoint.north_m, waypoint.east_m)
        if length_m <= horizon_m and not clear(place, end):
            way = find(place, end)
            if way is None:
                return i
            off_m = math.dist(way.points[-1], end)
            if off_m > 0.01:
                if i == len(waypoints) - 1:
                    return i
                beside.append((i, off_m))
                waypoint = replace(waypoint, north_m=way.points[-1][0], east_m=way.points[-1][1])
                end = way.points[-1]
            for point in way.points[1:-1]:
                found.append(Waypoint(*point, radius_m=way.radius_m, speed_mps=waypoint.speed_mps, straight=True))
                own.append(i)
            waypoint = replace(waypoint, straight=True)
        found.append(waypoint)
        own.append(i + 1)
        length_m += math.dist(place, end)
        place = end
    return Rounded(tuple(found), tuple(own), tuple(beside))
