"""The boat's own track since it was armed, loops cut: a way back that is known to be free."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from companion.core.estimate import NavState
from companion.core.geodesy import LocalFrame

Place = tuple[float, float]

_STEP_M = 2.0  # between two points that are kept
_MOST_POINTS = 8000  # 16 km; then every other one is left out
_MOST_BENDS = 300
_STRAIGHTEN_M = 1.0  # points nearer than this to the straight line between others are left out of the way back


@dataclass(frozen=True, slots=True)
class TrackBack:
    """The own track as it is at one moment; it never changes. `points` lie in the plane of `origin`."""

    points: tuple[Place, ...]
    origin: LocalFrame
    frame: LocalFrame

    def way(self, begin: Place) -> tuple[Place, ...]:
        """From `begin`, where the boat is, along the track to where that began, in the plane of the estimate. Takes up
        to 50 ms."""
        frame, origin = self.frame, self.origin
        here = origin.to_ned(*frame.to_geodetic(*begin))
        back = straightened([here, *reversed(self.points)])[1:]
        return begin, *(frame.to_ned(*origin.to_geodetic(*point)) for point in back)


class OwnTrack:
    """`update` once a tick, in every mode. Remembers a point every 2 m, or farther apart on a long voyage.

    Where the track comes back to itself, what lies between is forgotten: it leads nowhere. Arming begins it anew.
    """

    def __init__(self, frame_of: Callable[[], LocalFrame]) -> None:
        """`frame_of()`: the local plane of the estimate."""
        self._frame_of = frame_of
        self._armed = False
        self._begin(None)

    def _begin(self, origin: LocalFrame | None) -> None:
        self._origin = origin  # the estimate's own plane may move
        self._points: list[Place] = []
        self._step_m = _STEP_M
        self._cells: dict[tuple[int, int], list[int]] = {}

    def update(self, nav: NavState, armed: bool) -> None:
        """Keep the place of the boat, if it is known and far enough from the last one."""
        if armed and not self._armed:
            self._begin(None)
        self._armed = armed
        if not armed or not nav.position_valid:
            return
        if self._origin is None:
            self._origin = LocalFrame(*self._frame_of().to_geodetic(nav.north_m, nav.east_m))
        place = self._origin.to_ned(*self._frame_of().to_geodetic(nav.north_m, nav.east_m))
        if not self._points or math.dist(place, self._points[-1]) >= self._step_m:
            self._keep(place)

    def back(self) -> TrackBack | None:
        """The track as it is now; None without one."""
        if self._origin is None or not self._points:
            return None
        return TrackBack(tuple(self._points), self._origin, self._frame_of())

    def _keep(self, place: Place) -> None:
        met = self._met(place)
        if met is not None:
            self._forget_from(met + 1)
            if math.dist(place, self._points[-1]) < 0.5 * self._step_m:
                return
        elif len(self._points) >= _MOST_POINTS:
            self._thin()
        self._cells.setdefault(self._cell(place), []).append(len(self._points))
        self._points.append(place)

    def _met(self, place: Place) -> int | None:
        """The earliest point that the boat has come back to; None where it is in new water."""
        north, east = self._cell(place)
        near = (
            i
            for row in (north - 1, north, north + 1)
            for column in (east - 1, east, east + 1)
            for i in self._cells.get((row, column), ())
            if i < len(self._points) - 1 and math.dist(place, self._points[i]) < self._step_m
        )
        return min(near, default=None)

    def _cell(self, place: Place) -> tuple[int, int]:
        return math.floor(place[0] / self._step_m), math.floor(place[1] / self._step_m)

    def _forget_from(self, first: int) -> None:
        for i in range(first, len(self._points)):
            self._cells[self._cell(self._points[i])].remove(i)
        del self._points[first:]

    def _thin(self) -> None:
        self._points = self._points[::2]
        self._step_m *= 2.0
        self._cells = {}
        for i, point in enumerate(self._points):
            self._cells.setdefault(self._cell(point), []).append(i)


def straightened(points: Sequence[Place]) -> tuple[Place, ...]:
    """The same line with fewer points (Douglas and Peucker 1973, by shapely), at most 300, both ends kept."""
    from shapely import LineString

    if len(points) < 3:
        return tuple(points)
    line, tolerance_m = LineString(points), _STRAIGHTEN_M
    while True:
        kept = tuple((north, east) for north, east in line.simplify(tolerance_m, preserve_topology=False).coords)
        if len(kept) <= _MOST_BENDS:
            return kept
        tolerance_m *= 2.0
