"""The operator's word reaches the estimator; why not reaches the operator."""

from __future__ import annotations

from companion.core.decision import Result
from companion.core.events import EventLog
from companion.supervisor.senses import Senses


def test_the_answer_is_passed_on() -> None:
    asked: list[tuple[bool, float]] = []
    senses = Senses(EventLog())

    def decide(accept: bool, now_s: float) -> str | None:
        asked.append((accept, now_s))
        return None

    senses.decide = decide
    assert senses.request(True, 3.0).result is Result.ACCEPTED
    assert senses.request(False, 4.0).result is Result.ACCEPTED
    assert asked == [(True, 3.0), (False, 4.0)]


def test_why_not_is_said() -> None:
    senses = Senses(EventLog())
    refused = senses.request(True, 1.0)
    assert refused.result is Result.TEMPORARILY_REJECTED
    assert refused.reason == "Accept refused: nothing is estimated"
    senses.decide = lambda accept, now_s: "no sensor waits for an answer"
    assert senses.request(False, 2.0).reason == "Reject refused: no sensor waits for an answer"
