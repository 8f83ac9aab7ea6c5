"""Ways inside an area with very many corners, by a grid of places: a shortest way on the grid, then straightened.

A way through a gap narrower than a cell may not be found. The grid and what its places see of each other are made once;
finding a way then takes milliseconds. Coordinates are (north_m, east_m).
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import shapely
from numpy.typing import NDArray

from companion.core.work import Lane
from companion.fence.area import FenceArea, Floats, Place
from companion.fence.way_round import ClearRoutes, is_for_few, way_inside

_CELLS = 6_400  # of the grid
_BEYOND = 1.1  # the grid is so much larger than all zones
_WORLD_M = 100_000.0  # an area larger than this is not fenced in: its outer line does not count
_NEIGHBOURS = ((0, 1), (1, 0), (1, 1), (1, -1))
_TRIED = 24  # nearest places of the grid that a begin or an end may see
_FEWEST = 2


def routes_in(area: FenceArea, legs: FenceArea | None = None) -> ClearRoutes | Roadmap:
    """What finds ways in an area: by its corners where they are few, else by a grid. `legs`: as `ClearRoutes` has it; a
    grid does without."""
    return ClearRoutes(area, legs=legs) if is_for_few(area) else Roadmap(area)


class Roadmap:
    """As `ClearRoutes`, for areas that have too many corners for it."""

    def __init__(self, area: FenceArea, grid: tuple[Floats, Any] | None = None) -> None:
        """`grid`: places and graph of the same area in another lane."""
        self._area = area
        self._places, self._graph = self._gridded() if grid is None else grid
        if grid is None and len(self._places):  # the first search takes long
            self._search(tuple(self._places[0].tolist()), tuple(self._places[-1].tolist()))

    def _gridded(self) -> tuple[Floats, Any]:
        from scipy.sparse import coo_matrix

        area = self._area
        low, high = _extent(area)
        cell_m = max(1.0, math.sqrt(float(np.prod(high - low)) / _CELLS))
        counts = np.maximum(2, np.ceil((high - low) / cell_m).astype(int) + 1)
        norths, easts = (np.linspace(low[i], high[i], counts[i]) for i in (0, 1))
        places = np.stack(np.meshgrid(norths, easts, indexing="ij"), axis=-1)
        inside = np.array([shapely.intersects_xy(area.geometry, row[:, 0], row[:, 1]) for row in places])
        number = np.where(inside, np.cumsum(inside).reshape(inside.shape) - 1, -1)
        kept: Floats = places[inside]
        begins, ends = _edges(number)
        seen = self._sees(kept[begins], kept[ends])
        begins, ends = begins[seen], ends[seen]
        lengths = np.hypot(*(kept[begins] - kept[ends]).T)
        return kept, coo_matrix((lengths, (begins, ends)), shape=(len(kept), len(kept))).tocsr()

    def in_lane(self, lane: Lane) -> Roadmap:
        """The same for another thread (`FenceArea.in_lane`)."""
        return Roadmap(self._area.in_lane(lane), (self._places, self._graph))

    def find(self, begin: Place, end: Place, through: FenceArea | None = None) -> tuple[Place, ...] | None:
        """As `ClearRoutes.find`."""
        return way_inside(self._area, self._search, (begin, end), through)

    def _search(self, begin: Place, end: Place) -> tuple[Place, ...] | None:
        from scipy.sparse.csgraph import dijkstra

        first, last = self._seen_from(begin), self._seen_from(end)
        if not len(first) or not len(last):
            return None
        lengths, before = dijkstra(self._graph, directed=False, indices=last, return_predecessors=True)
        ways = (
            np.hypot(*(self._places[last] - end).T)[:, None]
            + lengths[:, first]
            + np.hypot(*(self._places[first] - begin).T)[None, :]
        )
        row, column = np.unravel_index(int(ways.argmin()), ways.shape)
        if not math.isfinite(ways[row, column]):
            return None
        node, way = int(first[column]), [begin]
        while node >= 0:
            way.append((float(self._places[node, 0]), float(self._places[node, 1])))
            node = int(before[row, node])
        return self._straightened([*way, end])

    def _seen_from(self, place: Place) -> NDArray[np.intp]:
        """Numbers of the nearest places of the grid that can be reached in a straight line."""
        nearest = np.argsort(np.hypot(*(self._places - place).T))[:_TRIED]
        seen = nearest[self._sees(np.broadcast_to(place, (len(nearest), 2)), self._places[nearest])]
        return seen[:_FEWEST]

    def _straightened(self, way: list[Place]) -> tuple[Place, ...]:
        """The way without points that it can do without: each time on to a point in sight, tried in ever longer
        steps."""
        kept, at = [way[0]], 0
        while at < len(way) - 1:
            reached, step = at + 1, 1
            while step:
                further = min(reached + step, len(way) - 1)
                in_sight = further > reached and self._area.covers((way[at], way[further]))
                reached = further if in_sight else reached
                step = 2 * step if in_sight else step // 2
            at = reached
            kept.append(way[at])
        return tuple(kept)

    def _sees(self, begins: Floats, ends: Floats) -> NDArray[np.bool_]:
        if not len(begins):
            return np.zeros(0, dtype=bool)
        return self._area.covers_each(np.stack((begins, ends), axis=1))


def _extent(area: FenceArea) -> tuple[Floats, Floats]:
    """Opposite corners of the box to lay the grid over: around the area, or around the zones that it leaves out."""
    geometry = area.geometry
    low, high = _box(geometry)
    if float((high - low).max(initial=0.0)) > _WORLD_M:
        holes = [hole for part in shapely.get_parts(geometry).tolist() for hole in part.interiors]
        low, high = _box(shapely.multilinestrings(holes))
    middle, half = 0.5 * (low + high), 0.5 * _BEYOND * (high - low)
    return middle - half, middle + half


def _box(geometry: Any) -> tuple[Floats, Floats]:
    bounds = np.asarray(shapely.bounds(geometry))
    return (bounds[:2], bounds[2:]) if np.all(np.isfinite(bounds)) else (np.zeros(2), np.zeros(2))


def _edges(number: NDArray[np.intp]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The two ends of each edge between neighbours of the grid. `number`: of each place; −1 for one that is outside."""
    rows, columns = number.shape
    begins, ends = [], []
    for down, across in _NEIGHBOURS:
        here = number[: rows - down, max(0, -across) : columns - max(0, across)]
        there = number[down:, max(0, across) : columns - max(0, -across)]
        both = (here >= 0) & (there >= 0)
        begins.append(here[both])
        ends.append(there[both])
    return np.concatenate(begins), np.concatenate(ends)
