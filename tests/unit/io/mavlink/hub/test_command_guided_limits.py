"""MAV_CMD_DO_GUIDED_LIMITS: time and distance; heights are none of a boat's."""

from __future__ import annotations

import math
from typing import Any

import pytest

ACCEPTED, DENIED = 0, 2
DO_GUIDED_LIMITS = 222
NAN = math.nan


def result(messages: list[Any]) -> int:
    (answer,) = [m for m in messages if m.get_type() == "COMMAND_ACK"]
    return int(answer.result)


@pytest.mark.parametrize(
    ("params", "limits"),
    [
        ((30.0, 5.0, 9.0, 50.0), (30.0, 50.0)),
        ((0.0, 0.0, 0.0, 20.0), (None, 20.0)),
        ((NAN, NAN, NAN, NAN), (None, None)),
        ((0.0, 0.0, 0.0, 0.0), (None, None)),
    ],
)
def test_limits(rig: Any, params: tuple[float, ...], limits: tuple[float | None, float | None]) -> None:
    assert result(rig.command(DO_GUIDED_LIMITS, *params)) == ACCEPTED
    assert rig.supervisor.asked == [("limit_offboard", *limits)]


@pytest.mark.parametrize("params", [(-1.0,), (30.0, 0.0, 0.0, -5.0), (math.inf,), (0.0, 0.0, 0.0, math.inf)])
def test_what_cannot_be_meant(rig: Any, params: tuple[float, ...]) -> None:
    messages = rig.command(DO_GUIDED_LIMITS, *params)
    assert result(messages) == DENIED and rig.supervisor.asked == []
    assert any(m.get_type() == "STATUSTEXT" and "limits" in m.text for m in messages)
