"""Path tracking: integral line of sight along a smooth track, at a speed that fits the bends ahead.

Course to sail χ_d = χ(s) − atan((e + κ z)/Δ), with z' = U Δ e / (Δ² + (e + κ z)²) (Børhaug, Pavlov & Pettersen 2008;
Fossen 2021, 12.3), Δ the look-ahead distance. Heading ψ_d = χ_d − β, with the crab angle β from `CrabCompensation`. A
waypoint counts as passed inside its radius or abeam of it, so the boat never circles one that it missed. The heading
setpoint never jumps: it turns at PATH_YAW_RATE at most.

A boat with sideways thrust and a known agility sails by a `PathPlan` instead: planned speed, heading, turn and
accelerations as feed-forward, and back to the track at PATH_BW_CROSS by sideways speed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from companion.core.angles import wrap_pi
from companion.core.estimate import NavState
from companion.core.frames import ned_to_body
from companion.core.setpoint import PATH_STEP_S, PathSetpoint, PlannedPose, Point, Progress
from companion.core.work import Job, Submit, at_once
from companion.guidance.agility import Agility, Weather
from companion.guidance.crab_compensation import CrabCompensation
from companion.guidance.path import PathKind, PathPoint
from companion.guidance.path_laying import CONTEXT, FromBoat, FromTrack, LaidTrack, Onward, PlanTerms, TrackShape
from companion.guidance.path_plan import PathPlan, PlanLimits
from companion.guidance.speed_profile import SpeedProfile
from companion.guidance.track import Track
from companion.guidance.waypoint import Waypoint
from companion.params.store import Parameters

_ALMOST_BACK_RAD = math.radians(120.0)  # a sharper turn leads back along the same line
_STRAIGHT_RAD = math.radians(15.0)  # the integral learns where the track turns by less over the look-ahead distance
_PLANNED_TURN = 0.7  # share of the yaw rate that bends are planned for; the rest is for corrections
_MOST_PACE = 2.0  # fastest motion of the point abeam along the track, in boat speeds: in a bend that is cut
_TIP_PACE = 1.5  # the same around the tip of a turn back
_TIP_1PM = 2.0  # a planned path's bend from which on the boat's place tells no progress: it may lie anywhere around it
_SURGE_SHARE = 3.0  # in PATH_ACC: how fast the speed setpoint changes as the bow turns to the course
_TURN_PREVIEW_S = 1.2  # lag of the heading loop
_PREVIEW_S = 0.5  # lag of the speed loop
_STEERAGE = 1.4  # times the current: speed over ground that leaves a speed through the water in every direction
_TURN_IN_PLACE_SHARE = 0.3  # of the speed, kept off the course by a boat that needs way to steer
_THRUST_LAG_S = 0.4  # from a command to its thrust
_LEAST_BACK_MPS = 0.3  # speed from which the way back to the track grows steeper as the boat slows down
_FAR_M = 0.5  # cross-track error from which the bow too turns back to the track
_CRAB_SHARE = 1.0  # of the commanded speed: a slower boat does not turn its bow further into the current
_CORRECTING = 0.4  # of the planned yaw rate: how fast the heading comes to the plan where the boat is off it
_NEW_WATER_MPS, _NEW_AIR_MPS = 0.15, 2.0  # changes of current and wind that are worth a new plan
_REGULATOR, _PREDICTIVE = 1, 2  # PATH_CTRL
_POSES = 19  # ahead: 5.4 s
_THROUGH = 1  # WP_CORNER
_THROUGH_WINDOW_M = 2.4  # widest window of a corner that is passed through


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
    beside the control thread. Remembers the track, the arc length reached (which never decreases), the waypoints
    passed, the integral of the line of sight, the drift, and the last setpoint's speed and heading.
    """

    def __init__(
        self,
        parameters: Parameters,
        can_sway: bool,
        top_mps: float = math.inf,
        agility: Agility | None = None,
        submit: Submit = at_once,
    ) -> None:
        self._parameters = parameters
        self._can_sway = can_sway
        self._agility = agility
        self._laid: LaidTrack | None = None
        self._plan: PathPlan | None = None
        self._terms: PlanTerms | None = None  # of the plan
        self._planning: Job[tuple[PlanTerms, PathPlan]] = Job(submit)
        self._crab = CrabCompensation(top_mps)
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
        self._surge = 0.0  # of the last setpoint
        self._yaw: float | None = None  # of the last setpoint
        self._commanded = 0.0

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

    def shape(self, nav: NavState | None = None) -> TrackShape:
        """How a track is laid now. `nav`: with its plan, for the weather that is known there."""
        parameters = self._parameters
        return TrackShape(
            kind=PathKind(int(parameters["PATH_KIND"])),
            radius_m=parameters["NAV_ACC_RAD"],
            widest_m=self._widest_m(),
            least_m=_THROUGH_WINDOW_M if self._plans else 0.0,
            through=self._plans and parameters["WP_CORNER"] == _THROUGH,
            terms=None if nav is None else self._terms_now(nav),
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
        self._plan, self._terms = laid.plan, laid.terms
        self._planning.drop()
        self._tip_end = 0.0

    def _begin(self, laid: LaidTrack, nav: NavState) -> None:
        """Sail a track from the boat's motion, nothing of what was learned before counts."""
        track = laid.track
        from_here = not isinstance(laid.joint, FromBoat) or laid.joint.place is not None
        self._passed = 0 if from_here else 1
        self._integral = 0.0
        self._crab.reset()
        self._yaw = None
        first_leg = laid.track.waypoint_s_m[1]
        self._s = min(first_leg, track.project(nav.north_m, nav.east_m, 0.0, first_leg))
        self._surge = nav.surge_mps
        course = track.at(self._s).course_rad
        self._speed = max(0.0, nav.north_mps * math.cos(course) + nav.east_mps * math.sin(course))

    @property
    def legs(self) -> list[list[tuple[float, float]]]:
        """The track from the boat on: closely spaced (north_m, east_m), one list for each waypoint ahead. Raises
        RuntimeError before `start`."""
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
        pace = _MOST_PACE * max(self._speed, self._creep_mps(), math.hypot(nav.north_mps, nav.east_mps))
        self._s = max(self._s, min(nearest, self._s + pace * dt_s))
        self._s = self._over_tips(track, dt_s)
        self._pass_waypoints(nav, track)
        here = track.at(self._s)
        error = -(nav.north_m - here.north_m) * math.sin(here.course_rad) + (nav.east_m - here.east_m) * math.cos(
            here.course_rad
        )
        straight = max(0.0, 1.0 - 2.0 * abs(nav.yaw_rate_radps) / math.radians(self._parameters["PATH_YAW_RATE"]))
        self._crab.update(nav, self._speed, straight, dt_s)
        plan = self._planned(nav, track)
        if plan is not None:
            setpoint = self._exactly(plan, nav, track, here, error, speed_mps, dt_s)
        else:
            last_speed = self._speed
            self._speed = self._next_speed(track, speed_mps, dt_s, self._steerage_mps(nav))
            ahead = track.at(self._s + _TURN_PREVIEW_S * self._speed)
            setpoint = self._setpoint(nav, here, ahead, error, lookahead, last_speed, dt_s)
        remaining = max(0.0, self._waypoint_s_m[-1] - self._s)
        self._finished = self._finished or self._at_end(nav, track)
        beside = track.at(nearest)
        way = nearest - math.hypot(nav.north_m - beside.north_m, nav.east_m - beside.east_m)
        return PathProgress(setpoint, self._passed, self._finished, self._s, remaining, way)

    @property
    def _plans(self) -> bool:
        """Whether the boat sails by a plan. The regulator of PATH_CTRL 1 keeps no sideways speed, as a plan asks."""
        parameters = self._parameters
        return self._agility is not None and parameters["PATH_EFFORT"] > 0.0 and parameters["PATH_CTRL"] != _REGULATOR

    # --- the place on the track ---

    def _radius(self, waypoint: Waypoint) -> float:
        return (
            waypoint.radius_m
            if waypoint.radius_m is not None and waypoint.radius_m > 0.0
            else self._parameters["NAV_ACC_RAD"]
        )

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

    def _over_tips(self, track: Track, dt_s: float) -> float:
        """The arc length reached. It advances by itself around the tip of a turn back: there the legs before and after
        the tip are equally near, so projection cannot tell them apart."""
        if self._plans:
            tip = abs(track.at(self._s).curvature_1pm) > _TIP_1PM
            return min(track.length_m, self._s + self._speed * dt_s) if tip else self._s
        beyond = self._s + _TURN_PREVIEW_S * self._speed + 3.0 * track.length_m / len(track.s_m)
        turn = wrap_pi(track.at(beyond).course_rad - track.at(self._s).course_rad)
        if abs(turn) > _ALMOST_BACK_RAD:
            self._tip_end = min(track.length_m, beyond)
        return max(self._s, min(self._tip_end, self._s + _TIP_PACE * max(self._speed, self._creep_mps()) * dt_s))

    def _past_end(self, nav: NavState, track: Track) -> bool:
        """Whether the boat has passed the line across the track at the last waypoint."""
        end = track.at(self._waypoint_s_m[-1])
        return (nav.north_m - end.north_m) * math.cos(end.course_rad) + (nav.east_m - end.east_m) * math.sin(
            end.course_rad
        ) >= 0.0

    def _at_end(self, nav: NavState, track: Track) -> bool:
        if self._passed < len(self._waypoints):
            return False
        if not self._stop_at_end:
            return True
        slow = math.hypot(nav.north_mps, nav.east_mps) <= 2.0 * self._creep_mps()
        return (slow and self._speed <= 2.0 * self._creep_mps()) or self._past_last_waypoint(nav, track)

    def _past_last_waypoint(self, nav: NavState, track: Track) -> bool:
        return self._s >= self._waypoint_s_m[-1] - 1.0e-6 and self._past_end(nav, track)

    # --- speed ---

    def _creep_mps(self) -> float:
        """Lowest speed of approach, so that the boat reaches the end."""
        return 0.1 * self._parameters["WP_SPEED"]

    def _steerage_mps(self, nav: NavState) -> float:
        """Speed below which the current, not the bow, says where a boat without sideways thrust goes. 0 on the way to
        the end, where the boat is to come to rest."""
        if self._can_sway or self._passed >= len(self._waypoints) - 1:
            return 0.0
        return _STEERAGE * math.hypot(*self._crab.water(nav))

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
                key[0],
                _PLANNED_TURN * math.radians(key[1]),
                key[2],
                self._stop_at_end,
            )
            self._profile_key = key
        wanted = min(max(0.0, speed_mps), self._profile.at(self._s + _PREVIEW_S * self._speed))
        if speed_mps > 0.0:
            wanted = max(wanted, min(speed_mps, least_mps))
        if self._stop_at_end and speed_mps > 0.0:
            wanted = max(wanted, min(speed_mps, self._creep_mps()))
        step = 1.25 * parameters["PATH_ACC"] * dt_s
        return min(self._speed + step, max(self._speed - 1.5 * step, wanted))

    # --- heading ---

    def _turned(self, last_rad: float, heading_rad: float, dt_s: float) -> float:
        """The heading setpoint: from `last_rad` towards `heading_rad`, at PATH_YAW_RATE at most."""
        most = math.radians(self._parameters["PATH_YAW_RATE"]) * dt_s
        self._yaw = wrap_pi(_towards(last_rad, last_rad + wrap_pi(heading_rad - last_rad), most))
        return self._yaw

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
        if abs(error) < 2.0 * lookahead and abs(here.curvature_1pm) * lookahead < _STRAIGHT_RAD:
            self._integral += self._speed * lookahead * error / (lookahead * lookahead + leaning * leaning) * dt_s
            bound = 0.6 * lookahead / gain if gain > 0.0 else 0.0
            self._integral = min(bound, max(-bound, self._integral))
        course = ahead.course_rad - math.atan2(error + gain * self._integral, lookahead)
        last = nav.yaw_rad if self._yaw is None else self._yaw
        best = self._crab.heading_rad(nav, course, self._speed, last)
        heading = self._turned(last, best, dt_s)
        off = wrap_pi(course - nav.yaw_rad)
        against = math.cos(best - course) < 0.0  # bow into a current that carries the boat along its course
        lowest = -1.0 if against else 0.0 if self._can_sway else _TURN_IN_PLACE_SHARE
        self._surge = _towards(
            self._surge, self._speed * max(lowest, math.cos(off)), _SURGE_SHARE * self._parameters["PATH_ACC"] * dt_s
        )
        sway = self._sway(nav, off) if self._can_sway else 0.0
        return PathSetpoint(
            heading,
            self._surge,
            sway,
            self._turn_rate(nav, here, ahead, leaning, lookahead),
            (self._speed - last_speed) / dt_s,
            self._progress(here, error),
        )

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

    def _planned(self, nav: NavState, track: Track) -> PathPlan | None:
        """The plan of the track; None for a boat without sideways thrust, with PATH_EFFORT 0, and until the first one
        is made. It is made anew when a limit, the current or the wind has changed."""
        terms = self._terms_now(nav)
        if terms is None:
            return None
        job, ends, waypoints, stops = self._planning, self._waypoint_s_m, self._waypoints, self._stop_at_end
        if not job.pending and (self._terms is None or terms.key != self._terms.key):
            job.begin(lambda: (terms, terms.plan(track, ends, waypoints, stops)))
        if job.done:
            self._terms, self._plan = job.take()
        return self._plan

    def _terms_now(self, nav: NavState) -> PlanTerms | None:
        """What a plan depends on now; None where the boat does not sail by one."""
        agility, parameters = self._agility, self._parameters
        if agility is None or not self._plans:
            return None
        weather = _weather(nav)
        share, top, least = parameters["PATH_EFFORT"], parameters["MPC_XY_VEL_MAX"], 0.5 * self._creep_mps()
        sway = agility.sway_mps(share)
        key = (
            share, top, least, sway,
            *(
                round(value / step)
                for value, step in (
                    (weather.water_north_mps, _NEW_WATER_MPS), (weather.water_east_mps, _NEW_WATER_MPS),
                    (weather.air_north_mps, _NEW_AIR_MPS), (weather.air_east_mps, _NEW_AIR_MPS),
                )
            ),
        )  # fmt: skip
        return PlanTerms(key, PlanLimits(agility, share, sway, least, weather), top)

    def _exactly(
        self,
        plan: PathPlan,
        nav: NavState,
        track: Track,
        here: PathPoint,
        error: float,
        speed_mps: float,
        dt_s: float,
    ) -> PathSetpoint:
        """The planned motion at the boat's place, and back to the track by sideways speed. Accelerations and turns are
        those of a little later, when the thrust that they need will have built up."""
        now = plan.at(self._s)
        self._commanded = min(speed_mps, self._parameters["MPC_XY_VEL_MAX"])
        creep = min(speed_mps, self._creep_mps()) if self._stop_at_end else 0.0
        wanted = max(creep, min(max(0.0, speed_mps), now.speed_mps))
        self._speed = min(
            self._speed + now.speeding_up_mps2 * dt_s, max(self._speed - 1.5 * now.braking_mps2 * dt_s, wanted)
        )
        pace = max(self._speed, creep)
        later_s = plan.ahead_m(self._s, _THRUST_LAG_S, pace)
        later, there = plan.at(later_s), track.at(later_s)
        later_speed = min(
            self._speed + now.speeding_up_mps2 * _THRUST_LAG_S, max(creep, min(max(0.0, speed_mps), later.speed_mps))
        )
        gain = (later_speed - self._speed) / _THRUST_LAG_S
        bend = later_speed * later_speed * there.curvature_1pm
        back = math.atan2(self._parameters["PATH_BW_CROSS"] * error, max(self._speed, _LEAST_BACK_MPS))
        course = here.course_rad - back
        heading, turn, change, against = self._bow(plan, nav, pace, error, dt_s)
        off = wrap_pi(course - nav.yaw_rad)
        surge = self._speed * max(-1.0 if against else 0.0, math.cos(off))
        assert self._terms is not None
        most_sway = max(self._parameters["DP_SPEED_SWAY"], self._terms.limits.sway_mps)
        sway = self._crab.sway_mps(nav, self._speed * math.sin(off), most_sway)
        along, across = ned_to_body(gain, bend, nav.yaw_rad - there.course_rad)
        return PathSetpoint(
            heading,
            surge,
            sway,
            turn,
            along + turn * sway,
            self._progress(here, error),
            across - turn * surge,
            change,
            True,
            self._poses(plan, nav, track, pace) if self._parameters["PATH_CTRL"] == _PREDICTIVE else (),
        )

    def _poses(self, plan: PathPlan, nav: NavState, track: Track, pace: float) -> tuple[PlannedPose, ...]:
        """The poses from now on, with the bow turned into the current as now."""
        speed, yaw = max(self._speed, _CRAB_SHARE * self._commanded), nav.yaw_rad if self._yaw is None else self._yaw
        poses = []
        for k in range(_POSES):
            s_m = self._s if k == 0 else plan.ahead_m(self._s, k * PATH_STEP_S, pace)
            there, course = track.at(s_m), plan.at(s_m).course_rad
            heading = self._crab.heading_rad(nav, course, speed, yaw)
            poses.append(PlannedPose(there.north_m, there.east_m, heading))
        return tuple(poses)

    def _bow(
        self, plan: PathPlan, nav: NavState, pace: float, error: float, dt_s: float
    ) -> tuple[float, float, float, bool]:
        """(heading, yaw rate, yaw acceleration, whether the bow points into a current that carries the boat
        along): the planned course of the bow, turned into the current as at the leg's speed, and towards the track
        where it is far. Rate and acceleration are those of the very same heading a little further on."""
        far = math.copysign(max(0.0, abs(error) - _FAR_M), error)
        aside = math.atan2(self._parameters["PATH_BW_CROSS"] * far, max(self._speed, _LEAST_BACK_MPS))
        last = nav.yaw_rad if self._yaw is None else self._yaw
        speed = max(self._speed, _CRAB_SHARE * self._commanded)
        course, best, turn, change = self._heading_ahead(plan, nav, pace, speed, aside, last)
        assert self._agility is not None
        most = _CORRECTING * self._agility.turn_radps(self._parameters["PATH_EFFORT"])
        self._yaw = wrap_pi(_towards(last + turn * dt_s, last + wrap_pi(best - last), most * dt_s))
        return self._yaw, turn, change, math.cos(best - course) < 0.0

    def _heading_ahead(
        self, plan: PathPlan, nav: NavState, pace: float, speed: float, aside: float, last: float
    ) -> tuple[float, float, float, float]:
        """(course, heading now, its rate, its acceleration), by differences along the plan in steps of the thrust's
        lag."""
        places = (self._s, *(plan.ahead_m(self._s, i * _THRUST_LAG_S, pace) for i in (1, 2)))
        courses = [plan.at(place).course_rad - aside for place in places]
        now, soon, later = (self._crab.heading_rad(nav, course, speed, last) for course in courses)
        first, second = wrap_pi(soon - now), wrap_pi(later - soon)
        return courses[0], now, first / _THRUST_LAG_S, (second - first) / _THRUST_LAG_S**2

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


def _weather(nav: NavState) -> Weather:
    """Current and wind as far as they are known."""
    water = (nav.current_north_mps or 0.0, nav.current_east_mps or 0.0)
    if nav.wind_speed_mps is None or nav.wind_from_rad is None:
        return Weather(*water)
    speed, towards = nav.wind_speed_mps, nav.wind_from_rad + math.pi
    return Weather(*water, speed * math.cos(towards), speed * math.sin(towards))


def _towards(value: float, wanted: float, most: float) -> float:
    return value + min(most, max(-most, wanted - value))
