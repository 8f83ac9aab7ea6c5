"""Commands and items that people know from ArduPilot's Rover, against a whole vessel in lockstep."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from companion.cli.rig import LockstepRig
from companion.core.geodesy import LocalFrame
from companion.io.mavlink.wire import messages as mavlink
from sitl.scenarios.rig import Conditions
from tests.protocol.desk import Desk, of, rover_desk

ACCEPTED, REJECTED, DENIED, UNSUPPORTED = 0, 1, 2, 3
ARM, SET_MODE, JUMP_TAG, GUIDED_LIMITS = 400, 176, 601, 222
FENCE_ENABLE, SET_REVERSE, YAW, DELAY, DISTANCE = 207, 194, 115, 112, 114
WAYPOINT, MARK, JUMP_TO_MARK = 16, 600, 601
ACRO, HOLD, AUTO, SMART_RTL = 1, 4, 10, 12
MISSION, FENCE = 0, 1
FRAME = LocalFrame(63.4389, 10.3990)
NAN = math.nan


def item(
    seq: int, command: int, point: tuple[float, float] = (0.0, 0.0), param1: float = 0.0, kind: int = MISSION
) -> Any:
    lat_deg, lon_deg = FRAME.to_geodetic(*point)
    place = (round(lat_deg * 1e7), round(lon_deg * 1e7), 0.0)
    return mavlink.MAVLink_mission_item_int_message(1, 1, seq, 6, command, 0, 1, param1, 0.0, 0.0, NAN, *place, kind)


def zone(half_m: float = 40.0) -> list[Any]:
    corners = ((half_m, -half_m), (half_m, half_m), (-half_m, half_m), (-half_m, -half_m))
    return [item(seq, 5001, corner, 4.0, FENCE) for seq, corner in enumerate(corners)]


@pytest.fixture
def desk(tmp_path: Path) -> Iterator[Desk]:
    with rover_desk(tmp_path) as desk:
        desk.ready()
        yield desk


def armed_in_hold(desk: Desk) -> None:
    assert desk.result(SET_MODE, 1.0, float(HOLD)) == ACCEPTED
    assert desk.result(ARM, 1.0) == ACCEPTED
    desk.tick(3)


def fenced(desk: Desk) -> bool:
    """Whether the vessel reports a fence in force."""
    desk.tick(15)
    bit = mavlink.MAV_SYS_STATUS_GEOFENCE
    return bool(desk.latest("SYS_STATUS").onboard_control_sensors_enabled & bit)


def test_fence_off_and_on(desk: Desk) -> None:
    assert desk.upload(zone(), FENCE) == ACCEPTED
    assert fenced(desk)
    armed_in_hold(desk)
    for param1, wanted in ((0.0, False), (2.0, False), (1.0, True), (2.0, True), (0.0, False)):
        assert desk.result(FENCE_ENABLE, param1) == ACCEPTED
        assert fenced(desk) is wanted
    assert desk.texts().count("Fence off until switched on or disarmed") == 2
    assert desk.result(ARM, 0.0) == ACCEPTED
    assert fenced(desk), "the next voyage begins with it"
    for param1 in (3.0, -1.0, 0.5, NAN):
        assert desk.result(FENCE_ENABLE, param1) == DENIED


def test_fence_items_travel_to_and_fro(desk: Desk) -> None:
    home = item(0, WAYPOINT)
    plan = [home, item(1, WAYPOINT, (10.0, 0.0)), item(2, FENCE_ENABLE, param1=0.0), item(3, WAYPOINT, (60.0, 0.0))]
    assert desk.upload(plan) == ACCEPTED
    (back,) = of(desk.tell(mavlink.MAVLink_mission_request_int_message(1, 1, 2, MISSION)), "MISSION_ITEM_INT")
    assert (back.command, back.param1) == (FENCE_ENABLE, 0.0)
    assert desk.upload([home, item(1, FENCE_ENABLE, param1=3.0)]) == mavlink.MAV_MISSION_INVALID_PARAM1


def until_surge(desk: Desk, low_mps: float, high_mps: float) -> None:
    """Sail until the boat's speed ahead is between these. The ground station stays heard."""

    def there() -> bool:
        tick = desk.vessel.last_tick
        assert tick is not None
        if round(desk.rig.now_s, 1) % 1.0 == 0.0:
            desk.heartbeat()
        return low_mps < tick.nav.surge_mps < high_mps

    desk.until(f"{low_mps} to {high_mps} m/s", there)


