"""MAV_CMD_USER_2: retractable thrusters; and where they stand, as ground stations are told."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

from companion.config.vessel import find, load
from companion.core.actuation import ThrusterCondition
from tests.unit.io.mavlink.hub.conftest import Rig

ACCEPTED, DENIED = 0, 2
USER_2 = 31011


def result(messages: list[Any]) -> int:
    (answer,) = [m for m in messages if m.get_type() == "COMMAND_ACK"]
    return int(answer.result)


@pytest.mark.parametrize(("selector", "lower"), [(1.0, True), (2.0, False)])
def test_lower_and_retract(rig: Rig, selector: float, lower: bool) -> None:
    assert result(rig.command(USER_2, selector)) == ACCEPTED
    assert rig.supervisor.asked == [("lower_thrusters", lower)]


@pytest.mark.parametrize("selector", [0.0, 3.0, 1.5, math.nan])
def test_what_it_is_not(rig: Rig, selector: float) -> None:
    assert result(rig.command(USER_2, selector)) == DENIED
    assert rig.supervisor.asked == []


@pytest.mark.parametrize(
    ("condition", "value"),
    [
        (ThrusterCondition.RETRACTED, 0.0),
        (ThrusterCondition.MOVING, 0.5),
        (ThrusterCondition.READY, 1.0),
        (ThrusterCondition.FAILED, math.nan),
    ],
)
def test_where_it_stands_is_told(rig: Rig, condition: ThrusterCondition, value: float) -> None:
    rig.vessel.config = load(find("revolt"))
    rig.run(2.0, conditions=(ThrusterCondition.READY, ThrusterCondition.READY, condition))
    told = [m for m in rig.desk.hear() if m.get_type() == "NAMED_VALUE_FLOAT"]
    assert {m.name for m in told} == {"bow_down"}
    assert all(m.value == value or (math.isnan(value) and math.isnan(m.value)) for m in told)


def test_a_boat_without_one_says_nothing(rig: Rig) -> None:
    boat = load(find("revolt"))
    rig.vessel.config = replace(boat, thrusters=boat.thrusters[:2])
    rig.run(2.0, conditions=(ThrusterCondition.READY, ThrusterCondition.READY))
    assert not [m for m in rig.desk.hear() if m.get_type() == "NAMED_VALUE_FLOAT"]
