"""Results of sea trials that a test has made up."""

from __future__ import annotations

from concurrent.futures import Future

from companion.core.storing import Stored, Ticket
from companion.core.trial_results import TrialFinding


class KnownTrials:
    """`TrialResults` whose futures and tickets the test settles (`runs`, `ticket`). `at_once`: each ticket is durable
    from the start."""

    def __init__(self, proposal: str | None = "b", in_force: str | None = "a", at_once: bool = True) -> None:
        self.proposal, self.in_force = proposal, in_force
        self.runs: Future[TrialFinding] = Future()
        self.ticket = Ticket(Stored.DURABLE if at_once else Stored.PENDING)
        self.parameters: dict[str, float] = {}
        self.done: list[str] = []

    def identify(self) -> Future[TrialFinding]:
        self.done.append("identify")
        return self.runs

    def accept(self) -> Ticket:
        self.done.append("accept")
        return self.ticket

    def undo(self) -> Ticket:
        self.done.append("undo")
        return self.ticket