def test_stern_first_by_command_until_another_mode(desk: Desk) -> None:
    assert desk.upload([item(0, WAYPOINT), item(1, WAYPOINT, (40.0, 0.0))]) == ACCEPTED
    assert desk.result(SET_REVERSE, 0.0) == ACCEPTED
    assert desk.result(SET_REVERSE, 1.0) == REJECTED
    desk.tick()
    assert "Stern first refused: no mission under way" in desk.texts()
    assert desk.result(SET_MODE, 1.0, float(AUTO)) == ACCEPTED
    assert desk.result(ARM, 1.0) == ACCEPTED
    until_surge(desk, 0.2, 9.0)
    assert desk.result(SET_REVERSE, 1.0) == ACCEPTED
    until_surge(desk, -9.0, -0.2)
    assert "Mission: stern first" in desk.texts()
    assert desk.result(SET_MODE, 1.0, float(HOLD)) == ACCEPTED
    desk.tick(3)
    assert desk.result(SET_MODE, 1.0, float(AUTO)) == ACCEPTED
    until_surge(desk, 0.2, 9.0)
    for param1 in (2.0, -1.0, 0.5, NAN):
        assert desk.result(SET_REVERSE, param1) == DENIED


def test_stern_first_as_an_item(desk: Desk) -> None:
    home = item(0, WAYPOINT)
    plan = [home, item(1, SET_REVERSE, param1=1.0), item(2, WAYPOINT, (30.0, 0.0))]
    assert desk.upload(plan) == ACCEPTED
    (back,) = of(desk.tell(mavlink.MAVLink_mission_request_int_message(1, 1, 1, MISSION)), "MISSION_ITEM_INT")
    assert (back.command, back.param1) == (SET_REVERSE, 1.0)
    assert desk.result(SET_MODE, 1.0, float(AUTO)) == ACCEPTED
    assert desk.result(ARM, 1.0) == ACCEPTED
    until_surge(desk, -9.0, -0.3)
    assert desk.upload([home, item(1, SET_REVERSE, param1=2.0)]) == mavlink.MAV_MISSION_INVALID_PARAM1


def test_a_jet_refuses_to_go_astern(tmp_path: Path) -> None:
    rig = LockstepRig(Conditions("rescuerunner", seed=3), tmp_path / "log", link="memory:desk?dialect=ardupilot")
    jet = Desk(tmp_path, rig)
    try:
        jet.tick()
        assert jet.result(SET_REVERSE, 1.0) == DENIED
        jet.tick()
        assert "Stern first refused: this boat has no way astern" in jet.texts()
        plan = [item(0, WAYPOINT), item(1, SET_REVERSE, param1=1.0), item(2, WAYPOINT, (30.0, 0.0))]
        assert jet.upload(plan) == mavlink.MAV_MISSION_INVALID_PARAM1
        jet.tick()
        assert any("this boat has no way astern; remove it" in text for text in jet.texts())
    finally:
        jet.close()


