"""MAV_CMD_USER_4: the operator's word on sensors that seem to lie."""

from __future__ import annotations

import math
from typing import Any

import pytest

from companion.core.decision import Outcome, Result
from tests.unit.io.mavlink.hub.conftest import Rig

ACCEPTED, TEMPORARILY_REJECTED, DENIED = 0, 1, 2
USER_4 = 31013


def result(messages: list[Any]) -> int:
    (answer,) = [m for m in messages if m.get_type() == "COMMAND_ACK"]
    return int(answer.result)


@pytest.mark.parametrize(("param1", "accept"), [(1.0, True), (2.0, False)])
def test_accept_or_reject(rig: Rig, param1: float, accept: bool) -> None:
    assert result(rig.command(USER_4, param1)) == ACCEPTED
    assert rig.supervisor.asked == [("senses", accept)]


@pytest.mark.parametrize("param1", [0.0, 3.0, 1.5, math.nan])
def test_what_it_is_not(rig: Rig, param1: float) -> None:
    assert result(rig.command(USER_4, param1)) == DENIED
    assert rig.supervisor.asked == []


def test_nothing_to_answer(rig: Rig) -> None:
    rig.supervisor.outcome = Outcome(Result.TEMPORARILY_REJECTED, "Accept refused: no sensor waits for an answer")
    assert result(rig.command(USER_4, 1.0)) == TEMPORARILY_REJECTED


def test_sent_again_by_a_client_that_missed_the_answer_it_is_done_once(rig: Rig) -> None:
    for _ in range(3):
        assert result(rig.command(USER_4, 1.0)) == ACCEPTED
    assert rig.supervisor.asked == [("senses", True)]
