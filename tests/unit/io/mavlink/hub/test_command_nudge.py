"""MAV_CMD_USER_1: nudges and headings."""

from __future__ import annotations

import math
from typing import Any

import pytest

from tests.unit.io.mavlink.hub.conftest import Rig

ACCEPTED, DENIED = 0, 2
USER_1 = 31010


def result(messages: list[Any]) -> int:
    (answer,) = [m for m in messages if m.get_type() == "COMMAND_ACK"]
    return int(answer.result)


def test_a_nudge(rig: Rig) -> None:
    assert result(rig.command(USER_1, 1.0, 1.5, -0.5, 10.0)) == ACCEPTED
    assert rig.supervisor.asked == [("nudge", 1.5, -0.5, pytest.approx(math.radians(10.0)))]


def test_what_is_left_out_does_not_change(rig: Rig) -> None:
    assert result(rig.command(USER_1, 1.0, math.nan, 2.0, math.nan)) == ACCEPTED
    assert rig.supervisor.asked == [("nudge", 0.0, 2.0, 0.0)]


def test_a_heading(rig: Rig) -> None:
    assert result(rig.command(USER_1, 2.0, 270.0)) == ACCEPTED
    assert rig.supervisor.asked == [("set_heading", pytest.approx(math.radians(270.0)))]


@pytest.mark.parametrize(
    "params", [(0.0,), (3.0, 1.0), (1.5, 1.0), (math.nan, 1.0), (2.0, 361.0), (2.0, -1.0), (2.0, math.nan)]
)
def test_what_it_is_not(rig: Rig, params: tuple[float, ...]) -> None:
    assert result(rig.command(USER_1, *params)) == DENIED
    assert rig.supervisor.asked == []


def test_sent_again_by_a_client_that_missed_the_answer_it_is_done_once(rig: Rig) -> None:
    for _ in range(3):
        assert result(rig.command(USER_1, 1.0, 1.0, 0.0, 0.0)) == ACCEPTED
    assert len(rig.supervisor.asked) == 1
    assert result(rig.command(USER_1, 1.0, 0.5, 0.0, 0.0)) == ACCEPTED
    assert len(rig.supervisor.asked) == 2


@pytest.mark.parametrize("between", [(512, 242.0), (511, 30.0, 100_000.0), (410,), (401,)])
def test_what_the_client_reads_meanwhile_makes_a_repetition_no_new_nudge(rig: Rig, between: tuple[float, ...]) -> None:
    rig.command(USER_1, 1.0, 1.0, 0.0, 0.0)
    assert result(rig.command(int(between[0]), *between[1:])) == ACCEPTED
    assert result(rig.command(USER_1, 1.0, 1.0, 0.0, 0.0)) == ACCEPTED
    assert len(rig.supervisor.asked) == 1
