"""The sides of an area, in blocks of neighbours with a bounding box each, and the blocks in groups: a tick looks at the
few that matter.

Of many sides, the nearest is looked for in the boxes that are not further away than the nearest first vertex of a box.
So the result is that of looking at all of them. Coordinates are (north_m, east_m).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry.base import BaseGeometry

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

_BLOCK = 64
_GROUP = 64  # blocks
_FEW = 2_000  # sides that are all looked at
_RINGS_AT_ONCE = 500  # so that other threads have their turn


class Nearest(NamedTuple):
    """Vector from a place to the nearest point of the sides, and its length."""

    distance_m: float
    north_m: float
    east_m: float


class Rings(NamedTuple):
    """The vertices of all rings, one ring after the other, with the area always on the same side. `before`, `after`:
    indices of each vertex's neighbours in its ring."""

    places: Floats
    before: Indices
    after: Indices


def rings_of(geometry: BaseGeometry) -> Rings:
    """Vertices of every ring: outer rings counter-clockwise with (north, east) as (x, y), holes clockwise. The first
    vertex is not repeated at the end."""
    parts = [part for part in shapely.get_parts(geometry).tolist() if part.geom_type == "Polygon" and not part.is_empty]
    places, before, after = [np.zeros((0, 2))], [np.zeros(0, np.intp)], [np.zeros(0, np.intp)]
    count = 0
    for part in parts:
        rings = [part.exterior, *part.interiors]
        for first in range(0, len(rings), _RINGS_AT_ONCE):
            found = _some_rings(rings[first : first + _RINGS_AT_ONCE], outer=first == 0)
            places.append(found.places)
            before.append(found.before + count)
            after.append(found.after + count)
            count += len(found.places)
    return Rings(np.concatenate(places), np.concatenate(before), np.concatenate(after))


def _some_rings(rings: list[BaseGeometry], outer: bool) -> Rings:
    """`outer`: the first of them is an outer ring."""
    counter = shapely.is_ccw(rings)
    counter[1:] = ~counter[1:]
    if not outer:
        counter[:1] = ~counter[:1]
    turned = [ring if good else ring.reverse() for ring, good in zip(rings, counter.tolist(), strict=True)]
    closed, ring = shapely.get_coordinates(turned, return_index=True)
    last = np.append(ring[1:] != ring[:-1], True)
    places, ring = closed[~last], ring[~last]
    first = np.append(True, ring[1:] != ring[:-1])
    begins = np.nonzero(first)[0]
    ends = np.append(begins[1:], len(places)) - 1
    index = np.arange(len(places))
    before, after = index - 1, index + 1
    before[begins], after[ends] = ends, begins
    return Rings(places, before, after)


class _Boxes(NamedTuple):
    """Bounding boxes of runs of things: their corners, the first vertex in each, and the numbers of what is in it."""

    low: Floats
    high: Floats
    first: Floats
    begins: Indices
    sizes: Indices

    def grouped(self) -> _Boxes:
        """The boxes of groups of these."""
        begin = np.arange(0, len(self.low), _GROUP)
        low, high = np.minimum.reduceat(self.low, begin), np.maximum.reduceat(self.high, begin)
        return _Boxes(low, high, self.first[begin], begin, np.diff(begin, append=len(self.low)))

    def members(self, which: Indices) -> Indices:
        """Numbers of what is in these boxes, in order."""
        counts = self.sizes[which]
        behind = np.cumsum(counts) - counts
        numbers: Indices = np.repeat(self.begins[which] - behind, counts) + np.arange(counts.sum())
        return numbers


class Sides:
    """Straight sides. They never change."""

    def __init__(self, rings: Rings) -> None:
        self._start = rings.places
        self._along = rings.places[rings.after] - rings.places
        self._square = np.maximum((self._along**2).sum(axis=1), 1.0e-12)
        self._levels: tuple[_Boxes, ...] = ()  # the coarsest first; none for few sides
        if len(self._start) > _FEW:
            number = np.arange(len(self._start))
            ring_begin = np.maximum.accumulate(np.where(rings.before > number, number, 0))
            begin = np.nonzero((number - ring_begin) % _BLOCK == 0)[0]  # a block is a part of one ring
            end = self._start + self._along
            low = np.minimum.reduceat(np.minimum(self._start, end), begin)
            high = np.maximum.reduceat(np.maximum(self._start, end), begin)
            blocks = _Boxes(low, high, self._start[begin], begin, np.diff(begin, append=len(number)))
            self._levels = (blocks.grouped(), blocks)

    def __len__(self) -> int:
        return len(self._start)

    def nearest(self, north_m: float, east_m: float) -> Nearest:
        """The nearest point of the sides. Raises ValueError where there are none."""
        place = np.array((north_m, east_m))
        which: Indices | None = None
        for boxes in self._levels:
            which = np.arange(len(boxes.low)) if which is None else which
            off = np.maximum(np.maximum(boxes.low[which] - place, place - boxes.high[which]), 0.0)
            least = np.einsum("ij,ij->i", off, off)
            to_first = boxes.first[which] - place
            most = float(np.einsum("ij,ij->i", to_first, to_first).min())
            which = boxes.members(which[least <= most * (1.0 + 1e-9)])
        return self._nearest_of(slice(None) if which is None else which, place)

    def _nearest_of(self, which: Indices | slice, place: Floats) -> Nearest:
        along = self._along[which]
        off = place - self._start[which]
        share = np.minimum(1.0, np.maximum(0.0, np.einsum("ij,ij->i", off, along) / self._square[which]))
        way = share[:, None] * along - off
        squares = np.einsum("ij,ij->i", way, way)
        nearest = int(squares.argmin())
        return Nearest(math.sqrt(float(squares[nearest])), float(way[nearest, 0]), float(way[nearest, 1]))

    def first_hit_m(self, north_m: float, east_m: float, north: float, east: float) -> float:
        """Distance from a place to the sides along the unit vector (north, east); infinite where it never meets
        them."""
        found: Indices | None = None
        for boxes in self._levels:
            found = np.arange(len(boxes.low)) if found is None else found
            low, high = boxes.low[found], boxes.high[found]
            middle, half = 0.5 * (low + high) - (north_m, east_m), 0.5 * (high - low)
            beside = np.abs(middle[:, 0] * east - middle[:, 1] * north) - half @ (abs(east), abs(north))
            ahead = middle @ (north, east) + half @ (abs(north), abs(east))
            found = boxes.members(found[(beside <= _NEAR_M) & (ahead >= -_NEAR_M)])
        which = slice(None) if found is None else found
        start, along = self._start[which], self._along[which]
        off_n, off_e = start[:, 0] - north_m, start[:, 1] - east_m
        cross = north * along[:, 1] - east * along[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            way = (off_n * along[:, 1] - off_e * along[:, 0]) / cross
            share = (off_n * east - off_e * north) / cross
        hits = way[(np.abs(cross) > 1.0e-12) & (way >= 0.0) & (share >= -1.0e-9) & (share <= 1.0 + 1.0e-9)]
        return float(hits.min()) if len(hits) else math.inf


_NEAR_M = 1.0e-3  # by which a box counts as larger than it is
