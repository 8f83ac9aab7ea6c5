"""What the vessel announces: to ground stations as STATUSTEXT, in the log as events."""

from __future__ import annotations

from collections.abc import Callable

from companion.core.decision import Event, TextKind

SHORT_NAME = 16
"""Most characters of a device's name in an announcement: a STATUSTEXT shows 50 in all."""

Announce = Callable[[float, TextKind, str, str], None]
"""(t_s, kind, name, text): `EventLog.say`, as blocks take it."""


def unheard(t_s: float, kind: TextKind, name: str, text: str) -> None:
    """Announce nothing: for blocks that stand alone."""


def encodable(text: str) -> str:
    """The text as any log and link can hold it: of a file's name, bytes that are not UTF-8 are spelt out."""
    return text.encode(errors="backslashreplace").decode()


class EventLog:
    """Collects the events of a tick. The same name and text within `repeat_s` is announced once, unless it is news
    again meanwhile."""

    def __init__(self, repeat_s: float = 10.0) -> None:
        self._repeat_s = repeat_s
        self._pending: list[Event] = []
        self._last: dict[str, Event] = {}

    def say(self, t_s: float, kind: TextKind, name: str, text: str) -> None:
        """Announce an event. `name`: stable, for programs (`mode_changed`, `gcs_lost`); `text`: for people, made
        `encodable`."""
        text = encodable(text)
        last = self._last.get(name)
        if last is not None and last.text == text and t_s - last.t_s < self._repeat_s:
            return
        event = Event(t_s, kind, name, text)
        self._last[name] = event
        self._pending.append(event)

    def renew(self, name: str) -> None:
        """What is announced next under that name is news, whatever was said before: its contrary has come true."""
        self._last.pop(name, None)

    def drain(self) -> tuple[Event, ...]:
        """The events since the last call, oldest first."""
        pending, self._pending = tuple(self._pending), []
        return pending
