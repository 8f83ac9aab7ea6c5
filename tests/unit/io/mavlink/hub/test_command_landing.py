"""NAV_TAKEOFF and NAV_LAND as clients written for aircraft send them, and the landed state that they wait for."""

from __future__ import annotations

import math
from typing import Any

import pytest

from companion.core.decision import Outcome, Result
from companion.io.mavlink.wire import messages as mavlink
from tests.unit.io.mavlink.hub.conftest import Rig
from tests.unit.io.mavlink.hub.test_commands import ACCEPTED, DENIED, result

TAKE_OFF, LAND = 22, 21
NAN = math.nan


@pytest.mark.parametrize("params", [(), (NAN,) * 7, (NAN, NAN, NAN, NAN, NAN, NAN, 488.0), (0.0,) * 6 + (10.0,)])
def test_a_take_off_with_whatever_params(rig: Rig, params: tuple[float, ...]) -> None:
    """As MAVSDK sends it to PX4, and Cockpit to ArduPilot."""
    assert result(rig.command(TAKE_OFF, *params)) == ACCEPTED
    assert rig.supervisor.asked == [("take_off",)]


def test_a_refusal_is_answered_as_such(rig: Rig) -> None:
    rig.supervisor.outcome = Outcome(Result.DENIED, "no")
    assert result(rig.command(TAKE_OFF)) == DENIED


@pytest.mark.parametrize(
    ("params", "place"),
    [
        ((), None),
        ((NAN,) * 7, None),
        ((0.0, 0.0, 0.0, NAN, 63.5, 10.5, 0.0), (63.5, 10.5)),
    ],
)
def test_land_here_or_at_a_place(rig: Rig, params: tuple[float, ...], place: Any) -> None:
    assert result(rig.command(LAND, *params)) == ACCEPTED
    assert rig.supervisor.asked == [("land", place)]


def test_land_at_no_place_on_earth_is_denied(rig: Rig) -> None:
    assert result(rig.command(LAND, 0.0, 0.0, 0.0, 0.0, 91.0, 10.0)) == DENIED
    assert rig.supervisor.asked == []


def test_the_landed_state_that_clients_wait_for(rig: Rig) -> None:
    on_ground, in_air = mavlink.MAV_LANDED_STATE_ON_GROUND, mavlink.MAV_LANDED_STATE_IN_AIR

    def state() -> int:
        answers = rig.command(512, float(mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE))
        return int(next(m for m in answers if m.get_type() == "EXTENDED_SYS_STATE").landed_state)

    assert state() == on_ground
    rig.supervisor.change(armed=True)
    assert state() == in_air
    rig.supervisor.change(landed=True)
    assert state() == on_ground
