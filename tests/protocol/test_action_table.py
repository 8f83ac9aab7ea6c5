"""Every row of the plug-ins' table against a whole vessel in lockstep: taken where the table says so, understood
everywhere."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator

import pytest

from companion.core.setpoint import PoseSetpoint
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.personas import ARDUPILOT, PX4
from gcs_plugins.commands import ACTIONS, MODES, OperatorAction, Where
from tests.protocol.desk import Desk, Sender
from tests.protocol.test_qgroundcontrol import FRAME, item
from tests.trials import KnownTrials

ARM, SET_MODE, PAUSE_CONTINUE, MISSION_START = 400, 176, 193, 300
ACCEPTED, UNSUPPORTED = mavlink.MAV_RESULT_ACCEPTED, mavlink.MAV_RESULT_UNSUPPORTED


@pytest.fixture(scope="module")
def desk(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Desk]:
    desk = Desk(tmp_path_factory.mktemp("table"))
    desk.tick()
    desk.ready()
    assert desk.upload([item(n, 16, *point) for n, point in enumerate(((30.0, 0.0), (30.0, 30.0), (0.0, 30.0)))]) == 0
    yield desk
    desk.close()


def leader_heard(desk: Desk) -> None:
    """A phone's FOLLOW_TARGET, 30 m ahead."""
    phone = Sender(77)
    for _ in range(5):
        lat_deg, lon_deg = FRAME.to_geodetic(30.0, 0.0)
        at = (round(desk.rig.now_s * 1000), 3, round(lat_deg * 1e7), round(lon_deg * 1e7), 0.0)
        rest = ([0.0] * 3, [0.0] * 3, [1.0, 0.0, 0.0, 0.0], [0.0] * 3, [2.0, 0.0, 2.0], 0)
        desk.rig.send(phone.packed(mavlink.MAVLink_follow_target_message(*at, *rest)))
        desk.tick(2)


def armed_in(desk: Desk, mode: str) -> None:
    assert desk.result(SET_MODE, 1.0, MODES[mode].px4) == ACCEPTED
    assert desk.result(ARM, 1.0) == ACCEPTED
    desk.tick(3)


def bring_about(desk: Desk, where: Where) -> None:
    """The state in which the table says that an action is taken."""
    desk.heartbeat()
    assert desk.result(ARM, 0.0, 21196.0) == ACCEPTED
    desk.tick(3)
    if where in (Where.DISARMED, Where.UNLESS_NEEDED):
        return
    armed_in(desk, "Hold")
    if where is Where.PAUSED:
        assert desk.result(MISSION_START) == ACCEPTED
        desk.tick(10)
        assert desk.result(PAUSE_CONTINUE, 0.0) == ACCEPTED
    if where is Where.LEADER:
        leader_heard(desk)
    desk.vessel.supervisor.trial_duty.results = KnownTrials() if where in (Where.TRIAL, Where.ACCEPTED) else None
    if where is Where.ASKED:
        desk.rig.world.add_fault("gnss_jump", 2.0)
        desk.tick(15)


@pytest.mark.parametrize("action", ACTIONS, ids=lambda action: action.name)
def test_a_row_is_taken_where_the_table_says(desk: Desk, action: OperatorAction) -> None:
    bring_about(desk, action.where)
    assert desk.result(action.command, *action.all_params()) == ACCEPTED, desk.texts()[-3:]
    if action.mode is not None:
        assert desk.latest("HEARTBEAT").custom_mode == MODES[action.mode].px4


@pytest.mark.parametrize("action", ACTIONS, ids=lambda action: action.name)
def test_a_row_is_understood_by_a_boat_that_lies_disarmed(desk: Desk, action: OperatorAction) -> None:
    bring_about(desk, Where.DISARMED)
    assert desk.result(action.command, *action.all_params()) != UNSUPPORTED


def test_stop_and_nudges_do_what_they_say(desk: Desk) -> None:
    rows = {action.name: action for action in ACTIONS}
    bring_about(desk, Where.HOLD)
    desk.tick(30)
    before = desk.vessel.last_tick
    assert before is not None and isinstance(before.setpoint, PoseSetpoint)
    north_m, east_m, yaw_rad = (before.setpoint.north_m, before.setpoint.east_m, before.setpoint.yaw_rad)
    desk.result(rows["nudge-starboard"].command, *rows["nudge-starboard"].all_params())
    for _ in range(22):
        desk.heartbeat()
        desk.tick(10)
    after = desk.vessel.last_tick
    assert after is not None and isinstance(after.setpoint, PoseSetpoint)
    moved = (after.setpoint.north_m - north_m, after.setpoint.east_m - east_m)
    assert moved == pytest.approx((-math.sin(yaw_rad), math.cos(yaw_rad)), abs=0.05)
    desk.result(rows["stop"].command, *rows["stop"].all_params())
    desk.tick()
    last = desk.vessel.last_tick
    assert last is not None and all(thruster.throttle == 0.0 for thruster in last.command.thrusters)


def test_mode_numbers_are_those_of_the_links() -> None:
    for persona, numbers in (
        (PX4, {m: n.px4 for m, n in MODES.items()}),
        (ARDUPILOT, {m: n.rover for m, n in MODES.items()}),
    ):
        assert {mode.value: number for mode, number in persona.modes.items()} == numbers


@pytest.mark.parametrize("rover", [False, True])
def test_mode_numbers_are_exact_in_the_32_bits_of_a_param(rover: bool) -> None:
    for action in ACTIONS:
        params = action.all_params(rover)
        assert len(params) == 7
        assert action.mode is None or struct.unpack("<f", struct.pack("<f", params[1]))[0] == params[1]
