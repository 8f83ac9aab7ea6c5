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
from functools import cached_property, reduce

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely.geometry import LineString, MultiPolygon, Point, Polygon, box
from shapely.geometry.base import BaseGeometry

from companion.core.work import Lane
from companion.fence.sides import Sides, rings_of

Floats = NDArray[np.float64]
Place = tuple[float, float]

_WORLD_M = 500_000.0  # without inclusion zones, everything up to here is inside
_SAG_M = 0.02  # error of the polygon that stands for a circle, to the safe side
_MOST_ARC_SIDES, _LEAST_ARC_SIDES = 720, 12
_MOST_DISC_SIDES = 120_000  # of all circles together: beyond that, each is drawn more coarsely
_TOUCH_M = 1.0e-6
_INSIDE_M = 1.0e-3  # a place so far beyond the line is surely inside
_SIMPLER_M = 0.01
_FEW_SIDES = 60
_PIECE_M = 20.0
_DEEP_M, _DEEP_SHARE = 0.5, 0.02  # how exactly the largest disc inside is found
_MIDDLE_SHARE = 0.9  # of its radius: so far inside is the middle
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
    """An area that never changes. It is empty where the zones of a group do not overlap. One thread may query it; the
    others query theirs (`in_lane`)."""

    def __init__(self, groups: Mapping[int, Sequence[Shape]], exclusions: Sequence[Shape]) -> None:
        """`groups`: inclusion zones by group number. `exclusions`: exclusion zones."""
        discs = sum(isinstance(shape, Disc) for shapes in (*groups.values(), exclusions) for shape in shapes)
        most = min(_MOST_ARC_SIDES, max(_LEAST_ARC_SIDES, _MOST_DISC_SIDES // max(1, discs)))
        inside = [
            reduce(shapely.intersection, [_polygon(shape, True, most) for shape in shapes])
            for shapes in groups.values()
        ]
        area = shapely.union_all(inside) if inside else box(-_WORLD_M, -_WORLD_M, _WORLD_M, _WORLD_M)
        forbidden = shapely.union_all([_polygon(shape, False, most) for shape in exclusions])
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
        self._sides = Sides(rings_of(geometry))
        self._others: dict[Lane, FenceArea] = {}
        self._use()

    def in_lane(self, lane: Lane) -> FenceArea:
        """The same area for another thread: the prepared geometries of GEOS serve one thread at a time, and two at once
        end the process. Call it there: the first time it takes as long as preparing them."""
        if lane is Lane.CONTROL:
            return self
        if lane not in self._others:
            self._others[lane] = self._copy()
        return self._others[lane]

    def _copy(self) -> FenceArea:
        area = FenceArea.__new__(FenceArea)
        area.geometry, area._touching = (shapely.from_wkb(shapely.to_wkb(g)) for g in (self.geometry, self._touching))
        area._sides, area._others = self._sides, {}
        shapely.prepare(area.geometry)
        shapely.prepare(area._touching)
        area._use()
        return area

    def _use(self) -> None:
        """Use the prepared geometries: GEOS makes their indices with the first and the second use, which takes long."""
        if self.geometry.is_empty:
            return
        place = shapely.point_on_surface(self.geometry)
        for _ in range(3):
            self.contains(place.x, place.y)
            self.covers(((place.x, place.y), (place.x + 1.0, place.y)))
            self.nearest_inside(place.x, place.y)

    @property
    def empty(self) -> bool:
        """Whether no place is inside."""
        return bool(self.geometry.is_empty)

    @property
    def is_small(self) -> bool:
        """Whether queries take so little time that a tick can make some hundred of them."""
        return len(self._sides) <= _FEW_SIDES

    def shrunk(self, by_m: float) -> FenceArea:
        """The places that are inside by at least `by_m` (to 1 % of it at corners that stick into the area)."""
        return FenceArea.of(self.geometry.buffer(-by_m, quad_segs=_ARCS)) if by_m > 0.0 else self

    def within(self, disc: Disc) -> FenceArea:
        """The places of this area that are inside the disc too; none for a disc without a radius."""
        kept = _polygon(disc, True, _MOST_ARC_SIDES) if disc.radius_m > 0.0 else Polygon()
        return FenceArea.of(shapely.intersection(self.geometry, kept))

    def contains(self, north_m: float, east_m: float) -> bool:
        """Whether the place is inside; the line itself is inside."""
        return bool(shapely.intersects_xy(self.geometry, north_m, east_m))

    def margin(self, north_m: float, east_m: float) -> Margin:
        """Signed distance to the line and the direction of its nearest point; −∞ for an empty area."""
        if len(self._sides) == 0:
            return Margin(-math.inf, 0.0, 0.0)
        distance_m, way_north_m, way_east_m = self._sides.nearest(north_m, east_m)
        if distance_m < 1.0e-9:
            return Margin(0.0, 0.0, 0.0)
        signed_m = distance_m if self.contains(north_m, east_m) else -distance_m
        return Margin(signed_m, way_north_m / distance_m, way_east_m / distance_m)

    def way_to_line_m(self, north_m: float, east_m: float, north: float, east: float) -> float:
        """Distance from a place to the line along the unit vector (north, east); infinite where that never meets it."""
        return self._sides.first_hit_m(north_m, east_m, north, east)

    def way_inside_m(self, north_m: float, east_m: float, north: float, east: float) -> float:
        """As `way_to_line_m`; of a place outside, from the nearest one inside, and 0 where the vector leads out."""
        if self.contains(north_m, east_m):
            return self.way_to_line_m(north_m, east_m, north, east)
        back = self.margin(north_m, east_m)
        if north * back.north + east * back.east <= 0.0:
            return 0.0
        in_m = _INSIDE_M - back.distance_m
        begin = north_m + in_m * back.north, east_m + in_m * back.east
        return self.way_to_line_m(*begin, north, east) if self.contains(*begin) else math.inf

    def nearest_inside(self, north_m: float, east_m: float) -> Place | None:
        """The nearest place of the area: the place itself where it is inside. None for an empty area."""
        if self.empty:
            return None
        if self.contains(north_m, east_m):
            return north_m, east_m
        point = shapely.get_point(shapely.shortest_line(self.geometry, Point(north_m, east_m)), 0)
        return float(point.x), float(point.y)

    @cached_property
    def middle(self) -> FenceArea:
        """The places that are nearly as far from the line as any. The first time it takes some milliseconds."""
        least_m, most_m = 0.0, math.sqrt(self.geometry.area)  # of the largest disc inside: its radius
        while most_m - least_m > max(_DEEP_M, _DEEP_SHARE * most_m):
            tried_m = 0.5 * (least_m + most_m)
            if self.geometry.buffer(-tried_m, quad_segs=_ARCS).is_empty:
                most_m = tried_m
            else:
                least_m = tried_m
        return self.shrunk(_MIDDLE_SHARE * least_m)

    def covers(self, line: Sequence[Place] | Floats) -> bool:
        """Whether the whole line lies inside; touching is inside."""
        return bool(shapely.covers(self._touching, _line(line)))

    def covers_each(self, lines: Floats) -> NDArray[np.bool_]:
        """As `covers`, for many lines of two points each: shape (n, 2, 2) → (n,)."""
        result: NDArray[np.bool_] = shapely.covers(self._touching, shapely.linestrings(lines))
        return result

    def covers_lines(self, lines: Sequence[Sequence[Place]]) -> list[bool]:
        """As `covers` to within a centimetre, for many lines of two points or more each."""
        if not lines:
            return []
        places = np.concatenate([np.asarray(line, dtype=np.float64) for line in lines])
        numbers = np.repeat(np.arange(len(lines)), [len(line) for line in lines])
        given = shapely.linestrings(places, indices=numbers)
        simpler = shapely.simplify(given, _SIMPLER_M, preserve_topology=False)
        covered: list[bool] = shapely.covers(self._touching, simpler).tolist()
        return covered

    def contains_each(self, places: Sequence[Place]) -> list[bool]:
        """As `contains`, for many places."""
        points = np.asarray(places, dtype=np.float64).reshape(-1, 2)
        inside: list[bool] = shapely.intersects_xy(self.geometry, points[:, 0], points[:, 1]).tolist()
        return inside

    def first_exit(self, line: Sequence[Place] | Floats, forgive_start: bool = False) -> Place | None:
        """Where the line first leaves the area; None where it does not. `forgive_start`: a line that begins outside may
        come in; only what follows counts."""
        return None if self.covers(line) else self._exit(np.asarray(line, dtype=np.float64), forgive_start)[0]

    def _exit(self, line: Floats, forgive: bool) -> tuple[Place | None, bool]:
        """Where a line that is not covered first leaves the area, and whether its end still belongs to a forgiven
        beginning outside. Long lines are halved, since their difference from an area of many sides takes long."""
        halves = None if self.is_small else _halves(line)
        if halves is None:
            return self._exit_of_piece(line, forgive)
        for half in halves:
            if self.covers(half):
                forgive = False
                continue
            place, forgive = self._exit(half, forgive)
            if place is not None:
                return place, False
        return None, forgive

    def _exit_of_piece(self, line: Floats, forgive: bool) -> tuple[Place | None, bool]:
        """As `_exit`, exactly."""
        whole = _line(line)
        if forgive and len(line) > 2 and not whole.is_simple:  # GEOS cuts a line where it meets itself
            return self._exit_by_legs(line)
        if not shapely.intersects(self._touching, whole):  # their difference would look at all sides
            return (None, True) if forgive else ((float(line[0, 0]), float(line[0, 1])), False)
        outside = shapely.difference(whole, self._touching)
        parts = [part for part in shapely.get_parts(outside).tolist() if part.length > 10.0 * _TOUCH_M]
        begin, end = Point(line[0]), Point(line[-1])
        lasts = forgive and any(part.distance(begin) <= _TOUCH_M and part.distance(end) <= _TOUCH_M for part in parts)
        if forgive:
            parts = [part for part in parts if part.distance(begin) > _TOUCH_M]
        if not parts:
            return None, lasts
        places = sorted((float(whole.project(Point(*part.coords[0]))), part.coords[0]) for part in parts)
        return (float(places[0][1][0]), float(places[0][1][1])), False

    def _exit_by_legs(self, line: Floats) -> tuple[Place | None, bool]:
        """As `_exit` of a line whose beginning outside is forgiven, leg by leg."""
        forgive = True
        for leg in (line[i : i + 2] for i in range(len(line) - 1)):
            place, forgive = (None, False) if self.covers(leg) else self._exit_of_piece(leg, forgive)
            if place is not None:
                return place, False
        return None, forgive

    def corners(self, simplified_m: float = 0.0) -> Floats:
        """Vertices that stick into the area: a shortest way can bend only there. Shape (n, 2). `simplified_m`:
        tolerance by which the boundary is simplified first."""
        places, across, _ = self._turns(simplified_m)
        return places[across < -1.0e-9]

    def notches(self, simplified_m: float, least_rad: float) -> Floats:
        """Vertices where the area reaches into what is left out, by a turn of at least `least_rad`: where a gap has
        closed. Shape (n, 2)."""
        places, across, along = self._turns(simplified_m)
        return places[np.arctan2(across, along) > least_rad]

    def _turns(self, simplified_m: float) -> tuple[Floats, Floats, Floats]:
        """The vertices, shape (n, 2), and the cross and dot products of the sides before and after each; the area lies
        on the same side of all, and the cross product is negative where it turns away from it."""
        geometry = self.geometry.simplify(simplified_m) if simplified_m > 0.0 else self.geometry
        rings = rings_of(geometry)
        here = rings.places
        before, after = here - here[rings.before], here[rings.after] - here
        across: Floats = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
        return here, across, np.einsum("ij,ij->i", before, after)


def _halves(line: Floats) -> tuple[Floats, Floats] | None:
    """The line cut in the middle of its length; None for a short one."""
    steps = np.hypot(*np.diff(line, axis=0).T)
    length = np.concatenate(([0.0], np.cumsum(steps)))
    if length[-1] <= _PIECE_M:
        return None
    half = 0.5 * length[-1]
    i = min(len(steps) - 1, max(0, int(np.searchsorted(length, half, side="right")) - 1))
    share = (half - length[i]) / steps[i]
    middle = line[i] + share * (line[i + 1] - line[i])
    return np.vstack((line[: i + 1], [middle])), np.vstack(([middle], line[i + 1 :]))


def _line(points: Sequence[Place] | Floats) -> LineString:
    array = np.asarray(points, dtype=np.float64)
    return LineString(array if len(array) > 1 else np.repeat(array, 2, axis=0))


def _areal(geometry: BaseGeometry) -> BaseGeometry:
    """The polygons of a geometry, without the points and lines in which zones may touch."""
    parts = [part for part in shapely.get_parts(geometry).tolist() if part.geom_type == "Polygon" and part.area > 0.0]
    return MultiPolygon(parts) if len(parts) != 1 else parts[0]


def _polygon(shape: Shape, inclusion: bool, most: int) -> BaseGeometry:
    """A zone as a shapely polygon. A circle becomes one of at most `most` sides, inside it (inclusion) or around it
    (exclusion)."""
    if not isinstance(shape, Disc):
        return _areal(shapely.make_valid(Polygon(shape)))  # GEOS refuses some mixtures of areas and lines
    sag = min(0.5, _SAG_M / shape.radius_m)
    count = min(most, max(16, math.ceil(math.pi / math.acos(1.0 - sag))))
    radius_m = shape.radius_m if inclusion else shape.radius_m / math.cos(math.pi / count)
    angles = np.arange(count) * (math.tau / count)
    return Polygon(
        np.column_stack((shape.north_m + radius_m * np.cos(angles), shape.east_m + radius_m * np.sin(angles)))
    )
