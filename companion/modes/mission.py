"""Mission: carries out the executor's tasks one after another."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from companion.config.top_speed import top_speed_mps
from companion.config.vessel import VesselConfig
from companion.core.decision import KnownRefusal, MissionState, ModeDeclaration, ModeId, ModeInputs, TextKind
from companion.core.events import EventLog
from companion.core.geodesy import LocalFrame, distance_and_bearing
from companion.core.setpoint import PoseSetpoint, Setpoint
from companion.core.work import Lane
from companion.guidance.orbit import OrbitGuidance
from companion.guidance.sideslip import steered_hull_of
from companion.guidance.turning import bends_of
from companion.mission.executor import MissionExecutor
from companion.mission.plan import item_number
from companion.mission.tasks import (
    Action,
    BeginTrial,
    Complete,
    Dock,
    Orbit,
    ReturnHome,
    RoutePoint,
    Sail,
    SeaTrial,
    Stay,
    Task,
    Turn,
    Wait,
)
from companion.modes.mode import FURTHEST_LEG_M, Mode
from companion.modes.parts.berth import BerthChoice
from companion.modes.parts.docking import Docking
from companion.modes.parts.headway import Headway
from companion.modes.parts.mission_fence import MissionFence
from companion.modes.parts.mission_gate import MissionGate
from companion.modes.parts.mission_terms import orbit_circle
from companion.modes.parts.refusals import FAR_AWAY, FENCE_REFUSALS
from companion.modes.parts.repeats import Repeats
from companion.modes.parts.return_point import Homeward, ReturnPoint
from companion.modes.parts.route_sailing import RoundObstacles, RouteSailing
from companion.modes.parts.search import Search, Waiting
from companion.modes.parts.sideways_leg import SidewaysLeg
from companion.modes.parts.transit_round import transit_round
from companion.modes.parts.turn import TurnPlan
from companion.obstacles.way_round import WayRound
from companion.params.store import Parameters
from companion.positioning.hold_point import HoldPoint

_TASKS_A_TICK = 4
_FAR_OFF = 2.0  # acceptance radii: of a waypoint that is passed further off, this is said
_SAIL_ON_S = 1.0  # along the path under way, while the next one is laid; then the boat stops
_Ending = Stay | Wait | Turn | ReturnHome | Dock  # standing tasks that the mission itself finds done
_Standing = _Ending | SeaTrial
_MOVING = Sail | Dock | Orbit  # tasks that leave the boat moving, so a standing task must stop it first


@dataclass(frozen=True, slots=True)
class Destinations:
    """The destinations of a mission besides its waypoints: home or a rally point, and a berth."""

    point: ReturnPoint
    berths: BerthChoice
    docking: Docking


class MissionMode(Mode):
    """Carries out the executor's task (sail, stay, wait, turn, orbit, return, dock) and reports when it is complete.

    Remembers the present task, the route of the present path, how many points of it are passed, and when a stay began.
    Remembers too the actions that the supervisor has not performed yet. The mode idles while disarmed; the mission
    starts when the boat is armed.
    """

    declaration = ModeDeclaration(
        id=ModeId.MISSION,
        text="Sails the mission; starts when armed",
        px4=0x04040000,
        rover=10,  # AUTO
        standard_mode=6,  # MISSION
        shows_standard=True,
        again="a mission that has ended starts over",
        commands=(300, 224),  # MISSION_START, DO_SET_MISSION_CURRENT
        refusals=(
            KnownRefusal(r"no mission loaded", "no mission loaded", "Draw a plan and upload it."),
            FAR_AWAY,
            KnownRefusal(r".*no way home.*", "no way home inside the fence", "Change the fence, or the rally points."),
            *FENCE_REFUSALS,
        ),
    )

    def __init__(
        self,
        config: VesselConfig,
        parameters: Parameters,
        executor: MissionExecutor,
        destinations: Destinations,
        events: EventLog,
        frame: Callable[[], LocalFrame],
        fence: MissionFence,
    ) -> None:
        self._fence = fence
        self._parameters = parameters
        self._executor = executor
        self._point = destinations.point
        self._docking = destinations.docking
        self._berths = destinations.berths
        self._events = events
        self._frame = frame
        self._can_sway = config.limits.sway_n > 0.0
        self._hold_point = HoldPoint(config, parameters, fence.guard)
        self._leg = SidewaysLeg(self._hold_point)
        self._on_leg = False  # `_leg` sails now
        self._at_berth = False  # docking has started and was not refused
        self._landing = False  # the boat goes to hold where the mission lands it
        self._sailing = RouteSailing(config, parameters, executor, fence)
        self._homing: Search[Homeward | str] = Search(fence.submit_urgent)
        self._home: Homeward | str | None = None  # the way to it
        top_mps, bends = top_speed_mps(config), bends_of(config, steady=True)
        self._orbit = OrbitGuidance(parameters, self._can_sway, top_mps, bends, steered_hull_of(config))
        self._headway = Headway("Mission", events)
        self._task: Task | None = None
        self._since_s: float | None = None
        self._wait_s = math.inf
        self._turn: TurnPlan | None = None
        self._turning = False  # the turn's last step is not requested yet
        self._actions: list[Action] = []
        self._waiting = Waiting(events)  # the boat holds until the way is found
        self._repeats = Repeats()
        self._gate = MissionGate(executor)
        self._blocked: str | None = None
        self._way_home = False
        self._homeward = False  # the last task leads home or lands
        self._minds_check = self._minds_route = False  # a new fence, until its effect on the mission is known

    @property
    def most_astern_mps(self) -> float:
        """The highest speed of legs that are sailed stern first."""
        return self._sailing.astern_mps

    @property
    def blocked(self) -> str | None:
        """Why the mission cannot continue: its next path crosses the fence, so the boat stops. None: not blocked."""
        return self._blocked

    def fence_refusal(self, inputs: ModeInputs) -> str | None:
        """Return which item of the rest of the mission leads out of the fence, or None."""
        return self._fence.refusal(inputs, self._sailing.tracker.shape())

    @property
    def fence_checked(self) -> bool:
        """Whether `fence_refusal` has seen all of the mission; that of a long one takes a while."""
        return self._fence.checked

    def chosen_again(self, inputs: ModeInputs) -> bool:
        """Start over unless the mission is under way."""
        return self._executor.progress.state is not MissionState.ACTIVE

    def mind_fence(self, inputs: ModeInputs) -> str | None:
        """Lead the present route round the new fence; stop the mission if the rest of it crosses the fence. Where that
        takes long, the boat sails on meanwhile: the fence stops it in time."""
        self._minds_check, self._minds_route = True, self._under_way is not None
        return self._mind_new_fence(inputs)

    def _mind_new_fence(self, inputs: ModeInputs) -> str | None:
        """Why the mission cannot go on, as far as that is known by now."""
        if self._minds_check:
            reason = self.fence_refusal(inputs)
            self._minds_check = reason is None and not self.fence_checked
            if reason is not None:
                self._minds_route = False
                return reason
        if self._minds_route and (task := self._under_way) is not None:
            done, reason = self._sailing.led_round(task, inputs)
            if done:
                self._minds_route = False
                self._headway.rebase()
                self._stop_if_blocked(reason, inputs)
        return None

    @property
    def ended(self) -> MissionState | None:
        """COMPLETE after the last item, NO_MISSION if the mission was removed, None while items remain."""
        state = self._executor.progress.state
        return state if state in (MissionState.COMPLETE, MissionState.NO_MISSION) else None

    @property
    def docked(self) -> bool:
        """Whether the boat has docked at the berth of the last completed item."""
        return self._at_berth and self._docking.docked

    @property
    def voyage_over(self) -> bool:
        """Whether the mission has ended at home, at a berth or where it landed the boat."""
        return self.ended is MissionState.COMPLETE and self._homeward

    @property
    def alongside(self) -> bool:
        """Whether a docking item keeps the boat against a berth."""
        return self._at_berth and self._docking.alongside

    def stuck_s(self, now_s: float) -> float | None:
        """Seconds without headway on the present task; None if unknown."""
        return self._docking.stuck_s(now_s) if self._at_berth else self._headway.stuck_s(now_s)

    def way_ahead(self) -> Sequence[tuple[float, float]]:
        """The path, circle or line of the present task."""
        if self._blocked is None and isinstance(self._task, Sail) and not self._on_leg:
            return [point for leg in self._sailing.tracker.legs for point in leg]
        if self._blocked is None and isinstance(self._task, Orbit):
            return self._orbit.line()
        return self._hold_point.way_ahead if isinstance(self._task, Stay | ReturnHome) else ()

    def way_speed_mps(self, inputs: ModeInputs) -> float:
        """The speed of the present item, at most the set speed, m/s."""
        asked_mps, most_mps = None, inputs.speed_mps
        if isinstance(self._task, Orbit):
            asked_mps = self._task.speed_mps
        elif isinstance(self._task, Sail):
            asked_mps, most_mps = self._sailing.asked_mps, self._sailing.speed_mps(inputs)
        return most_mps if asked_mps is None else min(asked_mps, most_mps)

    @property
    def docking(self) -> bool:
        """Whether a docking item is under way."""
        return self._at_berth

    @property
    def goes_round(self) -> bool:
        """Whether the boat sails a route, or is in transit to a point."""
        if isinstance(self._task, Sail) and not self._on_leg:
            return self._blocked is None
        return isinstance(self._task, Stay | ReturnHome) and self._hold_point.in_transit

    def way_round(self, inputs: ModeInputs) -> WayRound[Any] | None:
        """The rest of the present route. Waypoints that cannot be reached are passed beside, which is announced; not
        the last one."""
        task = self._task
        if not isinstance(task, Sail):
            return transit_round(self._hold_point, inputs)
        route, find = self._sailing.rest, self._sailing.finder(task, inputs)

        def lay(found: RoundObstacles | int, inputs: ModeInputs) -> str | None:
            if self._task is not task or self._on_leg or self._sailing.rest != route:
                return None
            if isinstance(found, int):
                return f"item {item_number(route[found].seq)} cannot be reached"
            self._sailing.go_round(task, found, inputs)
            self._headway.rebase()
            for index, off_m in found.rounded.beside:
                text = f"Item {item_number(route[index].seq)} in an obstacle: passed {off_m:.0f} m off"
                self._events.say(inputs.now_s, TextKind.ATTENTION, "item_beside", text)
            return None

        return WayRound(find, lay)

    def excuse(self) -> None:
        """Restart the headway watch."""
        self._headway.reset()
        self._docking.excuse()

    def take_actions(self) -> tuple[Action, ...]:
        """Return the actions for the supervisor to perform, each only once."""
        actions, self._actions = (*self._actions, *self._executor.take_actions()), []
        return actions

    def check(self, inputs: ModeInputs) -> str | None:
        """Refuse without a mission, or if the next item is too far away or the mission crosses the fence."""
        if self._executor.progress.state is MissionState.NO_MISSION:
            return "no mission loaded"
        place = self._executor.next_place
        if place is None or not inputs.nav.position_valid:
            return None
        seq, lat_deg, lon_deg = place
        away_m, _ = distance_and_bearing(inputs.nav.lat_deg, inputs.nav.lon_deg, lat_deg, lon_deg)
        return (
            self.fence_refusal(inputs)
            if away_m <= FURTHEST_LEG_M
            else f"item {item_number(seq)} is {away_m / 1000.0:.0f} km away"
        )

    def enter(self, inputs: ModeInputs) -> str | None:
        """Start or continue the mission at the executor's next item."""
        refusal = self.check(inputs) or self._executor.begin()
        if refusal is None:
            self._give_up()
            self._task = self._blocked = None
            self._headway.reset()
            self._at_berth = False
            self._hold_point.stop_here(inputs.nav)
        return refusal

    def resume(self, inputs: ModeInputs) -> str | None:
        """Start the present task again from the present position. Complete tasks stay complete. Docking goes on as it
        is: what was given up is not tried again."""
        docks = self._at_berth and self._executor.task is self._task
        if docks and self._docking.resume(inputs) is None:
            return None
        if self.ended is None:
            return self.enter(inputs)
        self._task = None
        return None

    def leave(self) -> None:
        """Pause the mission."""
        self._executor.pause()
        self._give_up()
        self._task = None
        self._gate.restart()

    def _give_up(self) -> None:
        """Look for no way any longer."""
        self._sailing.drop()
        self._homing.drop()
        self._waiting.reset()
        self._minds_check = self._minds_route = False

    def update(self, inputs: ModeInputs) -> Setpoint:
        """Carry out the executor's task; stop when there is none."""
        self._actions += self._gate.mind(inputs)
        if (self._minds_check or self._minds_route) and (reason := self._mind_new_fence(inputs)) is not None:
            self._stop_if_blocked(reason, inputs)
        for _ in range(_TASKS_A_TICK):
            task = self._executor.task
            if task is None or isinstance(task, Complete):
                break
            if task is not self._task:
                if (setpoint := self._awaited(task, inputs)) is not None:
                    return setpoint
                self._take_up(task, inputs)
            if self._blocked is not None:
                return self._hold_point.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)
            setpoint = self._step(task, inputs)
            if self._executor.task is task:
                return setpoint
        return self._rest(inputs)

    def _step(self, task: Sail | Orbit | _Standing, inputs: ModeInputs) -> Setpoint:
        match task:
            case Sail():
                return self._sail(task, inputs)
            case Orbit():
                return self._go_round(task, inputs)
            case _:
                return self._stand(task, inputs)

    def _rest(self, inputs: ModeInputs) -> Setpoint:
        """Stop at the end of the tasks; stay at the berth if docked."""
        if self.docked:
            self._task = Complete()
            return self._docking.update(inputs)
        if not isinstance(self._task, Complete):
            if not isinstance(self._task, _Standing):
                self._hold_point.stop_here(inputs.nav)
            self._task = Complete()
        return self._hold_point.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)

    @property
    def _under_way(self) -> Sail | None:
        """The route whose path the boat sails; None where it sails none."""
        return self._task if isinstance(self._task, Sail) and not self._on_leg else None

    def _is_planned(self, task: Task, inputs: ModeInputs) -> bool:
        """Whether the task can be taken up within a tick; its way is looked for else."""
        if isinstance(task, Sail):
            return self._goes_on(task) or self._sailing.ready(task, self._under_way, inputs)
        if isinstance(task, ReturnHome):
            return self._knows_home(inputs)
        return True

    def _awaited(self, task: Sail | Orbit | _Standing, inputs: ModeInputs) -> Setpoint | None:
        """What the boat does until the task can be taken up; None where it can."""
        seq = task.route[0].seq if isinstance(task, Sail) else task.seq
        if not isinstance(task, Stay) and self._repeats.too_soon(seq, inputs.now_s):  # a stay belongs to its way there
            if isinstance(self._task, _MOVING):
                self._hold_point.stop_here(inputs.nav)
                self._task = None
            return self._hold_point.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)
        return None if self._is_planned(task, inputs) else self._wait_for_plan(inputs)

    def _goes_on(self, task: Sail) -> bool:
        """Whether the boat already sails this rest of its route."""
        before, sailing = self._task, self._sailing
        same = isinstance(before, Sail) and (before.stop, before.astern) == (task.stop, task.astern)
        return same and sailing.route[sailing.reported :] == task.route

    def _knows_home(self, inputs: ModeInputs) -> bool:
        here, returning = (inputs.nav.north_m, inputs.nav.east_m), self._point.now(inputs.home)
        if returning.is_at_hand(here):
            self._home = returning.find(here)
            return True
        laying, key = self._hold_point.laying(), self._point.key(inputs.home)
        answer = self._homing.look(key, here, lambda: returning.in_lane(Lane.URGENT).laid(here, laying))
        self._home = None if answer is None else answer.found
        return answer is not None

    def _wait_for_plan(self, inputs: ModeInputs) -> Setpoint:
        """Sail on, or hold here, until the way is found; it takes seconds at most."""
        waited_s = self._waiting.waited_s(inputs.now_s)
        sails_on = self._under_way is not None and waited_s < _SAIL_ON_S
        if not sails_on and (isinstance(self._task, _MOVING) or (self._task is None and not self._waiting.waits)):
            self._hold_point.stop_here(inputs.nav)
            self._task = None
        self._blocked = self._waiting.update(inputs.now_s)
        if sails_on:
            return self._sailing.update(inputs).setpoint
        return self._hold_point.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)

    # --- taking up a task ------------------------------------------------------------------------------------------

    def _take_up(self, task: Task, inputs: ModeInputs) -> None:
        sailed = isinstance(task, Sail) and self._goes_on(task)
        before, self._task = self._task, task
        self._repeats.take_up(inputs.now_s)
        self._waiting.reset()
        self._minds_route = False
        self._homeward = isinstance(task, ReturnHome | Dock)
        self._headway.rebase()
        self._at_berth = False
        self._since_s = None
        match task:
            case Sail():
                self._start_sailing(task, inputs, before, sailed)
            case Stay():
                north_m, east_m = self._frame().to_ned(task.lat_deg, task.lon_deg)
                self._hold_point.go_to(
                    inputs.nav, north_m, east_m, task.yaw_rad, None, fresh=isinstance(before, _MOVING)
                )
            case Wait() | SeaTrial():
                self._start_wait(task, inputs, before)
            case Turn():
                self._start_turn(task, inputs, before)
            case ReturnHome():
                self._return_home(task, inputs)
            case Dock():
                self._go_to_berth(task, inputs)
            case Orbit():
                self._start_orbit(task, inputs)

    def finish_trial(self, inputs: ModeInputs) -> None:
        """The trial of the present item is complete: the mission goes on with the next one."""
        if isinstance(task := self._executor.task, SeaTrial):
            self._complete(task.seq, inputs)

    def _start_sailing(self, task: Sail, inputs: ModeInputs, before: Task | None, sailed: bool) -> None:
        """`sailed`: the boat already sails this rest of its route."""
        if not sailed:
            before_path = before if isinstance(before, Sail) and not self._on_leg else None
            if task.astern is not self._sailing.astern:
                text = "Mission: stern first" if task.astern else "Mission: bow first"
                self._events.say(inputs.now_s, TextKind.ROUTINE, "stern_first", text)
            refusal = self._sailing.take_up(task, before_path, inputs)
            self._on_leg = False
            if not self._sailing.rest:
                self._start_leg(inputs)
            self._stop_if_blocked(refusal, inputs)

    def _start_wait(self, task: Wait | SeaTrial, inputs: ModeInputs, before: Task | None) -> None:
        """Stay here, for a while or until the supervisor has changed to Trial."""
        if isinstance(task, SeaTrial):
            self._actions.append(BeginTrial(task.seq, task.radius_m))
        self._wait_s = math.inf
        if isinstance(before, _MOVING | None):
            self._hold_point.stop_here(inputs.nav)

    def _start_turn(self, task: Turn, inputs: ModeInputs, before: Task | None) -> None:
        if isinstance(before, _MOVING | None):
            self._hold_point.stop_here(inputs.nav)
        self._turn = TurnPlan(inputs.nav.yaw_rad, task.yaw_rad, task.relative, task.direction)
        self._turning = True
        if not self._can_sway:
            text = f"Item {item_number(task.seq)}: this boat cannot turn on the spot"
            self._events.say(inputs.now_s, TextKind.REFUSAL, "turn_skipped", text)

    def _return_home(self, task: ReturnHome, inputs: ModeInputs) -> None:
        found = "no home position" if self._home is None else self._home
        self._way_home = not isinstance(found, str)
        if isinstance(found, str):
            self._hold_point.stop_here(inputs.nav)
            self._events.say(
                inputs.now_s, TextKind.REFUSAL, "no_home", f"Item {item_number(task.seq)}: {found}, holding here"
            )
        else:
            self._hold_point.go_along(inputs.nav, found.way, found.laid)

    def _start_orbit(self, task: Orbit, inputs: ModeInputs) -> None:
        circle = orbit_circle(task, self._frame(), self._parameters)
        leave_to = None if task.leave_to is None else self._frame().to_ned(*task.leave_to)
        self._orbit.start(circle, inputs.nav, 2.0 * math.pi * task.turns, leave_to)
        terms = self._sailing.terms(inputs)
        self._stop_if_blocked(terms.track_refusal([self._orbit.line()], [task.seq]), inputs)

    def _go_to_berth(self, task: Dock, inputs: ModeInputs) -> None:
        """Start docking. If it is refused, announce why and hold here. Where the boat should not dock, or cannot, it
        goes there and holds."""
        yaw_rad = self._sailing.terms(inputs).berth_heading_rad(task)
        self._landing = yaw_rad is None
        if yaw_rad is None:
            north_m, east_m = self._frame().to_ned(task.lat_deg, task.lon_deg)
            self._hold_point.go_to(inputs.nav, north_m, east_m, task.yaw_rad, None)
            return
        refusal = self._docking.start(self._berths.at(task.lat_deg, task.lon_deg, yaw_rad), inputs)
        self._at_berth = refusal is None
        if refusal is not None:
            self._hold_point.stop_here(inputs.nav)
            self._events.say(
                inputs.now_s,
                TextKind.REFUSAL,
                "dock_refused",
                f"Item {item_number(task.seq)}: docking refused: {refusal}",
            )

    def _stop_if_blocked(self, reason: str | None, inputs: ModeInputs) -> None:
        self._blocked = reason
        if self._blocked is not None:
            self._hold_point.stop_here(inputs.nav)

    def _start_leg(self, inputs: ModeInputs) -> None:
        self._on_leg = True
        end = self._sailing.route[-1]
        north_m, east_m = self._frame().to_ned(end.lat_deg, end.lon_deg)
        yaw_rad = inputs.nav.yaw_rad if end.yaw_rad is None else end.yaw_rad
        self._leg.start(inputs.nav, north_m, east_m, yaw_rad, end.speed_mps)

    # --- carrying it out -------------------------------------------------------------------------------------------

    def _sail(self, task: Sail, inputs: ModeInputs) -> Setpoint:
        sailing = self._sailing
        if sailing.sideways and not sailing.rest:
            return self._sail_sideways(task, inputs)
        progress = sailing.update(inputs)
        self._headway.update(progress.way_m, inputs.speed_mps, inputs.now_s)
        if sailing.tracker.took_over:
            self._stop_if_blocked(sailing.refusal(inputs), inputs)
        passed = len(sailing.route) - sailing.sideways if progress.finished else progress.passed
        if task.stop and not progress.finished:
            passed = min(passed, len(sailing.route) - 1)  # the last one is reached at rest
        while sailing.reported < passed and self._executor.task is task:
            point = sailing.route[sailing.reported]
            sailing.reported += 1
            self._complete(point.seq, inputs, self._far_off_m(point, inputs))
        if sailing.sideways and not sailing.rest:
            self._start_leg(inputs)
        elif not self._minds_route and self._executor.task is task:
            sailing.foresee(task, inputs)
        return progress.setpoint

    def _sail_sideways(self, task: Sail, inputs: ModeInputs) -> Setpoint:
        self._leg.update(inputs.nav)
        setpoint = self._at_hold_point(inputs)
        if self._leg.arrived:
            self._sailing.reported += 1
            self._complete(task.route[-1].seq, inputs)
        return setpoint

    def _go_round(self, task: Orbit, inputs: ModeInputs) -> Setpoint:
        speed_mps = self.way_speed_mps(inputs)
        progress = self._orbit.update(inputs.nav, speed_mps, inputs.dt_s)
        self._headway.update(progress.way_m, speed_mps, inputs.now_s)
        if progress.finished:
            self._complete(task.seq, inputs)
        return progress.setpoint

    def _stand(self, task: _Standing, inputs: ModeInputs) -> Setpoint:
        if self._at_berth:
            setpoint = self._docking.update(inputs)
        else:
            setpoint = self._at_hold_point(inputs)
        if not isinstance(task, SeaTrial) and self._is_done(task, setpoint, inputs):
            self._complete(task.seq, inputs)
        return setpoint

    def _at_hold_point(self, inputs: ModeInputs) -> Setpoint:
        setpoint = self._hold_point.update(inputs.nav, None, inputs.speed_mps, inputs.dt_s)
        if self._hold_point.way_m is not None:
            self._headway.update(self._hold_point.way_m, inputs.speed_mps, inputs.now_s)
        return setpoint

    def _is_done(self, task: _Ending, setpoint: Setpoint, inputs: ModeInputs) -> bool:
        match task:
            case Stay():
                return self._has_stayed(task, inputs)
            case Wait():
                if self._since_s is None or math.isinf(self._wait_s):
                    self._since_s = inputs.now_s
                    self._wait_s = task.wait_s(inputs.nav.time_unix_ns)
                return inputs.now_s - self._since_s >= self._wait_s
            case Turn():
                return self._is_turned(setpoint)
            case Dock():
                return not self._hold_point.going if self._landing else self.docked
            case ReturnHome():
                return self._way_home and not self._hold_point.going

    def _has_stayed(self, task: Stay, inputs: ModeInputs) -> bool:
        """Whether the time is over, and the bow has come to the heading that the item asks for."""
        if self._since_s is None and self._is_near(inputs):
            self._since_s = inputs.now_s
        if task.duration_s is None or self._since_s is None or inputs.now_s - self._since_s < task.duration_s:
            return False
        return task.yaw_rad is None or not self._can_sway or self._hold_point.arrived

    def _is_near(self, inputs: ModeInputs) -> bool:
        north_m, east_m = self._hold_point.target
        off_m = math.hypot(north_m - inputs.nav.north_m, east_m - inputs.nav.east_m)
        return not self._hold_point.in_transit and off_m <= self._parameters["NAV_ACC_RAD"]

    def _is_turned(self, setpoint: Setpoint) -> bool:
        if not self._can_sway or self._turn is None or not isinstance(setpoint, PoseSetpoint):
            return True
        if self._turning:
            self._hold_point.turn_to(self._turn.update(setpoint.yaw_rad))
            self._turning = not self._turn.in_last_step
            return False
        return self._hold_point.arrived

    def _far_off_m(self, point: RoutePoint, inputs: ModeInputs) -> float:
        """How far off a waypoint the boat passes it, abeam; 0 where that is near."""
        north_m, east_m = self._frame().to_ned(point.lat_deg, point.lon_deg)
        off_m = math.hypot(north_m - inputs.nav.north_m, east_m - inputs.nav.east_m)
        return off_m if off_m > _FAR_OFF * (point.radius_m or self._parameters["NAV_ACC_RAD"]) else 0.0

    def _complete(self, seq: int, inputs: ModeInputs, off_m: float = 0.0) -> None:
        """`off_m`: how far off its place, where that is to be said."""
        before = self._executor.progress.reached
        self._actions += self._executor.complete(seq)
        if self._executor.progress.reached != before and self._repeats.reached(seq, inputs.now_s):
            kind = TextKind.ATTENTION if off_m else TextKind.ROUTINE
            how = f"passed {off_m:.0f} m off" if off_m else "reached"
            self._events.say(inputs.now_s, kind, "item_reached", f"Mission item {item_number(seq)} {how}")
