"""The shortest way inside a fence: A* over the visibility graph of the corners, whose edges are computed when needed.

In a polygon the shortest way bends only at corners that stick into the area (Lozano-Pérez & Wesley 1979).
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable

import numpy as np
import shapely
from numpy.typing import NDArray

from companion.core.work import Lane
from companion.fence.area import FenceArea, Floats, Place

Visible = NDArray[np.bool_]

_MOST_CORNERS = 150
_MOST_ZONES = 30  # each keeps three corners and more, and the first tolerances leave them
_SIMPLER_M = (0.2, 0.5, 1.0, 3.0, 10.0, 30.0, 100.0)
_NOTCH_RAD = math.radians(20.0)  # a sharper corner into what is taken may be the begin of a gap that only a leg fits


def is_for_few(area: FenceArea) -> bool:
    """Whether the corners of an area can be few enough for `ClearRoutes`: each zone keeps three of them."""
    zones = sum(1 + len(part.interiors) for part in shapely.get_parts(area.geometry).tolist() if not part.is_empty)
    return zones <= _MOST_ZONES


Search = Callable[[Place, Place], tuple[Place, ...] | None]


def way_inside(
    area: FenceArea,
    search: Search,
    ends: tuple[Place, Place],
    through: FenceArea | None,
    legs: FenceArea | None = None,
) -> tuple[Place, ...] | None:
    """Points between both ends, which are included; None where there is no way. `search` finds it between two places
    inside.

    From a begin outside the area, the way first goes to the nearest place inside. An end outside is allowed if it is
    inside the wider area `through`: the last leg then goes to it from the nearest place inside. `legs`: where the
    others may lie, if not in `area`.
    """
    begin, end = ends
    start, goal = area.nearest_inside(*begin), area.nearest_inside(*end)
    if start is None or goal is None:
        return None
    if goal != end and (through is None or not through.covers((goal, end))):
        return None
    found = (start, goal) if (legs or area).covers((start, goal)) else search(start, goal)
    if found is None:
        return None
    return (*(() if start == begin else (begin,)), *found, *(() if goal == end else (end,)))


class ClearRoutes:
    """Shortest ways inside `area`, which already includes the clearance. Remembers the corners, and which of them see
    each other."""

    def __init__(
        self,
        area: FenceArea,
        seen: tuple[Floats, dict[int, Visible]] | None = None,
        legs: FenceArea | None = None,
    ) -> None:
        """`seen`: the corners, and what is known of their sight, from the same area in another lane. `legs`: the wider
        area in which all legs may lie, so that only bends keep to `area`: a straight leg fits a narrower gap."""
        self._area, self._legs = area, legs or area
        self._corners, self._visible = (self._few_corners(area, legs is not None), {}) if seen is None else seen

    def in_lane(self, lane: Lane) -> ClearRoutes:
        """The same for another thread (`FenceArea.in_lane`)."""
        legs = None if self._legs is self._area else self._legs.in_lane(lane)
        return ClearRoutes(self._area.in_lane(lane), (self._corners, self._visible.copy()), legs)

    @staticmethod
    def _few_corners(area: FenceArea, gaps: bool) -> Floats:
        """Corners of a simplified area inside this one: so few that an arc is not a hundred bends. `gaps`: with the
        places where a gap has closed, unless these are too many."""
        for tolerance_m in _SIMPLER_M:
            corners = area.shrunk(tolerance_m).corners(tolerance_m)
            if len(corners) <= _MOST_CORNERS:
                break
        notches = area.notches(tolerance_m, _NOTCH_RAD) if gaps else corners[:0]
        return np.vstack((corners, notches)) if len(notches) <= _MOST_CORNERS else corners

    def find(self, begin: Place, end: Place, through: FenceArea | None = None) -> tuple[Place, ...] | None:
        """Points from `begin` to `end`, both included, as `way_inside` has it; None where there is no way."""
        return way_inside(self._area, self._search, (begin, end), through, self._legs)

    def look_around(self) -> None:
        """Compute now what all corners see of each other, so that `find` takes less time."""
        for corner in range(len(self._corners)):
            self._visible[corner] = self._sees(self._corners[corner], self._corners)

    def _search(self, begin: Place, end: Place) -> tuple[Place, ...] | None:
        """A* from `begin` to `end`, both inside; None where there is no way."""
        count = len(self._corners)
        points = np.vstack((self._corners, [begin], [end]))
        source, goal = count, count + 1
        to_goal = np.hypot(points[:, 0] - end[0], points[:, 1] - end[1])
        goal_visible = self._sees(points[goal], self._corners)
        best = np.full(count + 2, math.inf)
        best[source] = 0.0
        before: dict[int, int] = {}
        queue = [(float(to_goal[source]), source)]
        done: set[int] = set()
        while queue:
            _, node = heapq.heappop(queue)
            if node == goal:
                return self._unwound(points, before, goal)
            if node in done:
                continue
            done.add(node)
            steps = np.hypot(points[:, 0] - points[node, 0], points[:, 1] - points[node, 1])
            lengths = best[node] + steps
            visible = self._visible_from(node, source, goal_visible, points)
            for other in np.nonzero(visible & (lengths < best - 1.0e-9))[0].tolist():
                best[other] = lengths[other]
                before[other] = node
                heapq.heappush(queue, (float(lengths[other] + to_goal[other]), other))
        return None

    def _visible_from(self, node: int, source: int, goal_visible: Visible, points: Floats) -> Visible:
        """Which points `node` sees, shape (corners + 2,): the corners, then source and goal."""
        if node == source:
            return np.append(self._sees(points[source], self._corners), [False, False])
        if node not in self._visible:
            self._visible[node] = self._sees(points[node], self._corners)
        return np.append(self._visible[node], [False, goal_visible[node]])

    def _sees(self, place: Floats, others: Floats) -> Visible:
        """Which of `others` can be reached in a straight line."""
        lines = np.stack((np.broadcast_to(place, others.shape), others), axis=1)
        return self._legs.covers_each(lines) if len(others) else np.zeros(0, dtype=bool)

    @staticmethod
    def _unwound(points: Floats, before: dict[int, int], node: int) -> tuple[Place, ...]:
        """The points on the way to `node`, from its begin on."""
        way = [node]
        while way[-1] in before:
            way.append(before[way[-1]])
        return tuple((float(points[i, 0]), float(points[i, 1])) for i in reversed(way))
