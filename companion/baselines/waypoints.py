"""Waypoint law of the ÅBOAT thesis (Storbacka 2021, 5.1…5.4; WP_LAW 1): steer for the next intermediate waypoint.

When a section of the route begins, it is interpolated into intermediate waypoints, WPT_DENSITY for each 100 m. The
heading is the initial great-circle bearing to the next of them, the distance the haversine. A waypoint counts as
reached only inside its radius, so a boat that misses one circles it, as the boat of the thesis did. The speed is that
of the route, reduced while the bow points elsewhere (5.1) and towards the last waypoint.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.core.geodesy import LocalFrame
from companion.core.setpoint import PathSetpoint, Point, Progress
from companion.guidance.path import Path, PathKind, build_path
from companion.guidance.path_tracking import PathProgress
from companion.guidance.waypoint import Waypoint
from companion.params.store import Parameters

EARTH_RADIUS_M = 6_371_000.0
_SLOWEST_SHARE = 0.3  # of the speed, kept in a turn
_STOPPED_SHARE = 0.1  # of the speed, kept up to the last waypoint


class _Intermediate(NamedTuple):
    """An intermediate waypoint: arc length along the curve, and place in the local plane and on Earth."""

    s_m: float
    north_m: float
    east_m: float
    lat_deg: float
    lon_deg: float


def bearing_rad(lat1_deg: float, lon1_deg: float, lat2_deg: float, lon2_deg: float) -> float:
    """Initial great-circle bearing from the first place to the second in rad, 0…2π clockwise from north.

    atan2(sin Δλ cos φ2, cos φ1 sin φ2 − sin φ1 cos φ2 cos Δλ)
    """
    a, b, dlon = math.radians(lat1_deg), math.radians(lat2_deg), math.radians(lon2_deg - lon1_deg)
    y = math.sin(dlon) * math.cos(b)
    x = math.cos(a) * math.sin(b) - math.sin(a) * math.cos(b) * math.cos(dlon)
    return math.atan2(y, x) % math.tau


def haversine_m(lat1_deg: float, lon1_deg: float, lat2_deg: float, lon2_deg: float) -> float:
    """Great-circle distance in m on a sphere of EARTH_RADIUS_M, by the haversine formula."""
    a, b, dlon = math.radians(lat1_deg), math.radians(lat2_deg), math.radians(lon2_deg - lon1_deg)
    h = math.sin(0.5 * (b - a)) ** 2 + math.cos(a) * math.cos(b) * math.sin(0.5 * dlon) ** 2
    return 2.0 * EARTH_RADIUS_M * math.asin(min(1.0, math.sqrt(h)))


def thesis_legs(
    waypoints: Sequence[Waypoint], nav: NavState, parameters: Parameters
) -> list[list[tuple[float, float]]]:
    """The curve from the boat that the law's intermediate waypoints would lie on, one list for each waypoint."""
    law = ThesisWaypoints(parameters)
    law.start(waypoints, nav)
    return law.legs


