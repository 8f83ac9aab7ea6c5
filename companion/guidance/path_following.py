"""Waypoint tracking: integral line of sight along a smooth track, at a speed that fits the bends ahead.

Course to sail χ_d = χ(s) − atan((e + κ z)/Δ), with z' = U Δ e / (Δ² + (e + κ z)²) (Børhaug, Pavlov & Pettersen 2008; Fossen 2021, 12.3), Δ the
look-ahead distance; heading ψ_d = χ_d − β with the crab angle β from the current where that is known, else from the
drift across the bow. A waypoint counts as passed inside its radius or abeam of it, so a missed one is left behind and never circled.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from companion.core.angles import wrap_pi
from companion.core.types import NavState, Setpoint, SetpointKind
from companion.guidance.path import PathKind, PathPoint, build_path
from companion.guidance.speed_profile import SpeedProfile
from companion.guidance.track import Track
from companion.params import Parameters

_ALMOST_BACK_RAD = math.radians(120.0)  # a turn sharper than this goes back along the same line
_MOST_CRAB_SINE = math.sin(math.radians(45.0))
_CRAB_SPEED_MPS = 0.15  # through the water, at least: slower boats do not crab, they drift
_DRIFT_TIME_S = 4.0
_STRAIGHT_RAD = math.radians(15.0)  # turn within the look-ahead distance below which the integral learns
_PLANNED_TURN = 0.7  # share of the yaw rate that bends are planned for; the rest is for corrections
_TURN_PREVIEW_S = 1.2  # the heading loop is this far behind
_PREVIEW_S = 0.5  # the speed loop is this far behind
_TURN_IN_PLACE_SHARE = 0.3  # of the speed, kept while the bow points elsewhere by a boat that steers by its way


@dataclass(frozen=True, slots=True)
class Waypoint:
    """A point to pass within `radius_m` (None: NAV_ACC_RAD), reached at most at `speed_mps` (None: as commanded)."""

    north_m: float
    east_m: float
    radius_m: float | None = None
    speed_mps: float | None = None


@dataclass(frozen=True, slots=True)
class PathProgress:
    """What to do now, how many waypoints were passed since the start, and where on the track the boat is."""

    setpoint: Setpoint
    passed: int
    finished: bool
    s_m: float
    remaining_m: float


class PathFollower:
    """`start(waypoints, nav)`, then `update(nav, speed_mps, dt_s)` → PathProgress with a setpoint of kind PATH.

    Remembers the track, the arc length reached (which never goes back), the waypoints passed, the integral of the line of sight, the drift
    seen and the speed last asked for. `can_sway`: the boat can push itself sideways; the setpoint then brings a sideways speed too.
    """

    def __init__(self, parameters: Parameters, can_sway: bool) -> None:
        self._parameters = parameters
        self._can_sway = can_sway
        self._waypoints: tuple[Waypoint, ...] = ()
        self._track: Track | None = None
        self._profile: SpeedProfile | None = None
        self._profile_key: tuple[float, ...] = ()
        self._stations: tuple[float, ...] = ()
        self._stop_at_end = True
        self._passed = 0
        self._finished = False
        self._s = self._integral = self._speed = 0.0
        self._drift_north = self._drift_east = 0.0

    def start(
        self, waypoints: Sequence[Waypoint], nav: NavState, stop_at_end: bool = True, from_here: bool = True, kind: PathKind | None = None
    ) -> None:
        """Lay the track. `from_here`: it begins at the boat and leads to the first waypoint; else it begins at the first waypoint, which
        counts as passed. `kind` None: as PATH_KIND says. Raises ValueError for no waypoints or a non-finite one."""
        if not waypoints:
            raise ValueError("a path needs waypoints")
        from_here = from_here or len(waypoints) == 1
        begin = (Waypoint(nav.north_m, nav.east_m),) if from_here else ()
        all_points = (*begin, *waypoints)
        points = [(w.north_m, w.east_m) for w in all_points]
        path = build_path(points, PathKind(int(self._parameters["PATH_KIND"])) if kind is None else kind)
        self._waypoints = tuple(waypoints)
        self._track = Track(path, points, [self._radius(w) for w in all_points], self._widest_m())
        self._stations = self._track.waypoint_s_m[len(begin) :]
        self._stop_at_end = stop_at_end
        self._passed = 0 if from_here else 1
        self._finished = False
        self._profile_key = ()
        self._integral = 0.0
        self._drift_north = self._drift_east = 0.0
        first_leg = self._track.waypoint_s_m[1]
        self._s = 0.0 if from_here else min(first_leg, self._track.project(nav.north_m, nav.east_m, 0.0, first_leg))
        course = self._track.at(self._s).course_rad
        self._speed = max(0.0, nav.north_mps * math.cos(course) + nav.east_mps * math.sin(course))

    @property
    def legs(self) -> list[list[tuple[float, float]]]:
        """The line laid, (north_m, east_m) closely spaced, a part for each waypoint it leads to. Raises RuntimeError before `start`."""
        if self._track is None:
            raise RuntimeError("PathFollower.legs before start")
        ends = [*self._stations[:-1], self._track.length_m]
        begins = [0.0, *ends[:-1]]
        return [self._track.part(a, max(a, b)) for a, b in zip(begins, ends, strict=True)]

    def update(self, nav: NavState, speed_mps: float, dt_s: float) -> PathProgress:
        """One step: where on the track, which waypoints passed, which heading and speed. Raises RuntimeError before `start`."""
        track = self._track
        if track is None:
            raise RuntimeError("PathFollower.update before start")
        lookahead = max(self._parameters["PATH_LOOKAHEAD"], self._parameters["PATH_LOOK_TIME"] * self._speed)
        window = max(2.0 * lookahead, 4.0 * math.hypot(nav.north_mps, nav.east_mps) * dt_s)
        self._s = max(self._s, track.project(nav.north_m, nav.east_m, self._s, window))
        self._s = self._over_tips(track)
        self._pass_waypoints(nav, track)
        here = track.at(self._s)
        error = -(nav.north_m - here.north_m) * math.sin(here.course_rad) + (nav.east_m - here.east_m) * math.cos(here.course_rad)
        last_speed = self._speed
        self._speed = self._next_speed(track, speed_mps, dt_s)
        self._update_drift(nav, dt_s)
        ahead = track.at(self._s + _TURN_PREVIEW_S * self._speed)
        setpoint = self._setpoint(nav, here, ahead, error, lookahead, last_speed, dt_s)
        remaining = max(0.0, track.length_m - self._s)
        self._finished = self._finished or self._at_end(nav, track)
        return PathProgress(setpoint, self._passed, self._finished, self._s, remaining)

    # --- where ---

    def _radius(self, waypoint: Waypoint) -> float:
        return waypoint.radius_m if waypoint.radius_m is not None and waypoint.radius_m > 0.0 else self._parameters["NAV_ACC_RAD"]

    def _widest_m(self) -> float:
        """The window beyond which a right-angled bend can already be sailed at full speed: its radius is window/2.83."""
        top = self._parameters["MPC_XY_VEL_MAX"]
        turn = max(top / math.radians(self._parameters["PATH_YAW_RATE"]), top * top / self._parameters["PATH_ACC_LAT"])
        return 3.0 * turn

    def _pass_waypoints(self, nav: NavState, track: Track) -> None:
        """Count the waypoints now inside their radius or abeam."""
        while self._passed < len(self._waypoints):
            waypoint, station = self._waypoints[self._passed], self._stations[self._passed]
            inside = math.hypot(waypoint.north_m - nav.north_m, waypoint.east_m - nav.east_m) <= self._radius(waypoint)
            is_last = self._passed == len(self._waypoints) - 1
            abeam = self._s >= station - 1.0e-6 if not is_last else self._past_end(nav, track)
            if not inside and not abeam:
                return
            self._passed += 1

    def _over_tips(self, track: Track) -> float:
        """The arc length reached, or that just past the tip of a turn straight back which lies within the preview: there the way out and
        the way back are equally near, and only going on tells them apart."""
        beyond = self._s + _TURN_PREVIEW_S * self._speed + 3.0 * track.length_m / len(track.s_m)
        turn = wrap_pi(track.at(beyond).course_rad - track.at(self._s).course_rad)
        return min(track.length_m, beyond) if abs(turn) > _ALMOST_BACK_RAD else self._s

    @staticmethod
    def _past_end(nav: NavState, track: Track) -> bool:
        """Whether the boat is past the plane across the track at its end."""
        end = track.at(track.length_m)
        return (nav.north_m - end.north_m) * math.cos(end.course_rad) + (nav.east_m - end.east_m) * math.sin(end.course_rad) >= 0.0

    def _at_end(self, nav: NavState, track: Track) -> bool:
        if self._passed < len(self._waypoints):
            return False
        if not self._stop_at_end:
            return True
        slow = math.hypot(nav.north_mps, nav.east_mps) <= 2.0 * self._creep_mps()
        return (slow and self._speed <= 2.0 * self._creep_mps()) or self._past_end_station(nav, track)

    def _past_end_station(self, nav: NavState, track: Track) -> bool:
        return self._s >= track.length_m - 1.0e-6 and self._past_end(nav, track)

    # --- how fast ---

    def _creep_mps(self) -> float:
        """The speed at which the end is neared, so that it is reached."""
        return 0.1 * self._parameters["WP_SPEED"]

    def _next_speed(self, track: Track, speed_mps: float, dt_s: float) -> float:
        parameters = self._parameters
        key = (parameters["PATH_ACC_LAT"], parameters["PATH_YAW_RATE"], parameters["PATH_ACC"], parameters["MPC_XY_VEL_MAX"])
        if self._profile is None or key != self._profile_key:
            legs = [min(key[3], w.speed_mps) if w.speed_mps is not None else key[3] for w in self._waypoints]
            self._profile = SpeedProfile(
                track.s_m, track.curvature_1pm, self._stations, legs, key[0], _PLANNED_TURN * math.radians(key[1]), key[2], self._stop_at_end
            )
            self._profile_key = key
        wanted = min(max(0.0, speed_mps), self._profile.at(self._s + _PREVIEW_S * self._speed))
        if self._stop_at_end and speed_mps > 0.0:
            wanted = max(wanted, min(speed_mps, self._creep_mps()))
        step = 1.25 * parameters["PATH_ACC"] * dt_s
        return min(self._speed + step, max(self._speed - 1.5 * step, wanted))

    # --- which way ---

    def _update_drift(self, nav: NavState, dt_s: float) -> None:
        """Learn the boat's sideways drift over ground as a velocity in NED, so that it turns out of the way with the boat in a bend. Only
        what lies across the bow is seen; in a bend the hull slips for other reasons and nothing is learnt."""
        straight = max(0.0, 1.0 - 2.0 * abs(nav.yaw_rate_radps) / math.radians(self._parameters["PATH_YAW_RATE"]))
        across_north, across_east = -math.sin(nav.yaw_rad), math.cos(nav.yaw_rad)
        drift = min(self._speed, max(-self._speed, nav.sway_mps))
        missing = drift - (self._drift_north * across_north + self._drift_east * across_east)
        learnt = missing * straight * min(1.0, dt_s / _DRIFT_TIME_S)
        self._drift_north += learnt * across_north
        self._drift_east += learnt * across_east

    def _crab_for(self, nav: NavState, course_rad: float) -> float:
        """Angle from the heading to hold to `course_rad`, against the current where it is known, else against the drift seen."""
        c, s = math.cos(course_rad), math.sin(course_rad)
        north, east = nav.current_north_mps, nav.current_east_mps
        if north is None or east is None:
            across, through = self._drift_east * c - self._drift_north * s, self._speed
        else:
            across = east * c - north * s
            through = math.hypot(self._speed - (north * c + east * s), across)
        most = _MOST_CRAB_SINE * max(through, _CRAB_SPEED_MPS)
        return math.asin(min(most, max(-most, across)) / max(through, _CRAB_SPEED_MPS))

    def _setpoint(self, nav: NavState, here: PathPoint, ahead: PathPoint, error: float, lookahead: float, last_speed: float, dt_s: float) -> Setpoint:
        gain = self._parameters["PATH_INTEGRAL"]
        leaning = error + gain * self._integral
        if abs(error) < 2.0 * lookahead and abs(here.curvature_1pm) * lookahead < _STRAIGHT_RAD:
            self._integral += self._speed * lookahead * error / (lookahead * lookahead + leaning * leaning) * dt_s
            bound = 0.6 * lookahead / gain if gain > 0.0 else 0.0
            self._integral = min(bound, max(-bound, self._integral))
        course = ahead.course_rad - math.atan2(error + gain * self._integral, lookahead)
        heading = course - self._crab_for(nav, course)
        off = wrap_pi(course - nav.yaw_rad)
        lowest = 0.0 if self._can_sway else _TURN_IN_PLACE_SHARE
        surge = self._speed * max(lowest, math.cos(off))
        sway = 0.0
        if self._can_sway:
            bound = self._parameters["DP_SPEED_SWAY"]
            sway = min(bound, max(-bound, self._speed * math.sin(off)))
        target = self._waypoints[min(self._passed, len(self._waypoints) - 1)]
        station = self._stations[min(self._passed, len(self._waypoints) - 1)]
        return Setpoint(
            SetpointKind.PATH,
            north_m=here.north_m,
            east_m=here.east_m,
            yaw_rad=wrap_pi(heading),
            surge_mps=surge,
            sway_mps=sway,
            yaw_rate_radps=self._turn_rate(nav, here, ahead, leaning, lookahead),
            surge_mps2=(self._speed - last_speed) / dt_s,
            target_north_m=target.north_m,
            target_east_m=target.east_m,
            cross_track_error_m=error,
            course_rad=wrap_pi(here.course_rad),
            distance_to_go_m=max(0.0, station - self._s),
        )

    def _turn_rate(self, nav: NavState, here: PathPoint, ahead: PathPoint, leaning: float, lookahead: float) -> float:
        """How fast the course to sail turns: with the bend, and as the boat nears the track or leaves it.

        With the bend only as fast as the boat really gets along: one that wind pins down in a bend must first turn back to its course.
        """
        along = nav.north_mps * math.cos(here.course_rad) + nav.east_mps * math.sin(here.course_rad)
        pace = min(self._speed, max(0.0, along))
        drift = -nav.north_mps * math.sin(here.course_rad) + nav.east_mps * math.cos(here.course_rad)
        rate = pace * ahead.curvature_1pm - drift * lookahead / (lookahead * lookahead + leaning * leaning)
        limit = math.radians(self._parameters["PATH_YAW_RATE"])
        return min(limit, max(-limit, rate))
