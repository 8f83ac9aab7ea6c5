"""Laying a track: what it depends on is taken first, and never changes. So the rest, which takes up to half a second,
can be done beside the control thread."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from companion.guidance.path import PathKind, PathPoint, build_path
from companion.guidance.path_plan import PathPlan, PlanLimits
from companion.guidance.track import Track, turns_rad
from companion.guidance.waypoint import Waypoint

CONTEXT = 16  # waypoints on either side that shape a section; further ones change a cubic spline by under 1e-9
_ONWARD_RADII = 1.3  # how far a replaced track continues, so that its first bend begins at the boat
_STRAIGHT_CORNERS = 200.0  # of a radius that would fit a straight line; ten samples each
# The widest window of a corner that is passed through, at the leg's speed, by its angle: a gentle one costs little
# thrust anyway, at a sharp one a wider swing costs little way and saves much thrust.
_ANGLES_RAD, _SWINGS_S = (math.radians(60.0), math.radians(90.0), math.radians(130.0)), (4.2, 4.6, 7.5)
_SWING_BEND_S = 0.55  # radius of the tightest bend in a swing through a right angle, over the leg's speed
THROUGH_M = 0.17  # how near the track passes a waypoint that is to be passed through, within 0.2 m
_NEW_WATER_MPS, _NEW_AIR_MPS = 0.15, 2.0  # changes of current and mean wind that are worth a new plan

Place = tuple[float, float]


def swing_bend_1pm(speed_mps: float) -> float:
    """The curvature of the tightest bend in a swing through a right angle, on legs of that speed."""
    return 1.0 / (_SWING_BEND_S * speed_mps)


@dataclass(frozen=True, slots=True)
class FromBoat:
    """A track that begins at the boat, or at its first waypoint, which then counts as passed (`place` None)."""

    place: Place | None

    def points(self, first: Waypoint) -> tuple[Waypoint, ...]:
        """The points of the track before the first waypoint."""
        return () if self.place is None else (Waypoint(*self.place),)

    def begin_s_m(self, track: Track) -> float:
        """Arc length of the track at which it is to be sailed from."""
        return 0.0


@dataclass(frozen=True, slots=True)
class FromTrack:
    """A track that leaves the present one at `here`, in its direction. `radius_m`: NAV_ACC_RAD."""

    here: PathPoint
    radius_m: float

    def points(self, first: Waypoint) -> tuple[Waypoint, ...]:
        """As `FromBoat.points`."""
        here = self.here
        c, s = math.cos(here.course_rad), math.sin(here.course_rad)
        away_m = math.hypot(first.north_m - here.north_m, first.east_m - here.east_m)
        ahead_m = min(_ONWARD_RADII * self.radius_m, 0.5 * away_m)
        # nearer, the bend is narrower: rounded as widely as usual, it would begin behind the boat, off its track
        is_ahead = (first.north_m - here.north_m) * c + (first.east_m - here.east_m) * s > 0.0
        narrow_m = ahead_m / _ONWARD_RADII if is_ahead and ahead_m < _ONWARD_RADII * self.radius_m else None
        return tuple(
            Waypoint(here.north_m + x * c, here.east_m + x * s, radius_m=narrow_m, straight=True)
            for x in (-_ONWARD_RADII * self.radius_m, 0.0, ahead_m)
        )

    def begin_s_m(self, track: Track) -> float:
        """As `FromBoat.begin_s_m`."""
        return track.waypoint_s_m[1]


@dataclass(frozen=True, slots=True)
class Onward:
    """A track that goes on from the present one, whose last points these are: the same as if it had been laid with all
    of them."""

    last: tuple[Waypoint, ...]

    def points(self, first: Waypoint) -> tuple[Waypoint, ...]:
        """As `FromBoat.points`."""
        return self.last

    def begin_s_m(self, track: Track) -> float:
        """As `FromBoat.begin_s_m`."""
        return track.waypoint_s_m[len(self.last) - 1]


Joint = FromBoat | FromTrack | Onward


@dataclass(frozen=True, slots=True)
class PlanTerms:
    """What a plan depends on besides its track. `top_mps`: the speed commanded."""

    limits: PlanLimits
    top_mps: float

    def still_hold(self, now: PlanTerms) -> bool:
        """Whether `now` differs by no more than is worth a new plan."""
        a, b = self.limits.weather, now.limits.weather
        water = math.hypot(a.water_north_mps - b.water_north_mps, a.water_east_mps - b.water_east_mps)
        air = math.hypot(a.air_north_mps - b.air_north_mps, a.air_east_mps - b.air_east_mps)
        return self.asks_the_same(now) and water <= _NEW_WATER_MPS and air <= _NEW_AIR_MPS

    def asks_the_same(self, other: PlanTerms) -> bool:
        """Whether both are for the same speed and share of the limits, in whatever weather."""
        return self.limits.share == other.limits.share and self.top_mps == other.top_mps

    def plan(self, track: Track, leg_end_s_m: Sequence[float], waypoints: Sequence[Waypoint], stops: bool) -> PathPlan:
        """The plan of a track with these legs."""
        top = self.top_mps
        legs = [min(top, w.speed_mps) if w.speed_mps is not None else top for w in waypoints]
        return PathPlan(track, leg_end_s_m, legs, self.limits, stops)


@dataclass(frozen=True, slots=True)
class TrackShape:
    """The parameters that shape a track. `radius_m`: NAV_ACC_RAD; `widest_m`: of the window of its means; `through`:
    waypoints without a radius of their own are passed through (WP_CORNER), at `cruise_mps` (WP_SPEED) or the leg's own
    speed. `terms`: None without a plan."""

    kind: PathKind
    radius_m: float
    widest_m: float
    through: bool
    cruise_mps: float
    terms: PlanTerms | None

    def lay(
        self, joint: Joint, waypoints: Sequence[Waypoint], beyond: Sequence[Waypoint], stop_at_end: bool
    ) -> LaidTrack:
        """The track to `waypoints`, shaped by those `beyond`, with its plan. Raises ValueError for no waypoints or a
        non-finite one."""
        if not waypoints:
            raise ValueError("a path needs waypoints")
        begin = joint.points(waypoints[0])
        shape = (*begin, *waypoints, *beyond)
        points = [(w.north_m, w.east_m) for w in shape]
        path = build_path(points, self.kind, [w.straight for w in shape])
        if len(points) == 2:  # a straight line has no corner, and needs few samples
            wide_m = max(self._corner_m(shape[1]), path.length_m / _STRAIGHT_CORNERS)
            track = Track(path, points, [wide_m, wide_m], max(self.widest_m, 3.0 * wide_m))
        else:
            radii = [self._corner_m(w) for w in shape]
            swings = [self._swing_m(w, turn) for w, turn in zip(shape, turns_rad(points), strict=True)]
            track = Track(path, points, radii, self.widest_m, swings)
        ends = track.waypoint_s_m[len(begin) : len(begin) + len(waypoints)]
        plan = None if self.terms is None else self.terms.plan(track, ends, waypoints, stop_at_end)
        points_to_sail = (*begin, *waypoints)
        return LaidTrack(
            joint, track, points_to_sail, tuple(waypoints), ends, stop_at_end, self.through, self.terms, plan
        )

    def acceptance_m(self, waypoint: Waypoint) -> float:
        """The radius within which a waypoint counts as passed."""
        return waypoint.own_radius_m or self.radius_m

    def _corner_m(self, waypoint: Waypoint) -> float:
        """How near to a waypoint the track passes."""
        return THROUGH_M if self._passes_through(waypoint) else self.acceptance_m(waypoint)

    def _swing_m(self, waypoint: Waypoint, turn_rad: float) -> float:
        """The widest window of the swing through a waypoint; 0: the corner is only cut."""
        if not self._passes_through(waypoint):
            return 0.0
        swing_s = float(np.interp(abs(turn_rad), _ANGLES_RAD, _SWINGS_S))
        return swing_s * (self.cruise_mps if waypoint.speed_mps is None else waypoint.speed_mps)

    def _passes_through(self, waypoint: Waypoint) -> bool:
        return self.through and waypoint.own_radius_m is None


@dataclass(frozen=True, slots=True, eq=False)
class LaidTrack:
    """A track and what it was laid for. `points`: of the track, up to the last waypoint; `ends_s_m`: arc length abeam
    of each waypoint. `through`: as in its `TrackShape`."""

    joint: Joint
    track: Track
    points: tuple[Waypoint, ...]
    waypoints: tuple[Waypoint, ...]
    ends_s_m: tuple[float, ...]
    stop_at_end: bool
    through: bool
    terms: PlanTerms | None
    plan: PathPlan | None

    @property
    def begin_s_m(self) -> float:
        """Arc length at which it is to be sailed from."""
        return self.joint.begin_s_m(self.track)

    def legs(self, from_s_m: float) -> list[list[Place]]:
        """The track from an arc length on: closely spaced (north_m, east_m), one list for each waypoint. Those of
        waypoints before it stay at its place."""
        begins = [max(from_s_m, s_m) for s_m in (from_s_m, *self.ends_s_m[:-1])]
        return [self.track.part(a, max(a, b)) for a, b in zip(begins, self.ends_s_m, strict=True)]
