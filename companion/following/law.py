"""The following law: along the leader's track for a follow position astern, else towards a point that moves with it.

Astern, the gap is measured along the track. Its rate is then the difference of the two present speeds, and the leader's
present speed is fed forward: the boat slows down when the leader does, not where it did. The course is line of sight on
the track, with the curvature of the track fed forward.

Elsewhere, the velocity is that of the follow position plus a closing velocity towards it, led around the keep-out
circle (constant-bearing guidance; Breivik & Fossen 2008).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

from companion.config.top_speed import top_speed_mps
from companion.config.vessel import VesselConfig
from companion.core.actuation import ZERO_WRENCH, Wrench
from companion.core.angles import wrap_pi
from companion.core.estimate import Leader, NavState
from companion.core.setpoint import PathSetpoint, Point, Progress, Setpoint, WrenchSetpoint
from companion.following.clearance import TURNING_RAD, Clearance, MotionPlan
from companion.following.keep_out import EITHER, round_m, way_round
from companion.following.kept_distance import KeptDistance
from companion.following.track import LeaderTrack, TrackPoint
from companion.guidance.coasting import Coasting
from companion.guidance.crab_compensation import CrabCompensation
from companion.guidance.turning import turning_of
from companion.params.store import Parameters

_ASTERN_RAD = math.radians(10.0)  # off dead astern: within it, the follow position lies on the track
_REACH_M = 12.0  # along the track, in which the boat's place on it is sought
_ROUND_ABOUT = 1.5  # the straight way, from which on a way along the track leads round about
_NEAR_SHARE = 0.25  # of the distance, within which it does not matter
_PREVIEW_S = 0.35  # lag of the yaw loop
_PREVIEW_SHARE = 0.4  # of the time by which slow steering makes it later
_BRAKING_MPS2 = -0.35  # of the leader: at or below it the leader is taken to be stopping
_COAST_SHARE = 0.9  # of the way that is left, in which the hull must be able to run out
_BRAKED_S = 1.5  # in which a boat that waits loses its way, where its own thrust would turn it by going on
_LEAST_MPS = 0.3  # a slower velocity has no direction
# To the follow position: within it the boat closes up as gently as if that stood still, which evens out what receivers
# make of the gap; further off it counts on the way that the leader goes on meanwhile.
_GENTLE_M = 3.0
_BEHIND_SHARE = 0.6  # of the leader's speed: by it a boat that is too far ahead drops back
_FASTEST_MPS = 25.0
_STEERAGE_SHARE = 0.3  # of the speed, kept while the bow points elsewhere
_STOP_REACH = 1.2  # times the least distance astern
_STANDING_MPS = 0.5  # a slower leader stands still
_REST_BAND_M, _REST_BAND_SHARE = 4.0, 0.3  # how far a resting boat may drift: fixed part, share of the distance
_COAST_MPS = 0.6  # a boat without reverse that is too fast by this coasts
_NEAR_M, _NEAR_COAST_MPS = 1.5, 0.3  # the same where it is nearer to the leader than its follow position by more
_BURST_MPS = 0.4  # a boat without reverse near a follow position at rest: pushes only when slower by this

_BESIDE = 2.0  # radii at which the leader is passed: nearer than that to one that stands, the boat goes slowly
BESIDE_MPS = 1.2
"""Top speed there, of a boat that can stop."""


class _MovingPoint(NamedTuple):
    """The follow position in NED, its velocity and the turn of that."""

    north_m: float
    east_m: float
    north_mps: float
    east_mps: float
    turn_radps: float


class _Approach(NamedTuple):
    """Velocity over ground towards the follow position, in NED. `closing_mps`: its part relative to that position;
    `way_m`: the way that is left; `side`: on which the leader is passed, as `keep_out.way_round` gives it."""

    north_mps: float
    east_mps: float
    closing_mps: float
    way_m: float
    side: int


@dataclass(frozen=True, slots=True)
class WayRound:
    """Places (north_m, east_m) that lead to the follow position, the boat's own left out. `radius_m`: how closely each
    bend is to be passed."""

    places: tuple[tuple[float, float], ...]
    radius_m: float


@dataclass(frozen=True, slots=True)
class FollowMotion:
    """What the boat is to do: course and speed over ground, how they change, and how far it is from its follow
    position."""

    course_rad: float
    speed_mps: float
    turn_radps: float
    gain_mps2: float
    target: tuple[float, float]  # (north_m, east_m) of the follow position
    off_m: float  # to the follow position: along the track, or straight
    cross_m: float | None  # cross-track error, positive to starboard; None off the track
    track_rad: float | None  # course of the track there; None off the track
    feed_mps: float = 0.0  # speed of the follow position
    evading: bool = False  # keeps clear of the leader instead
    resting: bool = False  # the leader stands still and the boat is near enough


class FollowLaw:
    """`start`, then `update(nav, leader, follow_position, now_s)` → FollowMotion, and `setpoint(motion, …)` → Setpoint.

    A follow position is (distance_m, bearing_rad) in the leader's frame. Remembers the leader's track, the boat's place
    on it (None while it is off the track), the side on which the boat rounds the leader, the drift and the last heading
    asked for.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters, can_reverse: bool) -> None:
        self._config = config
        self._parameters = parameters
        self._can_sway = config.limits.sway_n > 0.0
        self._can_reverse = can_reverse
        self._coasting = Coasting(config.hull, _FASTEST_MPS)
        self._turning = turning_of(config, on_the_spot=False)
        self._crab = CrabCompensation(top_speed_mps(config), self._turning.steered)
        self.track = LeaderTrack()
        self._clearance = Clearance(config, parameters, can_reverse)
        self._s: float | None = None
        self._strayed = False  # off its way along the track, to keep clear
        self._side = EITHER
        self._yaw: float | None = None
        self._cruising_mps = 0.0
        self._preview_s = _PREVIEW_S
        self._resting = False
        self._rested = False  # since the leader stands
        self._asked = (0.0, math.pi)  # distance and bearing of the follow position, as asked for
        self._kept = KeptDistance(config, parameters)
        self._kept_m = 0.0

    # --- the follow position ---------------------------------------------------------------------------------------

    @property
    def distance_m(self) -> float:
        """Distance of the follow position from the leader: as asked for, but no nearer than is safe."""
        return self._kept_m

    @property
    def _stop_m(self) -> float:
        """The distance at which the boat is to stop behind the leader, at most: a longer one is no matter of safety,
        and in a sharp bend the straight distance to the leader is shorter."""
        return _STOP_REACH * self._kept.of((0.0, math.pi))

    @property
    def astern(self) -> bool:
        """Whether the follow position lies on the leader's track."""
        return abs(wrap_pi(self._asked[1] - math.pi)) < _ASTERN_RAD

    @property
    def most_mps(self) -> float:
        """Top speed in Follow, by the parameters."""
        p = self._parameters
        return min(p["MPC_XY_VEL_MAX"], p["FLW_TGT_MAX_VEL"])

    @property
    def lookahead_m(self) -> float:
        """Lookahead distance of the line of sight: longer at speed (FOLL_LOOK_T), never below PATH_LOOKAHEAD."""
        p = self._parameters
        return max(p["PATH_LOOKAHEAD"], p["FOLL_LOOK_T"] * self._cruising_mps)

    def start(self, nav: NavState, leader: Leader, follow_position: tuple[float, float], now_s: float) -> None:
        """Begin to follow. The leader's earlier track is not known, so it is taken as a straight line astern."""
        self._asked, self._kept_m = follow_position, self._kept.of(follow_position)
        course = leader_course_rad(leader)
        if course is None:
            course = math.atan2(leader.east_m - nav.east_m, leader.north_m - nav.north_m)
        self.track = LeaderTrack(min(2.0, max(0.25, 0.1 * self.distance_m)))
        self.track.start(leader, 2.0 * self.distance_m, course, now_s)
        self._s = None
        self._strayed = False
        self._side = EITHER
        self._yaw = None
        self._resting = self._rested = False
        self._crab.reset()
        self._clearance.reset()
        self._cruising_mps = math.hypot(nav.north_mps, nav.east_mps)

    def update(
        self,
        nav: NavState,
        leader: Leader,
        follow_position: tuple[float, float],
        now_s: float,
        steers_late_s: float = 0.0,
        way: WayRound | None = None,
    ) -> FollowMotion:
        """One step: the motion that leads to the follow position, or keeps clear of the leader. `steers_late_s`: by how
        much the yaw loop answers later than the file says. `way`: the way to sail there, where something lies
        between."""
        self._preview_s = _PREVIEW_S + _PREVIEW_SHARE * steers_late_s
        changed, self._asked = follow_position != self._asked, follow_position
        self._kept_m = self._kept.of(follow_position)
        self.track.update(leader, now_s)
        self._cruising_mps = math.hypot(nav.north_mps, nav.east_mps)
        found = self._along_track(nav, leader) if self.astern and way is None else None
        plan: MotionPlan | None
        if way is not None:
            motion, plan = self._along_way(nav, leader, way), None
        else:
            motion, plan = self._to_point(nav, leader) if found is None else found
        self._resting = self._may_rest(motion, nav, leader, changed)
        stands = abs(leader.speed_mps) <= _STANDING_MPS
        self._rested = stands and not changed and (self._rested or self._resting)
        if self._resting:
            motion = replace(motion, course_rad=nav.yaw_rad, speed_mps=0.0, turn_radps=0.0, gain_mps2=0.0, resting=True)
        # a boat that rounds the leader passes it nearer, and one that holds beside it may drift as it turns its bow
        held = self._resting and self._can_reverse
        near_m = 0.0 if found is None or held else min(self.distance_m, self._stop_m)
        course = self._clearance.lying_rad(nav) if self._resting else motion.course_rad
        evasion = self._clearance.update(course, motion.speed_mps, near_m, nav, leader, None if self._resting else plan)
        if evasion is None:
            return motion
        self._strayed = True
        return replace(
            motion,
            course_rad=evasion.course_rad,
            speed_mps=evasion.speed_mps,
            turn_radps=0.0,
            gain_mps2=0.0,
            evading=True,
            resting=False,
        )

    def _may_rest(self, motion: FollowMotion, nav: NavState, leader: Leader, changed: bool) -> bool:
        """Whether the boat lies still: the leader stands, and the boat is at its follow position or near enough to it.

        A resting boat without reverse stays where it is at about that distance from the leader, whatever the bearing.
        It also lies still while the leader goes astern: it does not seek a follow position in the leader's way.
        """
        if leader.speed_mps < -_STANDING_MPS and not self._can_reverse:
            return self._about_as_far(nav, leader)
        if abs(leader.speed_mps) > _STANDING_MPS:
            return False
        if self._resting and not changed and self._can_reverse:
            return motion.off_m < 2.0 * _REST_BAND_M
        if self._resting and not changed:
            return self._about_as_far(nav, leader)
        return motion.off_m < _REST_BAND_M

    def _about_as_far(self, nav: NavState, leader: Leader) -> bool:
        """Whether the boat is about as far from the leader as its follow position, or nearer."""
        distance = math.hypot(nav.north_m - leader.north_m, nav.east_m - leader.east_m)
        return distance < self.distance_m + _REST_BAND_M + _REST_BAND_SHARE * self.distance_m

    def _along_track(self, nav: NavState, leader: Leader) -> tuple[FollowMotion, MotionPlan] | None:
        """Motion along the track, and how it goes on, seen along the straight line between the boats. None where the
        boat is not on the track."""
        track, look = self.track, self.lookahead_m
        before = None if self._strayed else self._s
        s = track.project(nav.north_m, nav.east_m, before, _REACH_M)
        here = track.at(s)
        dn, de = nav.north_m - here.north_m, nav.east_m - here.east_m
        cross = de * math.cos(here.course_rad) - dn * math.sin(here.course_rad)
        far = math.hypot(dn, de) > (look if before is None else 2.0 * look)
        if far or s > track.end_s_m - 0.5 * self._parameters["FOLL_MIN_DIST"] or s < track.begin_s_m - look:
            self._s = None
            return None
        goal_s = track.end_s_m - self.distance_m
        if self._strayed and self._leads_round(nav, goal_s - s, track.at(goal_s)):
            self._s = None
            return None
        self._s, self._strayed = s, self._strayed and abs(goal_s - s) > 0.5 * self.distance_m
        track.trim(min(s, goal_s))
        speed = self._speed(leader.speed_mps, goal_s - s, leader.acceleration_mps2)
        beside_mps = self._beside_mps((nav.north_m - leader.north_m, nav.east_m - leader.east_m), leader.speed_mps)
        speed = min(speed, beside_mps)
        preview_s = self._preview_s + self._turning.late_s(nav.surge_mps, nav.sway_mps)
        ahead = track.at(s + preview_s * self._cruising_mps)
        drift = nav.east_mps * math.cos(here.course_rad) - nav.north_mps * math.sin(here.course_rad)
        along = nav.north_mps * math.cos(here.course_rad) + nav.east_mps * math.sin(here.course_rad)
        turn = max(0.0, along) * ahead.curvature_1pm - drift * look / (look * look + cross * cross)
        goal = track.at(goal_s)
        gain = leader.acceleration_mps2 if abs(goal_s - s) < 0.5 * self.distance_m else 0.0
        course = wrap_pi(ahead.course_rad - self._towards_rad(cross, look))
        motion = FollowMotion(
            course,
            speed,
            turn,
            gain,
            (goal.north_m, goal.east_m),
            goal_s - s,
            cross,
            here.course_rad,
            abs(leader.speed_mps),
        )
        beyond = motion.off_m - math.hypot(nav.north_m - leader.north_m, nav.east_m - leader.east_m)

        def plan(off_north: float, off_east: float, leader_north: float, leader_east: float) -> tuple[float, float]:
            feed = math.hypot(leader_north, leader_east)
            return course, max(
                0.0, self._speed(feed, beyond + math.hypot(off_north, off_east), leader.acceleration_mps2)
            )

        return motion, plan

    def _leads_round(self, nav: NavState, way_m: float, goal: TrackPoint) -> bool:
        """Whether the way along the track leads far round to a follow position that is near: the leader has turned back
        past the boat."""
        straight_m = math.hypot(goal.north_m - nav.north_m, goal.east_m - nav.east_m)
        return abs(way_m) > _ROUND_ABOUT * straight_m + _NEAR_SHARE * self.distance_m

    def _towards_rad(self, cross_m: float, look_m: float) -> float:
        """How far the course leans towards the track: by line of sight, but no more than a boat in an arc can turn back
        from without crossing it."""
        rate_radps = math.radians(self._parameters["PATH_YAW_RATE"])
        most = self._turning.steepest_back_rad(abs(cross_m), self._cruising_mps, rate_radps)
        return min(most, max(-most, math.atan2(cross_m, look_m)))

    def _speed(self, feed_mps: float, off_m: float, push_mps2: float) -> float:
        """Speed over ground along the way, for a follow position `off_m` ahead that moves at `feed_mps` and
        accelerates by `push_mps2`."""
        p = self._parameters
        wanted = feed_mps + self._closing(off_m, max(0.0, feed_mps))
        if push_mps2 < _BRAKING_MPS2 and feed_mps > 0.0:
            left_m = off_m + feed_mps * feed_mps / (-2.0 * push_mps2)
            wanted = min(wanted, self._stopping_mps(left_m))
        lowest = -p["DP_SPEED_ASTERN"] if self._can_reverse else 0.0
        return min(self.most_mps, max(lowest, wanted))

    def _closing(self, off_m: float, feed_mps: float) -> float:
        """By how much the boat goes faster than its follow position: never more than it can lose on the way left."""
        p = self._parameters
        most = p["FOLL_CLOSE_V"]
        pull = p["FOLL_GAP_BW"] * off_m
        if pull <= 0.0:
            return max(-most, pull)
        if self._can_reverse:
            braking_mps2 = 1.4 * p["PATH_ACC"]
            gently = math.sqrt(feed_mps * feed_mps + braking_mps2 * off_m) - feed_mps
            allowed = max(gently, math.sqrt(braking_mps2 * max(0.0, off_m - _GENTLE_M)))
        else:
            allowed = self._coasting.speed_mps(self._coasting.way_m(feed_mps) + _COAST_SHARE * off_m) - feed_mps
        return max(0.0, min(most, pull, allowed))

    def _stopping_mps(self, left_m: float) -> float:
        """Speed from which the boat still stops in `left_m`."""
        if self._can_reverse:
            return math.sqrt(1.4 * self._parameters["PATH_ACC"] * max(0.0, left_m))
        return self._coasting.speed_mps(_COAST_SHARE * left_m)

    # --- round what lies between ---------------------------------------------------------------------------------

    def _along_way(self, nav: NavState, leader: Leader, way: WayRound) -> FollowMotion:
        """Motion to the next bend of the way, no faster than the boat can be in it."""
        self._s, self._strayed, self._side = None, True, EITHER
        point = self._position_point(nav, leader)
        feed = math.hypot(point.north_mps, point.east_mps)
        here, bend = (nav.north_m, nav.east_m), way.places[0]
        off_m = math.dist(here, bend) + sum(math.dist(a, b) for a, b in zip(way.places, way.places[1:], strict=False))
        speed = max(0.0, self._speed(feed, off_m, leader.acceleration_mps2))
        if len(way.places) > 1:
            speed = min(speed, self._before_bend_mps(math.dist(here, bend), way.radius_m))
        course = math.atan2(bend[1] - nav.east_m, bend[0] - nav.north_m)
        return FollowMotion(course, speed, 0.0, 0.0, (point.north_m, point.east_m), off_m, None, None, feed)

    def _before_bend_mps(self, left_m: float, radius_m: float) -> float:
        """The speed from which the boat has slowed down, within `left_m`, to one at which it turns in a circle of that
        radius."""
        p = self._parameters
        bend_mps = max(self._clearance.turning_mps, math.radians(p["PATH_YAW_RATE"]) * radius_m)
        if self._can_reverse:
            return math.sqrt(bend_mps * bend_mps + 1.4 * p["PATH_ACC"] * left_m)
        return self._coasting.speed_mps(self._coasting.way_m(bend_mps) + _COAST_SHARE * left_m)

    # --- a point that moves with the leader ------------------------------------------------------------------------

    def _position_point(self, nav: NavState, leader: Leader) -> _MovingPoint:
        """The follow position now. A boat without reverse that has drifted off beside a leader that stands comes back
        to that distance from it, not to the other side."""
        if self._rested and not self._can_reverse:
            bearing = math.atan2(nav.east_m - leader.east_m, nav.north_m - leader.north_m)
            dn, de = self.distance_m * math.cos(bearing), self.distance_m * math.sin(bearing)
            return _MovingPoint(leader.north_m + dn, leader.east_m + de, 0.0, 0.0, 0.0)
        if self.astern:
            goal = self.track.at(self.track.end_s_m - self.distance_m)
            speed = max(0.0, leader.speed_mps)
            return _MovingPoint(
                goal.north_m,
                goal.east_m,
                speed * math.cos(goal.course_rad),
                speed * math.sin(goal.course_rad),
                speed * goal.curvature_1pm,
            )
        heading = leader.yaw_rad if leader.yaw_rad is not None else self.track.at(self.track.end_s_m).course_rad
        bearing = heading + self._asked[1]
        dn, de = self.distance_m * math.cos(bearing), self.distance_m * math.sin(bearing)
        turn = leader.yaw_rate_radps
        if leader.astern and not self._can_reverse:  # without reverse it does not chase a boat that may stop at once
            return _MovingPoint(leader.north_m + dn, leader.east_m + de, 0.0, 0.0, 0.0)
        north, east = leader.north_mps - turn * de, leader.east_mps + turn * dn
        most = self.most_mps
        share = min(1.0, most / max(1e-6, math.hypot(north, east)))
        return _MovingPoint(leader.north_m + dn, leader.east_m + de, share * north, share * east, turn)

    def _to_point(self, nav: NavState, leader: Leader) -> tuple[FollowMotion, MotionPlan]:
        """Motion towards the follow position, and how it goes on if the leader goes straight on."""
        point = self._position_point(nav, leader)
        goal = point.north_m - leader.north_m, point.east_m - leader.east_m
        here = nav.north_m - leader.north_m, nav.east_m - leader.east_m
        approach = self._towards(here, goal, (point.north_mps, point.east_mps), self._side)
        self._side = approach.side
        speed = math.hypot(approach.north_mps, approach.east_mps)
        feed = math.hypot(point.north_mps, point.east_mps)
        near = feed / max(1e-6, feed + 2.0 * approach.closing_mps)
        last = nav.yaw_rad if self._yaw is None else self._yaw
        course = math.atan2(approach.east_mps, approach.north_mps) if speed > _LEAST_MPS else last
        most = self.most_mps
        motion = FollowMotion(
            course,
            min(most, speed),
            point.turn_radps * near,
            leader.acceleration_mps2 * near,
            (point.north_m, point.east_m),
            approach.way_m,
            None,
            None,
            feed,
        )
        side = self._side

        def plan(off_north: float, off_east: float, leader_north: float, leader_east: float) -> tuple[float, float]:
            planned = self._towards((off_north, off_east), goal, (leader_north, leader_east), side)
            speed_mps = math.hypot(planned.north_mps, planned.east_mps)
            return math.atan2(planned.east_mps, planned.north_mps), min(most, speed_mps)

        return motion, plan

    def _towards(
        self, here: tuple[float, float], goal: tuple[float, float], feed: tuple[float, float], side: int
    ) -> _Approach:
        """From `here` to `goal`, both in metres from the leader, around the keep-out circle. `feed`: velocity of the
        follow position; `side`: on which the leader was passed so far."""
        (wn, we), way, side = way_round(here, goal, round_m(self._parameters), side)
        speed = math.hypot(*feed)
        closing = self._closing(way, speed)
        back = (feed[0] * wn + feed[1] * we) / speed if speed > 1e-6 else 0.0  # −1: the way leads back
        if back < 0.0 and speed > 2.0 * _LEAST_MPS:
            closing = min(closing, _BEHIND_SHARE * speed / -back)
        closing = min(closing, self._beside_mps(here, speed))
        closing = min(closing, _spare_mps(speed, back * speed, self.most_mps))
        return _Approach(feed[0] + closing * wn, feed[1] + closing * we, closing, way, side)

    def _beside_mps(self, here: tuple[float, float], leader_mps: float) -> float:
        """Top speed beside a leader that stands, of a boat that can stop; infinite elsewhere. `here`: from the leader
        in m."""
        near = math.hypot(*here) < _BESIDE * round_m(self._parameters)
        return BESIDE_MPS if self._can_reverse and abs(leader_mps) < _STANDING_MPS and near else math.inf

    def let_go(self) -> None:
        """Something else steers: the next heading asked for begins at the boat's."""
        self._yaw = None

    # --- the setpoint ----------------------------------------------------------------------------------------------

    def setpoint(self, motion: FollowMotion, nav: NavState, dt_s: float) -> Setpoint:
        """Setpoint for path tracking: heading, turn and speed. A boat without reverse that has to slow down coasts
        instead (a zero wrench): the thrust that steers it would keep it going."""
        most = math.radians(self._parameters["PATH_YAW_RATE"])
        speed = motion.speed_mps
        straight = max(0.0, 1.0 - 2.0 * abs(nav.yaw_rate_radps) / most)
        self._crab.update(nav, max(0.0, speed), straight, dt_s)
        last = nav.yaw_rad if self._yaw is None else self._yaw
        turn = min(most, max(-most, motion.turn_radps))
        best = motion.course_rad
        if speed > _LEAST_MPS:
            best = self._crab.heading_rad(nav, motion.course_rad, speed, last) - self._slip_rad(nav.surge_mps, turn)
            if motion.evading and _goes_round(nav.yaw_rad, last, best):
                last = nav.yaw_rad
        self._yaw = wrap_pi(last + min(most * dt_s, max(-most * dt_s, wrap_pi(best - last)))) if speed > 0.0 else best
        off = wrap_pi(motion.course_rad - nav.yaw_rad)
        if motion.resting or (abs(off) < TURNING_RAD and self._runs_out(speed, nav, motion)):
            return WrenchSetpoint(ZERO_WRENCH, self._progress(motion, nav))
        if motion.evading and speed == 0.0 and self._clearance.steers_by_way and abs(off) < TURNING_RAD:
            braking = Wrench(-self._config.hull.m11_kg * nav.surge_mps / _BRAKED_S, 0.0, 0.0)
            return WrenchSetpoint(braking, self._progress(motion, nav))
        sway = 0.0
        if motion.evading:
            surge, sway = self._clearance.ahead_mps(speed, off), self._clearance.aside_mps(speed, off)
        else:
            least = 0.0 if self._can_sway else _STEERAGE_SHARE
            surge = speed * max(least, math.cos(off)) if speed > 0.0 else speed
        return PathSetpoint(
            self._yaw,
            surge,
            sway,
            yaw_rate_radps=turn,
            surge_mps2=motion.gain_mps2,
            progress=self._progress(motion, nav),
        )

    def _runs_out(self, speed_mps: float, nav: NavState, motion: FollowMotion) -> bool:
        """Whether a boat without reverse coasts. Towards a follow position at rest it coasts until it is well below the
        speed from which the hull just reaches it."""
        if self._can_reverse:
            return False
        if motion.feed_mps < _STANDING_MPS and speed_mps < self._clearance.turning_mps and not motion.evading:
            return nav.surge_mps > speed_mps - _BURST_MPS
        faster_mps = _NEAR_COAST_MPS if motion.off_m < -_NEAR_M else max(_COAST_MPS, 0.25 * speed_mps)
        return nav.surge_mps > speed_mps + faster_mps

    @staticmethod
    def _progress(motion: FollowMotion, nav: NavState) -> Progress:
        return Progress(
            place=Point(nav.north_m, nav.east_m),
            target=Point(*motion.target),
            cross_track_error_m=motion.cross_m,
            course_rad=motion.track_rad,
            distance_to_go_m=motion.off_m,
        )

    def _slip_rad(self, surge_mps: float, turn_radps: float) -> float:
        """Sideslip angle of a boat without sideways thrust in a steady turn, from Y(v) = m11 u r on the hull alone."""
        if self._can_sway or surge_mps < 1.0:
            return 0.0
        d = self._config.hull.damping
        resisting = d.y_v + d.y_uv * surge_mps
        force = self._config.hull.m11_kg * surge_mps * turn_radps
        across = force / resisting
        if d.y_vv > 0.0:
            across = (math.sqrt(resisting * resisting + 4.0 * d.y_vv * abs(force)) - resisting) / (2.0 * d.y_vv)
            across = math.copysign(across, force)
        return -math.atan2(across, surge_mps)


def _goes_round(yaw_rad: float, last_rad: float, best_rad: float) -> bool:
    """Whether from the heading asked for last, far ahead of the bow, the nearer way to the best one is the bow's
    longer."""
    left, ahead = wrap_pi(best_rad - yaw_rad), wrap_pi(best_rad - last_rad)
    return left * ahead < 0.0 and abs(ahead) > max(abs(left), 0.5 * math.pi)


def _spare_mps(feed_mps: float, along_mps: float, most_mps: float) -> float:
    """The closing velocity at which the boat's velocity is as fast as it may be: a faster one, cut down afterwards,
    would lead another way, into the keep-out circle. `along_mps`: the part of the feed along the way. Infinite for a
    follow position faster than the boat may be."""
    square = along_mps * along_mps + most_mps * most_mps - feed_mps * feed_mps
    return math.sqrt(square) - along_mps if most_mps > feed_mps else math.inf


def leader_course_rad(leader: Leader) -> float | None:
    """Heading of the leader, else its course over ground; None while neither is known."""
    if leader.yaw_rad is not None:
        return leader.yaw_rad
    return math.atan2(leader.east_mps, leader.north_mps) if leader.speed_mps > _LEAST_MPS else None
