"""What some services do beside handling messages: the hub looks for it once, when it begins."""

from __future__ import annotations

from typing import Protocol, runtime_checkable


@runtime_checkable
class AnsweringService(Protocol):
    """A service that owes answers to requests whose work is done beside the control thread."""

    def answer(self, now_s: float) -> None:
        """Answer what is done."""
        ...


@runtime_checkable
class ClosingService(Protocol):
    """A service that holds resources to release."""

    def close(self) -> None:
        """Release what the service holds."""
        ...
