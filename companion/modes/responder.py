"""Does what failsafes demand, and says when they begin and end."""

from __future__ import annotations

from collections.abc import Callable

from companion.core.types import ModeId, NavState, Severity
from companion.modes.events import EventLog
from companion.modes.failsafes import Action, Active, Failsafe, FailsafeMonitor
from companion.modes.helm import Helm
from companion.modes.hold import HoldMode
from companion.modes.situation import Situation, estimate_refusal
from companion.modes.sticks import Sticks


class Responder:
    """`update(now_s)` once a tick, after the newest readings are in. What it remembers is in `monitor`."""

    def __init__(self, helm: Helm, hold: HoldMode, sticks: Sticks, events: EventLog, situation_at: Callable[[float], Situation]) -> None:
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
        back = [failsafe for failsafe, cause_gone in changes.over if cause_gone and failsafe.stays is not None]
        for failsafe, cause_gone in changes.over:
            if cause_gone and failsafe not in back:
                self._events.say(now_s, Severity.NOTICE, f"{failsafe.name}_over", failsafe.ends)
        if changes.demand is not None:
            self._act(changes.demand, situation)
        for active in changes.begun:
            if active is not changes.demand:
                self._events.say(now_s, active.failsafe.severity, active.failsafe.name, active.failsafe.starts(situation))
        if was_neutral and not self.monitor.neutral and self._helm.armed:
            self._helm.resume(now_s)
        for failsafe in back:
            self._go_back(failsafe, situation)

    def _go_back(self, failsafe: Failsafe, situation: Situation) -> None:
        """To the mode that the boat was in, where nothing speaks against it; else it stays as it is, or holds if it is in that mode still."""
        helm, now_s, nav = self._helm, situation.now_s, situation.nav
        mode = helm.intended.id
        reason = None if failsafe.stays is None else failsafe.stays(situation)
        if reason is None and self.monitor.in_force:
            reason = "another failsafe lasts"
        if reason is None and helm.mode is not helm.intended:
            reason = helm.switch(mode, nav, now_s)
        if reason is not None and helm.mode is helm.intended and not self._bring_to(ModeId.HOLD, nav, now_s):
            helm.stop()
        done = mode.value if reason is None else f"stays in {helm.mode.id.value}: {reason}"
        self._events.say(now_s, Severity.NOTICE, f"{failsafe.name}_over", f"{failsafe.ends}: {done}")

    def _act(self, active: Active, situation: Situation) -> None:
        """What is demanded, or the next best: RTL, else Hold, else neutral."""
        now_s, nav = situation.now_s, situation.nav
        active.acted = True
        done = "neutral"
        if self._sticks.safe_switch and active.action is not Action.NEUTRAL:
            done = "left to the transmitter"
        elif active.action is not Action.NEUTRAL and self._stays_alongside(nav):
            done = "stays alongside, pushing"
        elif active.action is Action.MANUAL and self._bring_to(ModeId.MANUAL, nav, now_s):
            done = self._helm.mode.id.value
        elif active.action is Action.RTL and self._bring_to(ModeId.RTL, nav, now_s):
            done = "RTL"
        elif active.action is not Action.NEUTRAL and self._bring_to(ModeId.HOLD, nav, now_s):
            done = self._helm.mode.id.value
        else:
            active.neutral = True
            self._sticks.demand_centre(now_s, even_if_silent=True)
        text = f"{active.failsafe.starts(situation)}: {done}"
        self._events.say(now_s, active.failsafe.severity, active.failsafe.name, text)

    def _stays_alongside(self, nav: NavState) -> bool:
        """Pushing against a berth, and able to go on with it."""
        mode = self._helm.mode
        return mode.alongside and estimate_refusal(mode, nav) is None

    def _bring_to(self, mode: ModeId, nav: NavState, now_s: float) -> bool:
        """Have the boat in `mode`; on its way home already, it is not stopped by a Hold."""
        helm = self._helm
        present = helm.mode.id
        if present is not mode and present is not ModeId.RTL:
            return helm.switch(mode, nav, now_s, intended=False) is None
        if helm.refusal(present, nav, now_s) is not None:
            return False
        if present is ModeId.HOLD and self._hold.going:
            self._hold.hold_here(nav)
        return True
