"""Decide: once a tick, what the vessel is and what it should do. Requests that come between ticks are in
`requests.py`."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from companion.config.vessel import VesselConfig
from companion.core.actuation import Auxiliary, Wrench
from companion.core.arming import ArmingReport
from companion.core.decision import ACCEPTED, ModeId, ModeInputs, Outcome, Status, TextKind
from companion.core.estimate import NavState, Rig, usable
from companion.core.events import EventLog
from companion.core.geodesy import LocalFrame
from companion.core.readings import AisTarget, GnssFix, LeaderState, ManualInput, RcInput, RelativeFix
from companion.core.setpoint import NEUTRAL_SETPOINT, HeadingSetpoint, Setpoint, WrenchSetpoint, desired_motion
from companion.core.tick import DeviceHealth, Inputs
from companion.mission.executor import MissionExecutor
from companion.mission.plan import Plans
from companion.modes.mode import ModeInfo
from companion.modes.parts.offboard_target import OffboardTarget
from companion.modes.rtl import ReturnByTrack
from companion.modes.trial.mode import COMPLETE
from companion.obstacles.surroundings import Heard, Surroundings
from companion.params.store import Parameters
from companion.params.transmitter import AuxFunction
from companion.supervisor.arming import arming_refusals, arming_report
from companion.supervisor.authority import AuthorityRequest, Facts, RequestedAction, Right
from companion.supervisor.aux_functions import AuxFunctions
from companion.supervisor.channels import calibrated
from companion.supervisor.guided import Guided
from companion.supervisor.landing import Landing
from companion.supervisor.mode_changes import Cause
from companion.supervisor.parts import SupervisorParts
from companion.supervisor.requests import Requests
from companion.supervisor.situation import estimate_refusal
from companion.supervisor.switches import SwitchOrder

_MARKED_RESISTANCE = 2.0  # to turns, of the file's: worth telling people


class Supervisor(Requests):
    """Requests and messages come in between ticks; once a tick `update` → Status, then `guide` → Setpoint. None of it
    raises.

    Remembers its parts, the desired speed, and the last failure of fence and traffic guards. The boat starts disarmed
    and in Manual.
    """

    def __init__(
        self,
        config: VesselConfig,
        parameters: Parameters,
        plans: Plans,
        executor: MissionExecutor,
        events: EventLog,
        frame_of: Callable[[], LocalFrame],
    ) -> None:
        """`frame_of()`: the local plane of the estimate."""
        super().__init__(SupervisorParts(config, parameters, plans, executor, events, frame_of, self._choose))
        parts = self.parts
        self.auxiliary, self.following, self.retraction = parts.auxiliary, parts.following, parts.retraction
        self.payload = parts.payload
        self.ground_stations = parts.ground_stations
        self.calibration, self.motor_test = parts.calibration, parts.motor_test
        self.senses, self.trial_duty = parts.senses, parts.trial_duty
        modes = parts.helm.modes.values()
        self.modes = tuple(ModeInfo(mode.declaration, mode.text) for mode in modes)
        self._monitor = parts.responder.monitor
        self._aux = AuxFunctions(parts, self, plans)
        self.mission_edits = self._aux.mission_edits
        self.landing, self.guided = Landing(self), Guided(self)
        self._guard_failure = ""
        self._said_resistance = False
        self._desired_mps: float | None = 0.0  # speed ahead, of the last setpoint; None: it asks for forces

    @property
    def version(self) -> int:
        """Grows with every change of mode or arming."""
        return self._helm.version

    @property
    def mode_cause(self) -> Cause | None:
        """Why the mode changed last, or thrust was stopped; None before that."""
        return self._helm.cause

    # --- what comes in between ticks -------------------------------------------------------------------------------

    def manual_input(self, manual: ManualInput) -> None:
        """Sticks of the ground station that steers (`Action.GROUND_STICKS`)."""
        self.parts.sticks.ground_station_input(manual)

    def ground_station_heard(self, now_s: float) -> None:
        """A message of a ground station has come."""
        self.ground_stations.heard(now_s)

    def traffic_heard(self, report: AisTarget, now_s: float) -> None:
        """A report of another vessel, from a receiver or another system."""
        nav = self.parts.nav
        self.parts.traffic.take(report, now_s, (nav.lat_deg, nav.lon_deg) if nav.position_valid else None)

    @property
    def surroundings(self) -> Surroundings:
        """What ranging sensors see around the boat."""
        return self.parts.surroundings

    def obstacle_heard(self, reading: Heard, now_s: float) -> None:
        """Ranges, a radar target or a depth ahead, from a sensor or another system."""
        self.parts.surroundings.take(reading, now_s)

    def leader_heard(self, state: LeaderState) -> None:
        """A message of a lead boat. It is ignored unless that boat leads."""
        system, now_s = state.system_id, state.heard_s
        leads = self.refusal(AuthorityRequest(RequestedAction.LEADER_POSITION, Right.LEAD_BOAT, system), now_s) is None
        if leads:
            self.parts.leader.take(state)
        self.following.heard(state, leads)
        if leads and self.refusal(AuthorityRequest(RequestedAction.STAND_IN, Right.LEAD_BOAT, system), now_s) is None:
            self.ground_stations.heard(now_s)

    def place_heard(self, reading: GnssFix | RelativeFix, now_s: float) -> None:
        """A fix of a receiver aboard, or its vector from a moving base on the lead boat."""
        self.parts.relative.take(reading)

    def offboard_setpoint(self, target: OffboardTarget, now_s: float, guided: bool = False) -> str | None:
        """A setpoint of another computer. Returns why it is refused, or None. `guided`: its sender knows Offboard as
        Guided, which may wait for it."""
        if guided and self.guided.goes_to(target, now_s):
            return None
        reason = self.parts.offboard.take(target, self.parts.nav, now_s, slow=guided)
        if guided and reason is None:
            self.guided.taken(now_s)
        if reason is None and self.refusal(AuthorityRequest(RequestedAction.STAND_IN, Right.OFFBOARD), now_s) is None:
            self.ground_stations.heard(now_s)
        return reason

    def offboard_fault(self, now_s: float) -> str | None:
        """Why Offboard has no setpoint to steer by, or None."""
        return self.parts.offboard.silence(now_s)

    def limit_offboard(self, most_s: float | None, most_m: float | None) -> Outcome:
        """Limits of this stay in Offboard, or of the next one: time, and distance from where it began; None: none."""
        self.parts.offboard.limits.set(most_s, most_m)
        return ACCEPTED

    def thrust_achieved(self, achieved: Wrench, demanded: Wrench | None = None) -> None:
        """The wrench that the thrusters give in this cycle, from the allocation, and the one that was demanded; None:
        the same."""
        self.parts.achieved, self.parts.demanded = achieved, achieved if demanded is None else demanded

    def steers_late(self, by_s: float) -> None:
        """The boat answers its helm later by that than its file says."""
        self.parts.steers_late_s = by_s

    def turns_against(self, resistance: float, now_s: float) -> None:
        """The water resists a turn so many times as hard as the vessel's file says. Where it is markedly so, that is
        said, once."""
        parts = self.parts
        parts.turn_resistance = resistance
        if resistance >= _MARKED_RESISTANCE and not self._said_resistance:
            self._said_resistance = True
            text = f"Yaw damping is {resistance:.1f} times the vessel file's"
            parts.events.say(now_s, TextKind.ROUTINE, "turn_resistance", text)

    def thruster_failed(self, index: int, failed: bool) -> None:
        """A thruster has failed, or works again."""
        parts = self.parts
        parts.failed = parts.failed | {index} if failed else parts.failed - {index}

    # --- what others ask -------------------------------------------------------------------------------------------

    def refusal(self, request: AuthorityRequest, now_s: float) -> str | None:
        """Why `request` is refused now; "" where it is ignored, None where it is obeyed (`authority.py`)."""
        return self.parts.refusal(request, now_s)

    def facts(self, now_s: float) -> Facts:
        """What it depends on now who is obeyed."""
        return self.parts.facts(now_s)

    @property
    def armed(self) -> bool:
        """Whether the boat is armed."""
        return self._helm.armed

    def status(self, now_s: float) -> Status:
        """The vessel at this moment."""
        parts, helm = self.parts, self._helm
        return Status(
            t_s=now_s,
            mode=helm.mode.id,
            intended_mode=helm.intended.id,
            armed=helm.armed,
            arming_refusals=() if helm.armed else arming_refusals(parts.situation(now_s)),
            failsafes=self._monitor.names,
            home=parts.home.home,
            mission=parts.executor.progress,
            speed_override_mps=parts.cruise.asked_mps,
            fence=parts.fence.state,
            traffic=parts.traffic.targets,
            leader=parts.leader_now(now_s),
            orbit=helm.mode.orbit if helm.armed else None,
            landed=self.landing.landed,
            trial_left_s=parts.trial.time_left_s if helm.armed else None,
            guided=self.guided.shown,
        )

    def arming_report(self, now_s: float) -> ArmingReport:
        """What speaks now against arming and against each mode. It asks every mode, so not in every tick."""
        parts, helm = self.parts, self._helm
        inputs = parts.mode_inputs(now_s, 0.0)
        refusals = {mode: self._mode_refusal(mode, inputs) for mode in helm.modes}
        return arming_report(parts.situation(now_s), helm.modes, refusals)

    def mode_refusals(self, now_s: float) -> Mapping[ModeId, str | None]:
        """Why each mode cannot be chosen and entered now; None where it can. Not in every tick, as `arming_report`."""
        forbidden = {
            m: self.refusal(AuthorityRequest(RequestedAction.CHANGE_MODE, mode=m), now_s) for m in self._helm.modes
        }
        inputs = self.parts.mode_inputs(now_s, 0.0)
        return {mode: reason or self._mode_refusal(mode, inputs) for mode, reason in forbidden.items()}

    def _mode_refusal(self, mode: ModeId, inputs: ModeInputs) -> str | None:
        """Why the mode cannot be entered; None for the one that steers now. A mode that fails at it says so."""
        helm = self._helm
        if helm.armed and not helm.stopped and helm.mode.id is mode:
            return None
        try:
            return helm.refusal_with(mode, self.parts.nav, inputs)
        except Exception as error:  # noqa: BLE001  a list for people must not stop the boat
            return f"failed ({type(error).__name__}: {error})"

    # --- once a tick -----------------------------------------------------------------------------------------------

    def update(self, nav: NavState, inputs: Inputs, health: Sequence[DeviceHealth], now_s: float) -> Status:
        """Look at everything and act on failures. `health`: of every sensor and bridge."""
        parts = self.parts
        parts.nav, parts.inputs, parts.health = usable(nav), inputs, health
        parts.traffic.update(now_s)
        parts.distress.update(parts.traffic.targets, parts.nav, now_s)
        parts.see_leader(now_s)
        parts.surroundings.update(parts.nav, inputs.depth, now_s)
        parts.mission_duty.restore(now_s)
        parts.home.update(parts.nav, now_s)
        parts.standstill.update(now_s)
        parts.unmeasured.update(parts.nav, self._helm.armed, now_s)
        rc = calibrated(inputs.rc, parts.parameters)
        if parts.sticks.update(rc, now_s):
            self._helm.sticks_taken_over(now_s)
        self._obey_switches(rc, now_s)
        self._obey_safe_switch(now_s)
        parts.fence.update(parts.nav, self._helm.mode, self._helm.armed, now_s)
        parts.fence_duty.update(parts.mode_inputs(now_s, 0.0))
        parts.following.update(parts.mode_inputs(now_s, 0.0))
        parts.watch_hull(self._desired_mps, now_s)
        parts.responder.update(now_s)
        self.landing.update(now_s)
        parts.retraction.update(rc, now_s)
        parts.trial_duty.update(now_s)
        parts.mission_duty.tell_of_new_plan(now_s)
        parts.outlook.update(parts.nav, inputs.battery, now_s)
        return self.status(now_s)

    def guide(self, nav: NavState, now_s: float, dt_s: float) -> Setpoint:
        """The active mode's setpoint; neutral while disarmed, or while a failsafe or a failure stops the thrusters."""
        setpoint = self._guide(nav, now_s, dt_s)
        by_force = isinstance(setpoint, WrenchSetpoint | HeadingSetpoint)
        self._desired_mps = None if by_force else desired_motion(setpoint).surge_mps
        return setpoint

    def _guide(self, nav: NavState, now_s: float, dt_s: float) -> Setpoint:
        parts, helm = self.parts, self._helm
        parts.nav = usable(nav)
        if not helm.armed or self._stopped or self._monitor.neutral:
            parts.traffic_guard.reset()
            parts.obstacles.reset()
            return NEUTRAL_SETPOINT
        inputs = parts.mode_inputs(now_s, dt_s)
        setpoint = helm.guide(inputs)
        if helm.mode is parts.mission:
            parts.mission_duty.after(parts.nav, now_s)
        if helm.mode is parts.trial and parts.trial.ended is not None:
            if parts.trial.ended == COMPLETE:
                parts.trial_duty.completed(now_s)
            parts.mission_duty.trial_ended(parts.trial.ended, inputs)
            return NEUTRAL_SETPOINT
        if setpoint is None or self._stopped:
            return NEUTRAL_SETPOINT
        return self._guarded(setpoint, inputs)

    @property
    def _stopped(self) -> bool:
        """Whether the boat gets no thrust. One that waits for its leader stands by, as long as it knows where it is."""
        parts, helm = self.parts, self._helm
        return helm.stopped and not (parts.following.awaits and estimate_refusal(helm.mode, parts.nav) is None)

    @property
    def rig(self) -> Rig | None:
        """What drives a boat with a sail; None for another boat."""
        return None if self.parts.sailor is None else self.parts.sailor.rig

    def outputs(self, now_s: float, dt_s: float) -> Auxiliary:
        """Servos and relays now, after the pictures that are due."""
        parts, helm = self.parts, self._helm
        mission_runs = helm.armed and helm.mode is parts.mission and not helm.stopped
        parts.payload.update(parts.nav, helm.armed, mission_runs, now_s, dt_s)
        return parts.auxiliary.update(helm.armed, now_s)

    def _guarded(self, setpoint: Setpoint, inputs: ModeInputs) -> Setpoint:
        """The setpoint, clear of traffic and obstacles and inside the fence. If a guard fails, that is announced and
        the boat holds; Hold and modes steered by stick go on unguarded."""
        parts, helm, now_s = self.parts, self._helm, inputs.now_s
        try:
            steered = parts.traffic_guard.steer(setpoint, helm.mode, inputs)
            unasked = helm.mode is not helm.intended
            steered = parts.obstacles.steer(steered, helm.mode, inputs, parts.traffic_guard, unasked)
            if parts.obstacles.impossible is not None:
                self._give_up(parts.obstacles.impossible, now_s)
            if parts.sailor is not None:
                steered = parts.sailor.steer(steered, parts.nav, now_s, inputs.dt_s)
            return parts.fence.limited(steered, helm.mode, parts.nav, parts.cruise.speed_mps, now_s)
        except Exception as error:  # noqa: BLE001  whatever is wrong there, the boat must not be without a helm
            text = f"Fence and obstacles not guarded ({type(error).__name__}: {error})"
            if text != self._guard_failure:
                self._guard_failure = text
                self._events.say(now_s, TextKind.ALARM, "guard_failed", text)
            if helm.mode.by_stick or helm.mode is parts.hold:
                return setpoint
            if helm.switch(ModeId.HOLD, parts.nav, now_s, Cause.GUARD_FAILED) is not None:
                helm.stop(Cause.GUARD_FAILED)
            return NEUTRAL_SETPOINT

    def _give_up(self, reason: str, now_s: float) -> None:
        """No way leads round the obstacles: hold here."""
        parts, helm = self.parts, self._helm
        parts.obstacles.reset()
        self._events.say(now_s, TextKind.ALARM, "obstacle_stops", f"{helm.mode.id.value} impossible: {reason}"[:50])
        if helm.mode is parts.hold:
            parts.hold.hold_here(parts.nav)
        elif helm.switch(ModeId.HOLD, parts.nav, now_s, Cause.OBSTACLE) is not None:
            helm.stop(Cause.OBSTACLE)

    def _obey_switches(self, rc: RcInput | None, now_s: float) -> None:
        """What the transmitter's switches and its yaw stick ask for; while its kill switch is on the boat is
        disarmed."""
        switches = self.parts.switches
        for order in switches.update(rc, now_s):
            self._obey(order, now_s)
        if (gesture := self._aux.update(now_s)) is not None:
            self._obey(SwitchOrder(gesture), now_s)
        if switches.killed:
            self.disarm(now_s)

    def _obey(self, order: SwitchOrder, now_s: float) -> None:
        if order.mode is not None:
            how = ReturnByTrack() if order.function is AuxFunction.SMART_RTL else None
            self._choose(order.mode, now_s, Cause.TRANSMITTER, how)
        elif order.action is RequestedAction.ARM:
            self.arm(now_s, right=Right.TRANSMITTER)
        elif order.action is RequestedAction.DISARM:
            self.disarm(now_s)
        else:
            self._aux.switched(order.function, order.on, now_s)

    def _obey_safe_switch(self, now_s: float) -> None:
        """A mode that the safe switch forbids is left for Manual."""
        helm = self._helm
        if not self.parts.sticks.safe_switch:
            return
        if self.refusal(AuthorityRequest(RequestedAction.CHANGE_MODE, mode=helm.mode.id), now_s) is None:
            return
        self._events.say(now_s, TextKind.ATTENTION, "safe_switch", "Safe switch of the transmitter: Manual")
        helm.switch(ModeId.MANUAL, self.parts.nav, now_s, Cause.SAFE_SWITCH)
        self._monitor.override()
