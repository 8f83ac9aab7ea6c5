"""The track of a sailing boat: straight legs from waypoint to waypoint, which it may leave to beat against the wind."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

from companion.core.estimate import NavState
from companion.core.setpoint import PathSetpoint, Point, Progress
from companion.guidance.path_tracking import PathProgress
from companion.guidance.waypoint import Waypoint
from companion.params.store import Parameters

_BESIDE = 1.5  # radii: a boat that sails past a waypoint no further off has passed it


def straight_legs(begin: tuple[float, float], waypoints: Sequence[Waypoint]) -> list[list[tuple[float, float]]]:
    """The ends of each leg from `begin` on."""
    return [list(leg) for leg in pairwise((begin, *((w.north_m, w.east_m) for w in waypoints)))]


class SailTrack:
    """Same interface as `PathTracker`. The heading of a setpoint is the bearing of the next waypoint; `Sailor` makes of
    it one that the wind allows.

    A waypoint is passed inside its radius, or abeam within one and a half. Remembers the points, how many of them are
    passed, and where the boat is.
    """

    def __init__(self, parameters: Parameters) -> None:
        self._parameters = parameters
        self._waypoints: tuple[Waypoint, ...] = ()
        self._begin = self._here = (0.0, 0.0)
        self._passed = 0

    def start(
        self,
        waypoints: Sequence[Waypoint],
        nav: NavState,
        stop_at_end: bool = True,
        from_here: bool = True,
        beyond: Sequence[Waypoint] = (),
    ) -> None:
        """As `PathTracker.start`; `beyond` and `stop_at_end` do not matter here. Raises ValueError for no waypoints."""
        if not waypoints:
            raise ValueError("a path needs waypoints")
        self._waypoints = tuple(waypoints)
        self._begin, self._passed = (nav.north_m, nav.east_m), 0
        self._here = self._begin

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
        """As `PathTracker.legs`: the ends of each leg."""
        ahead = straight_legs(self._here, self._waypoints[self._passed :])
        return [[self._here, self._here] for _ in range(self._passed)] + ahead

    def update(self, nav: NavState, speed_mps: float, dt_s: float) -> PathProgress:
        """One step. Raises RuntimeError before `start`."""
        if not self._waypoints:
            raise RuntimeError("SailTrack.update before start")
        self._here = (nav.north_m, nav.east_m)
        while self._passed < len(self._waypoints) and self._is_passed(nav):
            self._passed += 1
        finished = self._passed == len(self._waypoints)
        index = min(self._passed, len(self._waypoints) - 1)
        goal = self._waypoints[index]
        begin, course_rad = self._leg(index)
        off_north, off_east = goal.north_m - nav.north_m, goal.east_m - nav.east_m
        away_m = math.hypot(off_north, off_east)
        c, s = math.cos(course_rad), math.sin(course_rad)
        cross_m = c * (nav.east_m - begin[1]) - s * (nav.north_m - begin[0])
        along_m = c * off_north + s * off_east
        rest_m = sum(math.dist(a, b) for a, b in self.legs[index + 1 :])
        bearing_rad = course_rad if finished else math.atan2(off_east, off_north)
        most_mps = self._parameters["MPC_XY_VEL_MAX"] if goal.speed_mps is None else goal.speed_mps
        progress = Progress(
            place=Point(goal.north_m, goal.east_m),
            target=Point(goal.north_m, goal.east_m),
            cross_track_error_m=cross_m,
            course_rad=course_rad,
            distance_to_go_m=away_m,
        )
        surge_mps = 0.0 if finished else min(max(0.0, speed_mps), most_mps)
        setpoint = PathSetpoint(bearing_rad, surge_mps, progress=progress)
        remaining_m = rest_m + away_m
        return PathProgress(setpoint, self._passed, finished, -remaining_m, remaining_m, -(rest_m + along_m))

    def _leg(self, index: int) -> tuple[tuple[float, float], float]:
        """Where the leg to that waypoint begins, and its course."""
        goal = self._waypoints[index]
        begin = self._begin
        if index > 0:
            before = self._waypoints[index - 1]
            begin = (before.north_m, before.east_m)
        return begin, math.atan2(goal.east_m - begin[1], goal.north_m - begin[0])

    def _is_passed(self, nav: NavState) -> bool:
        goal = self._waypoints[self._passed]
        radius_m = goal.radius_m if goal.radius_m else self._parameters["NAV_ACC_RAD"]
        _, course_rad = self._leg(self._passed)
        north_m, east_m = goal.north_m - nav.north_m, goal.east_m - nav.east_m
        away_m = math.hypot(north_m, east_m)
        abeam = north_m * math.cos(course_rad) + east_m * math.sin(course_rad) <= 0.0
        return away_m <= radius_m or (abeam and away_m <= _BESIDE * radius_m)
