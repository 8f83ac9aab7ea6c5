"""A storage and a worker whose work is done when a test says so."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Future
from typing import Any

from companion.core.storing import Stored, Ticket
from companion.core.tick import DeviceHealth
from companion.core.work import settle


class SlowStorage:
    """Remembers what it was given. A ticket of the parameters covers what was set before it was settled."""

    def __init__(self) -> None:
        self.tickets: list[Ticket] = []
        self.plans: list[tuple[int, tuple[Any, ...]]] = []
        self._newest = Ticket()

    def parameters(self) -> Ticket:
        if not self._newest.pending or self._newest not in self.tickets:
            self._newest = self._new()
        return self._newest

    def progress(self) -> Ticket:
        return self._new()

    def plan(self, kind: int, items: Sequence[Any]) -> Ticket:
        self.plans.append((int(kind), tuple(items)))
        return self._new()

    def health(self, now_s: float) -> Sequence[DeviceHealth]:
        return ()

    def lost(self) -> Sequence[str]:
        return ()

    def _new(self) -> Ticket:
        self.tickets.append(Ticket())
        return self.tickets[-1]

    def settle(self, state: Stored = Stored.DURABLE, reason: str = "", full: bool = False) -> None:
        """All tickets that are pending."""
        for ticket in self.tickets:
            if ticket.pending:
                ticket.reason, ticket.full, ticket.state = reason, full, state

    def fail(self, reason: str = "No space left on device", full: bool = True) -> None:
        self.settle(Stored.FAILED, reason, full)


class SlowWorker:
    """Carries work out when `work` is called."""

    def __init__(self) -> None:
        self._waiting: list[Callable[[], None]] = []

    def submit(self, work: Callable[[], Any], urgent: bool = False) -> Future[Any]:
        future: Future[Any] = Future()

        def carry_out() -> None:
            if future.set_running_or_notify_cancel():
                settle(future, work)

        self._waiting.append(carry_out)
        return future

    def work(self) -> int:
        """All that waits; how much that was."""
        waiting, self._waiting = self._waiting, []
        for carry_out in waiting:
            carry_out()
        return len(waiting)
