"""Says that the program stood still: the host was too busy, or stopped it."""

from __future__ import annotations

from companion.core.decision import TextKind
from companion.core.events import EventLog

LEAST_S = 0.5  # boards go neutral by then


class Standstill:
    """`update(now_s)` once a tick. Remembers the time of the last one."""

    def __init__(self, events: EventLog) -> None:
        self._events = events
        self._last_s: float | None = None

    def update(self, now_s: float) -> None:
        """Announce a tick that comes late."""
        late_s = 0.0 if self._last_s is None else now_s - self._last_s
        self._last_s = now_s
        if late_s >= LEAST_S:
            text = f"The program stood still for {late_s:.1f} s"
            self._events.say(now_s, TextKind.ATTENTION, "stood_still", text)