class ThesisWaypoints:
    """Same interface as `PathTracker`.

    Remembers the route and its curve, the remaining intermediate waypoints of the present section, how many waypoints
    of the route were passed, the boat's place along the curve, and the local frame for latitude and longitude.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._waypoints: tuple[Waypoint, ...] = ()
        self._path: Path | None = None
        self._waypoint_s_m: tuple[float, ...] = ()  # arc length of each waypoint of the route
        self._stop_at_end = True
        self._passed = 0
        self._s_m = 0.0
        self._finished = False
        self._section: list[_Intermediate] = []
        self._frame = LocalFrame(0.0, 0.0)
        self._origin = (0.0, 0.0)

    def start(
        self,
        waypoints: Sequence[Waypoint],
        nav: NavState,
        stop_at_end: bool = True,
        from_here: bool = True,
        beyond: Sequence[Waypoint] = (),
    ) -> None:
        """As `PathTracker.start`; `beyond` is ignored, as in the thesis. Raises ValueError for no waypoints or a
        non-finite one."""
        if not waypoints:
            raise ValueError("a path needs waypoints")
        from_here = from_here or len(waypoints) == 1
        begin = [Waypoint(nav.north_m, nav.east_m)] if from_here else []
        points = [*begin, *waypoints]
        straight = [w.straight for w in points]
        self._path = build_path(
            [(w.north_m, w.east_m) for w in points], PathKind(int(self._parameters["PATH_KIND"])), straight
        )
        self._waypoints = tuple(waypoints)
        self._waypoint_s_m = self._path.waypoint_s_m[len(begin) :]
        self._stop_at_end = stop_at_end
        self._passed = 0 if from_here else 1
        self._s_m = 0.0
        self._finished = False
        self._frame = LocalFrame(nav.lat_deg, nav.lon_deg)
        self._origin = (nav.north_m, nav.east_m)
        self._interpolate(self._path)

    def replace(
        self, waypoints: Sequence[Waypoint], nav: NavState, stop_at_end: bool = True, beyond: Sequence[Waypoint] = ()
    ) -> None:
        """Other waypoints under way, from the boat on. Raises as `start`."""
        self.start(waypoints, nav, stop_at_end)

    def go_on(
        self, waypoints: Sequence[Waypoint], nav: NavState, stop_at_end: bool = True, beyond: Sequence[Waypoint] = ()
    ) -> None:
        """The waypoints that follow those of the last start. Raises as `start`."""
        self.start(waypoints, nav, stop_at_end)

    @property
    def legs(self) -> list[list[tuple[float, float]]]:
        """As `PathTracker.legs`: points of the curve that the intermediate waypoints lie on."""
        path = self._path
        if path is None:
            raise RuntimeError("ThesisWaypoints.legs before start")
        ends = [max(self._s_m, s_m) for s_m in (0.0, *self._waypoint_s_m)]
        return [
            [path.position(a + (b - a) * k / count) for k in range(count + 1)]
            for a, b in pairwise(ends)
            for count in (max(1, math.ceil(b - a)),)
        ]

    def _interpolate(self, path: Path) -> None:
        """Compute the intermediate waypoints of the present section; the last of them is its waypoint of the route."""
        end = self._waypoint_s_m[self._passed]
        begin = self._waypoint_s_m[self._passed - 1] if self._passed > 0 else 0.0
        count = max(1, round((end - begin) * self._parameters["WPT_DENSITY"] / 100.0))
        self._section = []
        for k in range(1, count + 1):
            s = begin + (end - begin) * k / count
            north, east = path.position(s)
            self._section.append(_Intermediate(s, north, east, *self._geodetic(north, east)))

    def _geodetic(self, north_m: float, east_m: float) -> tuple[float, float]:
        return self._frame.to_geodetic(north_m - self._origin[0], east_m - self._origin[1])

    def update(self, nav: NavState, speed_mps: float, dt_s: float) -> PathProgress:
        """One step: heading and speed for the next intermediate waypoint. Raises RuntimeError before `start`."""
        path = self._path
        if path is None:
            raise RuntimeError("ThesisWaypoints.update before start")
        lat, lon = self._geodetic(nav.north_m, nav.east_m)
        self._reach(path, lat, lon)
        goal = self._section[0]
        away = haversine_m(lat, lon, goal.lat_deg, goal.lon_deg)
        bearing = wrap_pi(bearing_rad(lat, lon, goal.lat_deg, goal.lon_deg))
        remaining = away + path.length_m - goal.s_m
        off = wrap_pi(bearing - nav.yaw_rad)
        index = min(self._passed, len(self._waypoints) - 1)
        leg_mps = self._waypoints[index].speed_mps
        wanted = min(max(0.0, speed_mps), self._parameters["MPC_XY_VEL_MAX"] if leg_mps is None else leg_mps)
        if self._stop_at_end:
            slowing = math.sqrt(2.0 * self._parameters["PATH_ACC"] * remaining)
            wanted = min(wanted, max(slowing, _STOPPED_SHARE * wanted))
        self._s_m = back = path.project(nav.north_m, nav.east_m, goal.s_m, 2.0 * away + 1.0)
        here = path.at(back)
        error = -(nav.north_m - here.north_m) * math.sin(here.course_rad) + (nav.east_m - here.east_m) * math.cos(
            here.course_rad
        )
        progress = Progress(
            place=Point(goal.north_m, goal.east_m),
            target=Point(self._waypoints[index].north_m, self._waypoints[index].east_m),
            cross_track_error_m=error,
            course_rad=wrap_pi(here.course_rad),
            distance_to_go_m=away + self._waypoint_s_m[index] - goal.s_m,
        )
        surge = 0.0 if self._finished else wanted * max(_SLOWEST_SHARE, math.cos(off))
        setpoint = PathSetpoint(bearing, surge, progress=progress)
        return PathProgress(setpoint, self._passed, self._finished, back, remaining, -remaining)

    def _reach(self, path: Path, lat_deg: float, lon_deg: float) -> None:
        """Remove the intermediate waypoints that are reached; after the last of a section the next section begins."""
        while not self._finished:
            goal = self._section[0]
            if haversine_m(lat_deg, lon_deg, goal.lat_deg, goal.lon_deg) > self._radius():
                return
            if len(self._section) > 1:
                self._section.pop(0)
                continue
            self._passed += 1
            self._finished = self._passed == len(self._waypoints)
            if not self._finished:
                self._interpolate(path)

    def _radius(self) -> float:
        own = self._waypoints[self._passed].radius_m
        return own if own is not None and own > 0.0 else self._parameters["WPT_RADIUS"]
