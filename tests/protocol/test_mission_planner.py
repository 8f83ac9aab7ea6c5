"""What Mission Planner sends, in its order, against a whole vessel in lockstep on a link of the ardupilot persona.

Facts from its sources (ArduPilot/MissionPlanner at a2fcd74d6): `OpenBg`, `getVersionAsync`, `getParamListMavftpAsync`,
`getHomePositionAsync`, `setMode`, `setGuidedModeWP` of MAVLinkInterface.cs, MAVFtp.cs, and the streams that CurrentState.cs asks for.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pymavlink import mavftp, mavutil
from pymavlink.dialects.v20 import ardupilotmega

from companion.core.decision import ModeId
from companion.core.geodesy import LocalFrame
from companion.io.mavlink.wire import messages as mavlink
from companion.params.table import TABLE
from tests.protocol.desk import Desk, of, rover_desk

ACCEPTED = mavlink.MAV_RESULT_ACCEPTED
REQUEST_MESSAGE, CAPABILITIES, BANNER, GET_HOME, SET_MODE, ARM = 512, 520, 42428, 410, 176, 400
RESET, OPEN, BURST = 2, 4, 15
READ_SIZE = 110
MODES = {
    "Auto": 10,
    "Hold": 4,
    "Loiter": 5,
    "Guided": 15,
    "Steering": 3,
    "Acro": 1,
    "Smart RTL": 12,
    "RTL": 11,
    "Manual": 0,
}
FRAME = LocalFrame(63.4389, 10.3990)


@pytest.fixture
def desk(tmp_path: Path) -> Iterator[Desk]:
    with rover_desk(tmp_path) as desk:
        yield desk


def connect(desk: Desk) -> Any:
    """As far as the list of parameters. The version that came."""
    for _ in range(2):  # it waits for two heartbeats of one vehicle before it says anything
        while not of(desk.tick(), "HEARTBEAT"):
            pass
    text = mavlink.MAVLink_statustext_message(6, b"Mission Planner 1.3.83")
    assert not of(desk.tell(text, text, text), "COMMAND_ACK")
    assert desk.result(REQUEST_MESSAGE, 148.0) == ACCEPTED
    desk.command(CAPABILITIES, 0.0)
    (version,) = of(desk.tell(mavlink.MAVLink_autopilot_version_request_message(1, 1)), "AUTOPILOT_VERSION")
    return version


def test_it_sees_a_rover_that_is_a_boat(desk: Desk) -> None:
    connect(desk)
    beat = desk.latest("HEARTBEAT")
    assert (beat.type, beat.autopilot) == (mavlink.MAV_TYPE_SURFACE_BOAT, mavlink.MAV_AUTOPILOT_ARDUPILOTMEGA)
    assert mavutil.mode_mapping_rover[beat.custom_mode] == "MANUAL"


def test_the_banner_names_the_version_and_the_frame_where_it_looks_for_them(desk: Desk) -> None:
    """It takes a text with "rover" for the version, one with "frame" for the frame."""
    connect(desk)
    texts = [message.text.lower() for message in of(desk.command(BANNER), "STATUSTEXT")]
    assert [text for text in texts if "rover" in text] == texts[:1] and texts[0].startswith("usv companion")
    assert [text for text in texts if "frame" in text] == texts[1:]


def ftp(desk: Desk, seq: int, opcode: int, data: bytes, size: int, offset: int = 0) -> list[Any]:
    header = struct.pack("<HBBBBBBI", seq, 0, opcode, size, 0, 0, 0, offset)
    answers = desk.tell(mavlink.MAVLink_file_transfer_protocol_message(0, 1, 1, (header + data).ljust(251, b"\0")))
    return [bytes(message.payload) for message in of(answers, "FILE_TRANSFER_PROTOCOL")]


def test_all_parameters_come_as_one_file(desk: Desk) -> None:
    """By MAVFTP where the vehicle has it: reset, open, bursts of 110 bytes."""
    assert connect(desk).capabilities & mavlink.MAV_PROTOCOL_CAPABILITY_FTP
    path = b"@PARAM/param.pck?withdefaults=1"
    assert [answer[3] for answer in ftp(desk, 1, RESET, b"", 0)] == [128]
    (opened,) = ftp(desk, 2, OPEN, path, len(path))
    assert opened[3] == 128, "opened"
    (size,) = struct.unpack_from("<I", opened, 12)
    got, seq = b"", 3
    while len(got) < size:
        parts = ftp(desk, seq, BURST, b"", READ_SIZE, len(got))
        while not parts:
            desk.tick()
            parts = [bytes(message.payload) for message in of(desk.received[-50:], "FILE_TRANSFER_PROTOCOL")]
        for part in parts:
            if part[3] == 128 and part[5] == BURST and struct.unpack_from("<I", part, 8)[0] == len(got):
                got += part[12 : 12 + part[4]]
        seq += len(parts) + 1
    decoded = mavftp.MAVFTP.ftp_param_decode(got)
    assert decoded is not None and len(decoded.params) == len(TABLE)
    assert {name.decode() for name, _, _ in decoded.params} == {spec.name for spec in TABLE}


def test_the_list_of_parameters_without_mavftp(desk: Desk) -> None:
    """Values are plain floats, whatever their type: C casts, as with ArduPilot."""
    connect(desk)
    values = of(desk.tell(mavlink.MAVLink_param_request_list_message(1, 1)), "PARAM_VALUE")
    while len(values) < len(TABLE):
        values += of(desk.tick(), "PARAM_VALUE")
    served = {value.param_id: value.param_value for value in values}
    assert served["COM_RC_IN_MODE"] == desk.vessel.parameters["COM_RC_IN_MODE"]


def test_its_streams_come(desk: Desk) -> None:
    """It asks by the streams of old, with its default rates."""
    connect(desk)
    for stream, rate_hz in ((2, 2), (6, 2), (10, 4), (11, 4), (12, 2), (1, 2), (3, 2)):
        desk.tell(mavlink.MAVLink_request_data_stream_message(1, 1, stream, rate_hz, 1))
    desk.received.clear()
    desk.tick(50)
    kinds = {message.get_type() for message in desk.received}
    assert {"SYS_STATUS", "GLOBAL_POSITION_INT", "ATTITUDE", "VFR_HUD", "GPS_RAW_INT", "NAV_CONTROLLER_OUTPUT"} <= kinds


def test_no_message_comes_regularly_that_it_would_count_as_lost(desk: Desk) -> None:
    """It has fewer messages than we, and MAVProxy those of pymavlink's wheel; both see a gap where they skip one."""
    connect(desk)
    desk.ready()
    desk.received.clear()
    desk.tick(60)
    assert {message.get_msgId() for message in desk.received} <= set(ardupilotmega.mavlink_map)
    assert desk.result(ARM, 1.0) == ACCEPTED and desk.latest("CURRENT_MODE") is not None, "when it changes"
    assert of(desk.command(REQUEST_MESSAGE, 512.0), "CONTROL_STATUS"), "when it is asked for"


