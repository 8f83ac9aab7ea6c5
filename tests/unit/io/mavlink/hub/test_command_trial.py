"""MAV_CMD_USER_5: a sea trial, and the operator's word on what it found."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from companion.core.decision import ACCEPTED as DONE
from companion.core.decision import Outcome, Result
from companion.core.storing import Stored, Ticket
from companion.modes.trial.mode import TrialOrder
from tests.unit.io.mavlink.hub.conftest import Rig

ACCEPTED, TEMPORARILY_REJECTED, DENIED, FAILED = 0, 1, 2, 4
USER_5 = 31014
NAN = math.nan


def results(messages: list[Any]) -> list[int]:
    return [m.result for m in messages if m.get_type() == "COMMAND_ACK"]


@pytest.mark.parametrize(("params", "radius_m"), [((30.0,), 30.0), ((0.0,), None), ((NAN, NAN), None)])
def test_a_trial_with_its_circle(rig: Rig, params: tuple[float, ...], radius_m: float | None) -> None:
    assert results(rig.command(USER_5, *params)) == [ACCEPTED]
    assert rig.supervisor.asked == [("give_order", TrialOrder(radius_m))]


@pytest.mark.parametrize("params", [(-1.0,), (math.inf,), (0.0, 3.0), (0.0, 0.5)])
def test_what_it_is_not(rig: Rig, params: tuple[float, ...]) -> None:
    assert results(rig.command(USER_5, *params)) == [DENIED]
    assert rig.supervisor.asked == []


def word(rig: Rig, outcome: Outcome, ticket: Ticket | None) -> list[str]:
    """The supervisor answers so; returns what it is asked."""
    asked: list[str] = []

    def answer(what: str) -> tuple[Outcome, Ticket | None]:
        asked.append(what)
        return outcome, ticket

    duty = SimpleNamespace(accept=lambda now_s: answer("accept"), undo=lambda now_s: answer("undo"))
    rig.supervisor.trial_duty = duty  # type: ignore[attr-defined]
    return asked


@pytest.mark.parametrize(("param2", "what"), [(1.0, "accept"), (2.0, "undo")])
def test_the_word_is_acknowledged_once_it_is_stored(rig: Rig, param2: float, what: str) -> None:
    ticket = Ticket()
    asked = word(rig, DONE, ticket)
    assert results(rig.command(USER_5, 0.0, param2)) == [] and asked == [what]
    ticket.state = Stored.DURABLE
    assert results(rig.ask()) == [ACCEPTED]


def test_a_repetition_after_slow_storing_is_only_acknowledged_again(rig: Rig) -> None:
    """Counted from the command, the boat undid a second model for a client whose acknowledgement was lost."""
    ticket = Ticket()
    asked = word(rig, DONE, ticket)
    rig.command(USER_5, 0.0, 2.0)
    rig.run(4.0)
    ticket.state = Stored.DURABLE
    rig.ask()
    rig.run(0.5)
    assert results(rig.command(USER_5, 0.0, 2.0))[-1] == ACCEPTED and asked == ["undo"]


def test_what_could_not_be_stored_has_failed(rig: Rig) -> None:
    ticket = Ticket()
    word(rig, DONE, ticket)
    rig.command(USER_5, 0.0, 1.0)
    ticket.reason, ticket.state = "No space left on device", Stored.FAILED
    heard = rig.ask()
    assert results(heard) == [FAILED]
    assert "Trial: nothing changed: No space left on device" in [m.text for m in heard if m.get_type() == "STATUSTEXT"]


def test_a_refusal_is_temporary(rig: Rig) -> None:
    word(rig, Outcome(Result.TEMPORARILY_REJECTED, "Trial accept refused: no trial result waits"), None)
    assert results(rig.command(USER_5, 0.0, 1.0)) == [TEMPORARILY_REJECTED]
