"""The operator's word on sensors that seem to lie."""

from __future__ import annotations

from collections.abc import Callable

from companion.core.decision import ACCEPTED, Outcome, Result, TextKind
from companion.core.events import EventLog

Decide = Callable[[bool, float], str | None]
"""(accept, now_s) → why not, or None; `Estimator.answer`."""


class Senses:
    """`request` passes an answer on. Remembers nothing but who decides: set `decide` before the first request."""

    def __init__(self, events: EventLog) -> None:
        self._events = events
        self.decide: Decide = lambda accept, now_s: "nothing is estimated"

    def request(self, accept: bool, now_s: float) -> Outcome:
        """Believe the sensors that the boat asks about, wherever they have jumped to; or reject them: it asks no more,
        and uses them when they agree again."""
        reason = self.decide(accept, now_s)
        if reason is None:
            return ACCEPTED
        text = f"{'Accept' if accept else 'Reject'} refused: {reason}"
        self._events.say(now_s, TextKind.REFUSAL, "refused", text)
        return Outcome(Result.TEMPORARILY_REJECTED, text)
