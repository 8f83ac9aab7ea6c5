"""Keeping clear of the lead boat: predicts both boats, and finds the least change of course and speed that keeps the
distance.

Both boats are predicted for 13 s. The leader goes on as it does now; a braking leader comes to rest. The boat turns and
stops as slowly as it really does: a hull without reverse coasts as long as its drag lets it, and one that a jet or a
rudder steers turns only while it pushes. If the boat would come too near, other courses are predicted in the same way,
each with and without way on, and with way astern. This is the simulation-based choice of Johansen, Perez & Cristofaro
(2016), for one vessel.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

from companion.allocation.astern import STERN_FIRST_SHARE, astern_n
from companion.config.blades import steered_by_rudder
from companion.config.dimensions.derivation import top_speed_mps
from companion.config.dimensions.limits import sides_nm
from companion.config.reversing import turns_in_place, turns_on_the_spot
from companion.config.vessel import VesselConfig
from companion.core.angles import wrap_pi
from companion.core.estimate import NO_ESTIMATE, Leader, NavState
from companion.guidance.agility import agility_of
from companion.params.store import Parameters

_STEP_S, _STEPS = 0.5, 26
_TURN_SEEN_S, _PUSH_SEEN_S = 2.0, 1.5  # for how long the leader is predicted to go on turning and accelerating
_BRAKING_MPS2 = -0.35  # at or below it the leader is taken to be stopping
_STOPS_MPS2 = -1.0  # of a leader that stops, as far as a follow position allows for it
_FAR_AHEAD_M = 60.0
_TURN_LAG_S = 1.0
_TURN_GAIN_1PS = 1.2
_TURN_SHARE = 0.75  # of PATH_YAW_RATE, that the boat is predicted to reach
TURNING_RAD = math.radians(19.0)
"""Off its course by more, a boat that steers by its thrust pushes itself along to turn; within it, it may coast. Less
than the least change of course that is predicted."""
_ASIDE = tuple(side * math.radians(off) for off in range(20, 180, 20) for side in (1, -1))
_OFFSETS = (0.0, *_ASIDE, math.pi)
# The same of a boat that coasts and turns by its thrust. It turns right round to one side: by 180 degrees it would turn
# to either side in turns.
_COASTING_OFFSETS = (0.0, *_ASIDE, math.radians(175.0), -math.radians(175.0))
_GO_COST = 0.25  # of a course with way on
_BACK_COST_1PM = 0.1  # of a metre of way astern: a boat that steps aside is past the leader sooner
# of a reversal of the course chosen before; the second of a boat that can reverse its thrust as well
_SIDE_COST, _THRUST_SIDE_COST = 0.35, 0.6
_STEERING_ASTERN = 0.75  # least share of the yaw limit that the boat has at rest, if it steers while it goes astern
_BACK_RAD = math.radians(61.0)  # off the bow's present heading, up to which a boat turns while it goes astern
_SHORT_COST_1PM = 1.0  # of a metre too near
# The same at the end of the prediction, for a boat that coasts; where the leader then goes on and the boat lies still,
# for one that can.
_LAST_COST_1PM, _LATER_COST_1PM = 0.3, 0.6
_SLACK_M = 0.3
_SLOW_MPS = 3.0  # a slower leader may be coming to rest
_STOP_SHARE = 0.85  # of the distance at which the boat is to stop
_OWN_MPS = 0.3  # towards the leader; a slower approach is left to the law. Also of a leader that makes way
_THRUST_SHARE = 0.4  # of the surge limit, with which a boat that has reverse is predicted to brake and accelerate
_FASTER_MPS = 0.5  # than the leader, for one that gets out of its way
_STEERING_SHARE = 0.6  # of the thrust that steers: what drives the boat on meanwhile
_LONE_MPS = 1.0  # of a lone thruster that steers by its direction
_SLOWEST_SHARE = 0.5  # of the top speed in Follow
_WAY_SHARE = 0.5  # of the speed, kept by a boat that needs way to turn, while its bow points elsewhere
_ASIDE_SHARE, _ASIDE_TAU_S = 0.3, 2.5  # of the sway limit, whose speed aside is counted on; how late it comes
_SLIP_KEPT = 0.7  # a step later, of the sideways motion of a boat that coasts
_LEEWAY, _LEAST_DRIFT_MPS = 0.03, 0.15  # share of the wind speed with which it carries a boat; a slower drift is left
# How long the leader's way counts where the boat lies in the end, and for one that steers by its way: the leader is not
# there at once, and it does not step aside meanwhile.
_GOES_ON_S, _FOR_GOOD_S = 20.0, 1e9
_NEAR_SHARE = 0.4  # of FOLL_MARGIN: nearer than that the boat moves away again
_START_MPS, _STARTS_MPS2 = 0.3, 0.5  # of a leader at rest that goes ahead: to 1 m/s
_TURNS_RADPS = 0.05  # a slower turn of the leader does not lead it back past the boat


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
        self._offsets = _OFFSETS if can_reverse else _COASTING_OFFSETS
        self._turning_mps = turning_mps(config, parameters)
        back_mps = STERN_FIRST_SHARE * top_speed_mps(config.hull, astern_n(config)) if can_reverse else 0.0
        self._back_mps = max(parameters["DP_SPEED_ASTERN"], back_mps) if can_reverse else 0.0
        self._rest_share = _rest_share(config)
        self._steers_astern = (
            can_reverse and turns_on_the_spot(config.thrusters) and self._rest_share >= _STEERING_ASTERN
        )
        agility = agility_of(config)
        self._aside_mps = 0.0 if agility is None else agility.sway_mps(_ASIDE_SHARE)
        self._thrust_mps2 = _THRUST_SHARE * config.limits.surge_n / config.hull.m11_kg
        sidesteps = self._steers_astern or self._aside_mps > 0.0
        self._steers_by_way = can_reverse and not sidesteps and self._turning_mps > 0.0
        self._course: float | None = None
        self._turn_rad = 0.0
        self._too_near = False

    @property
    def turning_mps(self) -> float:
        """The speed that the boat reaches by the thrust that it steers with."""
        return self._turning_mps

    @property
    def steers_by_way(self) -> bool:
        """Whether a boat that can stop turns only while it pushes itself ahead, as by one propeller and a rudder."""
        return self._steers_by_way

    def ahead_mps(self, speed_mps: float, off_rad: float) -> float:
        """Speed along the hull for `speed_mps` on a course that lies `off_rad` off the bow. A boat that needs no way to
        turn goes no other way meanwhile; if the course lies abaft its beam, it begins to make way astern."""
        if speed_mps <= 0.0:
            return speed_mps
        along = math.cos(off_rad)
        if self._turning_mps > 0.0:
            return speed_mps * max(_WAY_SHARE, along)
        return max(-self._back_mps, speed_mps * along)

    def aside_mps(self, speed_mps: float, off_rad: float) -> float:
        """Speed to starboard of the hull, likewise; 0 without sideways thrust."""
        aside_mps = max(0.0, speed_mps) * math.sin(off_rad)
        return min(self._aside_mps, max(-self._aside_mps, aside_mps))

    @property
    def radius_m(self) -> float:
        """The distance that is kept: FOLL_MIN_DIST and FOLL_MARGIN."""
        return self._parameters["FOLL_MIN_DIST"] + self._parameters["FOLL_MARGIN"]

    @property
    def near_m(self) -> float:
        """The distance at which the boat moves away again: FOLL_MIN_DIST and a part of FOLL_MARGIN."""
        return self._parameters["FOLL_MIN_DIST"] + _NEAR_SHARE * self._parameters["FOLL_MARGIN"]

    def lying_rad(self, nav: NavState) -> float:
        """The heading at which the boat lies where it holds: into the drift that it cannot push against sideways; its
        own without one."""
        north_mps, east_mps = self._drift(nav)
        return math.atan2(-east_mps, -north_mps) if north_mps or east_mps else nav.yaw_rad

    def nearer_m(self, speed_mps: float) -> float:
        """By how much a boat in the track of a leader comes nearer to it where both make `speed_mps` and the leader
        stops: it loses its way or turns aside, whichever takes less."""
        nav = replace(NO_ESTIMATE, surge_mps=speed_mps, north_mps=speed_mps)
        leader = Leader(
            0, _FAR_AHEAD_M, 0.0, speed_mps, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, None, acceleration_mps2=_STOPS_MPS2
        )
        way = _leader_way(leader)
        ways = [offset for offset in self._offsets if offset >= 0.0 and self._can(0.0, offset)]
        return _FAR_AHEAD_M - max(self._distances(offset, 0.0, nav, way, slides=True)[0] for offset in ways)

    def reset(self) -> None:
        """Forget the last evasion."""
        self._course = None
        self._too_near = False

    def update(
        self, course_rad: float, speed_mps: float, stop_m: float, nav: NavState, leader: Leader, plan: MotionPlan | None
    ) -> Evasion | None:
        """`course_rad`, `speed_mps`: wanted over ground. `plan`: how these go on; None: unchanged. `stop_m`: distance
        at which the boat is to stop behind a leader that comes to rest.

        A leader that turns within the distance that is kept may come straight back, and one at rest may go ahead at any
        time. A boat that turns only as it pushes itself ahead then needs its room before that shows, so it keeps a way
        out from such a leader, and takes it while there is one."""
        radius_m = self.radius_m
        if abs(leader.speed_mps) < _SLOW_MPS or (leader.acceleration_mps2 < _BRAKING_MPS2 and not leader.astern):
            radius_m = max(radius_m, _STOP_SHARE * stop_m)
        distance = math.hypot(nav.north_m - leader.north_m, nav.east_m - leader.east_m)
        self._too_near = distance < (self.radius_m if self._too_near else self.near_m)
        if distance > radius_m + _STEPS * _STEP_S * (abs(leader.speed_mps) + max(abs(speed_mps), abs(nav.surge_mps))):
            self._course = None
            return None
        way = _leader_way(leader)
        kept = min(radius_m, distance - _SLACK_M)
        safe = not self._too_near and self._distances(course_rad, speed_mps, nav, way, plan, least_m=kept)[0] >= kept
        back, start = self._way_back(nav, leader), self._way_ahead(leader)
        if start is not None and not self._has_room(nav, start, min(self.near_m, kept)):
            return self._best(course_rad, nav, leader, start, radius_m)
        if safe and (back is None or self._has_room(nav, back, self.radius_m)):
            self._course = None
            return None
        return self._best(course_rad, nav, leader, way if back is None else back, radius_m)

    def _way_ahead(self, leader: Leader) -> list[_LeaderStep] | None:
        """The way of a leader at rest, or almost, that goes ahead; None where the boat need not turn by its way to get
        out of it, or has no reverse and keeps its distance by other rules."""
        if not self._steers_by_way or leader.yaw_rad is None or abs(leader.speed_mps) > _OWN_MPS:
            return None
        c, s = math.cos(leader.yaw_rad), math.sin(leader.yaw_rad)
        started = replace(
            leader,
            north_mps=_START_MPS * c,
            east_mps=_START_MPS * s,
            yaw_rate_radps=0.0,
            acceleration_mps2=_STARTS_MPS2,
            astern=False,
        )
        return _leader_way(started)

    def _way_back(self, nav: NavState, leader: Leader) -> list[_LeaderStep] | None:
        """The way of a leader that goes on turning until it heads for the boat; None where the boat can stop and turn,
        or the leader does not turn so tightly that it may come back past it."""
        turn_radps = leader.yaw_rate_radps
        if (
            (self._can_reverse and not self._steers_by_way)
            or leader.speed_mps < _OWN_MPS
            or abs(turn_radps) < _TURNS_RADPS
        ):
            return None
        if 2.0 * leader.speed_mps > self.radius_m * abs(turn_radps):
            return None
        bearing = math.atan2(nav.east_m - leader.east_m, nav.north_m - leader.north_m)
        course = math.atan2(leader.east_mps, leader.north_mps)
        left_rad = wrap_pi(bearing - course) * math.copysign(1.0, turn_radps)
        return _leader_way(leader, max(0.0, left_rad) / abs(turn_radps))

    def _has_room(self, nav: NavState, way: list[_LeaderStep], room_m: float) -> bool:
        """Whether a way out keeps that distance."""
        go_mps = self._go_mps(abs(way[0].speed_mps))
        courses = (wrap_pi(nav.yaw_rad + offset) for offset in self._offsets)
        return any(self._distances(course, go_mps, nav, way, least_m=room_m)[0] >= room_m for course in courses)

    def _go_mps(self, leader_mps: float) -> float:
        """The speed ahead at which the boat keeps clear."""
        return min(self._parameters["MPC_XY_VEL_MAX"], max(1.3 * self._turning_mps, self._faster_mps(leader_mps)))

    def _faster_mps(self, leader_mps: float) -> float:
        """A speed by which it gets away from a leader of that speed."""
        return leader_mps + max(_FASTER_MPS, 0.5 * self._turning_mps)

    def _best(
        self, wanted_rad: float, nav: NavState, leader: Leader, way: list[_LeaderStep], radius_m: float
    ) -> Evasion:
        """The course and speed of least cost: deviation, reversal, and metres too near."""
        leader_mps = abs(leader.speed_mps)
        go_mps, faster_mps = self._go_mps(leader_mps), self._faster_mps(leader_mps)
        speeds = (0.0, go_mps, -min(self._back_mps, faster_mps)) if self._can_reverse else (0.0, go_mps)
        late_cost_1pm = _LATER_COST_1PM if self._can_reverse else _LAST_COST_1PM
        best, turn_rad, found = math.inf, 0.0, Evasion(nav.yaw_rad, 0.0)
        for cost, offset, speed in self._priced(wanted_rad, nav.yaw_rad, speeds):
            if cost >= best:
                break
            course = wrap_pi(nav.yaw_rad + offset)
            hopeless_m = radius_m - (best - cost) / _SHORT_COST_1PM
            least, later = self._distances(course, speed, nav, way, least_m=hopeless_m)
            cost += _SHORT_COST_1PM * max(0.0, radius_m - least) + late_cost_1pm * max(0.0, radius_m - later)
            if cost < best:
                best, turn_rad, found = cost, offset, Evasion(course, speed)
        self._course, self._turn_rad = _way_rad(found), turn_rad
        return found

    def _priced(self, wanted_rad: float, yaw_rad: float, speeds: tuple[float, ...]) -> list[tuple[float, float, float]]:
        """(cost of deviation and reversal, turn in rad, speed) of all that is predicted, the cheapest first."""
        side_cost = _THRUST_SIDE_COST if self._can_reverse else _SIDE_COST
        left_rad = self._left_rad(yaw_rad)
        priced = []
        for offset, speed in self._choices(yaw_rad, speeds):
            course = wrap_pi(yaw_rad + offset)
            cost = abs(wrap_pi(course - wanted_rad)) / math.pi
            cost += _GO_COST if speed > 0.0 else -_BACK_COST_1PM * speed * _STEPS * _STEP_S
            if self._course is not None:
                way_rad = _way_rad(Evasion(course, speed))
                other_rad = wrap_pi(way_rad - self._course) if self._can_reverse else offset - left_rad
                cost += side_cost * abs(other_rad) / math.pi
            priced.append((cost, offset, speed))
        return sorted(priced, key=lambda one: one[0])

    def _choices(self, yaw_rad: float, speeds: tuple[float, ...]) -> list[tuple[float, float]]:
        """(turn in rad, speed) of all that is predicted. A boat that can stop first tries the way chosen before: the
        nearest of the others turns with the boat, tick by tick."""
        choices: list[tuple[float, float]] = []
        if self._course is not None and self._can_reverse:
            choices += [
                (wrap_pi(self._course - yaw_rad + (math.pi if v < 0.0 else 0.0)), v) for v in speeds if v != 0.0
            ]
        choices += [(offset, speed) for offset in self._offsets for speed in speeds]
        return [(offset, speed) for offset, speed in choices if self._can(speed, offset)]

    def _left_rad(self, yaw_rad: float) -> float:
        """The turn that is left to the course chosen before, on the side to which it was begun."""
        if self._course is None:
            return 0.0
        left = wrap_pi(self._course - yaw_rad)
        if abs(left) > 0.5 * math.pi and left * self._turn_rad < 0.0:
            return left + math.copysign(math.tau, self._turn_rad)
        return left

    def _can(self, speed_mps: float, offset_rad: float) -> bool:
        """Whether the boat can turn by that while it makes such way. One that has to push itself along to turn, and
        could as well stop, is not counted on to do both."""
        if speed_mps < 0.0:
            return offset_rad == 0.0 or (self._steers_astern and abs(offset_rad) < _BACK_RAD)
        return speed_mps > 0.0 or offset_rad == 0.0 or self._turning_mps == 0.0 or not self._can_reverse

    def _distances(
        self,
        course_rad: float,
        speed_mps: float,
        nav: NavState,
        way: list[_LeaderStep],
        plan: MotionPlan | None = None,
        slides: bool = False,
        least_m: float = -math.inf,
    ) -> tuple[float, float]:
        """Predict the boat: (least distance to the leader, that at the end) in m. The end is where the leader passes
        the boat, if that can lie still until then; where the boat comes nearer than `least_m`, the prediction ends
        there. `slides`: a boat that coasts slides outwards as far as its hull does in a turn, which its follow position
        allows for. Its choices count on less: else it would evade a leader that it lies safely beside, and turn on its
        thrust."""
        p = self._parameters
        fastest = _TURN_SHARE * math.radians(p["PATH_YAW_RATE"])
        if speed_mps <= 0.0 and plan is None:
            fastest *= math.sqrt(self._rest_share)
        north, east, yaw, r = nav.north_m, nav.east_m, nav.yaw_rad, nav.yaw_rate_radps
        drift_n, drift_e = self._drift(nav)
        u, v = nav.surge_mps, nav.sway_mps - drift_e * math.cos(yaw) + drift_n * math.sin(yaw)
        slip_n, slip_e = nav.north_mps - u * math.cos(yaw), nav.east_mps - u * math.sin(yaw)
        least = math.inf
        push = self._thrust_mps2 if self._can_reverse else 1.5 * p["PATH_ACC"]
        for leader_n, leader_e, leader_mps, leader_course in way:
            if plan is not None:
                going_n, going_e = leader_mps * math.cos(leader_course), leader_mps * math.sin(leader_course)
                # from the leader, both as they are when the step begins
                off_n, off_e = north - leader_n + _STEP_S * going_n, east - leader_e + _STEP_S * going_e
                course_rad, planned_mps = plan(off_n, off_e, going_n, going_e)
            off = wrap_pi(course_rad - yaw)
            r += (min(fastest, max(-fastest, _TURN_GAIN_1PS * off)) - r) * _STEP_S / (_STEP_S + _TURN_LAG_S)
            yaw += r * _STEP_S
            wanted = self._along_mps(speed_mps, off) if plan is None else planned_mps
            if abs(off) > TURNING_RAD and wanted >= 0.0:
                wanted = max(wanted, self._turning_mps)
            u = self._surge_mps(u, wanted, off, push)
            c, s = math.cos(yaw), math.sin(yaw)
            if self._can_reverse or slides:
                v = self._sway_mps(u, v, r, self.aside_mps(speed_mps, off) if plan is None else 0.0)
                across = v + drift_e * c - drift_n * s
                slip_n, slip_e = -across * s, across * c
            else:
                slip_n, slip_e = _SLIP_KEPT * slip_n, _SLIP_KEPT * slip_e
            north += _STEP_S * (u * c + slip_n)
            east += _STEP_S * (u * s + slip_e)
            least = min(least, math.hypot(north - leader_n, east - leader_e))
            if least < least_m:
                return least, least
        if self._can_reverse:
            return least, _passed_m(north, east, way[-1], _GOES_ON_S if self._steers_by_way else _FOR_GOOD_S)
        return least, math.hypot(north - way[-1].north_m, east - way[-1].east_m)

    def _surge_mps(self, u: float, wanted_mps: float, off_rad: float, push_mps2: float) -> float:
        """The speed along the hull a step later: by thrust, or as the hull's drag brakes it."""
        if u <= wanted_mps:
            return min(wanted_mps, u + _STEP_S * push_mps2)
        brake = self._hull.drag_n(u) / self._hull.m11_kg if u > 0.0 else 0.0
        if self._can_reverse and not self._turns_first(off_rad):
            brake = max(self._thrust_mps2, brake)
        return max(wanted_mps, u - _STEP_S * brake)

    def _turns_first(self, off_rad: float) -> bool:
        """Whether a turn takes all thrust of a boat that its rudders turn ahead only: none is left to brake or back."""
        return self._rest_share < _STEERING_ASTERN and abs(off_rad) > TURNING_RAD

    def _drift(self, nav: NavState) -> tuple[float, float]:
        """The velocity (north, east) with which wind and current carry a boat aside that can stop, but not push itself
        sideways. Zero for others, and where it is not known surely."""
        if not self._can_reverse or self._aside_mps > 0.0:
            return 0.0, 0.0
        north_mps, east_mps = nav.current_north_mps or 0.0, nav.current_east_mps or 0.0
        if nav.wind_speed_mps is not None and nav.wind_from_rad is not None:
            north_mps -= _LEEWAY * nav.wind_speed_mps * math.cos(nav.wind_from_rad)
            east_mps -= _LEEWAY * nav.wind_speed_mps * math.sin(nav.wind_from_rad)
        sure = math.hypot(north_mps, east_mps) > max(_LEAST_DRIFT_MPS, nav.current_accuracy_mps or 0.0)
        return (north_mps, east_mps) if sure else (0.0, 0.0)

    def _along_mps(self, speed_mps: float, off_rad: float) -> float:
        """The speed along the hull that is predicted: a boat that coasts is taken to have all of it at once."""
        return self.ahead_mps(speed_mps, off_rad) if self._can_reverse else speed_mps

    def _sway_mps(self, u: float, v: float, r: float, aside_mps: float) -> float:
        """The sideways speed a step later: by thrust, or of a hull that slides outwards in a turn until its course
        follows its bow."""
        if self._aside_mps > 0.0:
            return v + (aside_mps - v) * _STEP_S / (_STEP_S + _ASIDE_TAU_S)
        hull = self._hull
        lag_s = hull.sway_lag_s(u, v)
        if lag_s <= 0.0:
            return 0.0
        return (v - _STEP_S * hull.m11_kg / hull.m22_kg * u * r) / (1.0 + _STEP_S / lag_s)


