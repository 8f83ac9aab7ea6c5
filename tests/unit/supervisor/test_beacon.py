"""The beacon, against table 6.4 of the ReVolt thesis."""

from __future__ import annotations

import pytest

from companion.core.actuation import Beacon, Light, ThrusterCondition
from companion.core.decision import MissionProgress, MissionState, ModeId, Status
from companion.core.tick import DeviceHealth
from companion.supervisor.beacon import CAPSIZED, beacon
from companion.supervisor.failsafes import FAILSAFES

OFF, STEADY, BLINK = Light.OFF, Light.STEADY, Light.BLINK
READY, UP, MOVING, FAILED = (
    ThrusterCondition.READY,
    ThrusterCondition.RETRACTED,
    ThrusterCondition.MOVING,
    ThrusterCondition.FAILED,
)
WELL, ILL = DeviceHealth("gnss", True, 0.1), DeviceHealth("imu", False, None)


def status(mode: ModeId, armed: bool = True, failsafes: tuple[str, ...] = ()) -> Status:
    return Status(0.0, mode, mode, armed, (), failsafes, None, MissionProgress(MissionState.NO_MISSION, 0, 0))


@pytest.mark.parametrize("armed", [True, False])
@pytest.mark.parametrize("mode", list(ModeId))
def test_yellow_says_who_steers(mode: ModeId, armed: bool) -> None:
    shown = beacon(status(mode, armed), False, (WELL,), (READY,))
    assert shown == Beacon(OFF, STEADY if mode is ModeId.MANUAL else BLINK, BLINK)


def test_red_is_water() -> None:
    assert beacon(status(ModeId.HOLD), True, (WELL,), (READY,)).red is STEADY


@pytest.mark.parametrize(
    ("failsafes", "health", "conditions", "green"),
    [
        ((), (WELL, WELL), (READY, UP, MOVING), BLINK),
        (("leak",), (WELL,), (READY,), STEADY),
        ((), (WELL, ILL), (READY,), STEADY),
        ((), (WELL,), (READY, FAILED), STEADY),
    ],
)
def test_green_is_health(
    failsafes: tuple[str, ...],
    health: tuple[DeviceHealth, ...],
    conditions: tuple[ThrusterCondition, ...],
    green: Light,
) -> None:
    assert beacon(status(ModeId.HOLD, failsafes=failsafes), False, health, conditions).green is green


def test_red_is_a_capsized_boat_too() -> None:
    assert CAPSIZED in {row.name for row in FAILSAFES}
    assert beacon(status(ModeId.HOLD, failsafes=(CAPSIZED,)), False, (WELL,), (READY,)).red is STEADY
