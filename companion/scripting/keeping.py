"""When a script is started, killed and started again: a rule on what its keeper sees.

`Keeping.update(seen, now_s)` returns what to do. Time is an argument: of the computer's own clock.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, auto
from typing import Literal

from companion.core.decision import TextKind

MOST_FAILURES = 5  # in a row, after which it is given up
STEADY_S = 60.0  # after so long a run, earlier failures are forgotten
_LONGEST_PAUSE_S = 60.0
_KILL_AFTER_S = 3.0  # of a request to end

Restart = Literal["never", "failure", "always"]


class Deed(Enum):
    """What the keeper does."""

    NOTHING = auto()
    START = auto()
    ASK_TO_END = auto()
    KILL = auto()


@dataclass(frozen=True, slots=True)
class Seen:
    """What the keeper sees. `code`: exit code of a process that has ended, negative for a signal; None while it runs or
    before it was ever started. `beat_s`: when it last asked something of its interface. `reason`: its own last words.
    """

    runs: bool
    code: int | None = None
    beat_s: float = 0.0
    reason: str = ""


@dataclass(frozen=True, slots=True)
class News:
    """Something to announce."""

    kind: TextKind
    text: str


class Keeping:
    """The rule for one script. `fault`: why it does not run, for its health; None while it does or has done its work.

    Remembers when it was started, how often it failed in a row, and when to start it again.
    """

    def __init__(self, name: str, restart: Restart, watchdog_s: float, restart_s: float) -> None:
        self._name, self._restart, self._watchdog_s, self._restart_s = name, restart, watchdog_s, restart_s
        self.fault: str | None = "not started yet"
        self._started_s: float | None = None
        self._next_s: float | None = 0.0  # None: not again
        self._failures = 0
        self._asked_s: float | None = None
        self._why = ""  # it was ended
        self._news: list[News] = []

    @property
    def over(self) -> bool:
        """Whether it does not run and will not be started again."""
        return self._started_s is None and self._next_s is None

    def news(self) -> list[News]:
        """What is to be announced since the last call."""
        news, self._news = self._news, []
        return news

    def update(self, seen: Seen, enabled: bool, now_s: float) -> Deed:
        """`enabled`: whether scripts may run at all (SCR_ENABLE)."""
        if seen.runs:
            return self._running(seen, enabled, now_s)
        if self._started_s is not None:
            self._ended(seen, enabled, now_s)
        if not enabled:
            if self._next_s is not None:
                self.fault = "switched off: SCR_ENABLE"
            self._failures, self._next_s = 0, now_s
            return Deed.NOTHING
        if self._next_s is None or now_s < self._next_s:
            return Deed.NOTHING
        self._started_s, self._asked_s, self._why, self.fault = now_s, None, "", None
        self._say(TextKind.ROUTINE, "started")
        return Deed.START

    def not_started(self, reason: str, now_s: float) -> None:
        """Its process could not be made."""
        self._started_s = None
        self._fail(reason, now_s)

    def _running(self, seen: Seen, enabled: bool, now_s: float) -> Deed:
        if self._asked_s is not None:
            return Deed.KILL if now_s - self._asked_s > _KILL_AFTER_S else Deed.NOTHING
        assert self._started_s is not None
        silent_s = now_s - max(seen.beat_s, self._started_s)
        if not enabled:
            self._why = "switched off"
        elif self._watchdog_s > 0.0 and silent_s > self._watchdog_s:
            self._why = f"hung for {silent_s:.0f} s"
        else:
            return Deed.NOTHING
        self._asked_s = now_s
        return Deed.ASK_TO_END

    def _ended(self, seen: Seen, enabled: bool, now_s: float) -> None:
        assert self._started_s is not None
        steady = now_s - self._started_s > STEADY_S
        self._started_s, self._asked_s = None, None
        if steady:
            self._failures = 0
        if not enabled:
            self._say(TextKind.ROUTINE, "ended: SCR_ENABLE is 0")
            self._next_s = now_s
        elif seen.code == 0 and not self._why:
            self._say(TextKind.ROUTINE, "has ended")
            self._failures, self.fault = 0, None
            self._next_s = now_s + self._restart_s if self._restart == "always" else None
        else:
            self._fail(self._why or seen.reason or _ending(seen.code), now_s)

    def _fail(self, reason: str, now_s: float) -> None:
        self._failures += 1
        pause_s = min(_LONGEST_PAUSE_S, self._restart_s * 2.0 ** (self._failures - 1))
        self.fault = reason
        self._say(TextKind.ATTENTION, f"failed: {reason}")
        if self._restart == "never":
            self._next_s = None
        elif self._failures >= MOST_FAILURES:
            self._next_s = None
            self.fault = f"given up after {self._failures} failures: {reason}"
            self._say(TextKind.ATTENTION, f"given up after {self._failures} failures")
        else:
            self._next_s = now_s + pause_s

    def _say(self, kind: TextKind, text: str) -> None:
        self._news.append(News(kind, f"Script {self._name} {text}"))


def _ending(code: int | None) -> str:
    if code is None:
        return "it ended"
    return f"ended by signal {-code}" if code < 0 else f"exit code {code}"
