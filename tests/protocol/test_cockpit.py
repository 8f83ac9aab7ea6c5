"""What Cockpit sends, in its order, against a whole vessel in lockstep on a link of the ardupilot persona.

Facts from its sources (bluerobotics/cockpit at aa40c07ce), below src/libs/vehicle: vehicle-factory.ts (which vehicles
it takes), mavlink/vehicle.ts (what it sends), mavlink/defaults.ts (rates), ardupilot/types/modes.ts (names of modes).
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from companion.core.geodesy import LocalFrame
from companion.io.mavlink.wire import messages as mavlink
from companion.params.table import TABLE
from tests.protocol.desk import Desk, of, rover_desk

ACCEPTED, UNSUPPORTED = mavlink.MAV_RESULT_ACCEPTED, mavlink.MAV_RESULT_UNSUPPORTED
ARM, SET_MODE, START, INTERVAL, REQUEST_MESSAGE, REPOSITION = 400, 176, 300, 511, 512, 192
SET_CURRENT, CHANGE_SPEED, SET_HOME = 224, 178, 179
MANUAL, LOITER, AUTO, SMART_RTL, GUIDED = 0, 5, 10, 12, 15  # its RoverMode
FRAME = LocalFrame(63.4389, 10.3990)
RATES_HZ = {  # of the messages that its displays live on; it asks for some twenty others too
    mavlink.MAVLINK_MSG_ID_SYS_STATUS: 2,
    mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: 2,
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: 3,
    mavlink.MAVLINK_MSG_ID_ATTITUDE: 16,
    mavlink.MAVLINK_MSG_ID_VFR_HUD: 16,
    mavlink.MAVLINK_MSG_ID_BATTERY_STATUS: 3,
    mavlink.MAVLINK_MSG_ID_SYSTEM_TIME: 3,
}
OTHERS = (27, 116, 129, 29, 137, 143, 125, 152, 127, 124, 128, 162, 36, 65, 35, 164, 178, 194, 163, 173, 132, 285, 100)


@pytest.fixture
def desk(tmp_path: Path) -> Iterator[Desk]:
    with rover_desk(tmp_path) as desk:
        desk.ready()
        yield desk


def test_it_takes_the_boat_for_a_rover(desk: Desk) -> None:
    beat = desk.latest("HEARTBEAT")
    assert (beat.autopilot, beat.type) == (mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA, mavlink.MAV_TYPE_SURFACE_BOAT)
    assert beat.base_mode & mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED, "without it no mode is read"
    assert beat.custom_mode == MANUAL


def test_the_rates_that_it_asks_for_when_it_connects(desk: Desk) -> None:
    for number, rate_hz in RATES_HZ.items():
        assert desk.result(INTERVAL, float(number), 1e6 / rate_hz) == ACCEPTED, number
    for number in OTHERS:
        assert desk.result(INTERVAL, float(number), 5e5) in (ACCEPTED, UNSUPPORTED, mavlink.MAV_RESULT_DENIED), number
    assert not [text for text in desk.texts() if "refused" in text], "what it cannot have is not worth a window"
    desk.received.clear()
    desk.tick(100)
    heard = [message.get_type() for message in desk.received]
    for kind, least in (("SYS_STATUS", 18), ("GLOBAL_POSITION_INT", 28), ("GPS_RAW_INT", 18), ("ATTITUDE", 90)):
        assert heard.count(kind) >= least, kind


def test_parameters_are_asked_of_component_0(desk: Desk) -> None:
    values = of(desk.tell(mavlink.MAVLink_param_request_list_message(1, 0)), "PARAM_VALUE")
    while len(values) < len(TABLE):
        values += of(desk.tick(), "PARAM_VALUE")
    assert {value.param_count for value in values} == {len(TABLE)}
    back = of(desk.tell(mavlink.MAVLink_param_set_message(1, 0, b"WP_SPEED", 0.5, 9)), "PARAM_VALUE")
    assert back[0].param_value == 0.5


def test_time_and_delay(desk: Desk) -> None:
    desk.tell(mavlink.MAVLink_system_time_message(1_780_000_000_000_000, 5000))
    (answer,) = of(desk.tell(mavlink.MAVLink_timesync_message(0, 123_456_789, 1, 1)), "TIMESYNC")
    assert answer.ts1 == 123_456_789 and answer.tc1 != 0


def test_home(desk: Desk) -> None:
    answers = desk.command(REQUEST_MESSAGE, 242.0)
    assert [ack.result for ack in of(answers, "COMMAND_ACK")] == [ACCEPTED]
    assert len(of(answers, "HOME_POSITION")) == 1


def item(seq: int, north_m: float, east_m: float) -> Any:
    lat_deg, lon_deg = FRAME.to_geodetic(north_m, east_m)
    place = (round(lat_deg * 1e7), round(lon_deg * 1e7))
    return mavlink.MAVLink_mission_item_int_message(1, 1, seq, 6, 16, 0, 1, 0.0, 5.0, 0.0, 999.0, *place, 0.0, 0)


def test_a_mission_as_it_starts_pauses_and_returns(desk: Desk) -> None:
    """Its own way: LOITER, arm, MISSION_START; LOITER again to pause, SMART_RTL to return. It waits for the number that
    it asked for in the heartbeat."""
    plan = [item(0, 0.0, 0.0), item(1, 15.0, 0.0), item(2, 15.0, 15.0)]
    assert desk.upload(plan) == mavlink.MAV_MISSION_ACCEPTED
    assert of(desk.tell(mavlink.MAVLink_mission_request_list_message(1, 1, 0)), "MISSION_COUNT")[0].count == 3
    assert desk.result(SET_MODE, 1.0, float(LOITER)) == ACCEPTED
    assert shown(desk) == LOITER
    assert desk.result(ARM, 1.0) == ACCEPTED
    assert desk.result(START) == ACCEPTED
    assert shown(desk) == AUTO
    assert desk.result(SET_CURRENT, 2.0) == ACCEPTED
    assert desk.result(CHANGE_SPEED, 1.0, 0.5, -1.0) == ACCEPTED
    assert desk.result(SET_MODE, 1.0, float(LOITER)) == ACCEPTED
    assert shown(desk) == LOITER
    assert desk.result(SET_MODE, 1.0, float(SMART_RTL)) == ACCEPTED
    assert shown(desk) == SMART_RTL


def shown(desk: Desk) -> int:
    desk.tick(3)
    return int(desk.latest("HEARTBEAT").custom_mode)


def test_go_to_is_a_reposition_as_command_int(desk: Desk) -> None:
    """Its parameters are those of a waypoint: 0 for hold, radii and heading; so it has no leave to change the mode."""
    assert desk.result(ARM, 1.0) == ACCEPTED
    assert desk.result(SET_MODE, 1.0, float(GUIDED)) == ACCEPTED
    lat_deg, lon_deg = FRAME.to_geodetic(20.0, 0.0)
    x, y = round(lat_deg * 1e7), round(lon_deg * 1e7)
    go = mavlink.MAVLink_command_int_message(1, 1, 0, REPOSITION, 0, 0, 0.0, 0.0, 0.0, 0.0, x, y, 0.0)
    assert [ack.result for ack in of(desk.tell(go), "COMMAND_ACK")] == [ACCEPTED]
    desk.tick(12)
    tick = desk.vessel.last_tick
    assert tick is not None and tick.setpoint.progress.target.north_m == pytest.approx(20.0, abs=0.5)


def test_its_mapping_of_a_boat_steers(desk: Desk) -> None:
    """src/assets/joystick-profiles.ts, "Boat functions mapping": y and x are the left stick, r and z the right one. A
    Rover steers by y and takes z for throttle; here the right stick's z does nothing."""

    def steer(ticks: int, x: int = 0, y: int = 0, z: int = 0, r: int = 0) -> tuple[float, float, float]:
        for _ in range(ticks):
            desk.tell(mavlink.MAVLink_manual_control_message(1, x, y, z, r, 0, buttons2=0, s=0, t=0))
            desk.tick()
        tick = desk.vessel.last_tick
        assert tick is not None
        achieved = tick.allocation.achieved
        return achieved.surge_n, achieved.sway_n, achieved.yaw_nm

    steer(3)
    assert desk.result(SET_MODE, 1.0, float(MANUAL)) == ACCEPTED
    assert desk.result(ARM, 1.0) == ACCEPTED
    steer(3)
    ahead = steer(10, x=600)
    assert ahead[0] > 10.0 and ahead[2] == pytest.approx(0.0, abs=0.01)
    assert steer(10, y=600)[1] > 3.0
    surge_n, _, yaw_nm = steer(10, x=600, r=600)
    assert surge_n > 10.0 and yaw_nm > 3.0, "to starboard"
    assert steer(10, z=1000) == pytest.approx((0.0, 0.0, 0.0), abs=0.01)
