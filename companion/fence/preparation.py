"""From the items of a fence to all that the guard needs of it. Of a large fence this takes seconds, so it uses nothing
that may change meanwhile and can be done beside the control thread."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

from companion.core.geodesy import LocalFrame
from companion.core.work import Lane
from companion.fence.zones import FenceZone, fence_zones
from companion.mission.commands import is_no_circle
from companion.mission.plan import PlanItem, plan_id

if TYPE_CHECKING:
    from companion.fence.area import FenceArea, Shape
    from companion.fence.areas import FenceAreas

Place = tuple[float, float]
FEW_ITEMS = 200  # prepared within a tick; so are their ways
_ANY = 1  # of FENCE_GROUP0
_CORNER_CUT = 0.6  # share of a waypoint's radius by which the path may cut its corner
_TIGHT_SHARE = 0.2  # of NAV_ACC_RAD: waypoint radius on a way through a narrow gap


class Routes(Protocol):
    """Ways inside an area."""

    def find(self, begin: Place, end: Place, through: FenceArea | None = None) -> tuple[Place, ...] | None:
        """Points from `begin` to `end`, both included; None where there is no way. `through`: the wider area in which
        the last leg may lie."""
        ...

    def in_lane(self, lane: Lane) -> Routes:
        """The same for another thread (`FenceArea.in_lane`)."""
        ...


class Ways:
    """Ways that leave room for the corners that a path cuts. Remembers the routes for each radius; of a large fence,
    and of one with many zones, they are all made at the beginning."""

    def __init__(
        self, keeping: FenceArea, radius_m: float, large: bool, routes: Mapping[float, Routes] | None = None
    ) -> None:
        """`routes`: those made before, by radius; then no others are made here."""
        self._keeping = keeping
        self.large = large
        self._routes: dict[float, Routes] = dict(routes or {})
        self._others: dict[Lane, Ways] = {}
        from companion.fence.way_round import is_for_few

        if routes is not None:
            return
        for radius in _radii(radius_m) if large or not is_for_few(keeping) else ():
            self._routes[radius] = self._made(radius)

    def in_lane(self, lane: Lane) -> Ways:
        """The same for another thread (`FenceArea.in_lane`)."""
        if lane is Lane.CONTROL:
            return self
        if lane not in self._others:
            routes = {radius: routes.in_lane(lane) for radius, routes in self._routes.copy().items()}
            self._others[lane] = Ways(self._keeping.in_lane(lane), 0.0, self.large, routes)
        return self._others[lane]

    def radii_m(self, radius_m: float) -> Sequence[float]:
        """The radii to try, for a NAV_ACC_RAD of `radius_m`: those of a large fence stay as they were."""
        return tuple(self._routes) if self.large else _radii(radius_m)

    def of(self, radius_m: float) -> Routes:
        """The routes for one of these radii."""
        if radius_m not in self._routes:
            self._routes[radius_m] = self._made(radius_m)
        return self._routes[radius_m]

    def routes(self) -> Sequence[Routes]:
        """Those that were made."""
        return tuple(self._routes.values())

    def _made(self, radius_m: float) -> Routes:
        from companion.fence.roadmap import routes_in
        from companion.fence.way_round import ClearRoutes

        routes = routes_in(self._keeping.shrunk(_CORNER_CUT * radius_m))
        if self.large and isinstance(routes, ClearRoutes):
            routes.look_around()
        return routes


def _radii(radius_m: float) -> tuple[float, float]:
    return radius_m, _TIGHT_SHARE * radius_m


@dataclass(frozen=True, slots=True)
class Prepared:
    """A fence that can be put in force. `key`: what it depends on. `zones`: what the areas of the plan's zones alone
    depend on, and these areas. `no_circle`: index of the first item that is a circle of radius 0, or None."""

    key: tuple[object, ...]
    areas: FenceAreas | None
    ways: Ways | None
    zones: tuple[tuple[object, ...], FenceAreas | None] = (), None
    no_circle: int | None = None

    def pieces(self) -> list[object]:
        """All that is large."""
        areas = [one for one in (self.areas, self.zones[1]) if one is not None]
        routes = () if self.ways is None else self.ways.routes()
        return [*(piece for one in areas for piece in (one.fence, one.stopping, one.keeping)), *routes]


NOTHING = Prepared((), None, None)


@dataclass(frozen=True, slots=True)
class FencePlan:
    """All that a fence in force depends on: its items, the circle around home, the plane, the parameters, and the
    length of the boat."""

    items: tuple[PlanItem, ...]
    circle: FenceZone | None
    frame: LocalFrame
    group0: float
    margin_m: float
    length_m: float
    radius_m: float

    def build(self, before: Prepared = NOTHING) -> Prepared:
        """Prepare it. `before`: the fence prepared last; where only the circle differs, its zones serve again."""
        number, rest = plan_id(self.items), (self.frame, self.group0, self.margin_m)
        zones_key = (number, *rest)
        zones = before.zones[1] if before.zones[0] == zones_key else self._zones()
        areas = zones if self.circle is None else self._cut(zones, self.circle)
        ways = None if areas is None else Ways(areas.keeping, self.radius_m, len(self.items) > FEW_ITEMS)
        no_circle = next((item.seq for item in self.items if is_no_circle(item)), None)
        return Prepared((number, self.circle, *rest), areas, ways, (zones_key, zones), no_circle)

    def _cut(self, zones: FenceAreas | None, circle: FenceZone) -> FenceAreas:
        """The areas within the circle around home."""
        from companion.fence.area import Disc, FenceArea
        from companion.fence.areas import FenceAreas

        north_m, east_m = self.frame.to_ned(*circle.points[0])
        radius_m, half_m = circle.radius_m or 0.0, 0.5 * self.length_m
        uncut = zones or FenceAreas(*(FenceArea({}, ()) for _ in range(3)))

        def cut(area: FenceArea, by_m: float) -> FenceArea:
            return area.within(Disc(north_m, east_m, radius_m - by_m))

        kept_m = half_m + self.margin_m
        return FenceAreas(cut(uncut.fence, 0.0), cut(uncut.stopping, half_m), cut(uncut.keeping, kept_m))

    def _zones(self) -> FenceAreas | None:
        """The areas of the plan's zones; None if it has none."""
        from companion.fence.area import FenceArea
        from companion.fence.areas import FenceAreas

        zones = fence_zones(self.items)
        if not zones:
            return None
        groups: dict[int, list[Shape]] = {}
        for zone in zones:
            if zone.inclusion:
                apart = zone.group == 0 and self.group0 == _ANY
                groups.setdefault(-1 - zone.seq if apart else zone.group, []).append(_shape(zone, self.frame))
        fence = FenceArea(groups, [_shape(zone, self.frame) for zone in zones if not zone.inclusion])
        keeping = fence.shrunk(0.5 * self.length_m + self.margin_m)
        return FenceAreas(fence, fence.shrunk(0.5 * self.length_m), keeping)


def _shape(zone: FenceZone, frame: LocalFrame) -> Shape:
    from companion.fence.area import Disc

    points = [frame.to_ned(lat_deg, lon_deg) for lat_deg, lon_deg in zone.points]
    return points if zone.radius_m is None else Disc(*points[0], zone.radius_m)
