"""What is to be stored, and how far that is: nothing is acknowledged before it is on the medium."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum


class Stored(Enum):
    """How far it is. The writer goes on trying after a failure."""

    PENDING = "pending"
    DURABLE = "durable"
    FAILED = "failed"


@dataclass(slots=True, eq=False)
class Ticket:
    """One thing to store, as the writer gives it to who waits for it. `reason`: why the last attempt failed. `full`:
    because there is no space."""

    state: Stored = Stored.PENDING
    reason: str = ""
    full: bool = False

    @property
    def pending(self) -> bool:
        """Whether the first attempt is still to come, or under way."""
        return self.state is Stored.PENDING

    @property
    def durable(self) -> bool:
        """Whether it is on the medium."""
        return self.state is Stored.DURABLE

    @property
    def failed(self) -> bool:
        """Whether the last attempt failed. The writer may settle the ticket between two questions: neither pending nor
        durable does not mean failed."""
        return self.state is Stored.FAILED


def durable() -> Ticket:
    """The ticket of what needs no storing."""
    return Ticket(Stored.DURABLE)
