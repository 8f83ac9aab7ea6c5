"""What becomes of a sea trial: the model that its log gives, and which model counts."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Future
from dataclasses import dataclass
from typing import Protocol

from companion.core.storing import Ticket


class TrialResultError(Exception):
    """A log that gives no model: one line that says why."""


@dataclass(frozen=True, slots=True)
class TrialFinding:
    """What the log of a trial says.

    `better`: the new model predicts better than the one in force, which otherwise stays, with gains that suit it.
    `error_share`: its prediction error over that of the one in force; None where nothing could be compared.
    """

    better: bool
    error_share: float | None = None


class TrialResults(Protocol):
    """Identifies a model from a trial's log, and keeps which models were accepted. Nothing here waits for a computation
    or for the medium."""

    @property
    def proposal(self) -> str | None:
        """The name of the newest model that nobody has accepted yet; None without one."""
        ...

    @property
    def in_force(self) -> str | None:
        """The name of the model that counts from the next start on; None for that of the vessel's file."""
        ...

    @property
    def parameters(self) -> Mapping[str, float]:
        """Those that the accepted models set from the next start on, where no operator has."""
        ...

    def identify(self) -> Future[TrialFinding]:
        """Begin to identify a model from the log of this run. The future may raise TrialResultError."""
        ...

    def accept(self) -> Ticket:
        """Let the proposal count from the next start on."""
        ...

    def undo(self) -> Ticket:
        """Let the model before the one in force count again from the next start on."""
        ...
