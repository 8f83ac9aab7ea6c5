"""Servo and relay outputs, as missions and ground stations set them, with repetitions.

Disarmed is neutral for them too: what they move could hurt somebody. An output rests until the boat is armed, unless
the vessel's file sets `while_disarmed`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from companion.config.outputs import RelayConfig, ServoConfig
from companion.config.vessel import VesselConfig
from companion.core.actuation import Auxiliary
from companion.core.decision import ACCEPTED, Outcome, Result, TextKind
from companion.core.events import EventLog
from companion.mission.tasks import AuxiliaryAction, SetActuators, SetRelay, SetServo


@dataclass(frozen=True, slots=True)
class _Repeat:
    """`value` for half of each cycle and `back` for the other half, `count` times from `since_s`."""

    value: float | bool
    back: float | bool | None
    count: int
    cycle_s: float
    since_s: float

    def at(self, now_s: float) -> float | bool | None:
        """The output's value at `now_s`."""
        halves = int(2.0 * (now_s - self.since_s) / self.cycle_s + 1e-9)
        return self.back if halves % 2 or self.is_over(now_s) else self.value

    def is_over(self, now_s: float) -> bool:
        """Whether all cycles are done."""
        return now_s - self.since_s >= self.count * self.cycle_s - 1e-9


class AuxiliaryOutputs:
    """`request(action, now_s)` → Outcome; `update(armed, now_s)` once a tick → Auxiliary. None of it survives a
    restart.

    Remembers what each output was set to last, the repetitions under way, and whether the boat was armed at the last
    tick.
    """

    def __init__(self, config: VesselConfig, events: EventLog) -> None:
        self._servos, self._relays = config.servos, config.relays
        self._outputs: tuple[ServoConfig | RelayConfig, ...] = (*config.servos, *config.relays)
        self._events = events
        self._armed = False
        self._values: dict[ServoConfig | RelayConfig, float | bool | None] = {}
        self._repeats: dict[ServoConfig | RelayConfig, _Repeat] = {}
        for output in self._outputs:
            self._rest(output)

    def request(self, action: AuxiliaryAction, now_s: float) -> Outcome:
        """Set the output. A refusal is an event too."""
        reason, result = self._refusal(action)
        if reason is not None:
            self._events.say(now_s, TextKind.REFUSAL, "auxiliary_refused", reason)
            return Outcome(result, reason)
        match action:
            case SetServo():
                servo = self._servos[action.number - 1]
                self._set(servo, action.pulse_us, action.count, action.cycle_s, now_s)
                self._say(f"Servo {action.number} ({servo.name}): {action.pulse_us:g} µs", action.count, now_s)
            case SetRelay():
                relay = self._relays[action.number]
                on = not self._values[relay] if action.on is None else action.on
                self._set(relay, on, action.count, action.cycle_s, now_s)
                self._say(f"Relay {action.number} ({relay.name}): {'on' if on else 'off'}", action.count, now_s)
            case SetActuators():
                for servo, value in zip(self._servos, action.values, strict=False):
                    if value is not None:
                        share = 0.5 + 0.5 * min(1.0, max(-1.0, value))
                        self._set(servo, servo.min_us + share * (servo.max_us - servo.min_us), 0, 0.0, now_s)
                self._say("Actuators set", 0, now_s)
        return ACCEPTED

    def pulse_refusal(self, output: ServoConfig | RelayConfig) -> str | None:
        """Why the output may not move now, or None."""
        moves = self._armed or output.while_disarmed
        return None if moves else f"{output.name} moves only while the boat is armed"

    def pulse(self, output: ServoConfig | RelayConfig, value: float | bool, duration_s: float, now_s: float) -> None:
        """Set the output for a moment, without a word: a camera's shutter. Where it may not move, nothing happens."""
        if self.pulse_refusal(output) is None:
            self._set(output, value, 1, 2.0 * duration_s, now_s)

    def update(self, armed: bool, now_s: float) -> Auxiliary:
        """The outputs now. With disarming, those that may not move then go to rest and forget what was asked."""
        self._armed = armed
        for output in self._outputs:
            if not armed and not output.while_disarmed:
                self._rest(output)
        for output, repeat in list(self._repeats.items()):
            self._values[output] = repeat.at(now_s)
            if repeat.is_over(now_s):
                del self._repeats[output]
        pulses = tuple(None if (value := self._values[servo]) is None else float(value) for servo in self._servos)
        return Auxiliary(pulses, tuple(bool(self._values[relay]) for relay in self._relays))

    def _refusal(self, action: AuxiliaryAction) -> tuple[str | None, Result]:
        wanted = self._wanted(action)
        if isinstance(wanted, str):
            return wanted, Result.DENIED
        reason = next((text for output in wanted if (text := self.pulse_refusal(output)) is not None), None)
        return reason, Result.ACCEPTED if reason is None else Result.TEMPORARILY_REJECTED

    def _wanted(self, action: AuxiliaryAction) -> Sequence[ServoConfig | RelayConfig] | str:
        """The outputs that are to move, or why they cannot."""
        match action:
            case SetServo(number=number, pulse_us=pulse_us):
                if not 1 <= number <= len(self._servos):
                    return f"No servo output {number}: {_numbers(len(self._servos), 1)}"
                servo = self._servos[number - 1]
                if not servo.min_us <= pulse_us <= servo.max_us:
                    return f"Servo {number} ({servo.name}) takes {servo.min_us:g} to {servo.max_us:g} µs"
                return (servo,)
            case SetRelay(number=number):
                if not 0 <= number < len(self._relays):
                    return f"No relay {number}: {_numbers(len(self._relays), 0)}"
                return (self._relays[number],)
            case SetActuators(values=values):
                given = [number for number, value in enumerate(values, start=1) if value is not None]
                if any(number > len(self._servos) or not math.isfinite(values[number - 1] or 0.0) for number in given):
                    return f"No servo output {given[-1]}: {_numbers(len(self._servos), 1)}"
                return [self._servos[number - 1] for number in given]

    def _set(
        self, output: ServoConfig | RelayConfig, value: float | bool, count: int, cycle_s: float, now_s: float
    ) -> None:
        repeat = self._repeats.pop(output, None)
        if count > 0:
            back = self._values[output] if repeat is None else repeat.back
            self._repeats[output] = _Repeat(value, back, count, cycle_s, now_s)
        self._values[output] = value

    def _rest(self, output: ServoConfig | RelayConfig) -> None:
        self._repeats.pop(output, None)
        self._values[output] = output.rest_us if isinstance(output, ServoConfig) else False

    def _say(self, text: str, count: int, now_s: float) -> None:
        self._events.say(now_s, TextKind.ROUTINE, "auxiliary", f"{text}, {count} times" if count else text)


def _numbers(count: int, first: int) -> str:
    return "this boat has none" if count == 0 else f"this boat has {first} to {first + count - 1}"
