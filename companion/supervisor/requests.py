"""What people ask of the boat between two ticks. Each request returns an outcome; a refusal is an event too."""

from __future__ import annotations

import math

from companion.config.reversing import stern_first_refusal
from companion.core.decision import ACCEPTED, Home, MissionState, ModeId, Order, Outcome, Result, TextKind
from companion.core.geodesy import distance_and_bearing
from companion.mission.plan import item_number
from companion.modes.mode import FURTHEST_LEG_M
from companion.supervisor.arming import arming_refusals
from companion.supervisor.authority import AuthorityRequest, RequestedAction, Right
from companion.supervisor.homing import is_on_earth
from companion.supervisor.mode_changes import Cause
from companion.supervisor.parts import SupervisorParts

_RIGHTS = {Cause.LEAD_BOAT: Right.LEAD_BOAT, Cause.TRANSMITTER: Right.TRANSMITTER}


class Requests:
    """Remembers nothing itself; what a request changes is in `parts`. None of it raises."""

    def __init__(self, parts: SupervisorParts) -> None:
        self.parts = parts
        self._helm = parts.helm
        self._events = parts.events

    # --- modes -----------------------------------------------------------------------------------------------------

    def request_mode(self, mode: ModeId, now_s: float, order: Order | None = None) -> Outcome:
        """Choose a mode, armed or not; it never arms. The present mode again: Hold gives up a go-to, a mission that has
        ended starts over. `order`: how the mode is to be sailed; a boat that is disarmed forgets it."""
        return self._choose(mode, now_s, Cause.OPERATOR, order)

    def _choose(self, mode: ModeId, now_s: float, cause: Cause, order: Order | None = None) -> Outcome:
        self._helm.order = order
        outcome = self._choose_mode(mode, now_s, cause)
        self._helm.order = None
        return outcome

    def _choose_mode(self, mode: ModeId, now_s: float, cause: Cause) -> Outcome:
        helm, nav = self._helm, self.parts.nav
        reason = self._forbidden(mode, now_s, cause) or helm.choice_refusal(mode, nav, now_s)
        if reason is None and helm.mode is helm.modes[mode]:
            reason = self._same_mode(now_s)
        elif reason is None:
            reason = helm.switch(mode, nav, now_s, cause)
        if reason is not None:
            return self._refuse(Result.TEMPORARILY_REJECTED, f"{mode.value} refused: {reason}", now_s)
        self._taken_over(now_s)
        return ACCEPTED

    def give_order(self, order: Order, now_s: float) -> Outcome:
        """Choose the mode that the order is for, armed only; the mode carries the order out."""
        if not self._helm.armed:
            text = f"{order.mode.value} refused: arm first"
            return self._refuse(Result.TEMPORARILY_REJECTED, text, now_s)
        return self.request_mode(order.mode, now_s, order)

    def hold_here(self, now_s: float) -> Outcome:
        """Hold at the present place. A boat that holds already goes on; it gives up a go-to."""
        return self.request_mode(ModeId.HOLD, now_s)

    def pause(self, now_s: float) -> Outcome:
        """From any self-steered mode: hold here. A mission keeps its place."""
        mode = self._helm.mode
        if mode.by_stick:
            text = f"Pause refused: {mode.id.value} is steered by stick"
            return self._refuse(Result.TEMPORARILY_REJECTED, text, now_s)
        return self.hold_here(now_s)

    # --- arming ----------------------------------------------------------------------------------------------------

    def arm(self, now_s: float, force: bool = False, right: Right = Right.GROUND_STATION) -> Outcome:
        """`force` skips the checks, but not the kill switch, and cannot enter a mode that refuses. `right`: of the one
        who arms. A motor test ends."""
        if self._helm.armed:
            return ACCEPTED
        self.parts.motor_test.stop(None, now_s)
        situation = self.parts.situation(now_s)
        reasons = arming_refusals(situation, right, force)
        if not reasons and (reason := self._enter_armed(now_s)) is not None:
            reasons = (f"{situation.mode.id.value}: {reason}",)
        if reasons:
            for reason in reasons:
                self._events.say(now_s, TextKind.REFUSAL, "arming_refused", f"PreArm: {reason}")
            return Outcome(Result.TEMPORARILY_REJECTED, "; ".join(reasons))
        self.parts.responder.monitor.arming(situation)
        self._events.renew("disarmed")
        self._events.say(now_s, TextKind.ROUTINE, "armed", "Armed by force" if force else "Armed")
        return ACCEPTED

    def _enter_armed(self, now_s: float) -> str | None:
        """Why the mode cannot be entered; None: the boat is armed. With HOME_ON_ARM home moves before the mode begins,
        which may lead there."""
        home = self.parts.home
        before = home.home
        if self.parts.parameters["HOME_ON_ARM"]:
            home.set_here(self.parts.nav, now_s)
        reason = self._helm.arm(now_s)
        if reason is not None:
            home.home = before
        return reason

    def disarm(self, now_s: float, force: bool = False) -> Outcome:
        """Always possible, also under way: the thrusters stop, also those of a motor test. `force` changes nothing."""
        self.parts.motor_test.stop(None, now_s)
        if self._helm.armed:
            self._helm.disarm(now_s)
            self.parts.cruise.ask(None)
            self.parts.fence.switch(True, now_s)
            self._events.renew("armed")
            self._events.say(now_s, TextKind.ROUTINE, "disarmed", "Disarmed")
        return ACCEPTED

    def terminate(self, now_s: float) -> Outcome:
        """Neutral and disarmed at once."""
        self._events.say(now_s, TextKind.ALARM, "terminated", "Terminated: thrusters stopped")
        return self.disarm(now_s, force=True)

    # --- places ----------------------------------------------------------------------------------------------------

    def go_to(
        self, lat_deg: float, lon_deg: float, yaw_rad: float | None, speed_mps: float | None, now_s: float
    ) -> Outcome:
        """Go to that point and hold it. `yaw_rad` None or not finite: the heading of arrival. `speed_mps` None or not
        finite: the speed of missions."""
        parts, helm = self.parts, self._helm
        if (refused := self._go_to_refused(lat_deg, lon_deg, now_s)) is not None:
            return refused
        if helm.mode is not parts.hold:
            reason = helm.switch(ModeId.HOLD, parts.nav, now_s, Cause.OPERATOR)
            if reason is not None:
                return self._refuse(Result.TEMPORARILY_REJECTED, f"Go-to refused: {reason}", now_s)
        self._taken_over(now_s)
        parts.go_tos += 1
        north_m, east_m = parts.frame_of().to_ned(lat_deg, lon_deg)
        heading_rad = yaw_rad if yaw_rad is not None and math.isfinite(yaw_rad) else None

        def go() -> None:
            parts.hold.go_to(parts.nav, north_m, east_m, heading_rad, parts.cruise.limited(speed_mps))

        if (reason := helm.guarded(parts.hold, go, now_s)) is not None:
            return self._refuse(Result.FAILED, f"Go-to {reason}", now_s)
        distance_m, _ = distance_and_bearing(parts.nav.lat_deg, parts.nav.lon_deg, lat_deg, lon_deg)
        self._events.say(now_s, TextKind.ROUTINE, "go_to", f"Going to a point {distance_m:.0f} m away")
        return ACCEPTED

    def _go_to_refused(self, lat_deg: float, lon_deg: float, now_s: float) -> Outcome | None:
        """The refusal, if the boat cannot go there."""
        parts, nav = self.parts, self.parts.nav
        if not is_on_earth(lat_deg, lon_deg):
            return self._refuse(Result.DENIED, "Go-to refused: not a position", now_s)
        if not self._helm.armed:
            return self._refuse(Result.TEMPORARILY_REJECTED, "Go-to refused: arm first", now_s)
        reason = self._forbidden(ModeId.HOLD, now_s) or self._helm.refusal(ModeId.HOLD, nav, now_s)
        if reason is not None:
            return self._refuse(Result.TEMPORARILY_REJECTED, f"Go-to refused: {reason}", now_s)
        distance_m, _ = distance_and_bearing(nav.lat_deg, nav.lon_deg, lat_deg, lon_deg)
        if distance_m > FURTHEST_LEG_M:
            return self._refuse(Result.DENIED, f"Go-to refused: {distance_m / 1000.0:.0f} km away", now_s)
        reason = parts.fence.go_refusal(nav, *parts.frame_of().to_ned(lat_deg, lon_deg))
        return None if reason is None else self._refuse(Result.DENIED, f"Go-to refused: {reason}", now_s)

    def nudge(self, forward_m: float, starboard_m: float, turn_rad: float, now_s: float) -> Outcome:
        """In Hold: move the hold point along the held heading, and turn that heading."""
        return self.parts.nudges.nudge(forward_m, starboard_m, turn_rad, self.parts.nav, now_s)

    def set_heading(self, yaw_rad: float, now_s: float) -> Outcome:
        """In Hold: hold this heading at the same point."""
        return self.parts.nudges.head(yaw_rad, self.parts.nav, now_s)

    def set_home(self, home: Home | None, now_s: float) -> Outcome:
        """None: home is where the boat is."""
        parts = self.parts
        if home is None and not parts.home.set_here(parts.nav, now_s):
            return self._refuse(Result.TEMPORARILY_REJECTED, "Home refused: position not valid", now_s)
        if home is not None and not parts.home.set(home, now_s):
            return self._refuse(Result.DENIED, "Home refused: not a position", now_s)
        return ACCEPTED

    # --- missions --------------------------------------------------------------------------------------------------

    def start_mission(self, first: int | None, now_s: float) -> Outcome:
        """Mission mode, from item `first` where that is given. Starts when armed; does not arm."""
        if first is not None and (outcome := self.set_current(first, True, now_s)) != ACCEPTED:
            return outcome
        return self.request_mode(ModeId.MISSION, now_s)

    def resume(self, now_s: float) -> Outcome:
        """Go on with a paused mission."""
        paused = self.parts.executor.progress.state is MissionState.PAUSED
        if self._helm.mode is not self.parts.mission and not paused:
            return self._refuse(Result.TEMPORARILY_REJECTED, "Resume refused: no paused mission", now_s)
        return self.request_mode(ModeId.MISSION, now_s)

    def set_current(self, seq: int | None, reset: bool, now_s: float) -> Outcome:
        """Make `seq` the mission's current item, under way or not; None: keep the present one."""
        reason = self.parts.executor.set_current(seq, reset)
        if reason is not None:
            item = "Present item" if seq is None else f"Item {item_number(seq)}"
            return self._refuse(Result.DENIED, f"{item} refused: {reason}", now_s)
        return ACCEPTED

    def reset_mission(self, now_s: float) -> Outcome:
        """Make the first item the current one, and forget the jumps taken."""
        outcome = self.set_current(0, True, now_s)
        if outcome.accepted:
            self._events.say(now_s, TextKind.ROUTINE, "mission_reset", "Mission at its first item")
        return outcome

    def sail_astern(self, astern: bool, now_s: float) -> Outcome:
        """Sail the rest of the mission under way stern first, or bow first, as the boat sails everything else."""
        parts = self.parts
        if astern and (reason := stern_first_refusal(parts.config.thrusters)) is not None:
            return self._refuse(Result.DENIED, f"Stern first refused: {reason}", now_s)
        if astern and parts.executor.progress.state is not MissionState.ACTIVE:
            return self._refuse(Result.TEMPORARILY_REJECTED, "Stern first refused: no mission under way", now_s)
        parts.executor.sail_astern(astern)
        return ACCEPTED

    def change_speed(self, speed_mps: float | None, now_s: float) -> Outcome:
        """Speed of self-steered modes until the mission changes it or the boat is disarmed; None: WP_SPEED. Capped by
        MPC_XY_VEL_MAX."""
        if speed_mps is not None and not (math.isfinite(speed_mps) and speed_mps > 0.0):
            return self._refuse(Result.DENIED, f"Speed {speed_mps:g} m/s refused: it must be above 0", now_s)
        cruise = self.parts.cruise
        cruise.ask(speed_mps)
        self._helm.mode.drop_speed()
        limit = ", the most MPC_XY_VEL_MAX allows" if cruise.asked_mps != speed_mps else ""
        self._events.say(now_s, TextKind.ROUTINE, "speed_changed", f"Speed {cruise.speed_mps:.2f} m/s{limit}")
        return ACCEPTED

    # --- fence -----------------------------------------------------------------------------------------------------

    def switch_fence(self, on: bool, now_s: float) -> Outcome:
        """Fence off until it is switched on, another fence comes, or the boat is disarmed."""
        self.parts.fence.switch(on, now_s)
        return ACCEPTED

    # --- thrusters -------------------------------------------------------------------------------------------------

    def lower_thrusters(self, lower: bool, now_s: float) -> Outcome:
        """Retractable thrusters down, or up. Up is refused while an armed boat's mode needs them."""
        return self.parts.retraction.request(lower, now_s)

    # --- parts of requests -----------------------------------------------------------------------------------------

    def _refuse(self, result: Result, text: str, now_s: float) -> Outcome:
        self._events.say(now_s, TextKind.REFUSAL, "refused", text)
        return Outcome(result, text)

    def _forbidden(self, mode: ModeId, now_s: float, cause: Cause = Cause.OPERATOR) -> str | None:
        right = _RIGHTS.get(cause, Right.GROUND_STATION)
        return self.parts.refusal(AuthorityRequest(RequestedAction.CHANGE_MODE, right, mode=mode), now_s)

    def _same_mode(self, now_s: float) -> str | None:
        """The present mode is chosen again."""
        helm = self._helm
        helm.intended = helm.mode
        begins_anew = helm.armed and helm.mode.chosen_again(self.parts.mode_inputs(now_s, 0.0))
        return helm.enter_again(now_s) if begins_anew else None

    def _taken_over(self, now_s: float) -> None:
        """A person has decided: failsafes that last have had their turn, and thrust is free again."""
        parts, monitor = self.parts, self.parts.responder.monitor
        parts.choices += 1
        parts.sticks.overrule_silent_switch(now_s)
        if self._helm.armed and (monitor.neutral or self._helm.stopped):
            self._helm.resume(now_s)
        monitor.override()
        parts.following.taken_over(now_s)
