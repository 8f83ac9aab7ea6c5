"""Who steers: the modes, the one that is active, and going from one to another without ever raising."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from companion.core.types import ModeId, NavState, Setpoint, Severity
from companion.modes.events import EventLog
from companion.modes.mode import Mode, ModeInputs
from companion.modes.situation import estimate_refusal
from companion.modes.sticks import Sticks

InputsAt = Callable[[float, float], ModeInputs]


class Helm:
    """Remembers the active mode, the mode last asked for, whether the boat is armed, and whether thrust is stopped until the next request.

    A mode is entered only while armed. `version` grows with every change of mode or arming. `inputs_at(now_s, dt_s)` gives what modes see.
    """

    def __init__(self, modes: Mapping[ModeId, Mode], sticks: Sticks, events: EventLog, inputs_at: InputsAt) -> None:
        self.modes = modes
        self.mode = modes[ModeId.MANUAL]
        self.intended = self.mode
        self.armed = False
        self.version = 0
        self.stopped = False
        self.waits: Callable[[ModeId, NavState, float], bool] = lambda mode, nav, now_s: False
        """Whether a mode that cannot be entered yet may be chosen all the same: the boat is in it without thrust until it is resumed."""
        self._sticks = sticks
        self._events = events
        self._inputs_at = inputs_at

    def refusal(self, mode: ModeId, nav: NavState, now_s: float) -> str | None:
        """Why `mode` cannot be chosen now, or None."""
        candidate = self.modes[mode]
        return candidate.check(self._inputs_at(now_s, 0.0)) or estimate_refusal(candidate, nav)

    def choice_refusal(self, mode: ModeId, nav: NavState, now_s: float) -> str | None:
        """The same, but for a mode that may be chosen before it can be entered."""
        early = (self.modes[mode].early and not self.armed) or self.waits(mode, nav, now_s)
        return None if early else self.refusal(mode, nav, now_s)

    def switch(self, mode: ModeId, nav: NavState, now_s: float, intended: bool = True) -> str | None:
        """Another mode from now on, or the reason why not: all stays as it was then. `intended`: a person wants it, not a failsafe."""
        reason = self.choice_refusal(mode, nav, now_s)
        new, waits = self.modes[mode], False
        if reason is None and self.armed:
            before, waits = self.mode, self.waits(mode, nav, now_s)
            self._guarded_leave(before, now_s)
            reason = None if waits else self._guarded_enter(new, now_s)
            if reason is not None:
                self._recover(before, now_s)
        if reason is not None:
            return reason
        self.mode = new
        if intended:
            self.intended = new
        self.stopped = waits
        self.version += 1
        self._events.say(now_s, Severity.NOTICE, "mode_changed", f"Mode {mode.value}")
        return None

    def choose_disarmed(self, mode: ModeId) -> None:
        """After a restart: the mode to stand in, disarmed."""
        self.mode = self.intended = self.modes[mode]
        self.version += 1

    def arm(self, now_s: float) -> str | None:
        """Enter the chosen mode, or say why it cannot be entered."""
        reason = self._guarded_enter(self.mode, now_s)
        if reason is None:
            self.armed = True
            self.stopped = False
            self.version += 1
        return reason

    def disarm(self, now_s: float) -> None:
        self._guarded_leave(self.mode, now_s)
        self.armed = False
        self.stopped = False
        self.version += 1

    def resume(self, now_s: float) -> None:
        """Go on in the present mode after the thrusters were kept still."""
        self.stopped = self.guarded(self.mode, lambda: self.mode.resume(self._inputs_at(now_s, 0.0)), now_s) is not None

    def enter_again(self, now_s: float) -> str | None:
        """Begin the present mode anew; it goes on as it was where that is refused."""
        reason = self._guarded_enter(self.mode, now_s)
        self.stopped = self.stopped and reason is not None
        return reason

    def stop(self) -> None:
        """No thrust until something else is asked for."""
        self.stopped = True

    def guide(self, inputs: ModeInputs) -> Setpoint | None:
        """The active mode's setpoint. None if the mode failed: that is said, and the boat holds, or stops if it cannot."""
        try:
            setpoint = self.mode.update(inputs)
        except Exception as error:  # noqa: BLE001  whatever is wrong with a mode, the boat must not be without a helm
            self._failed(self.mode, error, inputs)
            return None
        if not _is_finite(setpoint):
            self._failed(self.mode, ValueError("setpoint is not finite"), inputs)
            return None
        return setpoint

    def _failed(self, mode: Mode, error: Exception, inputs: ModeInputs) -> None:
        text = f"{mode.id.value} failed ({type(error).__name__}: {error})"
        self._events.say(inputs.now_s, Severity.CRITICAL, "mode_failed", text)
        if mode.id is ModeId.HOLD or self.switch(ModeId.HOLD, inputs.nav, inputs.now_s, intended=False) is not None:
            self.stop()

    def _guarded_enter(self, mode: Mode, now_s: float) -> str | None:
        reason = self.guarded(mode, lambda: mode.enter(self._inputs_at(now_s, 0.0)), now_s)
        if reason is None:
            self._sticks.demand_centre(now_s, even_if_silent=not mode.by_stick)
            if mode.by_stick and self._sticks.must_centre:
                self._events.say(now_s, Severity.WARNING, "sticks_off_centre", "Sticks are off centre: centre them once to take control")
        return reason

    def _guarded_leave(self, mode: Mode, now_s: float) -> None:
        def leave() -> None:
            mode.leave()

        self.guarded(mode, leave, now_s)

    def _recover(self, before: Mode, now_s: float) -> None:
        """A mode refused after the one before it was left."""
        if self.guarded(before, lambda: before.resume(self._inputs_at(now_s, 0.0)), now_s) is not None:
            self.stop()

    def guarded(self, mode: Mode, step: Callable[[], str | None], now_s: float) -> str | None:
        """Have `mode` do something; what it refuses, or raises, comes back as a reason."""
        try:
            return step()
        except Exception as error:  # noqa: BLE001  as in `guide`
            reason = f"{type(error).__name__}: {error}"
            self._events.say(now_s, Severity.CRITICAL, "mode_failed", f"{mode.id.value} failed ({reason})")
            return f"failed ({reason})"


def _is_finite(setpoint: Setpoint) -> bool:
    total = setpoint.surge_mps + setpoint.sway_mps + setpoint.yaw_rate_radps
    total += (setpoint.north_m or 0.0) + (setpoint.east_m or 0.0) + (setpoint.yaw_rad or 0.0)
    if setpoint.wrench is not None:
        total += setpoint.wrench.surge_n + setpoint.wrench.sway_n + setpoint.wrench.yaw_nm
    return math.isfinite(total)
