"""Carries out what failsafes demand, and announces when they begin and end."""

from __future__ import annotations

from collections.abc import Callable

from companion.core.decision import ModeId, TextKind
from companion.core.estimate import NavState
from companion.core.events import EventLog
from companion.modes.hold import HoldMode
from companion.supervisor.authority import AuthorityRequest, RequestedAction, Right, refusal
from companion.supervisor.failsafes import Active, Changes, Failsafe, FailsafeAction, FailsafeMonitor
from companion.supervisor.helm import Helm
from companion.supervisor.mode_changes import Cause
from companion.supervisor.situation import Situation, estimate_refusal
from companion.supervisor.sticks import Sticks


class Responder:
    """`update(now_s)` once a tick, after the newest readings are in. What it remembers is in `monitor`."""

    def __init__(
        self, helm: Helm, hold: HoldMode, sticks: Sticks, events: EventLog, situation_at: Callable[[float], Situation]
    ) -> None:
        self.monitor = FailsafeMonitor()
        self._helm = helm
        self._hold = hold
        self._sticks = sticks
        self._events = events
        self._situation_at = situation_at

    def update(self, now_s: float) -> None:
        """Failsafes begin, act and end; after a neutral one the mode goes on."""
        was_neutral = self.monitor.neutral
        situation = self._situation_at(now_s)
        changes = self.monitor.update(situation)
        self._make_news(changes)
        back = [failsafe for failsafe, cause_gone in changes.over if cause_gone and failsafe.stays is not None]
        for failsafe, cause_gone in changes.over:
            if cause_gone and failsafe not in back:
                self._events.say(now_s, TextKind.ROUTINE, f"{failsafe.name}_over", failsafe.ends)
        if changes.demand is not None:
            self._act(changes.demand, situation)
        for active in changes.begun:
            if active is not changes.demand:
                self._events.say(now_s, active.failsafe.kind, active.failsafe.name, active.failsafe.starts(situation))
        if was_neutral and not self.monitor.neutral and self._helm.armed:
            self._helm.resume(now_s)
        for failsafe in back:
            self._go_back(failsafe, situation)

    def _make_news(self, changes: Changes) -> None:
        """What begins again was over before, and the other way round, however short that was."""
        for failsafe, _ in changes.over:
            self._events.renew(failsafe.name)
        for active in changes.begun:
            self._events.renew(f"{active.failsafe.name}_over")

    def _go_back(self, failsafe: Failsafe, situation: Situation) -> None:
        """Return to the mode that the boat was in, if nothing speaks against it. Otherwise it stays in the mode of the
        failsafe; if it never left its mode, it holds."""
        helm, now_s, nav = self._helm, situation.now_s, situation.nav
        mode = helm.intended.id
        reason = None if failsafe.stays is None else failsafe.stays(situation)
        if reason is None and self.monitor.in_force:
            reason = "another failsafe lasts"
        if reason is None and helm.mode is not helm.intended:
            reason = helm.switch(mode, nav, now_s, Cause.FAILSAFE_OVER)
        if reason is not None and helm.mode is helm.intended:
            self._hold_or_stop(nav, now_s)
        done = mode.value if reason is None else f"stays in {helm.mode.id.value}: {reason}"
        self._events.say(now_s, TextKind.ROUTINE, f"{failsafe.name}_over", f"{failsafe.ends}: {done}")

    def _hold_or_stop(self, nav: NavState, now_s: float) -> None:
        if not self._bring_to(ModeId.HOLD, nav, now_s, Cause.FAILSAFE_OVER):
            self._helm.stop(Cause.FAILSAFE_OVER)

    def _act(self, active: Active, situation: Situation) -> None:
        """Do what the failsafe demands, or the next best: RTL, then Hold, then neutral."""
        now_s, nav = situation.now_s, situation.nav
        goes_on = not active.failsafe.in_the_way
        active.acted = True
        done = "neutral"
        refused = refusal(AuthorityRequest(RequestedAction.CHANGE_MODE, Right.BOAT), situation.authority)
        if refused is not None and active.action is not FailsafeAction.NEUTRAL:
            done = refused
        elif active.action is not FailsafeAction.NEUTRAL and self._stays_alongside(nav):
            done = "stays alongside, pushing"
        elif active.action is FailsafeAction.MANUAL and self._bring_to(ModeId.MANUAL, nav, now_s, Cause.FAILSAFE):
            done = self._helm.mode.id.value
        elif active.action is FailsafeAction.RTL and self._bring_to(ModeId.RTL, nav, now_s, Cause.FAILSAFE):
            done = "RTL"
        elif active.action is not FailsafeAction.NEUTRAL and self._bring_to(
            ModeId.HOLD, nav, now_s, Cause.FAILSAFE, goes_on
        ):
            done = self._helm.mode.id.value
        else:
            active.neutral = True
            self._sticks.demand_centre(now_s)
        if self.monitor.neutral and not active.neutral:
            done = f"{done}, no thrust yet"
        text = f"{active.failsafe.starts(situation)}: {done}"
        self._events.say(now_s, active.failsafe.kind, active.failsafe.name, text)

    def _stays_alongside(self, nav: NavState) -> bool:
        """Whether the boat pushes against a berth and can go on with it."""
        mode = self._helm.mode
        return mode.alongside and estimate_refusal(mode, nav) is None

    def _bring_to(self, mode: ModeId, nav: NavState, now_s: float, cause: Cause, goes_on: bool = True) -> bool:
        """Have the boat in `mode`; `goes_on`: a boat on its way home stays on it. False where that is not possible."""
        helm = self._helm
        present = helm.mode.id
        if present is not mode and not (goes_on and present is ModeId.RTL):
            return helm.switch(mode, nav, now_s, cause) is None
        if helm.refusal(present, nav, now_s) is not None:
            return False
        if present is ModeId.HOLD and self._hold.going:
            self._hold.hold_here(nav)
        return True
