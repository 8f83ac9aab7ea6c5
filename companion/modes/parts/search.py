"""A search for a way that may take longer than a tick: it is done beside the control thread."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, Generic, TypeVar

from companion.core.decision import TextKind
from companion.core.events import EventLog

T = TypeVar("T")

_TELL_S = 1.0
_LONGEST_S = 30.0

Submit = Callable[[Callable[[], Any]], "Future[Any]"]


class Search(Generic[T]):
    """`begin(work)`; then `take()` once it is `done`. Without a worker it is done at once. Remembers the search under
    way.

    `work` uses nothing that may change meanwhile. Who begins it judges whether the result still fits.
    """

    def __init__(self, submit: Submit) -> None:
        self._submit = submit
        self._future: Future[T] | None = None

    @property
    def pending(self) -> bool:
        """Whether a search was begun whose result nobody took."""
        return self._future is not None

    @property
    def done(self) -> bool:
        """Whether there is a result to take."""
        return self._future is not None and self._future.done()

    def begin(self, work: Callable[[], T]) -> None:
        """Look for something else; what was looked for before is given up."""
        self.drop()
        self._future = self._submit(work)

    def take(self) -> T:
        """The result. Raises what the work raised, and RuntimeError where there is none."""
        future, self._future = self._future, None
        if future is None:
            raise RuntimeError("Search.take before begin")
        return future.result()

    def drop(self) -> None:
        """Give it up."""
        if self._future is not None:
            self._future.cancel()
            self._future = None


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

    def update(self, now_s: float) -> str | None:
        """Announce a wait of more than a second. Returns why it has to end after 30 s, else None."""
        self._since_s = now_s if self._since_s is None else self._since_s
        if not self._told and now_s - self._since_s >= _TELL_S:
            self._told = True
            self._events.say(now_s, TextKind.ROUTINE, "planning", "Planning a way")
        return f"no way found in {_LONGEST_S:.0f} s" if now_s - self._since_s >= _LONGEST_S else None
