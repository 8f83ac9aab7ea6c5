"""The modes, the active one, and the change from one to another. None of it raises."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from companion.core.decision import ModeId, ModeInputs, Order, TextKind
from companion.core.estimate import NavState
from companion.core.events import EventLog
from companion.core.setpoint import HeadingSetpoint, Setpoint, WrenchSetpoint, desired_motion
from companion.modes.mode import Mode
from companion.supervisor.mode_changes import Cause
from companion.supervisor.situation import estimate_refusal
from companion.supervisor.sticks import Sticks

InputsAt = Callable[[float, float], ModeInputs]


class Helm:
    """Remembers the active mode and the `cause` of it, the mode last asked for, whether the boat is armed, and whether
    thrust is stopped until the next request. `cause` is None before the first change of mode.

    A mode is entered only while armed. `version` grows with every change of mode or arming. `inputs_at(now_s, dt_s)`
    gives what modes see.
    """

    def __init__(self, modes: Mapping[ModeId, Mode], sticks: Sticks, events: EventLog, inputs_at: InputsAt) -> None:
        self.modes = modes
        self.mode = modes[ModeId.MANUAL]
        self.intended = self.mode
        self.armed = False
        self.version = 0
        self.stopped = False
        self.cause: Cause | None = None
        self._check_failures: dict[ModeId, str] = {}  # as announced
        self.order: Order | None = None
        """What is asked of a mode, while it is being chosen for that."""
        self.waits: Callable[[ModeId, NavState, float], bool] = lambda mode, nav, now_s: False
        """Whether a mode that cannot be entered yet may be chosen by an operator: the boat then is in it and stands by
        (`Mode.stand_by`), until it is resumed."""
        self._sticks = sticks
        self._events = events
        self._inputs_at = inputs_at

    def refusal(self, mode: ModeId, nav: NavState, now_s: float) -> str | None:
        """Why `mode` cannot be chosen now, or None."""
        return self.refusal_with(mode, nav, self._inputs_at(now_s, 0.0))

    def refusal_with(self, mode: ModeId, nav: NavState, inputs: ModeInputs) -> str | None:
        """As `refusal`, with what modes see now: who asks about all of them makes that once."""
        candidate = self.modes[mode]
        try:
            reason = candidate.check(inputs)
        except Exception as error:  # noqa: BLE001  as in `guide`; asked in every tick, so it is announced once
            reason = f"failed ({type(error).__name__}: {error})"
            if self._check_failures.get(mode) != reason:
                self._check_failures[mode] = reason
                self._events.say(inputs.now_s, TextKind.ALARM, "mode_failed", f"{mode.value} {reason}")
        return reason or estimate_refusal(candidate, nav)

    def choice_refusal(self, mode: ModeId, nav: NavState, now_s: float, cause: Cause = Cause.OPERATOR) -> str | None:
        """As `refusal`; None too for a mode that may be chosen before it can be entered."""
        waits = cause is Cause.OPERATOR and self.waits(mode, nav, now_s)
        early = waits or (self.modes[mode].declaration.early and not self.armed)
        return None if early else self.refusal(mode, nav, now_s)

    def switch(self, mode: ModeId, nav: NavState, now_s: float, cause: Cause) -> str | None:
        """Change to `mode`. Returns None, or the reason why not; all stays as it was then."""
        reason = self.choice_refusal(mode, nav, now_s, cause)
        new, waits = self.modes[mode], False
        if reason is None and self.armed:
            before, waits = self.mode, cause is Cause.OPERATOR and self.waits(mode, nav, now_s)
            self._guarded_leave(before, now_s)
            reason = None if waits else self._guarded_enter(new, now_s)
            if reason is not None:
                self._recover(before, now_s)
        if reason is not None:
            return reason
        self.mode = new
        if not cause.keeps_intended:
            self.intended = new
        self.cause = cause
        self.stopped = waits
        self.version += 1
        self._events.say(now_s, TextKind.ROUTINE, "mode_changed", f"Mode {mode.value}")
        return None

    def switch_for(self, order: Order, nav: NavState, now_s: float, cause: Cause) -> str | None:
        """As `switch`, to the mode that carries out `order`."""
        self.order = order
        reason = self.switch(order.mode, nav, now_s, cause)
        self.order = None
        return reason

    def choose_disarmed(self, mode: ModeId, cause: Cause) -> None:
        """The mode of a boat that is disarmed; it is not entered."""
        self.mode = self.intended = self.modes[mode]
        self.cause = cause
        self.version += 1

    def arm(self, now_s: float) -> str | None:
        """Enter the chosen mode. Returns None, or why it cannot be entered."""
        reason = self._guarded_enter(self.mode, now_s)
        if reason is None:
            self.armed = True
            self.stopped = False
            self.version += 1
        return reason

    def disarm(self, now_s: float) -> None:
        """Leave the active mode; it stays chosen."""
        self._guarded_leave(self.mode, now_s)
        self.armed = False
        self.stopped = False
        self.version += 1

    def resume(self, now_s: float) -> None:
        """Go on in the present mode after the thrusters were in neutral."""
        self.stopped = self.guarded(self.mode, lambda: self.mode.resume(self._inputs_at(now_s, 0.0)), now_s) is not None

    def enter_again(self, now_s: float) -> str | None:
        """Begin the present mode anew. Returns None, or why not: the mode then goes on as it was."""
        reason = self._guarded_enter(self.mode, now_s)
        self.stopped = self.stopped and reason is not None
        return reason

    def stop(self, cause: Cause) -> None:
        """No thrust until the next request."""
        self.stopped = True
        self.cause = cause

    def guide(self, inputs: ModeInputs) -> Setpoint | None:
        """The active mode's setpoint. None if the mode failed: that is announced, and the boat holds, or stops if it
        cannot hold."""
        try:
            setpoint = self.mode.stand_by(inputs) if self.stopped else self.mode.update(inputs)
        except Exception as error:  # noqa: BLE001  whatever is wrong with a mode, the boat must not be without a helm
            self._failed(self.mode, error, inputs)
            return None
        if not _is_finite(setpoint):
            self._failed(self.mode, ValueError("setpoint is not finite"), inputs)
            return None
        return setpoint

    def _failed(self, mode: Mode, error: Exception, inputs: ModeInputs) -> None:
        text = f"{mode.id.value} failed ({type(error).__name__}: {error})"
        self._events.say(inputs.now_s, TextKind.ALARM, "mode_failed", text)
        cause = Cause.MODE_FAILED
        if mode.id is ModeId.HOLD or self.switch(ModeId.HOLD, inputs.nav, inputs.now_s, cause) is not None:
            self.stop(cause)

    def _guarded_enter(self, mode: Mode, now_s: float) -> str | None:
        reason = self.guarded(mode, lambda: mode.enter(self._inputs_at(now_s, 0.0)), now_s)
        if reason is None:
            self._sticks.demand_centre(now_s)
            if self._sticks.must_centre and self._sticks.live(now_s) is not None:
                self._tell_to_centre(mode, now_s)
        return reason

    def sticks_taken_over(self, now_s: float) -> None:
        """Sticks that are off centre have taken over, from others or as the first."""
        if self.armed:
            self._tell_to_centre(self.mode, now_s)

    def _tell_to_centre(self, mode: Mode, now_s: float) -> None:
        if mode.by_stick:
            text = "Sticks off centre: centre them to take control"
            self._events.say(now_s, TextKind.ATTENTION, "sticks_off_centre", text)

    def _guarded_leave(self, mode: Mode, now_s: float) -> None:
        def leave() -> None:
            mode.leave()

        self.guarded(mode, leave, now_s)

    def _recover(self, before: Mode, now_s: float) -> None:
        """Go on in the mode before, after the new one refused."""
        if self.guarded(before, lambda: before.resume(self._inputs_at(now_s, 0.0)), now_s) is not None:
            self.stop(Cause.MODE_FAILED)

    def guarded(self, mode: Mode, step: Callable[[], str | None], now_s: float) -> str | None:
        """Run one step of `mode`. Returns None, or the reason that it gives or raises."""
        try:
            return step()
        except Exception as error:  # noqa: BLE001  as in `guide`
            reason = f"{type(error).__name__}: {error}"
            self._events.say(now_s, TextKind.ALARM, "mode_failed", f"{mode.id.value} failed ({reason})")
            return f"failed ({reason})"


def _is_finite(setpoint: Setpoint) -> bool:
    motion = desired_motion(setpoint)
    total = motion.surge_mps + motion.sway_mps + motion.yaw_rate_radps + (motion.yaw_rad or 0.0)
    if motion.place is not None:
        total += motion.place.north_m + motion.place.east_m
    if isinstance(setpoint, HeadingSetpoint | WrenchSetpoint):
        total += setpoint.wrench.surge_n + setpoint.wrench.sway_n + setpoint.wrench.yaw_nm
    return math.isfinite(total)
