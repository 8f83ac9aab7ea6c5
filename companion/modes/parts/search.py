"""A search for a way that may take longer than a tick: it is done beside the control thread."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Generic, TypeVar

from companion.core.decision import TextKind
from companion.core.events import EventLog
from companion.core.work import Job, Submit

T = TypeVar("T")

SAME_PLACE_M = 1.0
_TELL_S = 1.0
_LONGEST_S = 30.0

Key = tuple[object, ...]
Place = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Answer(Generic[T]):
    """What a search has found, and for which question: what it depends on, and where the boat was."""

    key: Key
    here: Place
    found: T

    def fits(self, key: Key, here: Place, near_m: float) -> bool:
        """Whether it answers that question too."""
        return key == self.key and math.dist(here, self.here) <= near_m


class Search(Generic[T]):
    """Finds what depends on a key and on the place of the boat: `look` each tick until it answers. Without a worker
    that is at once. Remembers the newest answer, and the question that is being worked on."""

    def __init__(self, submit: Submit) -> None:
        self._job: Job[Answer[T]] = Job(submit)
        self._asked: Key = ()
        self._answer: Answer[T] | None = None

    @property
    def pending(self) -> bool:
        """Whether it looks for something."""
        return self._job.pending

    def look(self, key: Key, here: Place, work: Callable[[], T], near_m: float = SAME_PLACE_M) -> Answer[T] | None:
        """The answer for a place within `near_m` from `here`; None while it is looked for. `work` uses nothing that may
        change meanwhile. Raises what it raised."""
        answer = self.known(key, here, near_m)
        if answer is None and (not self._job.pending or self._asked != key):
            self._asked = key
            self._job.begin(lambda: Answer(key, here, work()))
            answer = self.known(key, here, near_m)
        return answer

    def known(self, key: Key, here: Place, near_m: float = math.inf) -> Answer[T] | None:
        """As `look`, without looking for it."""
        if self._job.done:
            self._answer = self._job.take()
        answer = self._answer
        return answer if answer is not None and answer.fits(key, here, near_m) else None

    def drop(self) -> None:
        """Give up, and forget what was found."""
        self._job.drop()
        self._answer = None


class Waiting:
    """A mode that waits for a way: `update(now_s)` each tick, `reset()` once it has one. Remembers since when it waits,
    and whether it said so."""

    def __init__(self, events: EventLog) -> None:
        self._events = events
        self._since_s: float | None = None
        self._told = False

    @property
    def waits(self) -> bool:
        """Whether it waits."""
        return self._since_s is not None

    def reset(self) -> None:
        """It does not wait."""
        self._since_s, self._told = None, False

    def waited_s(self, now_s: float) -> float:
        """For how long it waits."""
        return 0.0 if self._since_s is None else now_s - self._since_s

    def update(self, now_s: float) -> str | None:
        """Announce a wait of more than a second. Returns why it has to end after 30 s, else None."""
        self._since_s = now_s if self._since_s is None else self._since_s
        if not self._told and now_s - self._since_s >= _TELL_S:
            self._told = True
            self._events.say(now_s, TextKind.ROUTINE, "planning", "Planning a way")
        return f"no way found in {_LONGEST_S:.0f} s" if now_s - self._since_s >= _LONGEST_S else None
