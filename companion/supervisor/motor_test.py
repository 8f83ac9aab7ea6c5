"""Thrusters run one by one while the boat is disarmed, to see which is which: for a moment, at low power.

The limits are those of `companion thruster-test`, and every command passes the gate.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

from companion.config.vessel import VesselConfig
from companion.core.actuation import ThrusterCommand
from companion.core.decision import ACCEPTED, Outcome, Result, TextKind
from companion.core.events import EventLog

MOST_POWER = 0.3  # share of full throttle: this tests wiring, not thrust
RAMP_S = 0.5  # to full power of the test
LONGEST_S = 10.0
_PAUSE_S = 1.0  # between the thrusters of a sequence
_STILL = ThrusterCommand(0.0, 0.0, None)


@dataclass(slots=True)
class _Turn:
    """One thruster that runs, or waits for its turn: `throttle` in force now on its way to `target`."""

    target: float
    begin_s: float
    end_s: float
    throttle: float = 0.0


class MotorTest:
    """`begin`, `stop` → Outcome; `update` once a tick → what the thrusters do, None while no test runs.

    A test ends by its time, and at once when something speaks against it. Remembers which thrusters run.
    """

    def __init__(self, config: VesselConfig, events: EventLog, objection: Callable[[int, float], str | None]) -> None:
        """`objection(index, now_s)`: why a thruster may not run now, or None."""
        self._thrusters = config.thrusters
        self._events = events
        self._objection = objection
        self._turns: dict[int, _Turn] = {}

    @property
    def running(self) -> bool:
        """Whether a thruster runs, or is about to."""
        return bool(self._turns)

    def begin(self, index: int, throttle: float, duration_s: float, now_s: float, count: int = 1) -> Outcome:
        """Run thruster `index` (from 0), or renew its test; `count`: how many, one after the other.

        `throttle`: −MOST_POWER…MOST_POWER; 0 stops it.
        """
        indices = range(index, index + count)
        refusal = self._refusal(indices, throttle, duration_s)
        result = Result.DENIED
        if refusal is None and throttle == 0.0:
            return self.stop(index, now_s)
        if refusal is None:
            refusal = next((reason for i in indices if (reason := self._objection(i, now_s)) is not None), None)
            result = Result.TEMPORARILY_REJECTED
        if refusal is not None:
            text = f"Motor test refused: {refusal}"
            self._events.say(now_s, TextKind.REFUSAL, "refused", text)
            return Outcome(result, text)
        for place, i in enumerate(indices):
            self._run(i, throttle, now_s + place * (duration_s + _PAUSE_S), duration_s, now_s)
        return ACCEPTED

    def stop(self, index: int | None, now_s: float) -> Outcome:
        """Stop one thruster, or all of them, at once."""
        for i in [index] if index is not None else list(self._turns):
            if self._turns.pop(i, None) is not None:
                self._over(i, now_s)
        return ACCEPTED

    def update(self, now_s: float, dt_s: float) -> tuple[ThrusterCommand, ...] | None:
        """What the thrusters do in this tick. A thruster that turns does so to its rest."""
        self._end(now_s)
        if not self._turns:
            return None
        commands = [_STILL] * len(self._thrusters)
        for i, turn in self._turns.items():
            if now_s < turn.begin_s:
                continue
            if turn.throttle == 0.0:
                text = f"Motor test: {self._thrusters[i].name} at {turn.target:+.0%}"
                self._events.say(now_s, TextKind.ROUTINE, "motor_test", text)
            reach = MOST_POWER / RAMP_S * dt_s
            turn.throttle += min(reach, max(-reach, turn.target - turn.throttle))
            thruster = self._thrusters[i]
            commands[i] = ThrusterCommand(0.0, turn.throttle, thruster.azimuth_rad if thruster.turns else None)
        return tuple(commands)

    def _run(self, index: int, throttle: float, begin_s: float, duration_s: float, now_s: float) -> None:
        turn = self._turns.get(index)
        if turn is not None and turn.begin_s <= now_s:
            turn.target, turn.end_s = throttle, now_s + duration_s
        else:
            self._turns[index] = _Turn(throttle, begin_s, begin_s + duration_s)

    def _end(self, now_s: float) -> None:
        """Forget the tests that are over, and all when something speaks against one of them."""
        for i in list(self._turns):
            if (reason := self._objection(i, now_s)) is not None:
                self._turns.clear()
                self._events.say(now_s, TextKind.ATTENTION, "motor_test", f"Motor test stopped: {reason}")
                return
        for i, turn in list(self._turns.items()):
            if now_s >= turn.end_s:
                del self._turns[i]
                self._over(i, now_s)

    def _over(self, index: int, now_s: float) -> None:
        self._events.say(now_s, TextKind.ROUTINE, "motor_test", f"Motor test over: {self._thrusters[index].name}")

    def _refusal(self, indices: range, throttle: float, duration_s: float) -> str | None:
        """What of a request is wrong whenever it is made."""
        number = len(self._thrusters)
        if not indices or indices[0] < 0 or indices[-1] >= number:
            return f"this boat has motors 1 to {number}"
        if not abs(throttle) <= MOST_POWER + 1e-6:
            return f"at most {MOST_POWER:.0%}"
        if not 0.0 < duration_s <= LONGEST_S:
            return f"give more than 0 and at most {LONGEST_S:g} s"
        backward = next((i for i in indices if throttle < 0.0 and self._thrusters[i].min_n >= 0.0), None)
        return None if backward is None else f"{self._thrusters[backward].name} has no reverse"


def is_stop(throttle: float, duration_s: float) -> bool:
    """Whether a client means the end of a test: no value, or no time."""
    return math.isnan(throttle) or duration_s == 0.0
