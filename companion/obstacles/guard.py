"""Keeping clear of obstacles: the boat always stops in time, and goes round where its mode can and a way is open.

It acts on what steers by itself (path and pose setpoints) and on the stick in Heading. Vessels that move are
`companion.traffic`'s, which asks here for its detours; towards what moves, too, this guard stops the boat.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Future
from dataclasses import replace
from typing import Any, Protocol

import numpy as np

from companion.config.reversing import turns_on_the_spot
from companion.config.vessel import VesselConfig
from companion.control.stick_governor import StickGovernor, StickLimit
from companion.core.actuation import ZERO_WRENCH
from companion.core.decision import ModeId, ModeInputs, TextKind
from companion.core.estimate import NavState
from companion.core.events import EventLog
from companion.core.frames import body_to_ned
from companion.core.ports import Worker
from companion.core.setpoint import (
    HeadingSetpoint,
    PathSetpoint,
    PoseSetpoint,
    Progress,
    Setpoint,
    WrenchSetpoint,
    braked,
    desired_motion,
)
from companion.core.work import AtOnce, Lane
from companion.fence.allowed import Place
from companion.fence.guard import FenceGuard
from companion.fence.limit import direction
from companion.guidance.stopping import stopping_point
from companion.obstacles.braking import Braking, stream_along_mps
from companion.obstacles.chart_water import ChartKeeper
from companion.obstacles.clear_way import clear_way_m, reach_m, stop_m
from companion.obstacles.keeping_off import KeepingOff
from companion.obstacles.occupancy import Floats
from companion.obstacles.open_water import OpenWater
from companion.obstacles.patience import Patience
from companion.obstacles.room_to_hold import RoomToHold
from companion.obstacles.surroundings import Surroundings
from companion.obstacles.way_round import WayRound
from companion.params.store import Parameters
from companion.positioning.hold_point import HoldPoint
from companion.positioning.straight_astern import straight_astern

_LOOK_S = 0.5
_WAY_M = 150.0  # of the way ahead that is looked at
_PLAN_S = 1.0  # between two plans
_LOOKS = 2  # in a row that find the way blocked
_MOVER_S = (0.0, 1.0, 2.0, 3.0)  # places of what moves, for the stop
_STOPPED_MPS, _MOVES_MPS = 0.1, 0.05
_SLOWED_SHARE = 0.8
_TOO_FAST_MPS = 0.2  # above the limit: a boat with a rudder brakes before it steers
_CARRIED_MPS = 0.8  # a boat in Hold that is no faster is carried, more than it goes
_HALTS_S = 2.0  # stopped, before it holds there
_STOPS_SPARE_M = 0.3  # of the least distance, for the stop of a reference
_STANDS_S = 5.0  # at rest on a free way: what it bends round lies too near ahead of the boat
_CRAMPED_S = 5.0  # of too little room in the watch circle: what only passes through it moves no hold point
_LEADER_M = 8.0  # around the leader, nothing is an obstacle to its follower


class GuardedMode(Protocol):
    """What the guard needs of a mode."""

    @property
    def id(self) -> ModeId:
        """Which mode it is."""
        ...

    @property
    def by_stick(self) -> bool:
        """Whether the operator steers the boat."""
        ...

    @property
    def docking(self) -> bool:
        """Whether the boat goes alongside: the berth is no obstacle."""
        ...

    @property
    def goes_round(self) -> bool:
        """Whether the mode has a way that can lead round obstacles now."""
        ...

    @property
    def drifts(self) -> bool:
        """Whether the boat now moves about a point that it cannot keep."""
        ...

    def way_ahead(self) -> Sequence[Place]:
        """(north_m, east_m) of the path from the boat on; empty where the mode sails along none."""
        ...

    def way_round(self, inputs: ModeInputs) -> WayRound[Any] | None:
        """How to lead the rest of the way round the obstacles; None where the mode has no way of its own."""
        ...

    def excuse(self) -> None:
        """The boat makes no way for good reason: the mode must not report it as stuck."""
        ...

    @property
    def held_point(self) -> Place | None:
        """The point about which the boat now moves; None where it keeps none."""
        ...

    def hold_instead(self, north_m: float, east_m: float) -> None:
        """Hold another point."""
        ...


class Detour(Protocol):
    """A detour round traffic that is under way."""

    @property
    def detour_ahead(self) -> Sequence[Place]:
        """The rest of it; empty without one."""
        ...

    def give_up_detour(self) -> None:
        """Leave it, and look for another way."""
        ...


class ObstacleGuard:
    """`steer(setpoint, mode, inputs, detour)` each tick; `reset()` in ticks without a setpoint.

    Ways round are looked for beside the control thread, and laid in the tick in which they are found.

    Remembers the mode that it acts for, when it looked and planned last, the search under way, how long no way was
    found, how patient it still is, since when it stops the boat or has too little room to hold, whether that brakes
    before it steers, and whether it backs the boat out or holds it. `impossible`: why the mode cannot go on, once that
    is settled.
    """

    def __init__(
        self,
        config: VesselConfig,
        parameters: Parameters,
        surroundings: Surroundings,
        fence: FenceGuard,
        events: EventLog,
        chart: ChartKeeper,
    ) -> None:
        self._config = config
        self._fence = fence
        self._governor = StickGovernor(config, parameters)
        self._parameters = parameters
        self._around = surroundings
        self._events = events
        self._chart = chart
        self._worker: Worker = AtOnce()
        self._work: tuple[WayRound[Any], Future[Any]] | None = None
        self.water = OpenWater(config, parameters, fence, chart)
        self._braking = Braking(config, parameters)
        self._keeping_off = KeepingOff(config, parameters, fence, self._braking, events)
        self._hold_point = HoldPoint(config, parameters, fence)
        self._room = RoomToHold(config, parameters)
        self._steers_by_flow = config.has_rudder
        self._steers_astern = turns_on_the_spot(config.thrusters)
        self._brakes = self._backing = False
        self._mode: GuardedMode | None = None
        self._holding = False
        self._looked_s = self._planned_s = -math.inf
        self._blocked = 0  # looks in a row
        self._since_s: float | None = None  # no way found since
        self._reason = ""
        self._slowed = False
        self._stopped_s: float | None = None  # on the way since
        self._cramped_s: float | None = None  # about its hold point since
        self._patience = Patience(parameters)
        self._circles: Floats = np.zeros((0, 3))
        self._told_blind = False
        self.impossible: str | None = None

    def work_with(self, worker: Worker) -> None:
        """Let `worker` look for ways round."""
        self._worker = worker

    def reset(self) -> None:
        """Nothing is steered."""
        self._work = None
        self._mode, self._holding, self._blocked, self._since_s, self._slowed = None, False, 0, None, False
        self._stopped_s = self._cramped_s = None
        self._brakes = self._backing = False
        self.impossible = None
        self._keeping_off.reset()
        self._patience.reset()

    def steer(
        self, setpoint: Setpoint, mode: GuardedMode, inputs: ModeInputs, detour: Detour, unasked: bool = False
    ) -> Setpoint:
        """The setpoint, or one that keeps clear of obstacles. `unasked`: the boat took the mode by itself."""
        if mode is not self._mode:
            self.reset()
            self._mode = mode
        guarded = mode.drifts or isinstance(setpoint, PathSetpoint | PoseSetpoint | HeadingSetpoint)
        guarded = guarded and self._around.on and not mode.docking
        if not guarded or not inputs.nav.position_valid:
            self.reset()
            self._tell_blind(guarded, inputs.now_s)
            return setpoint
        self._told_blind = False
        if inputs.now_s - self._looked_s >= _LOOK_S:
            self._looked_s = inputs.now_s
            self._look(mode, inputs, detour)
        self._lay(mode, inputs)
        if not len(self._circles) and math.isinf(self._around.shoals.way_m) and self._chart.water is None:
            self._holding = self._slowed = False
            return setpoint
        if self._backing and (astern_mps := self._backing_mps(inputs.nav)) >= _STOPPED_MPS:
            mode.excuse()
            return self._astern(inputs.nav, astern_mps, setpoint.progress)
        stopped = self._stopped_in_time(setpoint, mode, inputs)
        drifts = mode.drifts or (self._holding and not mode.goes_round and self._config.limits.sway_n <= 0.0)
        if not (mode.goes_round or drifts or unasked):
            return stopped
        water, nav = self.water.now, inputs.nav
        # In a Hold that somebody asked for it keeps off what lies alone: it would flee the dinghy that fetches it.
        movers = self._around.movers(inputs.now_s) if mode.goes_round or unasked else ()
        way_m = self._way_of_m(stopped, nav) if movers else math.inf
        aside = self._keeping_off.update(stopped, movers, water, nav, inputs.speed_mps, inputs.now_s, drifts, way_m)
        if aside is None:
            return stopped
        mode.excuse()
        return self._out_of_the_way(aside, nav, setpoint.progress)

    def _tell_blind(self, guarded: bool, now_s: float) -> None:
        """Without a position, what the sensors see has no place."""
        if guarded and self._around.heard and not self._told_blind:
            self._told_blind = True
            self._events.say(now_s, TextKind.ATTENTION, "obstacles_blind", "No position: obstacles are not avoided")

    # --- looking and planning --------------------------------------------------------------------------------------

    def _look(self, mode: GuardedMode, inputs: ModeInputs, detour: Detour) -> None:
        """Whether the way ahead is still open; a way round where it is not."""
        now_s, nav = inputs.now_s, inputs.nav
        lying = self._without_leader(self._around.lying(now_s), mode, inputs)
        self.water.set_obstacles(lying, nav, inputs.speed_mps)
        self._circles = self._without_leader(self._stopping_circles(now_s), mode, inputs)
        if not len(lying) and self._chart.water is None:
            self._cramped_s, self._backing = None, False
            self._open(now_s)
            return
        self._give_room(mode, inputs)
        aside = detour.detour_ahead
        whole = mode.way_ahead()
        if mode.goes_round and self._patience.look(whole, now_s) and self._may_give_up(inputs):
            self.impossible = "no way found round obstacles"
            return
        way = _first_part(aside or whole, _WAY_M)
        here = (nav.north_m, nav.east_m)
        if len(way) < 2 or (math.isinf(self.water.now.free_m([here, *way[1:]])) and not self._stands(now_s)):
            self._open(now_s)
            return
        self._blocked += 1
        if self._blocked < _LOOKS or now_s - self._planned_s < _PLAN_S:
            return
        self._planned_s = now_s
        if aside:
            detour.give_up_detour()
            return
        if mode.goes_round and self._work is None and (round_it := mode.way_round(inputs)) is not None:
            water = self.water.now
            self._work = round_it, self._worker.submit(lambda: round_it.find(water.in_lane(Lane.URGENT)), urgent=True)

    def _lay(self, mode: GuardedMode, inputs: ModeInputs) -> None:
        """Take the way round once it is found."""
        if self._work is None or not self._work[1].done():
            return
        (round_it, future), self._work = self._work, None
        now_s = inputs.now_s
        reason = round_it.lay(future.result(), inputs)
        if reason is None:
            self._since_s, self._blocked, self._stopped_s = None, 0, None
            self._backing = False  # it has room to turn to that way; astern, wind and current take it aside
            self._patience.laid(mode.way_ahead(), inputs.speed_mps, now_s)
            self._events.say(now_s, TextKind.ATTENTION, "obstacle_round", "Obstacle ahead: going round")
        else:
            self._no_way(reason, inputs)

    def _give_room(self, mode: GuardedMode, inputs: ModeInputs) -> None:
        """Where what lies leaves a boat that moves about its hold point too little room for that, it backs out, or
        holds another point."""
        nav, water, point = inputs.nav, self.water.now, mode.held_point
        waits = self._holding and self._hold_point.arrived
        before = self._backing
        kept = before or waits or point is not None or self._since_s is not None
        self._backing = kept and self._room.backs_out(nav, water, self._fence, before)
        here = nav.north_m, nav.east_m
        if self._backing or not (waits or point is not None):
            self._cramped_s = None
            return
        at = here if before else point or self._hold_point.target
        place = self._room.better(at, here, water) or (here if before else None)
        if place is None:
            self._cramped_s = None
        elif point is not None:
            self._cramped_s = inputs.now_s if self._cramped_s is None else self._cramped_s
            if inputs.now_s - self._cramped_s < _CRAMPED_S and not before:
                return
            mode.hold_instead(*place)
            text = "Obstacles in the watch circle: hold point moved"
            self._events.say(inputs.now_s, TextKind.ATTENTION, "hold_point_clear", text)
        else:
            self._hold_point.shift(*place, nav.yaw_rad)

    def _backing_mps(self, nav: NavState) -> float:
        """Speed at which the boat backs out: so that it stops short of what passes astern of it."""
        astern = -math.cos(nav.yaw_rad), -math.sin(nav.yaw_rad)
        way_m = clear_way_m(
            (nav.north_m, nav.east_m), astern, self._circles, reach_m(self._config) + stop_m(self._parameters)
        )
        return min(self._parameters["DP_SPEED_ASTERN"], self._braking.speed_mps(way_m, stream_along_mps(nav, *astern)))

    def _out_of_the_way(self, aside: PathSetpoint, nav: NavState, progress: Progress) -> Setpoint:
        if aside.surge_mps == 0.0:  # it coasts: a heading would cost thrust
            return WrenchSetpoint(ZERO_WRENCH, progress)
        if aside.surge_mps < 0.0 and not self._steers_astern:
            return self._astern(nav, -aside.surge_mps, progress)
        return replace(aside, progress=progress)

    def _astern(self, nav: NavState, astern_mps: float, progress: Progress) -> Setpoint:
        """Astern on the heading that the boat has; a rudder or a nozzle does not steer, which they do by thrust
        ahead."""
        if self._steers_astern:
            return PathSetpoint(nav.yaw_rad, -astern_mps, progress=progress)
        return straight_astern(self._config.hull, self._parameters, nav, astern_mps, progress)

    def _stands(self, now_s: float) -> bool:
        """Whether the boat is kept from a way that is free: from where it stands, that way begins otherwise."""
        return self._stopped_s is not None and now_s - self._stopped_s >= _STANDS_S

    def _open(self, now_s: float) -> None:
        if self._since_s is not None:
            self._events.say(now_s, TextKind.ROUTINE, "obstacle_gone", "Way is open again: going on")
        self._blocked, self._since_s = 0, None

    def _no_way(self, reason: str, inputs: ModeInputs) -> None:
        """It may open again, so the boat waits for CP_WAIT where it stops."""
        now_s, nav = inputs.now_s, inputs.nav
        self._reason = reason
        if self._since_s is None:
            self._since_s = now_s
            text = f"No way round yet: {reason}"
            self._events.say(now_s, TextKind.ATTENTION, "obstacle_waits", text[:50])
        at_rest = math.hypot(nav.north_mps, nav.east_mps) < _STOPPED_MPS + 2.0 * nav.velocity_accuracy_mps
        waited = now_s - self._since_s >= self._parameters["CP_WAIT"] and (at_rest or self._holding)
        if waited and self._may_give_up(inputs):
            self.impossible = reason

    def _may_give_up(self, inputs: ModeInputs) -> bool:
        """Not while something that moves comes near: the mode that follows keeps off nothing. Nor while the boat backs
        out, for room to turn to another way."""
        if self._backing:
            return False
        movers = self._around.movers(inputs.now_s)
        return not (self._keeping_off.lasts or self._keeping_off.comes(movers, inputs.nav))

    def _stopping_circles(self, now_s: float) -> Floats:
        """What the boat stops for: all that is seen, and where it will be soon."""
        circles = self._around.all_circles(now_s)
        soon = [
            (one.north_m + t_s * one.north_mps, one.east_m + t_s * one.east_mps, one.radius_m)
            for one in self._around.movers(now_s)
            for t_s in _MOVER_S
        ]
        return np.concatenate((circles, np.asarray(soon).reshape(-1, 3))) if soon else circles

    @staticmethod
    def _without_leader(circles: Floats, mode: GuardedMode, inputs: ModeInputs) -> Floats:
        """A follower keeps its distance from its leader by its own law."""
        leader = inputs.leader
        if mode.id is not ModeId.FOLLOW or leader is None:
            return circles
        return circles[np.hypot(circles[:, 0] - leader.north_m, circles[:, 1] - leader.east_m) > _LEADER_M]

    # --- stopping --------------------------------------------------------------------------------------------------

    def _stopped_in_time(self, setpoint: Setpoint, mode: GuardedMode, inputs: ModeInputs) -> Setpoint:
        nav = inputs.nav
        demand = _demand(setpoint, nav)
        along = self._along(mode, nav, demand)
        if along is None:
            return self._hold(setpoint, inputs) if self._holding else setpoint
        limit = self._limit_mps(nav, along)
        size = math.hypot(*demand)
        if isinstance(setpoint, HeadingSetpoint):
            return self._governor.limited(setpoint, nav, [StickLimit(along, limit)], inputs.now_s)
        if isinstance(setpoint, PoseSetpoint):
            return self._posed(setpoint, nav, along, inputs)
        slowed = self._is_slowed(limit < _SLOWED_SHARE * size, inputs.now_s)
        self._mind_stop(slowed and limit < _STOPPED_MPS, inputs.now_s)
        if slowed or self._since_s is not None:
            mode.excuse()
        if self._halts(setpoint, mode, nav, inputs.now_s):
            return self._hold(setpoint, inputs)
        if self._since_s is not None and (self._holding or limit < _STOPPED_MPS):
            return self._hold(setpoint, inputs)
        self._holding = False
        if size <= limit:
            return setpoint
        assert isinstance(setpoint, PathSetpoint)
        return self._slowed_path(setpoint, nav, limit / size, limit)

    def _along(self, mode: GuardedMode, nav: NavState, demand: Place) -> Place | None:
        """The direction in which the boat goes, or will go. One that is carried aside in Hold, and goes on as it turns,
        is not kept from its way back: to stop would not stop that, and what it is set onto it keeps off."""
        size, speed_mps = math.hypot(*demand), math.hypot(nav.north_mps, nav.east_mps)
        if mode.drifts and self._room.room_m > 0.0 and size > 0.0 and speed_mps < _CARRIED_MPS:
            return demand[0] / size, demand[1] / size
        return direction(nav, demand)

    def _slowed_path(self, setpoint: PathSetpoint, nav: NavState, share: float, limit: float) -> Setpoint:
        """That share of the motion asked for. Where no way is open, a boat without thrust astern coasts: thrust for a
        turn would speed it up, and leads nowhere. One with a rudder that is too fast brakes, on the heading that it
        has: a rudder turns it by thrust ahead."""
        if self._keeping_off.coasts and self._since_s is not None:
            return WrenchSetpoint(ZERO_WRENCH, setpoint.progress)
        if self._brakes_first(nav, limit):
            setpoint = replace(setpoint, yaw_rad=nav.yaw_rad, yaw_rate_radps=0.0)
        return braked(setpoint, share, self._parameters["PATH_ACC"] * min(1.0, limit))

    def _brakes_first(self, nav: NavState, limit: float) -> bool:
        """Whether a boat with a rudder is so much faster than the limit that it brakes; it goes on until it is not."""
        over_mps = nav.surge_mps - limit
        self._brakes = self._steers_by_flow and over_mps > (0.0 if self._brakes else _TOO_FAST_MPS)
        return self._brakes

    def _mind_stop(self, stopped: bool, now_s: float) -> None:
        if not stopped:
            self._stopped_s = None
        elif self._stopped_s is None:
            self._stopped_s = now_s

    def _halts(self, setpoint: Setpoint, mode: GuardedMode, nav: NavState, now_s: float) -> bool:
        """Whether a boat that is stopped in a mode that leads it round nothing holds there, until the way that it wants
        is free: wind and current would carry it onto what stopped it."""
        if mode.goes_round or mode.by_stick or mode.drifts:
            return False
        if not self._holding:
            halts = self._stopped_s is not None and now_s - self._stopped_s >= _HALTS_S
            if halts:
                self._events.say(now_s, TextKind.ATTENTION, "obstacle_stops", "Obstacle ahead: stopped")
            return halts
        motion = desired_motion(setpoint)
        wanted = body_to_ned(
            motion.surge_mps, motion.sway_mps, nav.yaw_rad if motion.yaw_rad is None else motion.yaw_rad
        )
        size = math.hypot(*wanted)
        return size < _MOVES_MPS or self._limit_mps(nav, (wanted[0] / size, wanted[1] / size)) < 0.5 * size

    def _is_slowed(self, slowed: bool, now_s: float) -> bool:
        """The same, said when it begins."""
        if slowed and not self._slowed:
            self._events.say(now_s, TextKind.ROUTINE, "obstacle_slowed", "Obstacle ahead: slowing down")
        self._slowed = slowed
        return slowed

    def _limit_mps(self, nav: NavState, along: tuple[float, float]) -> float:
        """Highest speed over ground in the direction `along` (a unit vector) from which the boat stops in time."""
        return self._braking.speed_mps(self._free_way_m(nav, along), stream_along_mps(nav, *along))

    def _way_of_m(self, setpoint: Setpoint, nav: NavState) -> float:
        """Way after which a path's setpoint will have to end; infinite for others."""
        if not isinstance(setpoint, PathSetpoint) or setpoint.surge_mps == 0.0:
            return math.inf
        sign = math.copysign(1.0, setpoint.surge_mps)
        return self._free_way_m(nav, (sign * math.cos(setpoint.yaw_rad), sign * math.sin(setpoint.yaw_rad)))

    def _free_way_m(self, nav: NavState, along: tuple[float, float]) -> float:
        """Way straight ahead until obstacles, a shoal or the chart."""
        chart = self._chart.water
        by_chart = math.inf if chart is None else chart.stop_m((nav.north_m, nav.east_m), along)
        return min(self._clear_way_m(nav, along), self._around.shoals.way_along_m(along), by_chart)

    def _clear_way_m(self, nav: NavState, along: tuple[float, float]) -> float:
        """Way straight ahead until the hull is too near to something. Where no way leads on, the boat will hold: with
        room for that."""
        keep_m = reach_m(self._config) + stop_m(self._parameters)
        if self._since_s is not None:
            keep_m += self._room.least_m + self._room.carried_m(stream_along_mps(nav, *along))
        return clear_way_m((nav.north_m, nav.east_m), along, self._circles, keep_m)

    def _posed(self, setpoint: PoseSetpoint, nav: NavState, along: Place, inputs: ModeInputs) -> Setpoint:
        """Dynamic positioning on its way to another pose, or at a velocity, stops where something lies before it, until
        that is gone. It stops as gently as its reference does, and begins in time for that."""
        speed = math.hypot(setpoint.surge_mps, setpoint.sway_mps)
        if not self._holding:
            stops_m = math.dist(stopping_point(nav, self._parameters), (nav.north_m, nav.east_m))
            in_time = stops_m < self._free_way_m(nav, along) + _STOPS_SPARE_M
            if speed < _MOVES_MPS or (in_time and self._limit_mps(nav, along) > max(_STOPPED_MPS, 0.5 * speed)):
                return setpoint
            self._events.say(inputs.now_s, TextKind.ATTENTION, "obstacle_stops", "Obstacle ahead: stopped")
        elif math.isinf(self.water.now.free_m(((nav.north_m, nav.east_m), (setpoint.north_m, setpoint.east_m)))):
            self._holding = False
            return setpoint
        return self._hold(setpoint, inputs)

    def _hold(self, setpoint: Setpoint, inputs: ModeInputs) -> Setpoint:
        """Hold where the boat has stopped; the target shown stays that of the mode."""
        if not self._holding:
            self._holding = True
            self._hold_point.stop_here(inputs.nav)
        held = self._hold_point.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)
        return replace(held, progress=replace(held.progress, target=setpoint.progress.target))


def _demand(setpoint: Setpoint, nav: NavState) -> tuple[float, float]:
    """Direction in which a setpoint sends the boat, in NED: its velocity in m/s, or its force in N."""
    if isinstance(setpoint, HeadingSetpoint):
        return body_to_ned(setpoint.wrench.surge_n, setpoint.wrench.sway_n, nav.yaw_rad)
    motion = desired_motion(setpoint)
    return body_to_ned(motion.surge_mps, motion.sway_mps, nav.yaw_rad)


def _first_part(way: Sequence[Place], length_m: float) -> list[Place]:
    """Points of a way up to about `length_m`, at least 1 m apart but for the last."""
    if not way:
        return []
    points, length = [way[0]], 0.0
    for place in way[1:]:
        step = math.dist(points[-1], place)
        if step >= 1.0 or place is way[-1]:
            points.append(place)
            length += step
            if length > length_m:
                break
    return points
