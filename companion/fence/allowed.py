"""Where the boat may be sent, by the fence as it is at one moment. It never changes, so work beside the control thread
can ask it too."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from companion.core.work import Lane

if TYPE_CHECKING:
    from companion.fence.area import FenceArea
    from companion.fence.areas import FenceAreas
    from companion.fence.preparation import Ways

Place = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Way:
    """Points to sail, the boat's own place first. `radius_m`: how closely each is to be passed; None: NAV_ACC_RAD."""

    points: tuple[Place, ...]
    radius_m: float | None

    @property
    def length_m(self) -> float:
        """Length along the straight legs."""
        return sum(math.dist(a, b) for a, b in zip(self.points, self.points[1:], strict=False))


@dataclass(frozen=True, slots=True)
class Allowed:
    """`areas`: None without a fence. `kept_m`: distance of plans from the fence. `radius_m`: of waypoints without one
    of their own."""

    areas: FenceAreas | None
    ways: Ways | None
    kept_m: float
    radius_m: float

    def in_lane(self, lane: Lane) -> Allowed:
        """The same for another thread (`FenceArea.in_lane`)."""
        if self.areas is None or lane is Lane.CONTROL:
            return self
        ways = None if self.ways is None else self.ways.in_lane(lane)
        return replace(self, areas=self.areas.in_lane(lane), ways=ways)

    @property
    def is_small(self) -> bool:
        """Whether ways are found within a tick."""
        return self.areas is None or self.areas.keeping.is_small

    def point_refusal(self, north_m: float, east_m: float) -> str | None:
        """Why the boat may not be sent to that point; None where it may."""
        areas = self.areas
        if areas is None or areas.keeping.contains(north_m, east_m):
            return None
        if not areas.fence.contains(north_m, east_m):
            return "outside the fence"
        return f"nearer than {self.kept_m:.1f} m to the fence"

    def line_refusal(self, line: Sequence[Place]) -> str | None:
        """Why the boat, which is at the begin of the line, may not be sent along it; None where it may. A boat outside
        may always come in."""
        areas = self.areas
        if areas is None:
            return None
        if areas.fence.first_exit(line, forgive_start=not areas.fence.contains(*line[0])) is not None:
            return "way crosses the fence"
        if areas.keeping.first_exit(line, forgive_start=True) is not None:
            return f"way nearer than {self.kept_m:.1f} m to the fence"
        return None

    def allows_berth(self, line: Sequence[Place]) -> bool:
        """Whether the boat may come alongside along `line`: at a berth only the fence counts, without a margin."""
        areas = self.areas
        return areas is None or areas.fence.first_exit(line, forgive_start=not areas.fence.contains(*line[0])) is None

    def is_open(self, begin: Place, end: Place) -> bool:
        """Whether the boat at `begin` may be sent straight to `end`: `line_refusal` without the reason, which takes
        long in a large fence."""
        areas = self.areas
        if areas is None or areas.keeping.covers((begin, end)):
            return True
        return not areas.keeping.contains(*begin) and self.line_refusal((begin, end)) is None

    def is_straight(self, begin: Place, end: Place) -> bool:
        """Whether `way` leads straight from `begin` to `end`, so that finding it takes no time."""
        keeping = None if self.areas is None else self.areas.keeping
        return keeping is None or (keeping.contains(*begin) and keeping.contains(*end) and keeping.covers((begin, end)))

    def inside(self, places: Sequence[Place]) -> Sequence[bool]:
        """Whether the boat may be sent to each of the places (`point_refusal`), for many at once."""
        return [True] * len(places) if self.areas is None else self.areas.keeping.contains_each(places)

    def clear(self, lines: Sequence[Sequence[Place]]) -> Sequence[bool]:
        """Whether each line lies where the boat may be sent, for many at once. False only means that `line_refusal`
        must tell."""
        return [True] * len(lines) if self.areas is None else self.areas.keeping.covers_lines(lines)

    def way(self, begin: Place, end: Place) -> Way | None:
        """The shortest way that keeps clear of the fence; None where there is none.

        It leaves room for the corners that the path cuts, or less room where the gap is narrow. An `end` inside the
        fence but too near to it is replaced by the nearest point that is far enough.
        """
        areas = self.areas
        if areas is None:
            return Way((begin, end), None)
        if not areas.fence.contains(*end):
            return None
        if not areas.keeping.contains(*end):
            inside = areas.keeping.nearest_inside(*end)
            if inside is None:
                return None
            end = inside
        assert self.ways is not None
        for radius in self.ways.radii_m(self.radius_m):
            points = self._find(areas.keeping, self.ways, radius, begin, end)
            if (
                points is not None
                and areas.fence.first_exit(points, forgive_start=not areas.fence.contains(*begin)) is None
            ):
                return Way(points, radius)
        return None

    @staticmethod
    def _find(keeping: FenceArea, ways: Ways, radius_m: float, begin: Place, end: Place) -> tuple[Place, ...] | None:
        """A way whose bends keep room for their radius; begin and end need not."""
        if keeping.contains(*begin) and keeping.covers((begin, end)):
            return begin, end
        return ways.of(radius_m).find(begin, end, through=keeping)
