"""The fence as an area in the local NED plane: inclusion zones by group, less exclusion zones.

A place is allowed inside all zones of at least one inclusion group, and outside every exclusion zone (MAVLink
common.xml, MAV_CMD_NAV_FENCE_…), and inside the circle around home where there is one. shapely builds the areas once.
Each tick asks for the signed distance and for the way to the line along a course: a few numpy operations on the sides.
Only this module imports shapely, and it is itself imported only where there is a fence. Coordinates are (north_m,
east_m).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import reduce

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import LineString, MultiPolygon, Point, Polygon, box
from shapely.geometry.base import BaseGeometry

Floats = NDArray[np.float64]
Place = tuple[float, float]

_WORLD_M = 500_000.0  # without inclusion zones, everything up to here is inside
_SAG_M = 0.02  # error of the polygon that stands for a circle, to the safe side
_MOST_ARC_SIDES = 720
_TOUCH_M = 1.0e-6
_ARCS = 4  # sides for each rounded corner of 90° in a shrunk area


@dataclass(frozen=True, slots=True)
class Disc:
    """A circular zone."""

    north_m: float
    east_m: float
    radius_m: float


Shape = Disc | Sequence[Place]


@dataclass(frozen=True, slots=True)
class Margin:
    """`distance_m` to the line, positive inside; `north`, `east`: unit vector to the nearest point of the line."""

    distance_m: float
    north: float
    east: float


class FenceArea:
    """An area that never changes. It is empty where the zones of a group do not overlap."""

    def __init__(self, groups: Mapping[int, Sequence[Shape]], exclusions: Sequence[Shape]) -> None:
        """`groups`: inclusion zones by group number. `exclusions`: exclusion zones."""
        inside = [
            reduce(shapely.intersection, [_polygon(shape, True) for shape in shapes]) for shapes in groups.values()
        ]
        area = shapely.union_all(inside) if inside else box(-_WORLD_M, -_WORLD_M, _WORLD_M, _WORLD_M)
        forbidden = shapely.union_all([_polygon(shape, False) for shape in exclusions])
        self._set(_areal(shapely.difference(area, forbidden)))

    @classmethod
    def of(cls, geometry: BaseGeometry) -> FenceArea:
        """An area from a shapely geometry."""
        area = cls.__new__(cls)
        area._set(_areal(geometry))
        return area

    def _set(self, geometry: BaseGeometry) -> None:
        self.geometry = geometry
        shapely.prepare(geometry)
        self._touching = geometry.buffer(_TOUCH_M, join_style="mitre")  # much quicker than round corners
        shapely.prepare(self._touching)
        sides = _sides(geometry)
        self._start, self._along = sides[:, 0], sides[:, 1] - sides[:, 0]
        self._square = np.maximum((self._along**2).sum(axis=1), 1.0e-12)

    @property
    def empty(self) -> bool:
        """Whether no place is inside."""
        return bool(self.geometry.is_empty)

    def shrunk(self, by_m: float) -> FenceArea:
        """The places that are inside by at least `by_m` (to 1 % of it at corners that stick into the area)."""
        return FenceArea.of(self.geometry.buffer(-by_m, quad_segs=_ARCS)) if by_m > 0.0 else self

    def within(self, disc: Disc) -> FenceArea:
        """The places of this area that are inside the disc too; none for a disc without a radius."""
        kept = _polygon(disc, True) if disc.radius_m > 0.0 else Polygon()
        return FenceArea.of(shapely.intersection(self.geometry, kept))

    def contains(self, north_m: float, east_m: float) -> bool:
        """Whether the place is inside; the line itself is inside."""
        return bool(shapely.intersects_xy(self.geometry, north_m, east_m))

    def margin(self, north_m: float, east_m: float) -> Margin:
        """Signed distance to the line and the direction of its nearest point; −∞ for an empty area."""
        if len(self._start) == 0:
            return Margin(-math.inf, 0.0, 0.0)
        off = np.array((north_m, east_m)) - self._start
        share = np.minimum(1.0, np.maximum(0.0, np.einsum("ij,ij->i", off, self._along) / self._square))
        way = share[:, None] * self._along - off
        squares = np.einsum("ij,ij->i", way, way)
        nearest = int(squares.argmin())
        distance_m = math.sqrt(float(squares[nearest]))
        north, east = float(way[nearest, 0]), float(way[nearest, 1])
        inside = self.contains(north_m, east_m)
        if distance_m < 1.0e-9:
            return Margin(0.0, 0.0, 0.0)
        return Margin(distance_m if inside else -distance_m, north / distance_m, east / distance_m)

    def way_to_line_m(self, north_m: float, east_m: float, north: float, east: float) -> float:
        """Distance from a place to the line along the unit vector (north, east); infinite where that never meets it."""
        off_n, off_e = self._start[:, 0] - north_m, self._start[:, 1] - east_m
        cross = north * self._along[:, 1] - east * self._along[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            way = (off_n * self._along[:, 1] - off_e * self._along[:, 0]) / cross
            share = (off_n * east - off_e * north) / cross
        hits = way[(np.abs(cross) > 1.0e-12) & (way >= 0.0) & (share >= -1.0e-9) & (share <= 1.0 + 1.0e-9)]
        return float(hits.min()) if len(hits) else math.inf

    def nearest_inside(self, north_m: float, east_m: float) -> Place | None:
        """The nearest place of the area: the place itself where it is inside. None for an empty area."""
        if self.empty:
            return None
        if self.contains(north_m, east_m):
            return north_m, east_m
        point = shapely.get_point(shapely.shortest_line(self.geometry, Point(north_m, east_m)), 0)
        return float(point.x), float(point.y)

    def covers(self, line: Sequence[Place] | Floats) -> bool:
        """Whether the whole line lies inside; touching is inside."""
        return bool(shapely.covers(self._touching, _line(line)))

    def covers_each(self, lines: Floats) -> NDArray[np.bool_]:
        """As `covers`, for many lines of two points each: shape (n, 2, 2) → (n,)."""
        result: NDArray[np.bool_] = shapely.covers(self._touching, shapely.linestrings(lines))
        return result

    def first_exit(self, line: Sequence[Place] | Floats, forgive_start: bool = False) -> Place | None:
        """Where the line first leaves the area; None where it does not. `forgive_start`: a line that begins outside may
        come in; only what follows counts."""
        if self.covers(line):
            return None
        outside = shapely.difference(_line(line), self._touching)
        parts = [part for part in shapely.get_parts(outside).tolist() if part.length > 10.0 * _TOUCH_M]
        if not parts:
            return None
        begin = Point(*(float(x) for x in line[0]))
        if forgive_start:
            parts = [part for part in parts if part.distance(begin) > _TOUCH_M]
        whole = _line(line)
        places = sorted((float(whole.project(Point(*part.coords[0]))), part.coords[0]) for part in parts)
        return (float(places[0][1][0]), float(places[0][1][1])) if places else None

    def corners(self, simplified_m: float = 0.0) -> Floats:
        """Vertices that stick into the area: a shortest way can bend only there. Shape (n, 2). `simplified_m`:
        tolerance by which the boundary is simplified first."""
        geometry = self.geometry.simplify(simplified_m) if simplified_m > 0.0 else self.geometry
        found: list[Floats] = []
        for ring in _rings(geometry):
            before, after = np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0)
            turn = (ring[:, 0] - before[:, 0]) * (after[:, 1] - ring[:, 1]) - (ring[:, 1] - before[:, 1]) * (
                after[:, 0] - ring[:, 0]
            )
            found.append(ring[turn < -1.0e-9])
        return np.concatenate(found) if found else np.zeros((0, 2))


def _line(points: Sequence[Place] | Floats) -> LineString:
    array = np.asarray(points, dtype=np.float64)
    return LineString(array if len(array) > 1 else np.repeat(array, 2, axis=0))


def _areal(geometry: BaseGeometry) -> BaseGeometry:
    """The polygons of a geometry, without the points and lines in which zones may touch."""
    parts = [part for part in shapely.get_parts(geometry).tolist() if part.geom_type == "Polygon" and part.area > 0.0]
    return MultiPolygon(parts) if len(parts) != 1 else parts[0]


def _polygon(shape: Shape, inclusion: bool) -> BaseGeometry:
    """A zone as a shapely polygon. A circle becomes a polygon inside it (inclusion) or around it (exclusion)."""
    if not isinstance(shape, Disc):
        return shapely.make_valid(Polygon(shape))
    sag = min(0.5, _SAG_M / shape.radius_m)
    count = min(_MOST_ARC_SIDES, max(16, math.ceil(math.pi / math.acos(1.0 - sag))))
    radius_m = shape.radius_m if inclusion else shape.radius_m / math.cos(math.pi / count)
    angles = np.arange(count) * (math.tau / count)
    return Polygon(
        np.column_stack((shape.north_m + radius_m * np.cos(angles), shape.east_m + radius_m * np.sin(angles)))
    )


def _rings(geometry: BaseGeometry) -> list[Floats]:
    """Vertices of every ring, with the area always on the same side: outer rings counter-clockwise with (north, east)
    as (x, y), holes clockwise. The first vertex is not repeated at the end."""
    rings: list[Floats] = []
    for part in shapely.get_parts(geometry).tolist():
        if part.geom_type != "Polygon" or part.is_empty:
            continue
        oriented = shapely.geometry.polygon.orient(part)
        rings += [np.asarray(ring.coords)[:-1] for ring in (oriented.exterior, *oriented.interiors)]
    return rings


def _sides(geometry: BaseGeometry) -> Floats:
    sides = [np.stack((ring, np.roll(ring, -1, axis=0)), axis=1) for ring in _rings(geometry)]
    return np.concatenate(sides) if sides else np.zeros((0, 2, 2))
