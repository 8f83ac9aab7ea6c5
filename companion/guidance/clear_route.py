"""The shortest way inside a fence: A* over the corners that stick into the area (the visibility graph, edges looked at as they are needed).

In a polygon the shortest way bends only at corners of its boundary that point inwards (Lozano-Pérez & Wesley 1979).
"""

from __future__ import annotations

import heapq
import math

import numpy as np
from numpy.typing import NDArray

from companion.guidance.fence_area import FenceArea, Floats, Place

Seen = NDArray[np.bool_]

_MOST_CORNERS = 150
_SIMPLER_M = (0.2, 0.5, 1.0, 3.0, 10.0, 30.0, 100.0)


class ClearRoutes:
    """Shortest ways inside `area`, which holds the clearance already. Remembers the corners and which of them see each other."""

    def __init__(self, area: FenceArea) -> None:
        self._area = area
        self._corners = self._few_corners(area)
        self._seen: dict[int, Seen] = {}

    @staticmethod
    def _few_corners(area: FenceArea) -> Floats:
        """Corners of a simpler area inside this one: few, so that arcs do not become a hundred bends."""
        for tolerance_m in _SIMPLER_M:
            corners = area.shrunk(tolerance_m).corners(tolerance_m)
            if len(corners) <= _MOST_CORNERS:
                break
        return corners

    def find(self, begin: Place, end: Place, through: FenceArea | None = None) -> tuple[Place, ...] | None:
        """Points from `begin` to `end`, both included; None where there is no way.

        A begin outside the area first goes to its nearest point; so does the way to an end that lies outside it but in the wider area
        `through`, whose last leg stays in there.
        """
        start, goal = self._area.nearest_inside(*begin), self._area.nearest_inside(*end)
        if start is None or goal is None or (goal != end and (through is None or not through.covers((goal, end)))):
            return None
        found = (start, goal) if self._area.covers((start, goal)) else self._search(start, goal)
        if found is None:
            return None
        return (*(() if start == begin else (begin,)), *found, *(() if goal == end else (end,)))

    def _search(self, begin: Place, end: Place) -> tuple[Place, ...] | None:
        count = len(self._corners)
        points = np.vstack((self._corners, [begin], [end]))
        source, goal = count, count + 1
        to_goal = np.hypot(points[:, 0] - end[0], points[:, 1] - end[1])
        goal_seen = self._sees(points[goal], self._corners)
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
            for other in np.nonzero(self._reach(node, source, goal_seen, points) & (lengths < best - 1.0e-9))[0].tolist():
                best[other] = lengths[other]
                before[other] = node
                heapq.heappush(queue, (float(lengths[other] + to_goal[other]), other))
        return None

    def _reach(self, node: int, source: int, goal_seen: Seen, points: Floats) -> Seen:
        """Which points `node` sees: corners, then source and goal."""
        if node == source:
            return np.append(self._sees(points[source], self._corners), [False, False])
        if node not in self._seen:
            self._seen[node] = self._sees(points[node], self._corners)
        return np.append(self._seen[node], [False, goal_seen[node]])

    def _sees(self, place: Floats, others: Floats) -> Seen:
        lines = np.stack((np.broadcast_to(place, others.shape), others), axis=1)
        return self._area.covers_each(lines) if len(others) else np.zeros(0, dtype=bool)

    @staticmethod
    def _unwound(points: Floats, before: dict[int, int], node: int) -> tuple[Place, ...]:
        way = [node]
        while way[-1] in before:
            way.append(before[way[-1]])
        return tuple((float(points[i, 0]), float(points[i, 1])) for i in reversed(way))