def test_acro_is_the_mode_of_rates(desk: Desk) -> None:
    """Sticks of a ground station: a quarter turn to starboard and half speed, then neutral without sticks."""

    def stick(x: int, r: int) -> None:
        desk.tell(mavlink.MAVLink_manual_control_message(1, x, 0, 500, r, 0))

    def steer(x: int, r: int, ticks: int) -> None:
        for _ in range(ticks):
            stick(x, r)
            desk.tick()

    steer(0, 0, 3)
    assert desk.result(SET_MODE, 1.0, float(ACRO)) == ACCEPTED
    assert desk.result(ARM, 1.0) == ACCEPTED
    steer(525, 525, 200)
    assert desk.latest("HEARTBEAT").custom_mode == ACRO
    tick = desk.vessel.last_tick
    assert tick is not None
    assert tick.nav.yaw_rate_radps == pytest.approx(0.5 * math.radians(20.0), rel=0.15)
    assert tick.nav.surge_mps == pytest.approx(0.5 * desk.vessel.parameters["WP_SPEED"], rel=0.2)


def held_deg(desk: Desk) -> float:
    tick = desk.vessel.last_tick
    assert tick is not None
    return math.degrees(tick.nav.yaw_rad) % 360.0


def turned_to(desk: Desk, heading_deg: float) -> None:
    def there() -> bool:
        return abs(math.remainder(held_deg(desk) - heading_deg, 360.0)) < 3.0

    desk.until(f"{heading_deg:.0f} deg", there, 120.0)


def test_a_turn_by_command_in_hold(desk: Desk) -> None:
    assert desk.result(YAW, 90.0, 0.0, 0.0, 0.0) == REJECTED, "not in Hold"
    armed_in_hold(desk)
    first_deg = held_deg(desk)
    assert desk.result(YAW, (first_deg + 40.0) % 360.0, 0.0, -1.0, 0.0) == DENIED, "the longer way"
    assert desk.result(YAW, (first_deg + 40.0) % 360.0, 0.0, 1.0, 0.0) == ACCEPTED
    turned_to(desk, first_deg + 40.0)
    begin_deg = held_deg(desk)
    assert desk.result(YAW, 30.0, 0.0, -1.0, 1.0) == ACCEPTED
    turned_to(desk, begin_deg - 30.0)
    for params in ((400.0,), (-1.0,), (NAN,), (190.0, 0.0, 1.0, 1.0), (10.0, 0.0, 2.0), (10.0, 0.0, 0.0, 2.0)):
        assert desk.result(YAW, *params) == DENIED


@pytest.mark.parametrize("command", [DELAY, DISTANCE])
def test_conditions_are_for_missions(desk: Desk, command: int) -> None:
    assert desk.result(command, 5.0) == UNSUPPORTED
    assert "conditions belong into a mission" in desk.texts()


def test_a_mark_is_jumped_to_by_command_and_by_item(desk: Desk) -> None:
    points = ((0.0, 0.0), (12.0, 0.0), (12.0, 12.0))
    plan = [item(0, WAYPOINT), item(1, WAYPOINT, points[1]), item(2, MARK, param1=7.0), item(3, WAYPOINT, points[2])]
    plan += [item(4, JUMP_TO_MARK, param1=7.0)]
    assert desk.upload(plan) == ACCEPTED
    assert desk.result(JUMP_TAG, 8.0) == DENIED
    assert desk.result(JUMP_TAG, 7.0) == ACCEPTED
    desk.tick(3)
    assert desk.latest("MISSION_CURRENT").seq in (2, 3)
    plan[4].param1 = 9.0
    assert desk.upload(plan) == mavlink.MAV_MISSION_INVALID_PARAM1


def test_guided_limits(desk: Desk) -> None:
    assert desk.result(GUIDED_LIMITS, 30.0, 0.0, 0.0, 50.0) == ACCEPTED
    assert desk.result(GUIDED_LIMITS, -1.0) == DENIED
    assert desk.vessel.supervisor.parts.offboard.limits is not None


def test_smart_rtl_is_taken_while_disarmed_too_and_shown(desk: Desk) -> None:
    assert desk.result(SET_MODE, 1.0, float(SMART_RTL)) == ACCEPTED
    desk.tick(3)
    assert desk.latest("HEARTBEAT").custom_mode == SMART_RTL