def test_home(desk: Desk) -> None:
    connect(desk)
    desk.ready()
    answers = desk.command(GET_HOME)
    assert [ack.result for ack in of(answers, "COMMAND_ACK")] == [ACCEPTED]
    (home,) = of(answers, "HOME_POSITION")
    assert (home.latitude * 1e-7, home.longitude * 1e-7) == pytest.approx((63.4389, 10.3990), abs=1e-4)


def item(seq: int, north_m: float, east_m: float) -> Any:
    lat_deg, lon_deg = FRAME.to_geodetic(north_m, east_m)
    place = (round(lat_deg * 1e7), round(lon_deg * 1e7))
    return mavlink.MAVLink_mission_item_int_message(
        1, 1, seq, 3, 16, int(seq == 0), 1, 0.0, 0.0, 0.0, 0.0, *place, 100.0, 0
    )


def test_a_mission_with_home_as_item_0_and_its_modes(desk: Desk) -> None:
    """A mode goes out as MAV_CMD_DO_SET_MODE, then as SET_MODE, twice."""
    connect(desk)
    desk.ready()
    plan = [item(0, 0.0, 0.0), item(1, 12.0, 0.0), item(2, 12.0, 12.0)]
    assert desk.upload(plan) == mavlink.MAV_MISSION_ACCEPTED
    (count,) = of(desk.tell(mavlink.MAVLink_mission_request_list_message(1, 1, 0)), "MISSION_COUNT")
    assert count.count == 3
    first = of(desk.tell(mavlink.MAVLink_mission_request_int_message(1, 1, 1, 0)), "MISSION_ITEM_INT")[0]
    assert (first.seq, first.x, first.y) == (1, plan[1].x, plan[1].y)
    assert desk.result(ARM, 1.0) == ACCEPTED
    for name, number in MODES.items():
        assert desk.result(SET_MODE, 1.0, float(number)) == ACCEPTED, name
        desk.tell(*[mavlink.MAVLink_set_mode_message(1, 1, number)] * 2)
        desk.tick(12)  # a heartbeat comes each second
        shown = mavutil.mode_mapping_rover[desk.latest("HEARTBEAT").custom_mode]
        assert shown == name.upper().replace(" ", "_"), name


def fly_to_here(desk: Desk, north_m: float, east_m: float) -> None:
    """*Fly To Here* (`setGuidedModeWP`): Guided as any mode, then one position; no acknowledgement is waited for."""
    desk.command(SET_MODE, 1.0, float(MODES["Guided"]))
    desk.tell(*[mavlink.MAVLink_set_mode_message(1, 1, MODES["Guided"])] * 2)
    place = (round(degrees * 1e7) for degrees in FRAME.to_geodetic(north_m, east_m))
    desk.tell(
        mavlink.MAVLink_set_position_target_global_int_message(0, 1, 1, 3, 0xFDF8, *place, 100.0, *(0.0,) * 8),
    )


def test_fly_to_here_goes_there(desk: Desk) -> None:
    connect(desk)
    desk.ready()
    assert desk.result(ARM, 1.0) == ACCEPTED
    fly_to_here(desk, 8.0, 3.0)
    desk.tick(3)
    fly_to_here(desk, 5.0, 2.0)  # at once somewhere else
    desk.tick(40)
    tick = desk.vessel.last_tick
    assert tick is not None and tick.setpoint.progress.target is not None
    target = tick.setpoint.progress.target
    assert (target.north_m, target.east_m) == pytest.approx((5.0, 2.0), abs=0.1)
    assert tick.status.mode is ModeId.HOLD and math.hypot(tick.nav.north_mps, tick.nav.east_mps) > 0.05, "on its way"
    assert not [text for text in desk.texts() if "setpoint" in text.lower()]