def _way_rad(evasion: Evasion) -> float:
    """The direction in which the boat goes: over its stern, where it backs."""
    return wrap_pi(evasion.course_rad + math.pi) if evasion.speed_mps < 0.0 else evasion.course_rad


def _rest_share(config: VesselConfig) -> float:
    """What the boat has of its yaw limit at rest and astern: less than 1 where rudders beside other thrusters help it
    under way."""
    thrusters, most_nm = config.thrusters, config.limits.yaw_nm
    if steered_by_rudder(thrusters) or most_nm <= 0.0 or not any(row.kind == "rudder" for row in thrusters):
        return 1.0
    return min(1.0, min(sides_nm(tuple(thrusters))) / most_nm)


def turning_mps(config: VesselConfig, parameters: Parameters) -> float:
    """The speed that a boat reaches by the thrust that it steers with; 0 for one that turns in place."""
    thrusters = config.thrusters
    if config.limits.sway_n > 0.0 or turns_in_place(thrusters):
        return 0.0
    kind, slowest_mps = thrusters[0].kind, _SLOWEST_SHARE * parameters["MPC_XY_VEL_MAX"]
    if kind == "jet":
        steering_n, slowest_mps = parameters["JET_STEER_N"], 5.0
    elif kind == "rudder":
        steering_n = parameters["RUD_STEER"] * thrusters[0].max_n
    else:
        return min(_LONE_MPS, slowest_mps)
    least = 1.0
    while least < slowest_mps and config.hull.drag_n(least) < _STEERING_SHARE * steering_n:
        least += 0.1
    return least


def _passed_m(north_m: float, east_m: float, leader: _LeaderStep, goes_on_s: float) -> float:
    """The distance at which the leader passes a place if it goes straight on for that time; the present one where it
    goes away."""
    dn, de = north_m - leader.north_m, east_m - leader.east_m
    c, s = math.cos(leader.course_rad), math.sin(leader.course_rad)
    ahead_m = math.copysign(1.0, leader.speed_mps) * (dn * c + de * s)
    if ahead_m <= 0.0:
        return math.hypot(dn, de)
    return math.hypot(max(0.0, ahead_m - goes_on_s * abs(leader.speed_mps)), de * c - dn * s)


def _leader_way(leader: Leader, turns_s: float = _TURN_SEEN_S) -> list[_LeaderStep]:
    """The leader, predicted at the end of each step. `turns_s`: for how long it goes on turning."""
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
        if t_s < turns_s:
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
