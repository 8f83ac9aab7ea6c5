"""Mission: carries out what the executor says, task by task."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from companion.config import VesselConfig
from companion.core.geodesy import LocalFrame, distance_and_bearing
from companion.core.types import MissionState, ModeId, Setpoint, Severity
from companion.guidance.crab import top_speed_mps
from companion.guidance.follower_choice import ChosenFollower
from companion.guidance.path_following import Waypoint
from companion.mission.executor import MissionExecutor
from companion.mission.tasks import Action, Complete, Dock, Gate, ReturnHome, RoutePoint, Sail, Stay, Task, Turn, Wait
from companion.modes.berth import BerthChoice
from companion.modes.docking import Docking
from companion.modes.events import EventLog
from companion.modes.headway import Headway
from companion.modes.mission_fence import MissionFence
from companion.modes.mode import Mode, ModeInputs
from companion.modes.rtl import ReturnPoint
from companion.modes.sideways_leg import SidewaysLeg
from companion.modes.station import Station
from companion.modes.turn import TurnPlan
from companion.params import Parameters

_TASKS_A_TICK = 4
FURTHEST_LEG_M = 50_000.0  # from where the boat is to where it would go: more than that is another boat's plan, or a slip


class MissionMode(Mode):
    """Sails, stays, waits, turns and returns as the executor's task says, and tells it what is done.

    Remembers the task under way, the route that the present path was laid through and how much of it is passed, when a stay began, and
    the actions that the supervisor has yet to perform. While disarmed the chosen mode idles; the mission starts when the boat is armed.
    """

    id = ModeId.MISSION
    text = "Sails the mission; starts when armed"

    def __init__(
        self,
        config: VesselConfig,
        parameters: Parameters,
        executor: MissionExecutor,
        point: ReturnPoint,
        docking: Docking,
        berths: BerthChoice,
        events: EventLog,
        frame: Callable[[], LocalFrame],
        fence: MissionFence,
    ) -> None:
        self._fence = fence
        self._parameters = parameters
        self._executor = executor
        self._point = point
        self._docking = docking
        self._berths = berths
        self._events = events
        self._frame = frame
        self._can_sway = config.limits.sway_n > 0.0
        self._station = Station(config, parameters, fence.guard)
        self._leg = SidewaysLeg(self._station)
        self._sideways = False  # the last leg of the route is sailed by `_leg`
        self._on_leg = False  # it is now
        self._at_berth = False  # docking goes on, not refused
        self._follower = ChosenFollower(parameters, self._can_sway, top_speed_mps(config))
        self._headway = Headway("Mission", events)
        self._task: Task | None = None
        self._route: tuple[RoutePoint, ...] = ()
        self._told = 0  # points of the route that the executor knows to be passed
        self._since_s: float | None = None
        self._wait_s = math.inf
        self._turn: TurnPlan | None = None
        self._turning = False  # its last step has not been asked for yet
        self._actions: list[Action] = []
        self._gate: Gate | None = None
        self._gate_since_s = 0.0
        self._blocked: str | None = None
        self._way_home = False

    @property
    def blocked(self) -> str | None:
        """Why the mission cannot go on from here: the way that comes next crosses the fence. The boat stops meanwhile."""
        return self._blocked

    def fence_refusal(self, inputs: ModeInputs) -> str | None:
        """What of the mission from here on does not keep inside the fence."""
        return self._fence.refusal(inputs)

    @property
    def ended(self) -> MissionState | None:
        """COMPLETE when the last item is done, NO_MISSION when the mission was taken away, None while there is something to do."""
        state = self._executor.progress.state
        return state if state in (MissionState.COMPLETE, MissionState.NO_MISSION) else None

    @property
    def docked(self) -> bool:
        """Lies at the berth of the item done last."""
        return self._at_berth and self._docking.docked

    @property
    def alongside(self) -> bool:
        return self._at_berth and self._docking.alongside

    def stuck_s(self, now_s: float) -> float | None:
        return self._headway.stuck_s(now_s)

    def way_ahead(self) -> Sequence[tuple[float, float]]:
        if self._blocked is None and isinstance(self._task, Sail) and not self._on_leg:
            return [point for leg in self._follower.legs for point in leg]
        return self._station.way_ahead if isinstance(self._task, Stay | ReturnHome) else ()

    def way_speed_mps(self, inputs: ModeInputs) -> float:
        asked_mps = self._route[self._told].speed_mps if isinstance(self._task, Sail) and self._told < len(self._route) else None
        return inputs.speed_mps if asked_mps is None else min(asked_mps, inputs.speed_mps)

    def excuse(self) -> None:
        self._headway.reset()

    def take_actions(self) -> tuple[Action, ...]:
        """What the mission wants changed; each is given once."""
        actions, self._actions = (*self._actions, *self._executor.take_actions()), []
        return actions

    def check(self, inputs: ModeInputs) -> str | None:
        if self._executor.progress.state is MissionState.NO_MISSION:
            return "no mission loaded"
        place = self._executor.next_place
        if place is None or not inputs.nav.position_valid:
            return None
        seq, lat_deg, lon_deg = place
        away_m, _ = distance_and_bearing(inputs.nav.lat_deg, inputs.nav.lon_deg, lat_deg, lon_deg)
        return self._fence.refusal(inputs) if away_m <= FURTHEST_LEG_M else f"item {seq} is {away_m / 1000.0:.0f} km away"

    def enter(self, inputs: ModeInputs) -> str | None:
        refusal = self.check(inputs) or self._executor.begin()
        if refusal is None:
            self._task = self._blocked = None
            self._headway.reset()
            self._at_berth = False
            self._station.stop_here(inputs.nav)
        return refusal

    def resume(self, inputs: ModeInputs) -> str | None:
        """Begin the present task anew, from where the boat is; what is complete is not started over."""
        if self.ended is None:
            return self.enter(inputs)
        self._task = None
        return None

    def leave(self) -> None:
        self._executor.pause()
        self._task = None
        self._gate = None

    def update(self, inputs: ModeInputs) -> Setpoint:
        self._mind_gate(inputs)
        for _ in range(_TASKS_A_TICK):
            task = self._executor.task
            if task is None or isinstance(task, Complete):
                break
            if task is not self._task:
                self._take_up(task, inputs)
            if self._blocked is not None:
                return self._station.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)
            setpoint = self._sail(task, inputs) if isinstance(task, Sail) else self._stand(task, inputs)
            if self._executor.task is task:
                return setpoint
        return self._rest(inputs)

    def _mind_gate(self, inputs: ModeInputs) -> None:
        """Let through what a condition held back, once it is met. A delay counts from here, and anew after a pause."""
        while (gate := self._executor.gate) is not None:
            if gate != self._gate:
                self._gate, self._gate_since_s = gate, inputs.now_s
            if not self._is_met(gate, inputs):
                return
            self._actions += self._executor.open_gate()

    def _is_met(self, gate: Gate, inputs: ModeInputs) -> bool:
        if gate.delay_s is not None:
            return inputs.now_s - self._gate_since_s >= gate.delay_s
        place = self._executor.next_place
        if place is None or gate.distance_m is None:
            return True
        away_m, _ = distance_and_bearing(inputs.nav.lat_deg, inputs.nav.lon_deg, place[1], place[2])
        return away_m <= gate.distance_m

    def _rest(self, inputs: ModeInputs) -> Setpoint:
        """Stop where the tasks ran out; at a berth, stay there."""
        if self.docked:
            self._task = Complete()
            return self._docking.update(inputs)
        if not isinstance(self._task, Complete):
            if not isinstance(self._task, Stay | Wait | Turn | ReturnHome):
                self._station.stop_here(inputs.nav)
            self._task = Complete()
        return self._station.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)

    # --- taking up a task ------------------------------------------------------------------------------------------

    def _take_up(self, task: Task, inputs: ModeInputs) -> None:
        before, self._task = self._task, task
        self._headway.rebase()
        self._at_berth = False
        self._since_s = None
        match task:
            case Sail():
                if isinstance(before, Sail) and before.stop == task.stop and self._route[self._told :] == task.route:
                    return  # the rest of what is being sailed
                self._lay_path(task, inputs, before)
            case Stay():
                north_m, east_m = self._frame().to_ned(task.lat_deg, task.lon_deg)
                self._station.go_to(inputs.nav, north_m, east_m, task.yaw_rad, None, fresh=isinstance(before, Sail | Dock))
            case Wait():
                self._wait_s = math.inf
                if isinstance(before, Sail | Dock | None):
                    self._station.stop_here(inputs.nav)
            case Turn():
                if isinstance(before, Sail | Dock | None):
                    self._station.stop_here(inputs.nav)
                self._turn = TurnPlan(inputs.nav.yaw_rad, task.yaw_rad, task.relative, task.direction)
                self._turning = True
                if not self._can_sway:
                    self._events.say(inputs.now_s, Severity.NOTICE, "turn_skipped", f"Item {task.seq}: this boat cannot turn on the spot")
            case ReturnHome():
                self._return_home(task, inputs)
            case Dock():
                self._go_to_berth(task, inputs)

    def _return_home(self, task: ReturnHome, inputs: ModeInputs) -> None:
        found = self._point.way((inputs.nav.north_m, inputs.nav.east_m), inputs.home)
        self._way_home = not isinstance(found, str)
        if isinstance(found, str):
            self._station.stop_here(inputs.nav)
            self._events.say(inputs.now_s, Severity.WARNING, "no_home", f"Item {task.seq}: {found}, holding here")
        else:
            self._station.go_along(inputs.nav, found[1])

    def _go_to_berth(self, task: Dock, inputs: ModeInputs) -> None:
        """A refusal is said, and the boat holds where it is."""
        refusal = self._docking.start(self._berths.at(task.lat_deg, task.lon_deg, task.yaw_rad), inputs)
        self._at_berth = refusal is None
        if refusal is not None:
            self._station.stop_here(inputs.nav)
            self._events.say(inputs.now_s, Severity.WARNING, "dock_refused", f"Item {task.seq}: docking refused: {refusal}; holding here")

    def _lay_path(self, task: Sail, inputs: ModeInputs, before: Task | None) -> None:
        """From where the boat is, or from the path that it is on: further along it where this is its next part."""
        follower, underway = self._follower, isinstance(before, Sail) and not self._on_leg
        goes_on = isinstance(before, Sail) and underway and self._told == len(self._route) and before.beyond[:1] == task.route[:1]
        self._route = task.route
        self._told = 0
        waypoints, beyond = self._waypoints(task.route), self._waypoints(task.beyond)
        last = task.route[-1]
        self._sideways = last.yaw_rad is not None and self._can_sway and bool(self._parameters["WP_YAW_MODE"])
        self._on_leg = False
        stop = task.stop
        if self._sideways:
            waypoints, beyond, stop = waypoints[:-1], [], False
        if not waypoints:
            self._start_leg(inputs)
            return
        if goes_on:
            follower.go_on(waypoints, inputs.nav, stop, beyond)
        elif underway:
            follower.replace(waypoints, inputs.nav, stop, beyond)
        else:
            follower.start(waypoints, inputs.nav, stop, beyond=beyond)
        self._mind_fence(inputs)

    def _waypoints(self, route: Sequence[RoutePoint]) -> list[Waypoint]:
        frame, surveys = self._frame(), bool(self._parameters["PATH_SURVEY"])
        return [Waypoint(*frame.to_ned(p.lat_deg, p.lon_deg), p.radius_m, p.speed_mps, surveys and p.straight) for p in route]

    def _mind_fence(self, inputs: ModeInputs) -> None:
        """The path just laid, from where the boat really is."""
        self._blocked = self._fence.track_refusal(self._follower.legs, [point.seq for point in self._route[self._told :]])
        if self._blocked is not None:
            self._station.stop_here(inputs.nav)

    def _start_leg(self, inputs: ModeInputs) -> None:
        self._on_leg = True
        end = self._route[-1]
        north_m, east_m = self._frame().to_ned(end.lat_deg, end.lon_deg)
        yaw_rad = inputs.nav.yaw_rad if end.yaw_rad is None else end.yaw_rad
        self._leg.start(inputs.nav, north_m, east_m, yaw_rad, end.speed_mps)

    # --- carrying it out -------------------------------------------------------------------------------------------

    def _sail(self, task: Sail, inputs: ModeInputs) -> Setpoint:
        if self._sideways and self._told == len(self._route) - 1:
            return self._sail_sideways(task, inputs)
        progress = self._follower.update(inputs.nav, inputs.speed_mps, inputs.dt_s)
        self._headway.update(progress.way_m, inputs.speed_mps, inputs.now_s)
        if self._follower.took_over:
            self._mind_fence(inputs)
        passed = len(self._route) - self._sideways if progress.finished else progress.passed
        if task.stop and not progress.finished:
            passed = min(passed, len(self._route) - 1)  # the last one is reached at rest
        while self._told < passed and self._executor.task is task:
            seq = self._route[self._told].seq
            self._told += 1
            self._complete(seq, inputs)
        if self._sideways and self._told == len(self._route) - 1:
            self._start_leg(inputs)
        return progress.setpoint

    def _sail_sideways(self, task: Sail, inputs: ModeInputs) -> Setpoint:
        self._leg.update(inputs.nav)
        setpoint = self._at_station(inputs)
        if self._leg.arrived:
            self._told += 1
            self._complete(task.route[-1].seq, inputs)
        return setpoint

    def _stand(self, task: Stay | Wait | Turn | ReturnHome | Dock, inputs: ModeInputs) -> Setpoint:
        if self._at_berth:
            setpoint = self._docking.update(inputs)
        else:
            setpoint = self._at_station(inputs)
        if self._is_done(task, setpoint, inputs):
            self._complete(task.seq, inputs)
        return setpoint

    def _at_station(self, inputs: ModeInputs) -> Setpoint:
        setpoint = self._station.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)
        if self._station.way_m is not None:
            self._headway.update(self._station.way_m, inputs.speed_mps, inputs.now_s)
        return setpoint

    def _is_done(self, task: Stay | Wait | Turn | ReturnHome | Dock, setpoint: Setpoint, inputs: ModeInputs) -> bool:
        match task:
            case Stay(duration_s=duration_s):
                if self._since_s is None and self._is_near(inputs):
                    self._since_s = inputs.now_s
                return duration_s is not None and self._since_s is not None and inputs.now_s - self._since_s >= duration_s
            case Wait():
                if self._since_s is None or math.isinf(self._wait_s):
                    self._since_s = inputs.now_s
                    self._wait_s = task.wait_s(inputs.nav.time_unix_ns)
                return inputs.now_s - self._since_s >= self._wait_s
            case Turn():
                return self._is_turned(setpoint)
            case Dock():
                return self.docked
            case ReturnHome():
                return self._way_home and not self._station.going

    def _is_near(self, inputs: ModeInputs) -> bool:
        north_m, east_m = self._station.target
        off_m = math.hypot(north_m - inputs.nav.north_m, east_m - inputs.nav.east_m)
        return not self._station.in_transit and off_m <= self._parameters["NAV_ACC_RAD"]

    def _is_turned(self, setpoint: Setpoint) -> bool:
        if not self._can_sway or self._turn is None or setpoint.yaw_rad is None:
            return True
        if self._turning:
            self._station.turn_to(self._turn.update(setpoint.yaw_rad))
            self._turning = not self._turn.in_last_step
            return False
        return self._station.arrived

    def _complete(self, seq: int, inputs: ModeInputs) -> None:
        before = self._executor.progress.reached
        self._actions += self._executor.complete(seq)
        if self._executor.progress.reached != before:
            self._events.say(inputs.now_s, Severity.INFO, "item_reached", f"Mission item {seq} reached")
