"""Following a lead boat: along its track where the station is astern, else towards a point that goes with it.

Astern the gap counts along the track, so its rate is the difference of the two speeds of now, and it is the leader's speed of now that is fed forward: the boat
slows down when the leader does, not where it did. The course is a line of sight on the track with the track's own turn fed forward. Elsewhere the
velocity is that of the station point plus one towards it, led around the keep-out circle (constant bearing; Breivik & Fossen 2008).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from companion.config import VesselConfig
from companion.core.angles import wrap_pi
from companion.core.types import ZERO_WRENCH, Leader, NavState, Setpoint, SetpointKind
from companion.guidance.clearance import Clearance, Plan
from companion.guidance.coasting import Coasting
from companion.guidance.crab import Crab, top_speed_mps
from companion.guidance.keep_out import EITHER, way_round
from companion.guidance.leader_track import LeaderTrack
from companion.params import Parameters

_ASTERN_RAD = math.radians(10.0)  # of dead astern, in which the station lies on the track
_REACH_M = 12.0  # along the track, for where the boat is on it
_PREVIEW_S = 0.35  # the yaw loop is this far behind
_BRAKING_MPS2 = -0.35  # of the leader, from which on it is taken to be stopping
_COAST_SHARE = 0.9
_LEAST_MPS = 0.3  # of a velocity, for it to have a direction
_BEHIND_SHARE = 0.6  # of the leader's speed, by which a boat that has gone too far drops back
_FASTEST_MPS = 25.0
_STEERAGE_SHARE = 0.3  # of the speed, kept while the bow points elsewhere
_EVADING_SHARE = 0.5  # likewise, out of the way of the leader
_ROUND_SHARE = 1.4  # of FOLL_MARGIN
_STANDING_MPS = 0.5  # slower than this the leader stands
_REST_BAND_M, _REST_BAND_SHARE = 4.0, 0.3  # beyond the station, and of its distance: so far a boat that rests may drift
_COAST_MPS = 0.6  # faster than it should be by this, a boat without way astern is left to run out
_BURST_MPS = 0.4
_COAST_RAD = math.radians(20.0)


@dataclass(frozen=True, slots=True)
class Motion:
    """What the boat is to do: course and speed over ground, how they change, and how it stands to its station."""

    course_rad: float
    speed_mps: float
    turn_radps: float
    gain_mps2: float
    station: tuple[float, float]
    off_m: float  # from the station: along the track, or straight
    cross_m: float | None  # of the track, positive to starboard
    track_rad: float | None
    feed_mps: float = 0.0  # of the station
    evading: bool = False  # it keeps the distance instead
    resting: bool = False  # the leader stands and the boat is where it belongs


class FollowLaw:
    """`start`, then `update(nav, leader, station, now_s)` → Motion, and `setpoint(motion, …)`.

    Remembers the leader's track, where the boat is on it (None while it is off it), the side on which it rounds the leader, the drift seen and the heading
    last asked for.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters, can_reverse: bool) -> None:
        self._config = config
        self._parameters = parameters
        self._can_sway = config.limits.sway_n > 0.0
        self._can_reverse = can_reverse
        self._coasting = Coasting(config.hull, _FASTEST_MPS)
        self._crab = Crab(top_speed_mps(config))
        self.track = LeaderTrack()
        self._clearance = Clearance(config, parameters, can_reverse)
        self._s: float | None = None
        self._side = EITHER
        self._yaw: float | None = None
        self._cruising_mps = 0.0
        self._resting = False
        self._station = (0.0, math.pi)  # distance and bearing asked for

    # --- the station -----------------------------------------------------------------------------------------------

    @property
    def distance_m(self) -> float:
        """Of the station, no nearer than the keep-out circle allows."""
        return max(self._station[0], self._round_m)

    @property
    def _round_m(self) -> float:
        """Radius at which the leader is passed: what is kept, and some more, so that it is not always a matter of that."""
        p = self._parameters
        return p["FOLL_MIN_DIST"] + _ROUND_SHARE * p["FOLL_MARGIN"]

    @property
    def astern(self) -> bool:
        """Whether the station lies on the leader's track."""
        return abs(wrap_pi(self._station[1] - math.pi)) < _ASTERN_RAD

    @property
    def _most_mps(self) -> float:
        p = self._parameters
        return min(p["MPC_XY_VEL_MAX"], p["FLW_TGT_MAX_VEL"])

    @property
    def lookahead_m(self) -> float:
        p = self._parameters
        return max(p["PATH_LOOKAHEAD"], p["FOLL_LOOK_T"] * self._cruising_mps)

    def start(self, nav: NavState, leader: Leader, station: tuple[float, float], now_s: float) -> None:
        """`station`: (distance_m, bearing_rad) in the leader's frame. The track begins straight astern of the leader; what it did before is not known."""
        self._station = station
        course = leader_course_rad(leader)
        if course is None:
            course = math.atan2(leader.east_m - nav.east_m, leader.north_m - nav.north_m)
        self.track = LeaderTrack(min(2.0, max(0.25, 0.1 * self.distance_m)))
        self.track.start(leader, 2.0 * self.distance_m, course, now_s)
        self._s = None
        self._side = EITHER
        self._yaw = None
        self._resting = False
        self._crab.reset()
        self._clearance.reset()
        self._cruising_mps = math.hypot(nav.north_mps, nav.east_mps)

    def update(self, nav: NavState, leader: Leader, station: tuple[float, float], now_s: float) -> Motion:
        """What the boat is to do now."""
        changed, self._station = station != self._station, station
        self.track.update(leader, now_s)
        self._cruising_mps = math.hypot(nav.north_mps, nav.east_mps)
        found = self._along_track(nav, leader) if self.astern else None
        motion, plan = self._to_point(nav, leader) if found is None else found
        self._resting = self._may_rest(motion, nav, leader, changed)
        if self._resting:
            motion = replace(motion, course_rad=nav.yaw_rad, speed_mps=0.0, turn_radps=0.0, gain_mps2=0.0, resting=True)
        near_m = 0.0 if found is None else self.distance_m  # on the way round the leader it is passed nearer
        evasion = self._clearance.update(motion.course_rad, motion.speed_mps, near_m, nav, leader, None if self._resting else plan)
        if evasion is None:
            return motion
        return replace(motion, course_rad=evasion.course_rad, speed_mps=evasion.speed_mps, turn_radps=0.0, gain_mps2=0.0, evading=True, resting=False)

    def _may_rest(self, motion: Motion, nav: NavState, leader: Leader, changed: bool) -> bool:
        """Whether the boat lies still: the leader stands, and the boat has come to its station, or lies about as far from the leader and would have to go round
        for it. Nor does a boat without way astern seek a station in the way of a leader that backs: it lies still, or keeps clear."""
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
        """From the leader, as the station is, or nearer."""
        distance = math.hypot(nav.north_m - leader.north_m, nav.east_m - leader.east_m)
        return distance < self.distance_m + _REST_BAND_M + _REST_BAND_SHARE * self.distance_m

    def _along_track(self, nav: NavState, leader: Leader) -> tuple[Motion, Plan] | None:
        """And how it will go on, seen along the straight between the boats. None where the boat is not on the track."""
        track, look = self.track, self.lookahead_m
        before = self._s
        s = track.project(nav.north_m, nav.east_m, before, _REACH_M)
        here = track.at(s)
        dn, de = nav.north_m - here.north_m, nav.east_m - here.east_m
        cross = de * math.cos(here.course_rad) - dn * math.sin(here.course_rad)
        far = math.hypot(dn, de) > (look if before is None else 2.0 * look)
        if far or s > track.end_s_m - 0.5 * self._parameters["FOLL_MIN_DIST"] or s < track.begin_s_m - look:
            self._s = None
            return None
        self._s = s
        track.trim(min(s, track.end_s_m - self.distance_m))
        goal_s = track.end_s_m - self.distance_m
        speed = self._speed(leader.speed_mps, goal_s - s, leader.acceleration_mps2)
        ahead = track.at(s + _PREVIEW_S * self._cruising_mps)
        drift = nav.east_mps * math.cos(here.course_rad) - nav.north_mps * math.sin(here.course_rad)
        along = nav.north_mps * math.cos(here.course_rad) + nav.east_mps * math.sin(here.course_rad)
        turn = max(0.0, along) * ahead.curvature_1pm - drift * look / (look * look + cross * cross)
        goal = track.at(goal_s)
        gain = leader.acceleration_mps2 if abs(goal_s - s) < 0.5 * self.distance_m else 0.0
        course = wrap_pi(ahead.course_rad - math.atan2(cross, look))
        motion = Motion(course, speed, turn, gain, (goal.north_m, goal.east_m), goal_s - s, cross, here.course_rad, abs(leader.speed_mps))
        beyond = motion.off_m - math.hypot(nav.north_m - leader.north_m, nav.east_m - leader.east_m)

        def plan(off_north: float, off_east: float, leader_north: float, leader_east: float) -> tuple[float, float]:
            feed = math.hypot(leader_north, leader_east)
            return course, max(0.0, self._speed(feed, beyond + math.hypot(off_north, off_east), leader.acceleration_mps2))

        return motion, plan

    def _speed(self, feed_mps: float, off_m: float, push_mps2: float) -> float:
        """Over ground along the way, for a station `off_m` ahead that goes at `feed_mps` and gains `push_mps2`."""
        p = self._parameters
        wanted = feed_mps + self._closing(off_m, max(0.0, feed_mps))
        if push_mps2 < _BRAKING_MPS2 and feed_mps > 0.0:
            left_m = off_m + feed_mps * feed_mps / (-2.0 * push_mps2)
            wanted = min(wanted, self._stopping_mps(left_m))
        lowest = -p["DP_SPEED_ASTERN"] if self._can_reverse else 0.0
        return min(self._most_mps, max(lowest, wanted))

    def _closing(self, off_m: float, feed_mps: float) -> float:
        """By how much faster than its station the boat goes; what can be taken off again on the way that is left."""
        p = self._parameters
        most = p["FOLL_CLOSE_V"]
        pull = p["FOLL_GAP_BW"] * off_m
        if pull <= 0.0:
            return max(-most, pull)
        if self._can_reverse:
            allowed = math.sqrt(feed_mps * feed_mps + 1.4 * p["PATH_ACC"] * off_m) - feed_mps
        else:
            allowed = self._coasting.speed_mps(self._coasting.way_m(feed_mps) + _COAST_SHARE * off_m) - feed_mps
        return max(0.0, min(most, pull, allowed))

    def _stopping_mps(self, left_m: float) -> float:
        """From which the boat still stops in that way."""
        if self._can_reverse:
            return math.sqrt(1.4 * self._parameters["PATH_ACC"] * max(0.0, left_m))
        return self._coasting.speed_mps(_COAST_SHARE * left_m)

    # --- a point that goes with the leader -------------------------------------------------------------------------

    def _station_point(self, leader: Leader) -> tuple[float, float, float, float, float]:
        """(north_m, east_m, north_mps, east_mps, turn) of the station."""
        if self.astern:
            goal = self.track.at(self.track.end_s_m - self.distance_m)
            speed = max(0.0, leader.speed_mps)
            return goal.north_m, goal.east_m, speed * math.cos(goal.course_rad), speed * math.sin(goal.course_rad), speed * goal.curvature_1pm
        heading = leader.yaw_rad if leader.yaw_rad is not None else self.track.at(self.track.end_s_m).course_rad
        bearing = heading + self._station[1]
        dn, de = self.distance_m * math.cos(bearing), self.distance_m * math.sin(bearing)
        turn = leader.yaw_rate_radps
        if leader.astern and not self._can_reverse:  # what has no way astern does not run after a boat that may stop at once
            return leader.north_m + dn, leader.east_m + de, 0.0, 0.0, 0.0
        north, east = leader.north_mps - turn * de, leader.east_mps + turn * dn
        most = self._most_mps
        share = min(1.0, most / max(1e-6, math.hypot(north, east)))
        return leader.north_m + dn, leader.east_m + de, share * north, share * east, turn

    def _to_point(self, nav: NavState, leader: Leader) -> tuple[Motion, Plan]:
        """And how it will go on, should the leader go on straight."""
        north_m, east_m, north, east, turn = self._station_point(leader)
        goal = north_m - leader.north_m, east_m - leader.east_m
        here = nav.north_m - leader.north_m, nav.east_m - leader.east_m
        vn, ve, closing, way, self._side = self._towards(here, goal, (north, east), self._side)
        speed, feed = math.hypot(vn, ve), math.hypot(north, east)
        near = feed / max(1e-6, feed + 2.0 * closing)
        course = math.atan2(ve, vn) if speed > _LEAST_MPS else (nav.yaw_rad if self._yaw is None else self._yaw)
        most = self._most_mps
        motion = Motion(course, min(most, speed), turn * near, leader.acceleration_mps2 * near, (north_m, east_m), way, None, None, feed)
        side = self._side

        def plan(off_north: float, off_east: float, leader_north: float, leader_east: float) -> tuple[float, float]:
            vn, ve, *_ = self._towards((off_north, off_east), goal, (leader_north, leader_east), side)
            return math.atan2(ve, vn), min(most, math.hypot(vn, ve))

        return motion, plan

    def _towards(
        self, here: tuple[float, float], goal: tuple[float, float], feed: tuple[float, float], side: int
    ) -> tuple[float, float, float, float, int]:
        """(north, east) m/s over ground, how much of it is towards the station, the way that is left, the side on which the leader is passed. `here`, `goal`:
        from the leader; `feed`: velocity of the station."""
        (wn, we), way, side = way_round(here, goal, self._round_m, side)
        speed = math.hypot(*feed)
        closing = self._closing(way, speed)
        back = (feed[0] * wn + feed[1] * we) / speed if speed > 1e-6 else 0.0  # −1: the way leads back
        if back < 0.0 and speed > 2.0 * _LEAST_MPS:
            closing = min(closing, _BEHIND_SHARE * speed / -back)
        return feed[0] + closing * wn, feed[1] + closing * we, closing, way, side

    # --- the setpoint ----------------------------------------------------------------------------------------------

    def setpoint(self, motion: Motion, nav: NavState, dt_s: float) -> Setpoint:
        """Heading, turn and speed through the loops of a boat under way. A boat without way astern that is to slow down is left to run out: the thrust that
        steers it would keep it going."""
        most = math.radians(self._parameters["PATH_YAW_RATE"])
        speed = motion.speed_mps
        straight = max(0.0, 1.0 - 2.0 * abs(nav.yaw_rate_radps) / most)
        self._crab.update(nav, max(0.0, speed), straight, dt_s)
        last = nav.yaw_rad if self._yaw is None else self._yaw
        turn = min(most, max(-most, motion.turn_radps))
        best = motion.course_rad
        if speed > _LEAST_MPS:
            best = self._crab.heading_rad(nav, motion.course_rad, speed, last) - self._slip_rad(nav.surge_mps, turn)
        self._yaw = wrap_pi(last + min(most * dt_s, max(-most * dt_s, wrap_pi(best - last)))) if speed > 0.0 else best
        off = wrap_pi(motion.course_rad - nav.yaw_rad)
        if motion.resting or (abs(off) < _COAST_RAD and self._runs_out(speed, nav, motion)):
            return self._shown(Setpoint(SetpointKind.WRENCH, wrench=ZERO_WRENCH), motion, nav)
        least = _EVADING_SHARE if motion.evading else 0.0 if self._can_sway else _STEERAGE_SHARE
        surge = speed * max(least, math.cos(off)) if speed > 0.0 else speed
        setpoint = Setpoint(
            SetpointKind.PATH, yaw_rad=self._yaw, surge_mps=surge, yaw_rate_radps=turn, surge_mps2=motion.gain_mps2
        )
        return self._shown(setpoint, motion, nav)

    def _runs_out(self, speed_mps: float, nav: NavState, motion: Motion) -> bool:
        """Without thrust: towards a station that stands, down to well below the speed from which the hull just reaches it."""
        if self._can_reverse:
            return False
        if motion.feed_mps < _STANDING_MPS and speed_mps < self._clearance.turning_mps and not motion.evading:
            return nav.surge_mps > speed_mps - _BURST_MPS
        return nav.surge_mps > speed_mps + max(_COAST_MPS, 0.25 * speed_mps)

    @staticmethod
    def _shown(setpoint: Setpoint, motion: Motion, nav: NavState) -> Setpoint:
        """With what people see of it."""
        return replace(
            setpoint,
            north_m=nav.north_m,
            east_m=nav.east_m,
            target_north_m=motion.station[0],
            target_east_m=motion.station[1],
            cross_track_error_m=motion.cross_m,
            course_rad=motion.track_rad,
            distance_to_go_m=motion.off_m,
        )

    def _slip_rad(self, surge_mps: float, turn_radps: float) -> float:
        """By how much the bow of a boat without sideways thrust points out of its course in a steady turn: Y(v) = m11 u r on the hull alone."""
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


def leader_course_rad(leader: Leader) -> float | None:
    """Where its bow points, or its way leads; None while it has neither."""
    if leader.yaw_rad is not None:
        return leader.yaw_rad
    return math.atan2(leader.east_mps, leader.north_mps) if leader.speed_mps > _LEAST_MPS else None
