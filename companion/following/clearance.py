"""Keeping clear of the lead boat: predicts both boats, and finds the least change of course and speed that keeps the
distance.

Both boats are predicted for 13 s. The leader goes on as it does now; a braking leader comes to rest. The boat turns and
stops as slowly as it really does: a hull without reverse coasts as long as its drag lets it, and turns only while it
pushes. If the boat would come too near, other courses are predicted in the same way, each with and without way on. This
is the simulation-based choice of Johansen, Perez & Cristofaro (2016), for one vessel.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from companion.config.vessel import VesselConfig
from companion.core.angles import wrap_pi
from companion.core.estimate import Leader, NavState
from companion.params.store import Parameters

_STEP_S, _STEPS = 0.5, 26
_TURN_SEEN_S, _PUSH_SEEN_S = 2.0, 1.5  # for how long the leader is predicted to go on turning and accelerating
_BRAKING_MPS2 = -0.35  # at or below it the leader is taken to be stopping
_TURN_LAG_S = 1.0
_TURN_GAIN_1PS = 1.2
_TURN_SHARE = 0.75  # of PATH_YAW_RATE, that the boat is predicted to reach
TURNING_RAD = math.radians(19.0)
"""Off its course by more, a boat that steers by its thrust pushes itself along to turn; within it, it may coast. Less
than the least change of course that is predicted."""
_OFFSETS = tuple(math.radians(20.0 * i) for i in (0, 1, -1, 2, -2, 3, -3, 4, -4, 5, -5, 6, -6, 7, -7, 8, -8, 9))
_GO_COST = 0.25  # of a course with way on
_SIDE_COST = 0.35  # of a reversal of the course chosen before
_SHORT_COST_1PM, _LATE_COST_1PM = 1.0, 0.3  # of a metre too near: at the closest, and at the end of the prediction
_SLACK_M = 0.3
_SLOW_MPS = 3.0  # a slower leader may be coming to rest
_STOP_SHARE = 0.85  # of the distance at which the boat is to stop
_OWN_MPS = 0.3  # towards the leader; a slower approach is left to the law
_THRUST_SHARE = 0.4  # of the surge limit, with which a boat that has reverse is predicted to brake and accelerate
_NEAR_SHARE = 0.4  # of FOLL_MARGIN: nearer than that the boat moves away again


class _LeaderStep(NamedTuple):
    """The leader at one step of the prediction. `speed_mps` is along its bow, negative astern; `course_rad` is the
    direction of the bow."""

    north_m: float
    east_m: float
    speed_mps: float
    course_rad: float


MotionPlan = Callable[[float, float, float, float], tuple[float, float]]
"""(north, east) from the leader in m, and the leader's velocity (north, east) in m/s → (course in rad, speed in m/s)
that the boat will then want."""


@dataclass(frozen=True, slots=True)
class Evasion:
    """Course and speed that keep the distance."""

    course_rad: float
    speed_mps: float


class Clearance:
    """`update(course, speed, …)` → None where these keep clear of the leader, else what to do instead.

    Remembers the course chosen to keep clear, and whether the boat is moving away because it was too near.
    """

    def __init__(self, config: VesselConfig, parameters: Parameters, can_reverse: bool) -> None:
        self._hull = config.hull
        self._parameters = parameters
        self._can_reverse = can_reverse
        self._steers_by_thrust = config.limits.sway_n <= 0.0
        least = 1.0
        if self._steers_by_thrust:  # the speed at which the drag equals the thrust that it steers with
            while least < 5.0 and config.hull.drag_n(least) < 0.6 * parameters["JET_STEER_N"]:
                least += 0.1
        self._turning_mps = least
        self._thrust_mps2 = _THRUST_SHARE * config.limits.surge_n / config.hull.m11_kg
        self._course: float | None = None
        self._too_near = False

    @property
    def turning_mps(self) -> float:
        """The speed that the boat reaches by the thrust that it steers with."""
        return self._turning_mps

    @property
    def radius_m(self) -> float:
        """The distance that is kept: FOLL_MIN_DIST and FOLL_MARGIN."""
        return self._parameters["FOLL_MIN_DIST"] + self._parameters["FOLL_MARGIN"]

    def reset(self) -> None:
        """Forget the last evasion."""
        self._course = None
        self._too_near = False

    def update(
        self, course_rad: float, speed_mps: float, stop_m: float, nav: NavState, leader: Leader, plan: MotionPlan | None
    ) -> Evasion | None:
        """`course_rad`, `speed_mps`: wanted over ground. `plan`: how these go on; None: unchanged. `stop_m`: distance
        at which the boat is to stop behind a leader that comes to rest."""
        p = self._parameters
        radius_m = self.radius_m
        if abs(leader.speed_mps) < _SLOW_MPS or (leader.acceleration_mps2 < _BRAKING_MPS2 and not leader.astern):
            radius_m = max(radius_m, _STOP_SHARE * stop_m)
        distance = math.hypot(nav.north_m - leader.north_m, nav.east_m - leader.east_m)
        near_m = p["FOLL_MIN_DIST"] + _NEAR_SHARE * p["FOLL_MARGIN"]
        self._too_near = distance < (self.radius_m if self._too_near else near_m)
        if distance > radius_m + _STEPS * _STEP_S * (abs(leader.speed_mps) + max(abs(speed_mps), abs(nav.surge_mps))):
            self._course = None
            return None
        way = _leader_way(leader)
        kept = min(radius_m, distance - _SLACK_M)
        if not self._too_near and self._distances(course_rad, speed_mps, nav, way, plan)[0] >= kept:
            self._course = None
            return None
        return self._best(course_rad, nav, leader, way, radius_m)

    def _best(
        self, wanted_rad: float, nav: NavState, leader: Leader, way: list[_LeaderStep], radius_m: float
    ) -> Evasion:
        """The course and speed of least cost: deviation, reversal, and metres too near."""
        p = self._parameters
        go_mps = min(p["MPC_XY_VEL_MAX"], max(1.3 * self._turning_mps, abs(leader.speed_mps) + 0.5 * self._turning_mps))
        speeds = (0.0, go_mps, -p["DP_SPEED_ASTERN"]) if self._can_reverse else (0.0, go_mps)
        best, found = math.inf, Evasion(nav.yaw_rad, 0.0)
        for offset in _OFFSETS:
            course = wrap_pi(nav.yaw_rad + offset)
            for speed in speeds:
                if speed < 0.0 and offset != 0.0:
                    continue
                cost = abs(wrap_pi(course - wanted_rad)) / math.pi + (_GO_COST if speed > 0.0 else 0.0)
                if self._course is not None:
                    cost += _SIDE_COST * abs(wrap_pi(course - self._course)) / math.pi
                if cost >= best:
                    continue
                least, last = self._distances(course, speed, nav, way)
                cost += _SHORT_COST_1PM * max(0.0, radius_m - least) + _LATE_COST_1PM * max(0.0, radius_m - last)
                if cost < best:
                    best, found = cost, Evasion(course, speed)
        self._course = found.course_rad
        return found

    def _distances(
        self, course_rad: float, speed_mps: float, nav: NavState, way: list[_LeaderStep], plan: MotionPlan | None = None
    ) -> tuple[float, float]:
        """Predict the boat: (least distance to the leader, distance at the end) in m."""
        hull, p = self._hull, self._parameters
        fastest = _TURN_SHARE * math.radians(p["PATH_YAW_RATE"])
        north, east, yaw, u, r = nav.north_m, nav.east_m, nav.yaw_rad, nav.surge_mps, nav.yaw_rate_radps
        slip_n, slip_e = nav.north_mps - u * math.cos(yaw), nav.east_mps - u * math.sin(yaw)
        least, distance = math.inf, math.hypot(nav.north_m - way[0][0], nav.east_m - way[0][1])
        brake, push = (self._thrust_mps2, self._thrust_mps2) if self._can_reverse else (0.0, 1.5 * p["PATH_ACC"])
        for leader_n, leader_e, leader_mps, leader_course in way:
            if plan is not None:
                going_n, going_e = leader_mps * math.cos(leader_course), leader_mps * math.sin(leader_course)
                # from the leader, both as they are when the step begins
                off_n, off_e = north - leader_n + _STEP_S * going_n, east - leader_e + _STEP_S * going_e
                course_rad, planned_mps = plan(off_n, off_e, going_n, going_e)
            off = wrap_pi(course_rad - yaw)
            r += (min(fastest, max(-fastest, _TURN_GAIN_1PS * off)) - r) * _STEP_S / (_STEP_S + _TURN_LAG_S)
            yaw += r * _STEP_S
            wanted = speed_mps
            if plan is not None:
                wanted = planned_mps
            if self._steers_by_thrust and abs(off) > TURNING_RAD:
                wanted = max(wanted, self._turning_mps)
            if u > wanted:
                drag = hull.drag_n(abs(u)) / hull.m11_kg
                u = max(wanted, u - _STEP_S * max(brake, drag if u > 0.0 else 0.0))
            else:
                u = min(wanted, u + _STEP_S * push)
            slip_n, slip_e = 0.7 * slip_n, 0.7 * slip_e
            north += _STEP_S * (u * math.cos(yaw) + slip_n)
            east += _STEP_S * (u * math.sin(yaw) + slip_e)
            distance = math.hypot(north - leader_n, east - leader_e)
            least = min(least, distance)
        return least, distance


def _leader_way(leader: Leader) -> list[_LeaderStep]:
    """The leader, predicted at the end of each step."""
    speed, push = leader.speed_mps, leader.acceleration_mps2
    sign = -1.0 if leader.astern else 1.0
    course = math.atan2(sign * leader.east_mps, sign * leader.north_mps)
    north, east = leader.north_m, leader.east_m
    braking = push < _BRAKING_MPS2
    gained = sign * push
    way = []
    for i in range(_STEPS):
        t_s = i * _STEP_S
        if braking:
            speed = sign * max(0.0, sign * speed + push * _STEP_S)
        elif abs(push) > -_BRAKING_MPS2 and t_s < _PUSH_SEEN_S:
            speed += gained * _STEP_S
        if t_s < _TURN_SEEN_S:
            course += leader.yaw_rate_radps * _STEP_S
        north += _STEP_S * speed * math.cos(course)
        east += _STEP_S * speed * math.sin(course)
        way.append(_LeaderStep(north, east, speed, course))
    return way


def closes_too_fast(nav: NavState, leader: Leader, least_m: float, time_s: float) -> bool:
    """Whether the boat, by its own way, would be within `least_m` of the leader in less than `time_s`, if both keep
    course and speed. A check of the time to collision that depends on no law and no plan."""
    north_m, east_m = leader.north_m - nav.north_m, leader.east_m - nav.east_m
    distance_m = math.hypot(north_m, east_m)
    if distance_m < 1e-3:
        return True
    own_mps = (nav.north_mps * north_m + nav.east_mps * east_m) / distance_m
    closing_mps = own_mps - (leader.north_mps * north_m + leader.east_mps * east_m) / distance_m
    return own_mps > _OWN_MPS and closing_mps > _OWN_MPS and distance_m - least_m < closing_mps * time_s
