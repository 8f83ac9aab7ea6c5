"""The water that is open to the boat: inside the fence, clear of the chart's obstacles and of what sensors see. Ways
through it.

What sensors see are circles. A way keeps half a boat's length and CP_DIST from each and from the chart's obstacles, and
the distance that it keeps from the fence anyway. It is the shortest one in the visibility graph of
`companion.fence.way_round`, over what the obstacles leave of the fence's own area.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from companion.config.vessel import VesselConfig
from companion.core.estimate import NavState
from companion.core.work import Lane
from companion.fence.allowed import Allowed, Place, Way
from companion.fence.guard import FenceGuard
from companion.obstacles.chart_water import ChartKeeper, ChartWater
from companion.obstacles.circling import Circling, circling_at
from companion.obstacles.clear_way import GRAZE_M
from companion.obstacles.occupancy import Floats
from companion.params.store import Parameters

if TYPE_CHECKING:
    from companion.fence.area import FenceArea

_AROUND_M = 80.0  # beyond the obstacles and the ends of the way, a way round may lead so far
_AROUND_CHART_M = (80.0, 500.0, 3000.0)  # the same round a chart's obstacles, tried in turn
_ARCS = 3  # sides for each quarter of an obstacle's circle
_CORNER_CUT = 0.6  # share of a waypoint's radius by which the path may cut its corner
_RADII = (1.0, 0.2)  # of NAV_ACC_RAD: waypoint radius on a way round, and through a narrow gap
_CIRCLING_RADII = (1.0, 0.5, 0.2)  # the same of a boat that turns in circles
_WORTH, _WORTH_RADII = 1.1, 2.0  # a way for wide bends may be longer by that factor, and by so many of their radii
_SIMPLER_M = 0.3
_START_M = 0.05
_SURE_M = 15.0  # from the boat: obstacles further off may be smaller than they look
_LEAST_RADIUS_M = 0.3


@dataclass(frozen=True, slots=True, eq=False)
class Water:
    """Queries over what is known at one moment. It never changes; work beside the control thread asks the same of its
    lane.

    `circles`: north_m, east_m, radius_m of obstacles that lie, shape (n, 3). `keep_m`: distance that the middle of the
    boat keeps from obstacles. `circling`: None for a boat that turns without way, so that it can sail narrow bends.
    """

    circles: Floats
    keep_m: float
    allowed: Allowed
    chart: ChartWater | None = None
    circling: Circling | None = None

    def in_lane(self, lane: Lane) -> Water:
        """The same for another thread (`FenceArea.in_lane`)."""
        chart = None if self.chart is None else self.chart.in_lane(lane)
        return replace(self, allowed=self.allowed.in_lane(lane), chart=chart)

    def free_m(self, way: Sequence[Place]) -> float:
        """How far along a way the boat keeps clear of all obstacles; infinite where it always does. Of an obstacle that
        is near at its begin, the way must lead away."""
        if len(way) < 2:
            return math.inf
        by_chart = math.inf if self.chart is None else self.chart.free_m(way)
        return min(by_chart, self._free_of_circles_m(way))

    def _free_of_circles_m(self, way: Sequence[Place]) -> float:
        if not len(self.circles):
            return math.inf
        circles = self._hoped(way[0])
        points = np.asarray(way, dtype=float)
        begin, along = points[:-1], np.diff(points, axis=0)
        lengths = np.hypot(along[:, 0], along[:, 1])
        keep = self.keep_m - GRAZE_M + circles[:, 2]
        keep = np.minimum(keep, np.hypot(*(circles[:, :2] - points[0]).T) - _START_M)
        off = circles[None, :, :2] - begin[:, None, :]
        share = np.einsum("sci,si->sc", off, along) / np.maximum(lengths**2, 1e-12)[:, None]
        share = np.clip(share, 0.0, 1.0)
        gaps = np.hypot(*np.moveaxis(off - share[:, :, None] * along[:, None, :], 2, 0))
        blocked = gaps < keep
        if not blocked.any():
            return math.inf
        before = np.concatenate(([0.0], np.cumsum(lengths)[:-1]))
        return float(np.where(blocked, before[:, None] + share * lengths[:, None], math.inf).min())

    def clear(self, begin: Place, end: Place) -> bool:
        """Whether the straight line keeps clear of obstacles and inside the fence."""
        return self.line_refusal((begin, end)) is None

    def is_open(self, begin: Place, end: Place) -> bool:
        """As `clear`, of fence and chart alone."""
        return self.allowed.is_open(begin, end) and (
            self.chart is None or self.chart.line_refusal((begin, end)) is None
        )

    def line_refusal(self, line: Sequence[Place]) -> str | None:
        """Why the boat may not be sent along the line: the fence, or an obstacle; None where it may."""
        return "obstacle in the way" if math.isfinite(self.free_m(line)) else self.allowed.line_refusal(line)

    def way(self, begin: Place, end: Place) -> Way | None:
        """The shortest way, or None. An `end` that is too near to an obstacle is replaced by the nearest place that is
        not."""
        if not len(self.circles):
            if self.chart is None:
                return self.allowed.way(begin, end)
            if self.chart.keeping.covers((begin, end)) and self.allowed.line_refusal((begin, end)) is None:
                return Way((begin, end), None)
        found = self._way(begin, end, self.circles)
        if found is not None and self._short_enough(found, math.dist(begin, end)):
            return found
        hopes = self._hoped(begin)
        if np.array_equal(hopes, self.circles):
            return found
        hoped = self._way(begin, end, hopes)
        takes = found is None or (hoped is not None and not self._short_enough(found, hoped.length_m))
        return hoped if takes else found

    def _hoped(self, begin: Place) -> Floats:
        """The obstacles, those further off as small as they may be: a far look is coarse, and gaps show on the way."""
        circles = self.circles.copy()
        far = np.hypot(*(circles[:, :2] - begin).T) - circles[:, 2] > _SURE_M
        circles[far, 2] = np.minimum(circles[far, 2], _LEAST_RADIUS_M)
        return circles

    def _way(self, begin: Place, end: Place, circles: Floats) -> Way | None:
        for around_m in (_AROUND_M,) if self.chart is None else _AROUND_CHART_M:
            found = self._way_within(begin, end, circles, around_m)
            if found is not None:
                return found
        return None

    def _way_within(self, begin: Place, end: Place, circles: Floats, around_m: float) -> Way | None:
        """With room for wide bends, unless one through narrower gaps is much shorter and the boat can follow it; at
        last, among what sensors see, through gaps that only a straight leg fits."""
        water = self._area(begin, end, circles, around_m)
        if water.empty:
            return None
        if not water.contains(*end):
            nearest = water.nearest_inside(*end)
            if nearest is None:
                return None
            end = nearest
        best = None
        shares = _RADII if self.circling is None else _CIRCLING_RADII
        kinds = [(share, False) for share in shares] + [(shares[-1], True)] * bool(len(circles))
        for share, straight in kinds:
            way = self._way_with_room(begin, end, water, share * self.allowed.radius_m, straight)
            if way is None or not self._follows(way):
                continue
            if best is None or not self._short_enough(best, way.length_m):
                best = way
            if self._short_enough(best, math.dist(begin, end)):
                break
        return best

    def _follows(self, way: Way) -> bool:
        """Whether the boat can sail the way: on to what lies beside one that it cannot, it would be carried. Where it
        lies, it must have room to turn to it."""
        circling = self.circling
        if circling is None or way.radius_m is None:
            return True
        turns = way.points[0] != circling.here or self._turns_to(way.points[1], circling)
        return turns and circling.follows(way.points, way.radius_m)

    def _turns_to(self, place: Place, circling: Circling) -> bool:
        arc = circling.arc_to(place)
        return arc is not None and math.isinf(replace(self, keep_m=circling.keep_m).free_m(arc))

    def _way_with_room(self, begin: Place, end: Place, water: FenceArea, radius_m: float, straight: bool) -> Way | None:
        """The shortest way whose bends have waypoints of that radius; None without one. `straight`: it has room for
        them at its bends alone, and goes straight through gaps. A begin outside the room for them is no reason to sail
        through an obstacle into it."""
        from companion.fence.area import FenceArea
        from companion.fence.roadmap import routes_in

        roomy = FenceArea.of(water.geometry.buffer(-_CORNER_CUT * radius_m, quad_segs=_ARCS))
        points = None
        if not roomy.empty:
            points = routes_in(roomy, water if straight else None).find(begin, end, through=water)
        if points is None or math.isfinite(self.free_m(points[:2])):
            return None
        return Way(points, radius_m)

    def _short_enough(self, wide: Way, length_m: float) -> bool:
        """Whether a way for wide bends is worth being so much longer than one of that length."""
        return wide.length_m <= _WORTH * length_m + _WORTH_RADII * self.allowed.radius_m

    def _area(self, begin: Place, end: Place, circles: Floats, around_m: float) -> FenceArea:
        import shapely

        from companion.fence.area import FenceArea

        places = np.vstack((circles[:, :2], [begin], [end]))
        low, high = places.min(axis=0) - around_m, places.max(axis=0) + around_m
        whole = shapely.box(*low, *high)
        if self.chart is not None:
            whole = shapely.intersection(self.chart.keeping.geometry, whole)
        if self.allowed.areas is not None:
            whole = shapely.intersection(self.allowed.areas.keeping.geometry, whole)
        rings = shapely.buffer(shapely.points(circles[:, :2]), circles[:, 2] + self.keep_m, quad_segs=_ARCS)
        taken = shapely.simplify(shapely.union_all(rings), _SIMPLER_M)
        return FenceArea.of(shapely.difference(whole, taken))


class OpenWater:
    """`now` → the water as it is. Remembers the obstacles as last set, and how the boat turned then."""

    def __init__(
        self, config: VesselConfig, parameters: Parameters, fence: FenceGuard, chart: ChartKeeper | None = None
    ) -> None:
        self._config = config
        self._parameters = parameters
        self._fence = fence
        self._chart = chart
        self._circles: Floats = np.zeros((0, 3))
        self._circling: Circling | None = None

    def set_obstacles(self, circles: Floats, nav: NavState, speed_mps: float) -> None:
        """`circles`: north_m, east_m, radius_m of all obstacles that lie, shape (n, 3). Not to be changed after.
        `nav`: the boat then; `speed_mps`: at which it sails."""
        self._circles = circles
        self._circling = circling_at(self._config, self._parameters, nav, speed_mps)

    @property
    def now(self) -> Water:
        """All that is known now."""
        keep_m = 0.5 * self._config.length_m + max(0.0, self._parameters["CP_DIST"])
        chart = None if self._chart is None else self._chart.water
        return Water(self._circles, keep_m, self._fence.allowed, chart, self._circling)

    def line_refusal(self, line: Sequence[Place]) -> str | None:
        """As `Water.line_refusal`."""
        return self.now.line_refusal(line)
