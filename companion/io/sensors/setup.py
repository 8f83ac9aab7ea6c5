"""Configuration of a device at the start: one command after the other, each until the device acknowledges it. Never
waits."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass

_ANSWER_S = 0.5
_TRIES = 4
_PAUSE_S = 5.0  # before it starts again
_SILENT_S = 3.0  # a device that sent nothing of use for so long may have lost its power and its settings


@dataclass(frozen=True, slots=True)
class Step:
    """A command: its bytes, the answer that acknowledges it, and what people call it."""

    name: str
    request: bytes
    answer: Hashable


class DeviceSetup:
    """Time, answers and the age of the last message → what to write now.

    A command without an answer goes out every 0.5 s, four times. After that, or when the device refuses a command, the
    setup starts again 5 s later. It also starts again when the port has come back, or the device after a silence.
    Remembers the step under way, how often it was sent, and when it is next.
    """

    def __init__(self, steps: Sequence[Step]) -> None:
        self._steps = tuple(steps)
        self._at = 0
        self._tries = 0
        self._next_s: float | None = None
        self._trouble = ""

    @property
    def done(self) -> bool:
        """Whether the device has acknowledged all commands."""
        return self._at >= len(self._steps)

    @property
    def remark(self) -> str:
        """The state for people; empty when all is acknowledged."""
        if self.done:
            return ""
        return self._trouble or f"being configured: {self._steps[self._at].name}"

    def restart(self) -> None:
        """Start again with the first command."""
        self._at = self._tries = 0
        self._next_s = None

    def due(self, now_s: float, silent_s: float) -> bytes:
        """What to write now, b'' for nothing. `silent_s`: since the device's last message of use."""
        if self.done:
            if silent_s <= _SILENT_S:
                return b""
            self.restart()
        if self._next_s is not None and now_s < self._next_s:
            return b""
        step = self._steps[self._at]
        if self._tries >= _TRIES:
            self._start_again(
                f"does not acknowledge {step.name}: is the device's transmit and receive line connected?", now_s
            )
            return b""
        self._tries += 1
        self._next_s = now_s + _ANSWER_S
        return step.request

    def heard(self, answer: Hashable) -> bool:
        """An answer of the device; True if it is the expected one. The next command is due at once."""
        if self.done or answer != self._steps[self._at].answer or self._tries == 0:
            return False
        self._at += 1
        self._tries = 0
        self._next_s = None
        if self._at == len(self._steps):
            self._trouble = ""
        return True

    def refused(self, why: str, now_s: float) -> None:
        """The device has refused the command."""
        if not self.done:
            self._start_again(f"refuses {self._steps[self._at].name}: {why}", now_s)

    def _start_again(self, trouble: str, now_s: float) -> None:
        self._trouble = trouble
        self.restart()
        self._next_s = now_s + _PAUSE_S
