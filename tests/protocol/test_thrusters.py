"""Thrusters that retract and thrusters that do not obey, from a ground station's desk: a whole vessel in lockstep."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from companion.cli.rig import LockstepRig
from companion.core.actuation import Beacon, Light, ThrusterCondition
from companion.io.mavlink.wire import messages as mavlink
from sitl.scenarios.rig import Conditions
from tests.protocol.desk import Desk

ACCEPTED, TEMPORARILY_REJECTED = 0, 1
USER_2, LOWER, RETRACT = 31011, 1, 2
ARM, SET_MODE = 400, 176
MANUAL, HOLD = (1, 1), (1, 4, 3)
BOW = 2

MakeDesk = Callable[..., Desk]


@pytest.fixture
def make_desk(tmp_path: Path) -> Iterator[MakeDesk]:
    desks: list[Desk] = []

    def make(wind: str | None = None) -> Desk:
        desks.append(Desk(tmp_path, LockstepRig(Conditions("revolt", seed=3, wind=wind), tmp_path / "log")))
        desks[0].ready()
        return desks[0]

    yield make
    for desk in desks:
        desk.close()


def sail(desk: Desk, seconds: float, sway: float | None = None) -> float:
    """The greatest distance from home. Sticks centred but for sway, where they are given. Never does a propeller run
    that is not down."""
    board, world, worst_m = desk.rig.world.boards[0], desk.rig.world, 0.0
    for k in range(round(10 * seconds)):
        if k % 10 == 0:
            desk.heartbeat()
        if sway is not None:
            desk.tell(mavlink.MAVLink_manual_control_message(1, 0, round(1000 * sway), 500, 0, 0))
        desk.tick()
        truth = world.truth
        assert board.last_command is not None
        assert truth.down["bow"] == 1.0 or board.last_command.thrusters[BOW].throttle == 0.0
        worst_m = max(worst_m, math.hypot(truth.north_m, truth.east_m))
    return worst_m


def condition(desk: Desk, index: int) -> ThrusterCondition:
    assert desk.vessel.last_tick is not None
    return desk.vessel.last_tick.conditions[index]


def test_retract_in_manual_and_hold_lowers_it_again(make_desk: MakeDesk, tmp_path: Path) -> None:
    desk = make_desk()
    board, travel_s = desk.rig.world.boards[0], desk.rig.config.thrusters[BOW].travel_s
    sail(desk, 0.5, sway=0.0)
    assert desk.result(SET_MODE, *MANUAL) == ACCEPTED and desk.result(ARM, 1) == ACCEPTED
    sail(desk, 3.0, sway=0.5)
    assert board.last_command is not None and board.last_command.thrusters[BOW].throttle > 0.3
    assert board.beacon == Beacon(Light.OFF, Light.STEADY, Light.BLINK)
    assert desk.result(USER_2, RETRACT) == ACCEPTED
    sail(desk, 1.0, sway=0.5)
    assert condition(desk, BOW) is ThrusterCondition.MOVING and desk.rig.world.truth.down["bow"] < 1.0
    sail(desk, travel_s, sway=0.5)
    assert condition(desk, BOW) is ThrusterCondition.RETRACTED and desk.latest("NAMED_VALUE_FLOAT").value == 0.0
    assert "Thruster bow is being retracted" in desk.texts() and "Thruster bow is retracted" in desk.texts()
    assert desk.result(SET_MODE, *HOLD) == ACCEPTED
    sail(desk, 1.0)
    assert "Hold: bow not down, sideways at most 5 of 25 N" in desk.texts()
    assert desk.result(USER_2, RETRACT) == TEMPORARILY_REJECTED
    sail(desk, travel_s)
    assert condition(desk, BOW) is ThrusterCondition.READY and "Thruster bow is lowered" in desk.texts()
    assert board.beacon == Beacon(Light.OFF, Light.BLINK, Light.BLINK)
    rows = (tmp_path / "log" / "ticks.csv").read_text(encoding="utf-8").splitlines()
    assert [rows[-1].split(",")[rows[0].split(",").index(f"{name}_condition")] for name in ("stern_port", "bow")] == [
        "ready",
        "ready",
    ]
    assert ",moving" in "".join(rows) and ",retracted" in "".join(rows)
    assert "bow_down" in (tmp_path / "log" / "truth.csv").read_text(encoding="utf-8").splitlines()[0]


def test_a_stuck_azimuth_is_found_while_holding(make_desk: MakeDesk) -> None:
    """In gusts and while the boat turns, so that the pods must: it is found within a few seconds, and the boat stays
    where it is."""
    desk = make_desk(wind="5@200")
    assert desk.result(SET_MODE, *HOLD) == ACCEPTED and desk.result(ARM, 1) == ACCEPTED
    assert sail(desk, 12.0) < 0.5
    desk.rig.world.add_fault("thruster_stern_port_stuck", 16.0)
    assert desk.result(31010, 1, 0.0, 0.0, 20.0) == ACCEPTED
    assert sail(desk, 5.0) < 0.5
    assert condition(desk, 0) is ThrusterCondition.FAILED
    assert desk.rig.world.boards[0].beacon.green is Light.STEADY
    assert sail(desk, 11.0) < 0.5
    assert desk.result(31010, 1, 0.0, 0.0, -20.0) == ACCEPTED
    assert sail(desk, 12.0) < 0.5
    assert condition(desk, 0) is ThrusterCondition.READY and "Thruster stern_port follows again" in desk.texts()


def test_a_propeller_running_by_itself_is_said_while_disarmed(make_desk: MakeDesk) -> None:
    desk = make_desk()
    desk.rig.world.add_fault("thruster_stern_port_runaway", 5.0)
    sail(desk, 4.0)
    alerts = [m.text for m in desk.received if m.get_type() == "STATUSTEXT" and m.severity == 1]
    assert alerts == ["Thruster stern_port runaway: cut power"]
    assert desk.result(ARM, 1) == TEMPORARILY_REJECTED
    assert "PreArm: thruster stern_port has failed" in desk.texts()


def test_a_thruster_that_does_not_come_down_is_left_out_and_said(make_desk: MakeDesk) -> None:
    desk = make_desk()
    assert desk.result(USER_2, RETRACT) == ACCEPTED
    sail(desk, 6.0)
    desk.rig.world.add_fault("thruster_bow_jammed")
    assert desk.result(SET_MODE, *HOLD) == ACCEPTED and desk.result(ARM, 1) == ACCEPTED
    assert sail(desk, 14.0) < 0.5
    assert condition(desk, BOW) is ThrusterCondition.FAILED
    assert "".join(desk.texts()).count("Thruster bow does not lower: not used") == 1
