"""What the vessel decides to be: answers requests, arms, watches for failures, and lets the active mode steer."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

from companion.config import VesselConfig
from companion.core.geodesy import LocalFrame, distance_and_bearing
from companion.core.types import (
    ACCEPTED,
    NEUTRAL_SETPOINT,
    ZERO_WRENCH,
    AisTarget,
    DeviceHealth,
    Home,
    Inputs,
    LeaderState,
    ManualInput,
    MissionState,
    ModeId,
    NavState,
    Outcome,
    Result,
    Setpoint,
    Severity,
    Status,
    Wrench,
)
from companion.mission.executor import MissionExecutor
from companion.mission.plan import Plans
from companion.modes import build_modes
from companion.modes.arming import arming_refusals
from companion.modes.auxiliary import AuxiliaryOutputs
from companion.modes.cruise import Cruise
from companion.modes.dock import DockMode
from companion.modes.events import EventLog
from companion.modes.fence_duty import FenceDuty
from companion.modes.fence_guard import FenceGuard
from companion.modes.follow_duty import FollowDuty
from companion.modes.helm import Helm
from companion.modes.hold import HoldMode
from companion.modes.homing import HomeKeeper, is_on_earth
from companion.modes.mission import FURTHEST_LEG_M, MissionMode
from companion.modes.mission_duty import MissionDuty
from companion.modes.mode import ModeInfo, ModeInputs
from companion.modes.nudges import Nudges
from companion.modes.offboard import OffboardMode
from companion.modes.offboard_target import OffboardTarget
from companion.modes.propulsion import lost_motions
from companion.modes.responder import Responder
from companion.modes.retraction import Retraction
from companion.modes.situation import NO_ESTIMATE, Situation, usable
from companion.modes.sticks import Sticks
from companion.modes.traffic_guard import TrafficGuard
from companion.nav.leader import LeaderTracker
from companion.nav.traffic import TrafficTracker
from companion.params import Parameters


class Supervisor:
    """Requests come in between ticks; once a tick `update` → Status, then `guide` → Setpoint. None of it ever raises.

    Remembers the newest estimate, inputs and device health, home, the speed asked for, the sticks, when a ground station was last heard,
    and through its parts the active mode, arming and failsafes. The boat starts disarmed and in Manual. Refusals are said as events too.
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
        self._config = config
        self._parameters = parameters
        self._executor = executor
        self._events = events
        self._frame_of = frame_of
        self._tracker = TrafficTracker(config.mmsi)
        self._leader = LeaderTracker(parameters)
        self._fence = FenceGuard(config, parameters, plans, events, frame_of)
        self._traffic = TrafficGuard(config, parameters, self._tracker, events, frame_of, self._fence)
        modes = build_modes(config, parameters, plans, executor, events, frame_of, self._fence)
        hold, mission, dock, offboard = (modes[mode] for mode in (ModeId.HOLD, ModeId.MISSION, ModeId.DOCK, ModeId.OFFBOARD))
        assert isinstance(hold, HoldMode) and isinstance(mission, MissionMode) and isinstance(dock, DockMode) and isinstance(offboard, OffboardMode)
        self._hold, self._mission, self._dock, self._offboard = hold, mission, dock, offboard
        self._cruise = Cruise(parameters)
        self.auxiliary = AuxiliaryOutputs(config, events)
        self._sticks = Sticks(parameters)
        self._home = HomeKeeper(events)
        self._helm = Helm(modes, self._sticks, events, self._mode_inputs)
        self.following = FollowDuty(parameters, self._helm, self._sticks, events, self.request_mode)
        self._mission_duty = MissionDuty(
            parameters, executor, mission, self._helm, self._home, self.auxiliary, self.following, events, self._cruise.ask
        )
        self._fence_duty = FenceDuty(self._fence, plans, self._helm, hold, mission, events)
        self._nudges = Nudges(config, parameters, self._helm, hold, events)
        self.retraction = Retraction(config, parameters, self._helm, events)
        self._responder = Responder(self._helm, hold, self._sticks, events, self._situation)
        self._monitor = self._responder.monitor
        self._bridges = frozenset(bridge.name for bridge in config.actuators)
        self._nav = NO_ESTIMATE
        self._inputs = Inputs()
        self._health: Sequence[DeviceHealth] = ()
        self._achieved = ZERO_WRENCH
        self._failed: frozenset[int] = frozenset()
        self._station_s: float | None = None
        self._guard_failure = ""
        self.modes = tuple(ModeInfo(mode.id, mode.selectable, mode.by_stick, mode.text) for mode in modes.values())

    @property
    def version(self) -> int:
        """Grows with every change of mode or arming."""
        return self._helm.version

    # --- what comes in between ticks -------------------------------------------------------------------------------

    def manual_input(self, manual: ManualInput) -> None:
        """Sticks of a ground station."""
        self._sticks.station_input(manual)

    def station_heard(self, system_id: int, now_s: float) -> None:
        """A ground station is there."""
        self._station_s = now_s

    def traffic_heard(self, report: AisTarget, now_s: float) -> None:
        """A report of another vessel, from a receiver or another system."""
        nav = self._nav
        self._tracker.take(report, now_s, (nav.lat_deg, nav.lon_deg) if nav.position_valid else None)

    def leader_heard(self, state: LeaderState) -> None:
        """A message of a lead boat."""
        counts = self._leader.take(state)
        self.following.heard(state, counts)
        if counts and self.following.stands_for_station(state):
            self._station_s = state.heard_s

    def offboard_setpoint(self, target: OffboardTarget, now_s: float) -> str | None:
        """From another computer, which in Offboard stands for a ground station; why it is not obeyed, or None."""
        reason = self._offboard.take(target, self._nav, now_s)
        if reason is None and self._helm.mode is self._offboard:
            self._station_s = now_s
        return reason

    def offboard_fault(self, now_s: float) -> str | None:
        """Why there is nothing to steer by in Offboard, or None."""
        return self._offboard.fault(now_s)

    def thrust_achieved(self, achieved: Wrench) -> None:
        """What the thrusters give in this cycle, as the allocation says."""
        self._achieved = achieved

    def thruster_failed(self, index: int, failed: bool) -> None:
        """A thruster has failed, or is well again."""
        self._failed = self._failed | {index} if failed else self._failed - {index}

    def request_mode(self, mode: ModeId, now_s: float) -> Outcome:
        """Choose a mode, armed or not; it never arms. The present mode again: Hold gives up a go-to, a mission that has ended starts over."""
        chosen = self._helm.modes[mode]
        reason = self._switch_forbids(mode, now_s) or self._helm.choice_refusal(mode, self._nav, now_s)
        if reason is None and self._helm.mode is chosen:
            reason = self._same_mode(now_s)
        elif reason is None:
            reason = self._helm.switch(mode, self._nav, now_s)
        if reason is not None:
            return self._refuse(Result.TEMPORARILY_REJECTED, f"{mode.value} refused: {reason}", now_s)
        self._taken_over(now_s)
        return ACCEPTED

    def arm(self, now_s: float, force: bool = False) -> Outcome:
        """`force` passes over the checks, but cannot enter a mode that cannot be."""
        if self._helm.armed:
            return ACCEPTED
        situation = self._situation(now_s)
        reasons: tuple[str, ...] = () if force else arming_refusals(situation)
        if not reasons and situation.mode_refusal is not None:
            reasons = (f"{situation.mode.id.value}: {situation.mode_refusal}",)
        if not reasons and (reason := self._helm.arm(now_s)) is not None:
            reasons = (f"{situation.mode.id.value}: {reason}",)
        if reasons:
            for reason in reasons:
                self._events.say(now_s, Severity.WARNING, "arming_refused", f"PreArm: {reason}")
            return Outcome(Result.TEMPORARILY_REJECTED, "; ".join(reasons))
        if self._parameters["HOME_ON_ARM"]:
            self._home.set_here(self._nav, now_s)
        self._monitor.override()
        self._events.say(now_s, Severity.NOTICE, "armed", "Armed by force" if force else "Armed")
        return ACCEPTED

    def disarm(self, now_s: float, force: bool = False) -> Outcome:
        """Always possible, also under way: the thrusters stop. `force` changes nothing."""
        if self._helm.armed:
            self._helm.disarm(now_s)
            self._cruise.ask(None)
            self._events.say(now_s, Severity.NOTICE, "disarmed", "Disarmed")
        return ACCEPTED

    def terminate(self, now_s: float) -> Outcome:
        """Neutral and disarmed at once."""
        self._events.say(now_s, Severity.CRITICAL, "terminated", "Terminated: thrusters stopped")
        return self.disarm(now_s, force=True)

    def go_to(self, lat_deg: float, lon_deg: float, yaw_rad: float | None, speed_mps: float | None, now_s: float) -> Outcome:
        """Hold, at that point. A yaw that is None or not a number: as the boat arrives; likewise a speed: as on missions."""
        if not is_on_earth(lat_deg, lon_deg):
            return self._refuse(Result.DENIED, "Go-to refused: not a position", now_s)
        if not self._helm.armed:
            return self._refuse(Result.TEMPORARILY_REJECTED, "Go-to refused: arm first", now_s)
        reason = self._switch_forbids(ModeId.HOLD, now_s) or self._helm.refusal(ModeId.HOLD, self._nav, now_s)
        if reason is not None:
            return self._refuse(Result.TEMPORARILY_REJECTED, f"Go-to refused: {reason}", now_s)
        distance_m, _ = distance_and_bearing(self._nav.lat_deg, self._nav.lon_deg, lat_deg, lon_deg)
        if distance_m > FURTHEST_LEG_M:
            return self._refuse(Result.DENIED, f"Go-to refused: {distance_m / 1000.0:.0f} km away", now_s)
        north_m, east_m = self._frame_of().to_ned(lat_deg, lon_deg)
        if (reason := self._fence.go_refusal(self._nav, north_m, east_m)) is not None:
            return self._refuse(Result.DENIED, f"Go-to refused: {reason}", now_s)
        if self._helm.mode is not self._hold and (reason := self._helm.switch(ModeId.HOLD, self._nav, now_s)) is not None:
            return self._refuse(Result.TEMPORARILY_REJECTED, f"Go-to refused: {reason}", now_s)
        self._taken_over(now_s)
        yaw_rad = yaw_rad if yaw_rad is not None and math.isfinite(yaw_rad) else None

        def go() -> None:
            self._hold.go_to(self._nav, north_m, east_m, yaw_rad, self._cruise.limited(speed_mps))

        if (reason := self._helm.guarded(self._hold, go, now_s)) is not None:
            return self._refuse(Result.FAILED, f"Go-to {reason}", now_s)
        self._events.say(now_s, Severity.INFO, "go_to", f"Going to a point {distance_m:.0f} m away")
        return ACCEPTED

    def hold_here(self, now_s: float) -> Outcome:
        """Hold at the present place; what is held already stays as it is, a go-to is given up."""
        return self.request_mode(ModeId.HOLD, now_s)

    def nudge(self, forward_m: float, starboard_m: float, turn_rad: float, now_s: float) -> Outcome:
        """In Hold: move what is held, as the held heading has it."""
        return self._nudges.nudge(forward_m, starboard_m, turn_rad, self._nav, now_s)

    def set_heading(self, yaw_rad: float, now_s: float) -> Outcome:
        """In Hold: hold this heading at the same point."""
        return self._nudges.head(yaw_rad, self._nav, now_s)

    def lower_thrusters(self, lower: bool, now_s: float) -> Outcome:
        """Retractable thrusters down, or up, which only Manual and a disarmed boat allow."""
        return self.retraction.request(lower, now_s)

    def start_mission(self, first: int | None, now_s: float) -> Outcome:
        """Mission mode, from item `first` where that is given. Starts when armed; does not arm."""
        if first is not None and (outcome := self.set_current(first, True, now_s)) != ACCEPTED:
            return outcome
        return self.request_mode(ModeId.MISSION, now_s)

    def pause(self, now_s: float) -> Outcome:
        """From any self-steered mode: hold here. A mission keeps its place."""
        if self._helm.mode.by_stick:
            return self._refuse(Result.TEMPORARILY_REJECTED, f"Pause refused: {self._helm.mode.id.value} is steered by stick", now_s)
        return self.hold_here(now_s)

    def resume(self, now_s: float) -> Outcome:
        """Back to a mission that was paused."""
        if self._helm.mode is self._mission:
            return self.request_mode(ModeId.MISSION, now_s)
        if self._executor.progress.state is not MissionState.PAUSED:
            return self._refuse(Result.TEMPORARILY_REJECTED, "Resume refused: no paused mission", now_s)
        return self.request_mode(ModeId.MISSION, now_s)

    def set_current(self, seq: int, reset: bool, now_s: float) -> Outcome:
        """Make `seq` the mission's current item, under way or not."""
        reason = self._executor.set_current(seq, reset)
        if reason is not None:
            return self._refuse(Result.DENIED, f"Mission item {seq} refused: {reason}", now_s)
        return ACCEPTED

    def change_speed(self, speed_mps: float | None, now_s: float) -> Outcome:
        """Speed of self-steered modes until the mission changes it or the boat is disarmed; None: WP_SPEED. Capped by MPC_XY_VEL_MAX."""
        if speed_mps is not None and not (math.isfinite(speed_mps) and speed_mps > 0.0):
            return self._refuse(Result.DENIED, f"Speed {speed_mps:g} m/s refused: it must be above 0", now_s)
        self._cruise.ask(speed_mps)
        self._hold.drop_speed()
        limited = self._cruise.asked_mps != speed_mps
        text = f"Speed {self._cruise.speed_mps:.2f} m/s" + (", the most MPC_XY_VEL_MAX allows" if limited else "")
        self._events.say(now_s, Severity.INFO, "speed_changed", text)
        return ACCEPTED

    def set_home(self, home: Home | None, now_s: float) -> Outcome:
        """None: home is where the boat is."""
        if home is None and not self._home.set_here(self._nav, now_s):
            return self._refuse(Result.TEMPORARILY_REJECTED, "Home refused: position not valid", now_s)
        if home is not None and not self._home.set(home, now_s):
            return self._refuse(Result.DENIED, "Home refused: not a position", now_s)
        return ACCEPTED

    def status(self, now_s: float) -> Status:
        """As the vessel stands at this moment."""
        helm = self._helm
        return Status(
            t_s=now_s,
            mode=helm.mode.id,
            intended_mode=helm.intended.id,
            armed=helm.armed,
            arming_refusals=() if helm.armed else arming_refusals(self._situation(now_s)),
            failsafes=self._monitor.names,
            home=self._home.home,
            mission=self._executor.progress,
            speed_override_mps=self._cruise.asked_mps,
            fence=self._fence.state,
            traffic=self._tracker.targets,
            leader=self._leader.leader(self._frame_of(), now_s),
        )

    # --- once a tick -----------------------------------------------------------------------------------------------

    def update(self, nav: NavState, inputs: Inputs, health: Sequence[DeviceHealth], now_s: float) -> Status:
        """Look at everything, act on failures, and say what the vessel is. `health`: of every sensor and bridge."""
        self._nav, self._inputs, self._health = usable(nav), inputs, health
        self._tracker.update(now_s)
        self._mission_duty.restore(now_s)
        self._home.update(self._nav, now_s)
        self._sticks.update(inputs.rc, now_s)
        self._obey_safe_switch(now_s)
        self._fence.update(self._nav, self._helm.mode, self._helm.armed, now_s)
        self._fence_duty.update(self._mode_inputs(now_s, 0.0))
        self.following.update(self._mode_inputs(now_s, 0.0))
        self._responder.update(now_s)
        self.retraction.update(inputs.rc, now_s)
        self._mission_duty.tell_of_new_plan(now_s)
        return self.status(now_s)

    def guide(self, nav: NavState, now_s: float, dt_s: float) -> Setpoint:
        """What the boat should do now: neutral while disarmed or kept still, else the active mode's setpoint."""
        self._nav = usable(nav)
        helm = self._helm
        if not helm.armed or helm.stopped or self._monitor.neutral:
            self._traffic.rest()
            return NEUTRAL_SETPOINT
        inputs = self._mode_inputs(now_s, dt_s)
        setpoint = helm.guide(inputs)
        if helm.mode is self._mission:
            self._mission_duty.after(self._nav, now_s)
        if setpoint is None or helm.stopped:
            return NEUTRAL_SETPOINT
        return self._guarded(setpoint, inputs)

    def _guarded(self, setpoint: Setpoint, inputs: ModeInputs) -> Setpoint:
        """Clear of traffic and inside the fence. Where minding them fails that is said and the boat holds; what is held, or steered by stick,
        goes on without."""
        helm, now_s = self._helm, inputs.now_s
        try:
            steered = self._traffic.steer(setpoint, helm.mode, inputs)
            return self._fence.limited(steered, self._nav, self._cruise.speed_mps, now_s)
        except Exception as error:  # noqa: BLE001  whatever is wrong there, the boat must not be without a helm
            text = f"Fence and traffic not minded ({type(error).__name__}: {error})"
            if text != self._guard_failure:
                self._guard_failure = text
                self._events.say(now_s, Severity.CRITICAL, "guard_failed", text)
            if helm.mode.by_stick or helm.mode is self._hold:
                return setpoint
            if helm.switch(ModeId.HOLD, self._nav, now_s, intended=False) is not None:
                helm.stop()
            return NEUTRAL_SETPOINT

    # --- parts of requests -----------------------------------------------------------------------------------------

    def _refuse(self, result: Result, text: str, now_s: float) -> Outcome:
        self._events.say(now_s, Severity.WARNING, "refused", text)
        return Outcome(result, text)

    def _switch_forbids(self, mode: ModeId, now_s: float) -> str | None:
        """The transmitter's safe switch allows Manual only, while the transmitter is heard."""
        if not self._sticks.safe_switch or mode is ModeId.MANUAL:
            return None
        return "safe switch of the transmitter is on" if self._sticks.transmitter_live(now_s) else None

    def _same_mode(self, now_s: float) -> str | None:
        helm = self._helm
        helm.intended = helm.mode
        if not helm.armed:
            return None
        if helm.mode is self._hold:
            if self._hold.going:
                self._hold.hold_here(self._nav)
            return None
        if helm.mode is self._mission and self._executor.progress.state is not MissionState.ACTIVE:
            return helm.enter_again(now_s)
        if helm.mode is self._dock and self._dock.given_up:
            return helm.enter_again(now_s)
        return None

    def _taken_over(self, now_s: float) -> None:
        """A person has decided: failsafes that last have had their turn, and thrust is free again."""
        if self._sticks.safe_switch and not self._sticks.transmitter_live(now_s):
            self._sticks.release_switch()
        if self._helm.armed and (self._monitor.neutral or self._helm.stopped):
            self._helm.resume(now_s)
        self._monitor.override()
        self.following.taken_over(now_s)

    def _mode_inputs(self, now_s: float, dt_s: float) -> ModeInputs:
        sticks, home, up = self._sticks.obeyed(now_s), self._home.home, self.retraction.up
        leader = self._leader.leader(self._frame_of(), now_s)
        fault, station = self.following.fault(self._nav, now_s), self.following.station
        return ModeInputs(
            self._nav, sticks, home, self._cruise.speed_mps, now_s, dt_s, self._achieved, self._failed, up, leader, fault, station
        )

    def _situation(self, now_s: float) -> Situation:
        helm = self._helm
        return Situation(
            now_s=now_s,
            nav=self._nav,
            inputs=self._inputs,
            bridges={device.name: device for device in self._health if device.name in self._bridges},
            sensors={device.name: device for device in self._health if device.name not in self._bridges},
            parameters=self._parameters,
            armed=helm.armed,
            mode=helm.mode,
            intended=helm.intended,
            mode_refusal=None if helm.armed else helm.refusal(helm.mode.id, self._nav, now_s),
            sticks_age_s=self._sticks.age_s(now_s) if self._sticks.heard else None,
            station_age_s=None if self._station_s is None else now_s - self._station_s,
            safe_switch=self._sticks.safe_switch,
            failed_thrusters=tuple([self._config.thrusters[i].name for i in sorted(self._failed)]) if self._failed else (),
            lost_motions=lost_motions(self._config.thrusters, self._failed),
            fence=self._fence.cause,
            leader=self.following.sight(self._nav, now_s),
            offboard=self._offboard.fault(now_s),
        )

    # --- parts of a tick -------------------------------------------------------------------------------------------

    def _obey_safe_switch(self, now_s: float) -> None:
        helm = self._helm
        if helm.mode.id is ModeId.MANUAL or not self._sticks.safe_switch or not self._sticks.transmitter_live(now_s):
            return
        self._events.say(now_s, Severity.WARNING, "safe_switch", "Safe switch of the transmitter: Manual")
        helm.switch(ModeId.MANUAL, self._nav, now_s)
        self._monitor.override()
