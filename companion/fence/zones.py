"""The zones of a fence, from its mission items."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from companion.mission.commands import CIRCLES, POLYGONS, Command, is_no_circle
from companion.mission.plan import PlanItem

_INCLUSIONS = frozenset({Command.FENCE_POLYGON_INCLUSION, Command.FENCE_CIRCLE_INCLUSION})


@dataclass(frozen=True, slots=True)
class FenceZone:
    """A polygon (`radius_m` None), or a circle around its one point. `points`: (lat_deg, lon_deg). `seq`: of its first
    item. `group`: for inclusions only."""

    seq: int
    inclusion: bool
    group: int
    points: tuple[tuple[float, float], ...]
    radius_m: float | None = None


def fence_zones(items: Sequence[PlanItem]) -> tuple[FenceZone, ...]:
    """The zones of a fence that has passed `check_plan`. A return point is not a zone and is ignored: RTL leads to home
    or to a rally point. A circle with radius 0 is none either."""
    zones: list[FenceZone] = []
    at = 0
    while at < len(items):
        item = items[at]
        count = int(item.param1) if item.command in POLYGONS else 1
        if item.command in POLYGONS | CIRCLES and not is_no_circle(item):
            inclusion = item.command in _INCLUSIONS
            points = tuple((vertex.lat_deg, vertex.lon_deg) for vertex in items[at : at + count])
            group = int(item.param2) if inclusion and item.param2 == item.param2 else 0
            zones.append(
                FenceZone(item.seq, inclusion, group, points, item.param1 if item.command in CIRCLES else None)
            )
        at += count
    return tuple(zones)
