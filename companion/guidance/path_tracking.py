"""Path tracking: integral line of sight along a smooth track, at a speed that fits the bends ahead.

Course to sail χ_d = χ(s) − atan((e + κ z)/Δ), with z' = U Δ (e + T e') / (Δ² + (e + κ z)²), T = √(Δ² + (e + κ z)²)/U
(Børhaug, Pavlov & Pettersen 2008; Fossen 2021, 12.3, where T is 0), Δ the look-ahead distance. On the way back to the
track that the line of sight asks for, e + T e' is 0: the boat learns only what it does not expect, and has nothing to
unlearn on the track. Heading ψ_d = χ_d − β, with the crab angle β from `CrabCompensation`. A waypoint counts as passed
inside its radius or abeam of it, so the boat never circles one that it missed. The heading setpoint never jumps: it
turns at PATH_YAW_RATE at most.

A boat with sideways thrust and a known agility sails by a plan instead: see `PlannedMotion`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.core.setpoint import PathSetpoint, Point, Progress
from companion.core.work import Submit, at_once
from companion.guidance.agility import Agility
from companion.guidance.carried_turn import CarriedTurn
from companion.guidance.crab_compensation import CrabCompensation
from companion.guidance.path import PathKind, PathPoint
from companion.guidance.path_laying import (
    CONTEXT,
    FromBoat,
    FromTrack,
    LaidTrack,
    Onward,
    TrackShape,
    swing_bend_1pm,
)
from companion.guidance.planned_motion import OnTrack, PlannedMotion
from companion.guidance.preview import ALMOST_BACK_RAD, OnLeg, Preview
from companion.guidance.rounding_up import RoundingUp
from companion.guidance.speed_profile import BendLimits, SpeedProfile
from companion.guidance.stopping import creep_mps
from companion.guidance.track import Track
from companion.guidance.turning import PLANNED_TURN, TURN_PREVIEW_S, UNKNOWN, Turning
from companion.guidance.waypoint import Waypoint
from companion.params.store import Parameters

_STRAIGHT_RAD = math.radians(15.0)  # the integral learns where the track turns by less over the look-ahead distance
_LEARNS, _LEARNS_IN_ARC = 2.0, 0.5  # look-ahead distances: a larger error is a way to the track, not an offset to learn
# A boat whose bow points so far elsewhere does not answer this law: it turns, or goes round traffic. Then it learns
# nothing: after 60 s beside its track a boat at 8 m/s overshot it by 10 m.
_ASTRAY_RAD = math.radians(20.0)
_MOST_PACE = 2.0  # fastest motion of the point abeam along the track, in boat speeds: in a bend that is cut
_TIP_PACE = 1.5  # the same around the tip of a turn back
# A planned path's bend from which on the boat's place tells no progress: it may lie anywhere around it. It is the mean
# from _TIP_M before the place to _TIP_M beyond: in the midst of a tip the bend may be less sharp for a moment.
_TIP_1PM, _TIP_M = 2.0, 0.1
_PAST_M = 0.2  # ahead of its place on the track, in the course there, a boat has sailed past a tip
_SURGE_SHARE = 1.5  # in PATH_ACC: how fast the speed setpoint changes as the bow turns to the course
_ROUNDING_SHARE = 3.0  # the same where the bow turns into a stream that carries the boat past its end
# Of the leg's speed, that a boat turned by the moment of its thrusters must keep in the bend of a swing: one that turns
# slower is carried off there.
_KEPT_IN_SWING = 0.35
_PREVIEW_S = 0.5  # lag of the speed loop
# Times the current: speed over ground at which the bow is turned into it by 27° at most. A slower boat turns it there
# and back within a bend, and is carried off meanwhile.
_STEERAGE = 2.2
_TURN_IN_PLACE_SHARE = 0.3  # of the speed, kept off the course by a boat that needs way to steer
_WIDE_M = 0.1  # by which a boat that turns on the spot may run wide until its bow points the right way
# One thruster that turns gives no moment while it goes from ahead to astern: for seconds the boat turns no further. In
# a bend, or with its bow so far off, a boat with such a thruster does not brake, up to so many times its planned speed.
# Before a sharper turn it does: it comes round in less room. One that is turning already goes on.
_UNBRAKED_RADPS, _UNBRAKED_RAD, _UNBRAKED = math.radians(3.0), (math.radians(10.0), math.radians(30.0)), 2.0
_TURNS_RADPS, _TURNS_RAD = math.radians(6.0), math.radians(110.0)
# From there on a boat whose bow points back to the track waits no longer for the rest of the turn: what carries it off
# would go on, and the heading back to the track turn on before its bow. (Off the track, times the sine of that angle.)
_BACK_M = 0.5
# At rest for so long, inside the last waypoint's radius, a boat has arrived, however fast it should still sail.
_RESTS_S = 10.0
_REGULATOR = 1  # PATH_CTRL
_THROUGH = 1  # WP_CORNER


@dataclass(frozen=True, slots=True)
class PathProgress:
    """The setpoint of this tick, the number of waypoints passed since the start, the arc length `s_m` reached on the
    track, and the distance that remains to the last waypoint.

    `way_m` grows as the boat comes nearer to the end, along the track or towards it: it measures headway.
    """

    setpoint: PathSetpoint
    passed: int
    finished: bool
    s_m: float
    remaining_m: float
    way_m: float


class PathTracker:
    """Call `start(waypoints, nav)`, then `update` every tick. Where laying the track would take too long, lay it beside
    the control thread (`shape`, `TrackShape.lay`), and `take` it.

    `can_sway`: the boat has sideways thrust; the setpoint then has a sideways speed too. `top_mps`: top speed
    through the water. `agility`: None for a boat whose bends PATH_ACC* and PATH_YAW_RATE bound. `submit`: makes plans
    beside the control thread. `turning`: how a boat without sideways thrust turns. Remembers the track, the arc length
    reached (which never decreases), the waypoints passed, for how long it rests at the end, the integral of the line
    of sight, the drift, and the last setpoint's speed and heading.
    """

    def __init__(
        self,
        parameters: Parameters,
        can_sway: bool,
        top_mps: float = math.inf,
        agility: Agility | None = None,
        submit: Submit = at_once,
        turning: Turning = UNKNOWN,
    ) -> None:
        self._parameters = parameters
        self._can_sway, self._turning = can_sway, turning
        self._pivots = turning.on_the_spot and not can_sway
        self._thrust_turns = turning.aside and turning.on_the_spot and not can_sway
        self._preview = Preview(parameters, turning, self._thrust_turns)
        self._learns = _LEARNS if turning.arc is None else _LEARNS_IN_ARC
        self._agility = agility
        self._laid: LaidTrack | None = None
        self._crab = CrabCompensation(top_mps, turning.steered)
        self._motion = None if agility is None else PlannedMotion(parameters, agility, self._crab, submit)
        self._up = RoundingUp(parameters, turning.on_the_spot)
        self._carried = CarriedTurn(parameters) if self._pivots and not turning.aside else None
        self._waypoints: tuple[Waypoint, ...] = ()
        self._track: Track | None = None
        self._profile: SpeedProfile | None = None
        self._profile_key: tuple[float, ...] = ()
        self._waypoint_s_m: tuple[float, ...] = ()
        self._stop_at_end = True
        self._passed = 0
        self._finished = False
        self._s = self._integral = self._speed = 0.0
        self._tip_end = 0.0  # arc length at which the last turn back ends
        self._rests_s = 0.0  # at the end, without way
        self._surge = 0.0  # of the last setpoint
        self._yaw: float | None = None  # of the last setpoint

    def start(
        self,
        waypoints: Sequence[Waypoint],
        nav: NavState,
        stop_at_end: bool = True,
        from_here: bool = True,
        beyond: Sequence[Waypoint] = (),
    ) -> None:
        """Lay the track. `from_here`: it begins at the boat; else it begins at the first waypoint, which counts as
        passed. `beyond`: later waypoints, which affect the shape alone. Raises ValueError for no waypoints or a
        non-finite one."""
        from_here = from_here or len(waypoints) == 1
        joint = FromBoat((nav.north_m, nav.east_m) if from_here else None)
        self.take(self.shape().lay(joint, waypoints, beyond, stop_at_end), nav)

    def replace(
        self, waypoints: Sequence[Waypoint], nav: NavState, stop_at_end: bool = True, beyond: Sequence[Waypoint] = ()
    ) -> None:
        """Change to other waypoints under way: the new track leaves the old one at the boat, in its direction. Raises
        ValueError as `start`."""
        joint = self.from_track()
        if joint is None or not waypoints:
            self.start(waypoints, nav, stop_at_end, beyond=beyond)
            return
        self.take(self.shape().lay(joint, waypoints, beyond, stop_at_end), nav)

    def go_on(
        self, waypoints: Sequence[Waypoint], nav: NavState, stop_at_end: bool = True, beyond: Sequence[Waypoint] = ()
    ) -> None:
        """Continue with the waypoints that follow: the track is the same as if `start` had been given all of them.
        Raises ValueError as `start`."""
        joint = self.onward()
        if joint is None:
            self.start(waypoints, nav, stop_at_end, beyond=beyond)
            return
        self.take(self.shape().lay(joint, waypoints, beyond, stop_at_end), nav)

    def turns_against(self, resistance: float) -> None:
        """The water resists a turn so many times as hard as the vessel's file says: the boat turns earlier, and slower
        where the moment bounds its speed."""
        if self._preview.early.turns_against(resistance):
            self._profile = None

    def shape(self, nav: NavState | None = None) -> TrackShape:
        """How a track is laid now. `nav`: with its plan, for the weather that is known there."""
        parameters = self._parameters
        return TrackShape(
            kind=PathKind(int(parameters["PATH_KIND"])),
            radius_m=parameters["NAV_ACC_RAD"],
            widest_m=self._widest_m(),
            through=parameters["WP_CORNER"] == _THROUGH and (self._plans or self._swings),
            cruise_mps=parameters["WP_SPEED"],
            terms=None if nav is None or self._motion is None or not self._plans else self._motion.terms(nav),
        )

    def from_track(self) -> FromTrack | None:
        """The joint of a track that replaces the present one; None without one."""
        return None if self._track is None else FromTrack(self._track.at(self._s), self._parameters["NAV_ACC_RAD"])

    def onward(self) -> Onward | None:
        """The joint of a track that goes on from the present one; None without one."""
        return None if self._laid is None else Onward(self._laid.points[-CONTEXT:])

    def take(self, laid: LaidTrack, nav: NavState) -> None:
        """Sail a track that was laid for about the place where the boat is."""
        here = None if self._track is None else self._track.at(self._s)
        track, joint, near = laid.track, laid.joint, laid.begin_s_m
        self._use(laid)
        if isinstance(joint, FromBoat) or here is None:
            self._begin(laid, nav)
        elif isinstance(joint, Onward):
            window_m = 4.0 * self._radius(joint.last[-1]) + self._parameters["PATH_LOOKAHEAD"]
            self._s = track.project(here.north_m, here.east_m, near, window_m)
        else:
            moved = here != joint.here
            self._s = track.project(here.north_m, here.east_m, near, 4.0 * joint.radius_m) if moved else near

    def _use(self, laid: LaidTrack) -> None:
        self._laid, self._track = laid, laid.track
        self._waypoints, self._waypoint_s_m = laid.waypoints, laid.ends_s_m
        self._stop_at_end = laid.stop_at_end
        self._passed = 0
        self._finished = False
        self._profile_key = ()
        if self._motion is not None:
            self._motion.take(laid)
        self._up.reset()
        if self._carried is not None:
            self._carried.reset()
        self._preview.begin()
        self._tip_end = self._rests_s = 0.0

    def _begin(self, laid: LaidTrack, nav: NavState) -> None:
        """Sail a track from the boat's motion, nothing of what was learned before counts."""
        track = laid.track
        from_here = not isinstance(laid.joint, FromBoat) or laid.joint.place is not None
        self._passed = 0 if from_here else 1
        self._integral = 0.0
        self._crab.reset()
        if self._plans:
            self._crab.begin(nav)
        self._yaw = None
        first_leg = laid.track.waypoint_s_m[1]
        self._s = min(first_leg, track.project(nav.north_m, nav.east_m, 0.0, first_leg))
        self._surge = nav.surge_mps
        course = track.at(self._s).course_rad
        self._speed = max(0.0, nav.north_mps * math.cos(course) + nav.east_mps * math.sin(course))

    @property
    def legs(self) -> list[list[tuple[float, float]]]:
        """The track from the boat on: closely spaced (north_m, east_m), one list for each waypoint; those that are
        passed have nothing but the boat's place. Raises RuntimeError before `start`."""
        if self._laid is None:
            raise RuntimeError("PathTracker.legs before start")
        return self._laid.legs(self._s)

    def update(self, nav: NavState, speed_mps: float, dt_s: float) -> PathProgress:
        """Find the boat on the track, count the waypoints passed, and make the setpoint, at `speed_mps` at most. Raises
        RuntimeError before `start`."""
        track = self._track
        if track is None:
            raise RuntimeError("PathTracker.update before start")
        lookahead = max(self._parameters["PATH_LOOKAHEAD"], self._parameters["PATH_LOOK_TIME"] * self._speed)
        window = max(2.0 * lookahead, 4.0 * math.hypot(nav.north_mps, nav.east_mps) * dt_s)
        nearest = track.project(nav.north_m, nav.east_m, self._s, window)
        self._go_along(nav, track, nearest, dt_s)
        self._pass_waypoints(nav, track)
        here = track.at(self._s)
        error = -(nav.north_m - here.north_m) * math.sin(here.course_rad) + (nav.east_m - here.east_m) * math.cos(
            here.course_rad
        )
        straight = max(0.0, 1.0 - 2.0 * abs(nav.yaw_rate_radps) / math.radians(self._parameters["PATH_YAW_RATE"]))
        # a planned boat asks for sideways speed itself: taken for drift, it would turn the bow across its course
        self._crab.update(nav, self._speed, 0.0 if self._plans else straight, dt_s)
        self._crab.sail_at(self._leg_mps(speed_mps), dt_s)
        motion = self._motion
        if motion is not None and self._plans and motion.is_planned(nav, speed_mps, self._s, dt_s):
            setpoint = self._exactly(motion, nav, OnTrack(track, self._s, here, error), dt_s)
        else:
            last_speed = self._speed
            self._round_up(nav, here, dt_s)
            self._speed = self._next_speed(track, speed_mps, dt_s, self._steerage_mps(nav))
            ahead = track.at(self._course_s_m(nav, track, error, lookahead))
            setpoint = self._setpoint(nav, here, ahead, error, lookahead, last_speed, dt_s)
        remaining = max(0.0, self._waypoint_s_m[-1] - self._s)
        self._finished = self._finished or self._at_end(nav, track, dt_s)
        beside = track.at(nearest)
        way = nearest - math.hypot(nav.north_m - beside.north_m, nav.east_m - beside.east_m)
        return PathProgress(setpoint, self._passed, self._finished, self._s, remaining, way)

    @property
    def _plans(self) -> bool:
        """Whether the boat sails by a plan. The regulator of PATH_CTRL 1 keeps no sideways speed, as a plan asks."""
        parameters = self._parameters
        return self._agility is not None and parameters["PATH_EFFORT"] > 0.0 and parameters["PATH_CTRL"] != _REGULATOR

    @property
    def _swings(self) -> bool:
        """Whether a boat without a plan turns fast enough to swing through a waypoint."""
        bends, cruise_mps = self._turning.bends, self._parameters["WP_SPEED"]
        if self._agility is not None or bends is None or self._turning.aside:
            return False
        return bends.at(swing_bend_1pm(cruise_mps)) >= _KEPT_IN_SWING * cruise_mps

    # --- the place on the track ---

    def _radius(self, waypoint: Waypoint) -> float:
        return waypoint.own_radius_m or self._parameters["NAV_ACC_RAD"]

    def _widest_m(self) -> float:
        """The window at which a right-angled corner becomes a bend for full speed: the bend's radius is
        window/2.83."""
        top = self._parameters["MPC_XY_VEL_MAX"]
        turn = max(top / math.radians(self._parameters["PATH_YAW_RATE"]), top * top / self._parameters["PATH_ACC_LAT"])
        return 3.0 * turn

    def _pass_waypoints(self, nav: NavState, track: Track) -> None:
        """Count the waypoints that the boat now passes: inside their radius, or abeam."""
        while self._passed < len(self._waypoints):
            waypoint, abeam_s = self._waypoints[self._passed], self._waypoint_s_m[self._passed]
            inside = math.hypot(waypoint.north_m - nav.north_m, waypoint.east_m - nav.east_m) <= self._radius(waypoint)
            is_last = self._passed == len(self._waypoints) - 1
            abeam = self._s >= abeam_s - 1.0e-6 if not is_last else self._past_end(nav, track)
            if not inside and not abeam:
                return
            self._passed += 1

    def _go_along(self, nav: NavState, track: Track, nearest_m: float, dt_s: float) -> None:
        """Take the arc length reached: by projection, or past a tip by its own advance. Which leads further, not both
        in turn: as the one gives way to the other, the place would jump."""
        before_m, speed_mps = self._s, max(self._speed, creep_mps(self._parameters))
        pace = _MOST_PACE * max(speed_mps, math.hypot(nav.north_mps, nav.east_mps))
        self._s = max(before_m, min(nearest_m, before_m + pace * dt_s))
        self._s = max(
            self._s,
            self._over_tips(nav, track, before_m, dt_s),
            self._past_tips(nav, track, nearest_m, before_m + speed_mps * dt_s),
        )

    def _over_tips(self, nav: NavState, track: Track, before_m: float, dt_s: float) -> float:
        """The arc length reached from `before_m` around the tip of a turn back, by itself: there the legs before and
        after the tip are equally near, so projection cannot tell them apart."""
        if self._plans:
            turn_rad = track.at(self._s + _TIP_M).course_rad - track.at(self._s - _TIP_M).course_rad
            tip = abs(turn_rad) > 2.0 * _TIP_M * _TIP_1PM
            return min(track.length_m, before_m + self._speed * dt_s) if tip else before_m
        beyond = self._s + TURN_PREVIEW_S * self._speed + 3.0 * track.spacing_m
        turn = wrap_pi(track.at(beyond).course_rad - track.at(self._s).course_rad)
        back = self._preview.turned_back_s_m(nav, track, self._s)
        if back > self._s:
            self._tip_end = max(self._tip_end, min(track.length_m, back + 3.0 * track.spacing_m))
        elif abs(turn) > ALMOST_BACK_RAD:
            self._tip_end = min(track.length_m, beyond)
        return min(self._tip_end, before_m + _TIP_PACE * max(self._speed, creep_mps(self._parameters)) * dt_s)

    def _past_tips(self, nav: NavState, track: Track, nearest_m: float, onward_m: float) -> float:
        """The arc length reached, which goes on to `onward_m` by itself where the boat lies ahead of it in the course
        there: beyond a tip that it did not see, whose course would lead it away for ever."""
        here = track.at(self._s)
        ahead_m = (nav.north_m - here.north_m) * math.cos(here.course_rad) + (nav.east_m - here.east_m) * math.sin(
            here.course_rad
        )
        if nearest_m > self._s or ahead_m < _PAST_M:
            return self._s
        return min(track.length_m, onward_m)

    def _course_s_m(self, nav: NavState, track: Track, error: float, lookahead: float) -> float:
        """Arc length at which the course is taken."""
        waypoint = self._waypoints[min(self._passed, len(self._waypoints) - 1)]
        through = self._laid is not None and self._laid.through
        leg = OnLeg(track, self._s, self._speed, waypoint.own_radius_m, through)
        usual_m = self._preview.ahead_m(nav, leg, error, lookahead)
        last = nav.yaw_rad if self._yaw is None else self._yaw
        if self._carried is None or self._up.lasts:
            return self._s + usual_m
        return self._carried.course_s_m(
            nav,
            track,
            self._s,
            usual_m,
            self._preview.ahead_s(nav, leg),
            self._crab.water(nav),
            lambda course_rad: self._best_heading(nav, course_rad, last),
        )

    def _past_end(self, nav: NavState, track: Track) -> bool:
        """Whether the boat has passed the line across the track at the last waypoint."""
        end = track.at(self._waypoint_s_m[-1])
        return (nav.north_m - end.north_m) * math.cos(end.course_rad) + (nav.east_m - end.east_m) * math.sin(
            end.course_rad
        ) >= 0.0

    def _at_end(self, nav: NavState, track: Track, dt_s: float) -> bool:
        if self._passed < len(self._waypoints):
            return False
        if not self._stop_at_end:
            return True
        slow = math.hypot(nav.north_mps, nav.east_mps) <= 2.0 * creep_mps(self._parameters)
        self._rests_s = self._rests_s + dt_s if slow else 0.0
        stopped = slow and self._speed <= 2.0 * creep_mps(self._parameters)
        return stopped or self._rests_s > _RESTS_S or self._past_last_waypoint(nav, track)

    def _past_last_waypoint(self, nav: NavState, track: Track) -> bool:
        return self._s >= self._waypoint_s_m[-1] - 1.0e-6 and self._past_end(nav, track)

    # --- speed ---

    def _leg_mps(self, commanded_mps: float) -> float:
        """The speed of the present leg, without its bends."""
        own = self._waypoints[min(self._passed, len(self._waypoints) - 1)].speed_mps
        return min(commanded_mps, self._parameters["MPC_XY_VEL_MAX"] if own is None else own)

    def _steerage_mps(self, nav: NavState) -> float:
        """Speed below which the current, not the bow, says where a boat without sideways thrust goes. Less where it is
        to come to rest."""
        if self._can_sway:
            return 0.0
        return min(_STEERAGE * math.hypot(*self._crab.water(nav)), self._stopping_mps())

    def _stopping_mps(self) -> float:
        """The highest speed from which the boat can still come to rest at the end; infinite where it need not."""
        if not self._stop_at_end:
            return math.inf
        # v² = 2a (left − T v)
        most_mps2, left_m = self._parameters["PATH_ACC"], max(0.0, self._waypoint_s_m[-1] - self._s)
        return math.sqrt((_PREVIEW_S * most_mps2) ** 2 + 2.0 * most_mps2 * left_m) - _PREVIEW_S * most_mps2

    def _round_up(self, nav: NavState, here: PathPoint, dt_s: float) -> None:
        """See whether the boat is so near the end that it turns its bow into the stream."""
        if self._can_sway or not self._stop_at_end or self._passed < len(self._waypoints) - 1:
            return
        self._up.update(nav, self._crab.water(nav), here.course_rad, self._waypoint_s_m[-1] - self._s, dt_s)

    def _next_speed(self, track: Track, speed_mps: float, dt_s: float, least_mps: float) -> float:
        """`least_mps`: no bend slows the boat below it."""
        parameters = self._parameters
        key = (
            parameters["PATH_ACC_LAT"],
            parameters["PATH_YAW_RATE"],
            parameters["PATH_ACC"],
            parameters["MPC_XY_VEL_MAX"],
        )
        if self._profile is None or key != self._profile_key:
            legs = [min(key[3], w.speed_mps) if w.speed_mps is not None else key[3] for w in self._waypoints]
            self._profile = SpeedProfile(
                track.s_m,
                track.curvature_1pm,
                self._waypoint_s_m,
                legs,
                BendLimits(key[0], PLANNED_TURN * math.radians(key[1]), self._preview.early.bends),
                key[2],
                self._stop_at_end,
            )
            self._profile_key = key
        wanted = min(max(0.0, speed_mps), self._profile.soon(self._s, _PREVIEW_S, self._speed))
        if self._thrust_turns:
            # it brakes before it turns
            wanted = min(wanted, self._profile.soon(self._s, _PREVIEW_S + TURN_PREVIEW_S, self._speed))
        if speed_mps > 0.0:
            wanted = max(wanted, min(speed_mps, least_mps))
        if self._stop_at_end and speed_mps > 0.0:
            wanted = max(wanted, min(speed_mps, creep_mps(self._parameters)))
        wanted = min(wanted, self._up.most_mps)
        step = 1.25 * parameters["PATH_ACC"] * dt_s
        return min(self._speed + step, max(self._speed - 1.5 * step, wanted))

    # --- heading ---

    def _turned(self, last_rad: float, heading_rad: float, dt_s: float) -> float:
        """The heading setpoint: from `last_rad` towards `heading_rad`, at PATH_YAW_RATE at most."""
        most = math.radians(self._parameters["PATH_YAW_RATE"]) * dt_s
        self._yaw = wrap_pi(_towards(last_rad, last_rad + wrap_pi(heading_rad - last_rad), most))
        return self._yaw

    def _setpoint_rate(self, to_turn_rad: float, dt_s: float, course_radps: float) -> float:
        """The yaw rate of the heading setpoint: that of the course; PATH_YAW_RATE in an arc, or where the turn pushes
        the boat aside, while it cannot follow, and on the spot in a stream while the bow has far to turn."""
        most = math.radians(self._parameters["PATH_YAW_RATE"])
        if self._carried is not None and self._carried.in_stream:
            follows = abs(to_turn_rad) <= _STRAIGHT_RAD
        else:
            follows = (self._turning.arc is None and not self._thrust_turns) or abs(to_turn_rad) <= most * dt_s
        return course_radps if follows else math.copysign(most, to_turn_rad)

    def _best_heading(self, nav: NavState, course_rad: float, last_rad: float) -> float:
        if self._up.lasts:
            return self._up.heading_rad(self._crab.water(nav), course_rad, self._speed)
        if not self._can_sway:
            return self._crab.heading_rad(nav, course_rad, self._speed, last_rad)
        return self._crab.bow_rad(nav, course_rad, self._speed, self._parameters["DP_SPEED_SWAY"], last_rad)

    def _sway(self, nav: NavState, off_rad: float) -> float:
        """Sideways speed over ground: that of the water, plus or minus DP_SPEED_SWAY by the thrusters."""
        return self._crab.sway_mps(nav, self._speed * math.sin(off_rad), self._parameters["DP_SPEED_SWAY"])

    def _setpoint(
        self,
        nav: NavState,
        here: PathPoint,
        ahead: PathPoint,
        error: float,
        lookahead: float,
        last_speed: float,
        dt_s: float,
    ) -> PathSetpoint:
        gain = self._parameters["PATH_INTEGRAL"]
        leaning = error + gain * self._integral
        away = -nav.north_mps * math.sin(here.course_rad) + nav.east_mps * math.cos(here.course_rad)
        learns = abs(error) < self._learns * lookahead and abs(here.curvature_1pm) * lookahead < _STRAIGHT_RAD
        last = nav.yaw_rad if self._yaw is None else self._yaw
        led_astray = abs(wrap_pi(nav.yaw_rad - last)) > _ASTRAY_RAD
        if learns and not self._up.lasts and not led_astray:
            # a boat that waits for its bow learns as slowly as it sails
            pace = min(self._speed, max(0.0, self._surge)) if self._pivots else self._speed
            far = math.hypot(lookahead, leaning)
            self._integral += lookahead * (pace * error + far * away) / (far * far) * dt_s
            bound = 0.6 * lookahead / gain if gain > 0.0 else 0.0
            self._integral = min(bound, max(-bound, self._integral))
        course = ahead.course_rad - self._towards_rad(error, gain * self._integral, lookahead)
        waits = self._carried is not None and self._carried.waits and not self._up.lasts
        best = last if waits else self._best_heading(nav, course, last)
        heading = self._turned(last, best, dt_s)
        off = wrap_pi(course - nav.yaw_rad)
        against = math.cos(best - course) < 0.0  # bow into a current that carries the boat along its course
        lowest = -1.0 if against else 0.0 if self._can_sway else _TURN_IN_PLACE_SHARE
        surge = self._speed * max(lowest, math.cos(off))
        towards_m = -error * math.sin(nav.yaw_rad - here.course_rad)
        if self._up.lasts:
            surge = max(surge, self._up.least_mps(nav, self._crab.water(nav), best))
        elif self._pivots and not against and towards_m < _BACK_M:
            surge = min(
                surge,
                creep_mps(self._parameters) if waits else self._turning_mps(_outside_rad(course, best, nav.yaw_rad)),
            )
        ramp = _ROUNDING_SHARE if self._up.lasts else _SURGE_SHARE
        wanted = max(surge, self._unbraked_mps(nav, ahead, wrap_pi(best - nav.yaw_rad)))
        self._surge = _towards(self._surge, wanted, ramp * self._parameters["PATH_ACC"] * dt_s)
        sway = self._sway(nav, off) if self._can_sway else 0.0
        return PathSetpoint(
            heading,
            self._surge,
            sway,
            self._setpoint_rate(wrap_pi(best - last), dt_s, self._turn_rate(nav, here, ahead, leaning, lookahead)),
            0.0 if self._up.lasts else self._gain_share * (self._speed - last_speed) / dt_s,
            self._progress(here, error),
        )

    @property
    def _gain_share(self) -> float:
        """Of the change of speed, that the bow's direction takes part in: none where the boat waits for its bow."""
        return min(1.0, max(-1.0, self._surge / self._speed)) if self._speed > 0.0 else 0.0

    def _unbraked_mps(self, nav: NavState, ahead: PathPoint, turn_rad: float) -> float:
        """The least speed asked of a boat that is turned by one thruster that turns itself, while it turns."""
        least_rad, most_rad = _UNBRAKED_RAD
        if nav.yaw_rate_radps * math.copysign(1.0, turn_rad) > _TURNS_RADPS:
            most_rad = _TURNS_RAD
        in_bend = self._speed * abs(ahead.curvature_1pm) > _UNBRAKED_RADPS
        turns = (in_bend or abs(turn_rad) > least_rad) and abs(turn_rad) < most_rad
        if not self._thrust_turns or not turns or self._up.lasts:
            return -math.inf
        return min(nav.surge_mps, _UNBRAKED * self._speed)

    def _towards_rad(self, error: float, learnt: float, lookahead: float) -> float:
        """How far the course leans towards the track: by line of sight, for the error no more than an arc allows."""
        rate_radps = math.radians(self._parameters["PATH_YAW_RATE"])
        most = self._turning.steepest_back_rad(abs(error), self._speed, rate_radps)
        most += abs(math.atan2(learnt, lookahead))
        return min(most, max(-most, math.atan2(error + learnt, lookahead)))

    def _turning_mps(self, turn_rad: float) -> float:
        """The speed at which the boat runs wide by no more than _WIDE_M while its bow turns by `turn_rad`."""
        rate = math.radians(self._parameters["PATH_YAW_RATE"])
        return max(creep_mps(self._parameters), 2.0 * _WIDE_M * rate / max(turn_rad * turn_rad, 1.0e-6))

    def _progress(self, here: PathPoint, error: float) -> Progress:
        target = self._waypoints[min(self._passed, len(self._waypoints) - 1)]
        abeam_s = self._waypoint_s_m[min(self._passed, len(self._waypoints) - 1)]
        return Progress(
            place=Point(here.north_m, here.east_m),
            target=Point(target.north_m, target.east_m),
            cross_track_error_m=error,
            course_rad=wrap_pi(here.course_rad),
            distance_to_go_m=max(0.0, abeam_s - self._s),
        )

    # --- a planned path ---

    def _exactly(self, motion: PlannedMotion, nav: NavState, place: OnTrack, dt_s: float) -> PathSetpoint:
        """The setpoint by the plan, from speed and heading of the last one."""
        motion.speed_mps, motion.yaw_rad = self._speed, self._yaw
        setpoint = motion.update(place, nav, self._progress(place.here, place.off_m), dt_s)
        self._speed, self._yaw = motion.speed_mps, motion.yaw_rad
        return setpoint

    def _turn_rate(self, nav: NavState, here: PathPoint, ahead: PathPoint, leaning: float, lookahead: float) -> float:
        """Yaw rate of the course to sail: by the bend, and by the change of the cross-track error.

        The part of the bend follows the true speed along the track: a boat that wind stops in a bend must first turn
        back to its course.
        """
        along = nav.north_mps * math.cos(here.course_rad) + nav.east_mps * math.sin(here.course_rad)
        pace = min(self._speed, max(0.0, along))
        drift = -nav.north_mps * math.sin(here.course_rad) + nav.east_mps * math.cos(here.course_rad)
        rate = pace * ahead.curvature_1pm - drift * lookahead / (lookahead * lookahead + leaning * leaning)
        limit = math.radians(self._parameters["PATH_YAW_RATE"])
        return min(limit, max(-limit, rate))


def _outside_rad(course_rad: float, heading_rad: float, yaw_rad: float) -> float:
    """How far the bow points outside of the angle between a course and the heading for it: inside, thrust ahead takes
    the boat along its course."""
    course, heading = wrap_pi(course_rad - yaw_rad), wrap_pi(heading_rad - yaw_rad)
    inside = course * heading <= 0.0 and abs(course - heading) <= math.pi
    return 0.0 if inside else min(abs(course), abs(heading))


def _towards(value: float, wanted: float, most: float) -> float:
    return value + min(most, max(-most, wanted - value))
