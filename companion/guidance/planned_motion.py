"""Setpoints of a boat that sails by a `PathPlan`: planned speed, heading, turn and accelerations as feed-forward, and
back to the track at PATH_BW_CROSS by sideways speed.

The plan is made anew, beside the control thread, when a limit, the current, the mean wind or the commanded speed has
changed. One for other weather is taken where it agrees with the present one, on a leg: it would brake for a bend later
or earlier, in the midst of it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.core.angles import wrap_pi
from companion.core.dead_zone import beyond_dead_zone
from companion.core.estimate import Air, NavState, air_over_ground
from companion.core.frames import body_to_ned, ned_to_body
from companion.core.setpoint import PATH_STEP_S, PathSetpoint, PlannedPose, Progress
from companion.core.work import Job, Submit, at_once
from companion.guidance.agility import Agility, Weather
from companion.guidance.crab_compensation import CrabCompensation
from companion.guidance.path import PathPoint
from companion.guidance.path_laying import LaidTrack, PlanTerms
from companion.guidance.path_plan import PathPlan, PlanLimits
from companion.guidance.stopping import creep_mps
from companion.guidance.track import Track
from companion.params.store import Parameters

_THRUST_LAG_S = 0.4  # from a command to its thrust
_ASIDE_LAG_S = 0.2  # from a command to the force across: azimuths turn a thrust that is there already
_LEAST_BACK_MPS = 0.3  # speed from which the way back to the track grows steeper as the boat slows down
_FAR_M = 0.5  # cross-track error from which the bow too turns back to the track
_CORRECTING = 0.4  # of the planned yaw rate: how fast the heading comes to the plan where the boat is off it
_ASTRAY_RAD, _ALL_ASTRAY_RAD = math.radians(10.0), math.radians(30.0)  # off the plan: between them it begins to hurry
_NEAR_M, _LEARNS_M = 0.1, 1.5  # cross-track errors between which the bow learns to lean towards the track
_LEAN_S, _LEAN_LASTS_S, _MOST_LEAN_M = 20.0, 60.0, 1.0
_FOLLOWED = 4.0  # times the lean: so much nearer to the track does the bow turn back already
_MOST_ASIDE_RAD = math.radians(60.0)  # towards the track: a boat in a stream makes good way along it meanwhile
_STEADY_RADPS = math.radians(1.0)  # slower than this the planned course is a leg's
_FORGOTTEN_RAD = math.radians(30.0)  # a turn after which a third of the lean is left: the stream comes from elsewhere
_ASIDE = 0.46  # of the share of the sway limit, for the sideways speed where the bow is not along the track
_SLOWEST_SHARE = 0.25  # of the commanded speed: no bend slows the boat below it
_HARDER, _HARDER_MPS2 = 1.3, 0.1  # times the planned braking, and more: a boat that is too fast slows down so hard
_JERK_MPS3 = 0.5  # from rest the setpoint speeds up as azimuths turn: what carries the boat aside is stopped first
_SPEED_STEP_MPS = 0.05  # commanded speeds are planned in steps
_MEAN_AIR_S = 20.0
_PREDICTIVE = 2  # PATH_CTRL
_POSES, _POSES_TO_AIM = 19, 12  # ahead: 5.4 s for that law, 3.3 s for thrusters that turn


@dataclass(frozen=True, slots=True)
class OnTrack:
    """The boat on its track: the arc length reached, the point there, and how far the boat is off to starboard."""

    track: Track
    s_m: float
    here: PathPoint
    off_m: float


class PlannedMotion:
    """Call `take` for a new track, then every tick `is_planned` and, where it is, `update`. Remembers the plan and what
    it was made for, the mean wind, the lean of the bow, and the velocity, speed and heading of the last setpoint:
    `speed_mps`, `yaw_rad`, which may be set. `submit`: makes plans beside the control thread."""

    def __init__(
        self, parameters: Parameters, agility: Agility, crab: CrabCompensation, submit: Submit = at_once
    ) -> None:
        self._parameters, self._agility, self._crab = parameters, agility, crab
        self._laid: LaidTrack | None = None
        self._plan: PathPlan | None = None
        self._terms: PlanTerms | None = None  # of the plan
        self._newer: tuple[PlanTerms, PathPlan] | None = None  # made, and not sailed by yet
        self._planning: Job[tuple[PlanTerms, PathPlan]] = Job(submit)
        self._air: Air | None = None
        self._commanded = parameters["WP_SPEED"]
        self._rise_mps2 = 0.0  # of the last setpoint's speed
        self._lean_m = 0.0  # by which the bow leans towards the track, as a cross-track error
        self.speed_mps = 0.0
        self.yaw_rad: float | None = None
        self._velocity: tuple[float, float] | None = None  # (north, east) that was asked for last

    def take(self, laid: LaidTrack) -> None:
        """A new track, perhaps with its plan."""
        self._laid, self._plan, self._terms = laid, laid.plan, laid.terms
        self._newer = None
        self._lean_m = 0.0
        self._planning.drop()

    def is_planned(self, nav: NavState, speed_mps: float, s_m: float, dt_s: float) -> bool:
        """Whether there is a plan of the track, at `speed_mps` at most, for a boat at `s_m`. It is made anew when a
        limit, the current, the mean wind or the speed has changed."""
        laid, job = self._laid, self._planning
        if laid is None:
            return False
        self._commanded = min(max(0.0, speed_mps), self._parameters["MPC_XY_VEL_MAX"])
        self._see_wind(nav, dt_s)
        terms = self.terms(nav)
        newest = self._terms if self._newer is None else self._newer[0]
        if not job.pending and (newest is None or self._plan is None or not newest.still_hold(terms)):
            job.begin(lambda: (terms, terms.plan(laid.track, laid.ends_s_m, laid.waypoints, laid.stop_at_end)))
        if job.done:
            self._newer = job.take()
        newer = self._newer
        if newer is not None and self._can_change(newer[0], newer[1], s_m):
            self._terms, self._plan = newer
            self._newer = None
        return self._plan is not None

    def _can_change(self, terms: PlanTerms, plan: PathPlan, s_m: float) -> bool:
        """Whether the boat may go over to a newer plan at `s_m`."""
        return (
            self._plan is None
            or self._terms is None
            or not self._terms.asks_the_same(terms)
            or self._plan.agrees(plan, s_m)
        )

    def terms(self, nav: NavState) -> PlanTerms:
        """What a plan depends on now, at the speed commanded last."""
        parameters = self._parameters
        share, most = parameters["PATH_EFFORT"], parameters["MPC_XY_VEL_MAX"]
        steps = math.ceil(self._commanded / _SPEED_STEP_MPS - 1.0e-6)
        top = min(most, max(1, steps) * _SPEED_STEP_MPS)
        sway = self._agility.sway_mps(_ASIDE * share)
        water = nav.current_north_mps or 0.0, nav.current_east_mps or 0.0
        weather = Weather(*water, *(self._air or air_over_ground(nav) or (0.0, 0.0)))
        return PlanTerms(PlanLimits(self._agility, share, sway, _SLOWEST_SHARE * top, weather), top)

    def update(self, place: OnTrack, nav: NavState, progress: Progress, dt_s: float) -> PathSetpoint:
        """The planned motion at the boat's place. Accelerations and turns are those of a little later, when the thrust
        that they need will have built up. Raises RuntimeError without a plan."""
        plan = self._plan
        if plan is None:
            raise RuntimeError("PlannedMotion.update without a plan")
        if self.yaw_rad is None:
            self._velocity = None
        creep = self._creep_mps
        gain = self._next_speed(plan, place.s_m, creep, dt_s)
        pace = max(self.speed_mps, creep)
        back = math.atan2(self._parameters["PATH_BW_CROSS"] * place.off_m, max(self.speed_mps, _LEAST_BACK_MPS))
        course = place.here.course_rad - back
        bends, turn, change, bow = self._turn(plan, place, nav, pace, dt_s)
        off = wrap_pi(course - nav.yaw_rad)
        # where the bow is to point astern of the course, a boat that waits for it waits for ever
        astern = min(0.0, math.cos(bow - course))
        surge = self.speed_mps * max(astern, math.cos(off))
        sway = self._sway_mps(nav, self.speed_mps * math.sin(off))
        up, down = plan.reach_mps2(place.s_m, self.speed_mps)
        most_mps2 = max(up, _at_most_mps2(down)) + self.speed_mps * abs(bends)
        surge, sway = self._eased(surge, sway, nav, most_mps2 * dt_s)
        soon = place.track.at(plan.ahead_m(place.s_m, _ASIDE_LAG_S, pace))
        bend = self.speed_mps * self.speed_mps * soon.curvature_1pm
        along, across = ned_to_body(gain, bend, nav.yaw_rad - soon.course_rad)
        assert self.yaw_rad is not None
        return PathSetpoint(
            self.yaw_rad,
            surge,
            sway,
            turn,
            along + turn * sway,
            progress,
            across - turn * surge,
            change,
            True,
            self._poses(plan, place, nav, pace),
        )

    def _eased(self, surge: float, sway: float, nav: NavState, most_mps: float) -> tuple[float, float]:
        """The velocity that is asked for, which changes over ground by `most_mps` at most: at a corner, or where the
        boat swings past its heading, the course that it is to sail turns at once."""
        if self._velocity is not None:
            x, y = ned_to_body(*self._velocity, nav.yaw_rad)
            change = math.hypot(surge - x, sway - y)
            share = min(1.0, most_mps / change) if change > 0.0 else 1.0
            surge, sway = x + share * (surge - x), y + share * (sway - y)
        self._velocity = body_to_ned(surge, sway, nav.yaw_rad)
        return surge, sway

    @property
    def _stops(self) -> bool:
        return self._laid is None or self._laid.stop_at_end

    @property
    def _most_sway_mps(self) -> float:
        """Sideways speed through the water that is asked for at most."""
        return max(self._parameters["DP_SPEED_SWAY"], self._agility.sway_mps(self._parameters["PATH_EFFORT"]))

    def _sway_mps(self, nav: NavState, wanted_mps: float) -> float:
        """The sideways speed over ground to ask for. While no current is known, the control law assumes none, and
        would push the boat the way that it drifts."""
        most = self._most_sway_mps
        if nav.current_north_mps is None:
            return min(most, max(-most, wanted_mps))
        return self._crab.sway_mps(nav, wanted_mps, most)

    @property
    def _creep_mps(self) -> float:
        """Lowest speed of approach, so that the boat reaches the end."""
        return min(self._commanded, creep_mps(self._parameters)) if self._stops else 0.0

    def _see_wind(self, nav: NavState, dt_s: float) -> None:
        """Take the mean of the wind, as far as it is known."""
        now = air_over_ground(nav)
        if now is None or self._air is None:
            self._air = now
            return
        part = min(1.0, dt_s / _MEAN_AIR_S)
        north, east = self._air
        self._air = north + part * (now[0] - north), east + part * (now[1] - east)

    # --- speed ---

    def _next_speed(self, plan: PathPlan, s_m: float, creep: float, dt_s: float) -> float:
        """Take the next speed along the track; returns the acceleration that follows, when the thrust for it will have
        built up: what drag takes by then is no longer there to speed up with."""
        up, down = plan.reach_mps2(s_m, self.speed_mps)
        down = _at_most_mps2(down)
        wanted = max(creep, min(self._commanded, plan.speed_mps(s_m)))
        last, up = self.speed_mps, min(up, max(0.0, self._rise_mps2) + _JERK_MPS3 * dt_s)
        self.speed_mps = min(last + up * dt_s, max(last - down * dt_s, wanted))
        self._rise_mps2 = (self.speed_mps - last) / dt_s
        later_m = plan.ahead_m(s_m, _THRUST_LAG_S, max(self.speed_mps, creep))
        later = max(creep, min(self._commanded, plan.speed_mps(later_m)))
        soon_up, _ = plan.reach_mps2(s_m, self.speed_mps + up * _THRUST_LAG_S)
        soon_up = min(soon_up, up + _JERK_MPS3 * _THRUST_LAG_S)
        return min(soon_up, max(-down, (later - self.speed_mps) / _THRUST_LAG_S))

    # --- heading ---

    def _turn(
        self, plan: PathPlan, place: OnTrack, nav: NavState, pace: float, dt_s: float
    ) -> tuple[float, float, float, float]:
        """Take the next heading: the planned course of the bow, turned into the current as at the leg's speed, and
        towards the track where it is far. Returns its planned rate, the rate to turn at and its change, a little
        further on, and the heading that the boat comes to."""
        near = max(_NEAR_M, _FAR_M - _FOLLOWED * abs(self._lean_m))
        far = beyond_dead_zone(place.off_m, near) + self._lean_m
        aside = math.atan2(self._parameters["PATH_BW_CROSS"] * far, max(self.speed_mps, _LEAST_BACK_MPS))
        aside = min(_MOST_ASIDE_RAD, max(-_MOST_ASIDE_RAD, aside))
        last = nav.yaw_rad if self.yaw_rad is None else self.yaw_rad
        aside_mps = self._most_sway_mps
        places = (place.s_m, *(plan.ahead_m(place.s_m, i * _ASIDE_LAG_S, pace) for i in (1, 2)))
        courses = [plan.course_rad(s_m) - aside for s_m in places]
        now, soon, later = (self._crab.bow_rad(nav, course, self.speed_mps, aside_mps, last) for course in courses)
        first, second = wrap_pi(soon - now), wrap_pi(later - soon)
        turn, change = (first + second) / (2.0 * _ASIDE_LAG_S), (second - first) / _ASIDE_LAG_S**2
        missing = wrap_pi(now - last)
        hurry = min(1.0, max(0.0, (abs(missing) - _ASTRAY_RAD) / (_ALL_ASTRAY_RAD - _ASTRAY_RAD)))
        most = self._correcting_radps(hurry) + abs(turn)
        taken = min(most, max(-most, missing / dt_s)) if dt_s > 0.0 else 0.0
        self.yaw_rad = wrap_pi(last + taken * dt_s)
        rate = turn + hurry * (taken - turn)
        self._learn_lean(place.off_m, rate, dt_s)
        return turn, rate, (1.0 - hurry) * change, now

    def _correcting_radps(self, hurry: float) -> float:
        """How fast the heading comes to the plan: with a share of the planned thrust near it, at PATH_YAW_RATE from
        far off, while a stream carries the boat away. `hurry`: 0 to 1."""
        usual = _CORRECTING * self._agility.turn_radps(self._parameters["PATH_EFFORT"], self.speed_mps)
        return usual + hurry * max(0.0, math.radians(self._parameters["PATH_YAW_RATE"]) - usual)

    def _learn_lean(self, off_m: float, turn_radps: float, dt_s: float) -> None:
        """Lean the bow towards the track that sideways thrust alone does not reach: none is left where the stream
        takes all of it ahead."""
        if abs(turn_radps) > _STEADY_RADPS:
            self._lean_m *= math.exp(-abs(turn_radps) * dt_s / _FORGOTTEN_RAD)
        elif abs(off_m) < _LEARNS_M:
            self._lean_m += (beyond_dead_zone(off_m, _NEAR_M) / _LEAN_S - self._lean_m / _LEAN_LASTS_S) * dt_s
            self._lean_m = min(_MOST_LEAN_M, max(-_MOST_LEAN_M, self._lean_m))

    def _poses(self, plan: PathPlan, place: OnTrack, nav: NavState, pace: float) -> tuple[PlannedPose, ...]:
        """The poses from now on, with the bow turned into the current as now; as many as are of use."""
        count = _POSES if self._parameters["PATH_CTRL"] == _PREDICTIVE else _POSES_TO_AIM if self._agility.aims else 0
        speed, aside_mps = self.speed_mps, self._most_sway_mps
        yaw = nav.yaw_rad if self.yaw_rad is None else self.yaw_rad
        poses = []
        for k in range(count):
            s_m = place.s_m if k == 0 else plan.ahead_m(place.s_m, k * PATH_STEP_S, pace)
            there, course = place.track.at(s_m), plan.course_rad(s_m)
            poses.append(
                PlannedPose(there.north_m, there.east_m, self._crab.bow_rad(nav, course, speed, aside_mps, yaw))
            )
        return tuple(poses)


def _at_most_mps2(down_mps2: float) -> float:
    """How hard a boat that is too fast slows down, by the braking planned."""
    return _HARDER * down_mps2 + _HARDER_MPS2
