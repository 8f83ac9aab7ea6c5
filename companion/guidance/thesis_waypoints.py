"""Waypoint tracking of the ÅBOAT thesis (Storbacka 2021, 5.1…5.4): steer for the next intermediate waypoint until inside its radius.

Each section of the route is interpolated into intermediate waypoints, WPT_DENSITY a 100 m, when the section begins. The heading asked for is
the initial great-circle bearing to the next of them, the distance the haversine; one counts as reached inside its radius and in no
other way, so a boat that misses one circles it, as the thesis's did. The speed is the route's, less while the bow points elsewhere (5.1),
and falls smoothly towards the last waypoint.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.core.angles import wrap_pi
from companion.core.geodesy import LocalFrame
from companion.core.types import NavState, Setpoint, SetpointKind
from companion.guidance.path import Path, PathKind, build_path
from companion.guidance.path_following import PathProgress, Waypoint
from companion.params import Parameters

EARTH_RADIUS_M = 6_371_000.0
_SLOWEST_SHARE = 0.3  # of the speed, in a turn
_STOPPED_SHARE = 0.1  # of the speed, at the last waypoint


def bearing_rad(lat1_deg: float, lon1_deg: float, lat2_deg: float, lon2_deg: float) -> float:
    """Initial great-circle bearing, 0…2π: atan2(sin Δλ cos φ2, cos φ1 sin φ2 − sin φ1 cos φ2 cos Δλ)."""
    a, b, dlon = math.radians(lat1_deg), math.radians(lat2_deg), math.radians(lon2_deg - lon1_deg)
    y = math.sin(dlon) * math.cos(b)
    x = math.cos(a) * math.sin(b) - math.sin(a) * math.cos(b) * math.cos(dlon)
    return math.atan2(y, x) % math.tau


def haversine_m(lat1_deg: float, lon1_deg: float, lat2_deg: float, lon2_deg: float) -> float:
    """Great-circle distance on a sphere."""
    a, b, dlon = math.radians(lat1_deg), math.radians(lat2_deg), math.radians(lon2_deg - lon1_deg)
    h = math.sin(0.5 * (b - a)) ** 2 + math.cos(a) * math.cos(b) * math.sin(0.5 * dlon) ** 2
    return 2.0 * EARTH_RADIUS_M * math.asin(min(1.0, math.sqrt(h)))


class ThesisWaypoints:
    """Same interface as `PathFollower`.

    Remembers the route and its curve, the section being sailed as intermediate waypoints (arc length and place), which of them
    is next, and the plane in which places become latitude and longitude.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._waypoints: tuple[Waypoint, ...] = ()
        self._path: Path | None = None
        self._stations: tuple[float, ...] = ()
        self._stop_at_end = True
        self._passed = 0
        self._finished = False
        self._crumbs: list[tuple[float, float, float, float, float]] = []  # s_m, north_m, east_m, lat_deg, lon_deg
        self._frame = LocalFrame(0.0, 0.0)
        self._origin = (0.0, 0.0)

    def start(
        self, waypoints: Sequence[Waypoint], nav: NavState, stop_at_end: bool = True, from_here: bool = True, beyond: Sequence[Waypoint] = ()
    ) -> None:
        """As `PathFollower.start`; the thesis knows nothing of what comes `beyond`. Raises ValueError for no waypoints or a non-finite one."""
        if not waypoints:
            raise ValueError("a path needs waypoints")
        from_here = from_here or len(waypoints) == 1
        begin = [Waypoint(nav.north_m, nav.east_m)] if from_here else []
        points = [*begin, *waypoints]
        straight = [w.straight for w in points]
        self._path = build_path([(w.north_m, w.east_m) for w in points], PathKind(int(self._parameters["PATH_KIND"])), straight)
        self._waypoints = tuple(waypoints)
        self._stations = self._path.waypoint_s_m[len(begin) :]
        self._stop_at_end = stop_at_end
        self._passed = 0 if from_here else 1
        self._finished = False
        self._frame = LocalFrame(nav.lat_deg, nav.lon_deg)
        self._origin = (nav.north_m, nav.east_m)
        self._interpolate(self._path)

    def replace(self, waypoints: Sequence[Waypoint], nav: NavState, stop_at_end: bool = True, beyond: Sequence[Waypoint] = ()) -> None:
        """Other waypoints under way: from where the boat is. Raises as `start`."""
        self.start(waypoints, nav, stop_at_end)

    def go_on(self, waypoints: Sequence[Waypoint], nav: NavState, stop_at_end: bool = True, beyond: Sequence[Waypoint] = ()) -> None:
        """The waypoints that follow those of the last start. Raises as `start`."""
        self.start(waypoints, nav, stop_at_end)

    @property
    def legs(self) -> list[list[tuple[float, float]]]:
        """As `PathFollower.legs`: the curve that the intermediate waypoints lie on."""
        path = self._path
        if path is None:
            raise RuntimeError("ThesisWaypoints.legs before start")
        spans = zip([0.0, *self._stations[:-1]], self._stations, strict=True)
        return [[path.position(a + (b - a) * k / count) for k in range(count + 1)] for a, b in spans for count in (max(1, math.ceil(b - a)),)]

    def _interpolate(self, path: Path) -> None:
        """The intermediate waypoints of the section that leads to the next waypoint of the route, which is the last of them."""
        end = self._stations[self._passed]
        begin = self._stations[self._passed - 1] if self._passed > 0 else 0.0
        count = max(1, round((end - begin) * self._parameters["WPT_DENSITY"] / 100.0))
        self._crumbs = []
        for k in range(1, count + 1):
            s = begin + (end - begin) * k / count
            north, east = path.position(s)
            self._crumbs.append((s, north, east, *self._geodetic(north, east)))

    def _geodetic(self, north_m: float, east_m: float) -> tuple[float, float]:
        return self._frame.to_geodetic(north_m - self._origin[0], east_m - self._origin[1])

    def update(self, nav: NavState, speed_mps: float, dt_s: float) -> PathProgress:
        """One step: heading for the next intermediate waypoint. Raises RuntimeError before `start`."""
        path = self._path
        if path is None:
            raise RuntimeError("ThesisWaypoints.update before start")
        lat, lon = self._geodetic(nav.north_m, nav.east_m)
        self._reach(path, lat, lon)
        s, north, east, crumb_lat, crumb_lon = self._crumbs[0]
        away = haversine_m(lat, lon, crumb_lat, crumb_lon)
        bearing = wrap_pi(bearing_rad(lat, lon, crumb_lat, crumb_lon))
        remaining = away + path.length_m - s
        off = wrap_pi(bearing - nav.yaw_rad)
        index = min(self._passed, len(self._waypoints) - 1)
        leg_mps = self._waypoints[index].speed_mps
        wanted = min(max(0.0, speed_mps), self._parameters["MPC_XY_VEL_MAX"] if leg_mps is None else leg_mps)
        if self._stop_at_end:
            slowing = math.sqrt(2.0 * self._parameters["PATH_ACC"] * remaining)
            wanted = min(wanted, max(slowing, _STOPPED_SHARE * wanted))
        back = path.project(nav.north_m, nav.east_m, s, 2.0 * away + 1.0)
        here = path.at(back)
        error = -(nav.north_m - here.north_m) * math.sin(here.course_rad) + (nav.east_m - here.east_m) * math.cos(here.course_rad)
        setpoint = Setpoint(
            SetpointKind.PATH,
            north_m=north,
            east_m=east,
            yaw_rad=bearing,
            surge_mps=0.0 if self._finished else wanted * max(_SLOWEST_SHARE, math.cos(off)),
            target_north_m=self._waypoints[index].north_m,
            target_east_m=self._waypoints[index].east_m,
            cross_track_error_m=error,
            course_rad=wrap_pi(here.course_rad),
            distance_to_go_m=away + self._stations[index] - s,
        )
        return PathProgress(setpoint, self._passed, self._finished, back, remaining, -remaining)

    def _reach(self, path: Path, lat_deg: float, lon_deg: float) -> None:
        """Strike off the intermediate waypoints that the boat is inside the radius of; the end of a section begins the next."""
        while not self._finished:
            _, _, _, crumb_lat, crumb_lon = self._crumbs[0]
            if haversine_m(lat_deg, lon_deg, crumb_lat, crumb_lon) > self._radius():
                return
            if len(self._crumbs) > 1:
                self._crumbs.pop(0)
                continue
            self._passed += 1
            self._finished = self._passed == len(self._waypoints)
            if not self._finished:
                self._interpolate(path)

    def _radius(self) -> float:
        own = self._waypoints[self._passed].radius_m
        return own if own is not None and own > 0.0 else self._parameters["WPT_RADIUS"]
