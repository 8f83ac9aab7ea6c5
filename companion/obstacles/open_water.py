"""The water that is open to the boat: inside the fence, and clear of what is known of obstacles. Ways through it.

Obstacles are circles. A way keeps half a boat's length and CP_DIST from each, and the distance that it keeps from the
fence anyway. It is the shortest one in the visibility graph of `companion.fence.way_round`, over what the obstacles
leave of the fence's own area.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from companion.config.vessel import VesselConfig
from companion.fence.guard import FenceGuard, Way
from companion.obstacles.occupancy import Floats
from companion.params.store import Parameters

if TYPE_CHECKING:
    from companion.fence.area import FenceArea

Place = tuple[float, float]

_AROUND_M = 80.0  # beyond the obstacles and the ends of the way, a way round may lead so far
_ARCS = 3  # sides for each quarter of an obstacle's circle
_CORNER_CUT = 0.6  # share of a waypoint's radius by which the path may cut its corner
_RADII = (1.0, 0.2)  # of NAV_ACC_RAD: waypoint radius on a way round, and through a narrow gap
_SIMPLER_M = 0.3
_START_M = 0.05
_SURE_M = 15.0  # from the boat: obstacles further off may be smaller than they look
_LEAST_RADIUS_M = 0.3
_GRAZE_M = 0.3  # by which a way that is already sailed may come nearer than planned


class OpenWater:
    """Queries over the obstacles as last set. Remembers them, and the areas made of them until they change."""

    def __init__(self, config: VesselConfig, parameters: Parameters, fence: FenceGuard) -> None:
        self._half_m = 0.5 * config.length_m
        self._parameters = parameters
        self._fence = fence
        self._circles: Floats = np.zeros((0, 3))

    def set_obstacles(self, circles: Floats) -> None:
        """`circles`: north_m, east_m, radius_m of all obstacles that lie, shape (n, 3)."""
        self._circles = circles

    @property
    def circles(self) -> Floats:
        """The obstacles as last set."""
        return self._circles

    @property
    def keep_m(self) -> float:
        """Distance that the middle of the boat keeps from obstacles."""
        return self._half_m + max(0.0, self._parameters["CP_DIST"])

    def free_m(self, way: Sequence[Place]) -> float:
        """How far along a way the boat keeps clear of all obstacles; infinite where it always does. Of an obstacle that
        is near at its begin, the way must lead away."""
        if len(way) < 2 or not len(self._circles):
            return math.inf
        circles = self._hoped(way[0])
        points = np.asarray(way, dtype=float)
        begin, along = points[:-1], np.diff(points, axis=0)
        lengths = np.hypot(along[:, 0], along[:, 1])
        keep = self.keep_m - _GRAZE_M + circles[:, 2]
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
        line = (begin, end)
        return math.isinf(self.free_m(line)) and self._fence.line_refusal(line) is None

    def line_refusal(self, line: Sequence[Place]) -> str | None:
        """Why the boat may not be sent along the line: the fence, or an obstacle; None where it may."""
        return "obstacle in the way" if math.isfinite(self.free_m(line)) else self._fence.line_refusal(line)

    def reachable(self, place: Place) -> bool:
        """Whether the boat may lie at that place."""
        circles = self._circles
        gaps = np.hypot(*(circles[:, :2] - place).T) - circles[:, 2]
        return bool((gaps >= self.keep_m - _GRAZE_M).all()) and self._fence.point_refusal(*place) is None

    def way(self, begin: Place, end: Place) -> Way | None:
        """The shortest way, or None. An `end` that is too near to an obstacle is replaced by the nearest place that is
        not."""
        if not len(self._circles):
            return self._fence.way(begin, end)
        found = self._way(begin, end, self._circles)
        return found or self._way(begin, end, self._hoped(begin))

    def _hoped(self, begin: Place) -> Floats:
        """The obstacles, those further off as small as they may be: a far look is coarse, and gaps show on the way."""
        circles = self._circles.copy()
        far = np.hypot(*(circles[:, :2] - begin).T) > _SURE_M
        circles[far, 2] = np.minimum(circles[far, 2], _LEAST_RADIUS_M)
        return circles

    def _way(self, begin: Place, end: Place, circles: Floats) -> Way | None:
        from companion.fence.area import FenceArea
        from companion.fence.way_round import ClearRoutes

        water = self._area(begin, end, circles)
        if water.empty:
            return None
        if not water.contains(*end):
            nearest = water.nearest_inside(*end)
            if nearest is None:
                return None
            end = nearest
        for share in _RADII:
            radius_m = share * self._parameters["NAV_ACC_RAD"]
            roomy = FenceArea.of(water.geometry.buffer(-_CORNER_CUT * radius_m, quad_segs=_ARCS))
            if roomy.empty:
                continue
            points = ClearRoutes(roomy).find(begin, end, through=water)
            if points is not None:
                return Way(points, radius_m)
        return None

    def _area(self, begin: Place, end: Place, circles: Floats) -> FenceArea:
        import shapely

        from companion.fence.area import FenceArea

        rings = shapely.buffer(shapely.points(circles[:, :2]), circles[:, 2] + self.keep_m, quad_segs=_ARCS)
        taken = shapely.simplify(shapely.union_all(rings), _SIMPLER_M)
        areas = self._fence.areas()
        places = np.vstack((circles[:, :2], [begin], [end]))
        low, high = places.min(axis=0) - _AROUND_M, places.max(axis=0) + _AROUND_M
        around = shapely.box(*low, *high)
        whole = around if areas is None else shapely.intersection(areas.keeping.geometry, around)
        return FenceArea.of(shapely.difference(whole, taken))
