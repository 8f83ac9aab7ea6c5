"""The obstacles of a chart in the local plane, and the water that they leave."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from companion.config.chart import ChartFeature
from companion.config.vessel import VesselConfig
from companion.core.geodesy import LocalFrame
from companion.core.ports import Worker
from companion.core.work import Lane
from companion.fence.allowed import Place
from companion.obstacles.clear_way import GRAZE_M, STOP_SHARE
from companion.params.store import Parameters

if TYPE_CHECKING:
    from shapely.geometry.base import BaseGeometry

    from companion.fence.area import FenceArea

_REACH_M = 20_000.0  # from the origin of the local plane: what lies further off is left out
_SIMPLER_M = 0.1
_ARCS = 4
_WORLD_M = 500_000.0
_DRAWN_M = (0.5, 2.0, 10.0, 50.0, 200.0)  # tolerances of what displays draw
_MOST_DRAWN = 1500  # corners


@dataclass(frozen=True, slots=True, eq=False)
class ChartWater:
    """Areas of open water that never change. `bare`: all but the obstacles themselves. `stopping`: where the middle of
    the boat may come to rest. `sailing`: where a way already laid may lead. `keeping`: where plans may lead.
    `outline`: the obstacles for displays, drawn coarsely."""

    bare: FenceArea
    stopping: FenceArea
    sailing: FenceArea
    keeping: FenceArea
    outline: tuple[tuple[Place, ...], ...]

    def in_lane(self, lane: Lane) -> ChartWater:
        """The same for another thread (`FenceArea.in_lane`)."""
        bare, stopping = self.bare.in_lane(lane), self.stopping.in_lane(lane)
        return ChartWater(bare, stopping, self.sailing.in_lane(lane), self.keeping.in_lane(lane), self.outline)

    def point_refusal(self, north_m: float, east_m: float) -> str | None:
        """Why the boat may not be sent to that point; None where it may."""
        if self.keeping.contains(north_m, east_m):
            return None
        return "too near a chart obstacle" if self.bare.contains(north_m, east_m) else "in a chart obstacle"

    def line_refusal(self, line: Sequence[Place]) -> str | None:
        """Why the boat, at the begin of the line, may not be sent along it; None where it may."""
        return "way crosses a chart obstacle" if math.isfinite(self.free_m(line)) else None

    def free_m(self, way: Sequence[Place]) -> float:
        """How far along a way the boat keeps clear; infinite where it always does. Where it begins too near, it must
        lead away, and never into an obstacle."""
        exits = [self.sailing.first_exit(way, forgive_start=True)]
        if not self.sailing.contains(*way[0]):
            inner = self.stopping if self.stopping.contains(*way[0]) else self.bare
            exits.append(inner.first_exit(way, forgive_start=True))
        return min((_along_m(way, place) for place in exits if place is not None), default=math.inf)

    def stop_m(self, here: Place, along: Place) -> float:
        """Way straight ahead, along a unit vector, until the hull is too near; infinite where it never is. From what is
        too near already, the way must lead away."""
        way_m = self.stopping.way_inside_m(*here, *along)
        return way_m if way_m < _REACH_M else math.inf


Key = tuple[LocalFrame, float, float]


class ChartKeeper:
    """`water` → the chart's open water as it is now; None without a chart, while CP_DIST is below 0, or while it is
    being made. Remembers it until the local plane, CP_DIST or CP_DEPTH_MIN changes."""

    def __init__(
        self,
        config: VesselConfig,
        parameters: Parameters,
        frame: Callable[[], LocalFrame],
        features: Sequence[ChartFeature] = (),
    ) -> None:
        self._half_m = 0.5 * config.length_m
        self._parameters = parameters
        self._frame = frame
        self._features = tuple(features)
        self._worker: Worker | None = None
        self._key: Key | None = None
        self._water: ChartWater | None = None
        self._work: tuple[Key, Future[ChartWater | None]] | None = None

    def load(self, features: Sequence[ChartFeature]) -> None:
        """Take a chart, and make its water at once: a tick has no time for it."""
        self._features, self._key = tuple(features), None
        _ = self.water

    def work_with(self, worker: Worker) -> None:
        """Let `worker` make the water anew when settings change."""
        self._worker = worker

    @property
    def key(self) -> Key | tuple[()]:
        """Changes whenever the water has changed; () without any."""
        return () if self.water is None or self._key is None else self._key

    @property
    def water(self) -> ChartWater | None:
        """The water as it is now."""
        p = self._parameters
        if not self._features or p["CP_DIST"] < 0.0:
            return None
        wanted = self._frame(), p["CP_DIST"], p["CP_DEPTH_MIN"]
        if wanted != self._key:
            self._make(wanted)
        return self._water

    @property
    def outline(self) -> tuple[tuple[Place, ...], ...]:
        """The obstacles for displays; empty without any."""
        water = self.water
        return () if water is None else water.outline

    def _make(self, wanted: Key) -> None:
        """Make it: at once the first time, else beside the control thread. Water in another plane counts no more."""
        frame, dist_m, depth_m = wanted
        build = partial(chart_water, self._features, frame, self._half_m, dist_m, depth_m)
        if self._worker is None or self._key is None:
            self._key, self._water = wanted, build()
            return
        if self._key[0] != frame:
            self._water = None
        if self._work is None or self._work[0] != wanted:
            self._work = wanted, self._worker.submit(build)
        if self._work[1].done():
            (self._key, future), self._work = self._work, None
            self._water = future.result()


def chart_water(
    features: Sequence[ChartFeature], frame: LocalFrame, half_m: float, dist_m: float, depth_m: float
) -> ChartWater | None:
    """The water that a chart leaves to a boat of half a length `half_m` that keeps `dist_m`, in water of at least
    `depth_m`; None where nothing of it is an obstacle within 20 km."""
    import shapely

    from companion.fence.area import FenceArea

    shapes = [_local(one, frame) for one in features if one.is_obstacle(depth_m)]
    taken = shapely.clip_by_rect(shapely.union_all(shapes), -_REACH_M, -_REACH_M, _REACH_M, _REACH_M)
    if taken.is_empty:
        return None
    parts = shapely.get_parts(taken)  # widened one by one, which is much quicker than all at once
    world = shapely.box(-_WORLD_M, -_WORLD_M, _WORLD_M, _WORLD_M)

    def left(by_m: float) -> FenceArea:
        wider = shapely.union_all(shapely.buffer(parts, by_m, quad_segs=_ARCS)) if by_m > 0.0 else taken
        return FenceArea.of(shapely.difference(world, wider))

    keep_m = half_m + dist_m
    stopping, sailing = left(half_m + STOP_SHARE * dist_m), left(keep_m - min(GRAZE_M, dist_m))
    return ChartWater(left(0.0), stopping, sailing, left(keep_m), _outline(taken))


def _local(feature: ChartFeature, frame: LocalFrame) -> object:
    """A feature in the local plane, (north_m, east_m), as wide as it is."""
    import numpy as np
    import shapely

    def project(places: object) -> object:
        lon_lat = np.asarray(places, dtype=float)
        return np.array([frame.to_ned(lat, lon) for lon, lat in lon_lat.tolist()]).reshape(-1, 2)

    placed = shapely.simplify(shapely.make_valid(shapely.transform(feature.geometry, project)), _SIMPLER_M)
    return placed.buffer(feature.radius_m, quad_segs=_ARCS) if feature.radius_m > 0.0 else placed


def _outline(taken: BaseGeometry) -> tuple[tuple[Place, ...], ...]:
    """The outer rings of the obstacles, simplified until displays can draw them."""
    import shapely

    for tolerance_m in _DRAWN_M:
        drawn = shapely.simplify(taken, tolerance_m, preserve_topology=False)
        parts = [
            part for part in shapely.get_parts(drawn).tolist() if part.geom_type == "Polygon" and not part.is_empty
        ]
        if shapely.get_num_coordinates(drawn) <= _MOST_DRAWN:
            break
    rings = [tuple((float(x), float(y)) for x, y in part.exterior.coords[:-1]) for part in parts]
    largest = sorted(rings, key=len, reverse=True)
    while sum(map(len, largest)) > _MOST_DRAWN:
        largest.pop()
    return tuple(largest)


def _along_m(way: Sequence[Place], place: Place) -> float:
    """Length of a way up to a place on it."""
    import shapely

    return float(shapely.line_locate_point(shapely.linestrings(way), shapely.points(place)))
