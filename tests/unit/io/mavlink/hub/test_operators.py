"""Who may command: all, those of a list, or the one that has control; and what the others are told."""

from __future__ import annotations

import re
from typing import Any

import pytest
from fastcrc import crc16

from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.actions import CONTROLLING, READING, REQUEST_OPERATOR_CONTROL, action_of
from companion.io.mavlink.wire.framer import pack
from companion.supervisor.authority import RequestedAction
from companion.supervisor.ground_stations import GroundStations

ARM, DISARM, TERMINATE = (400, 1.0), (400, 0.0), (185, 1.0)
SET_MODE, RETURN = (176, 1.0, 4.0, 3.0), (20,)
TAKE, TAKE_OPEN, RELEASE = (
    (REQUEST_OPERATOR_CONTROL, 1.0, 0.0),
    (REQUEST_OPERATOR_CONTROL, 1.0, 1.0),
    (REQUEST_OPERATOR_CONTROL, 0.0),
)
ACCEPTED, DENIED, UNSUPPORTED, FAILED = 0, 2, 3, 4


def ack(rig: Any, command: tuple[float, ...], desk: int) -> int:
    """Of a command; there is exactly one."""
    number, *params = command
    (answer,) = [m for m in rig.command(int(number), *params, desk=desk) if m.get_type() == "COMMAND_ACK"]
    assert answer.command == number
    return int(answer.result)


def texts(messages: list[Any]) -> list[str]:
    return [m.text for m in messages if m.get_type() == "STATUSTEXT"]


@pytest.fixture
def two(make_rig: Any) -> Any:
    """Stations 255 and 254 on links of their own."""
    rig = make_rig(["memory:a", "memory:b"])
    for desk in (0, 1):
        rig.ask(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3), desk=desk)
    return rig


def test_control_status_is_the_message_that_clients_know() -> None:
    """Checksum seeds as mavgen has them of MAVLink's development.xml, before and after April 2026."""
    assert mavlink.MAVLink_control_status_message.crc_extra == 184
    assert mavlink.CONTROL_STATUS_OWNERS.crc_extra == 21
    packed = pack(mavlink.CONTROL_STATUS_OWNERS(3, 254, (0,) * 10))
    assert (packed.id, packed.payload) == (512, b"\x03\xfe")


def test_control_status_comes_in_the_newest_form_too(two: Any) -> None:
    """QGroundControl's stable releases know the first form, its daily builds the newest; each drops the other."""
    assert ack(two, TAKE_OPEN, 1) == ACCEPTED
    two.desks[0].hear()
    two.run(3.0)
    data = two.desks[0].link.from_vessel()
    forms, sequences = {}, {}
    for payload, seed in ((b"\xfe\x03", 184), (b"\x03\xfe", 21)):
        found = re.findall(rb"(?=\xfd(\x02\0\0.\x01\x01\x00\x02\0" + re.escape(payload) + rb")(..))", data, re.DOTALL)
        sequences[seed] = [body[3] for body, _ in found]
        forms[seed] = [crc for body, crc in found if crc16.mcrf4xx(body + bytes((seed,))).to_bytes(2, "little") == crc]
    assert [len(found) for found in forms.values()] == [3, 3]
    assert sequences[184] == sequences[21], "who drops one form counts no packet as lost"


@pytest.mark.parametrize(
    ("current", "action"), [(0, RequestedAction.UPLOAD), (1, RequestedAction.UPLOAD), (2, RequestedAction.COMMAND)]
)
def test_a_waypoint_for_guided_is_a_command_not_an_upload(current: int, action: RequestedAction) -> None:
    """A script with leave to upload missions may not send the boat somewhere by one."""
    head, place = (1, 1, 0, 3, 16, current, 1, 0.0, 0.0, 0.0, 0.0), (634_400_000, 103_989_999, 0.0)
    assert action_of(mavlink.MAVLink_mission_item_int_message(*head, *place)) is action
    assert action_of(mavlink.MAVLink_mission_item_message(*head, 63.44, 10.4, 0.0)) is action


def test_all_may_command_by_default(two: Any) -> None:
    assert [ack(two, command, desk) for command in (ARM, SET_MODE, RETURN, DISARM) for desk in (0, 1)] == [ACCEPTED] * 8


def every_way(rig: Any) -> list[Any]:
    """All that station 254 can send to change the vessel, but for what keeps people safe."""
    sent: list[Any] = [
        m
        for command in (ARM, SET_MODE, RETURN, (300,), (31010, 1.0, 1.0), (246, 1.0))
        for m in rig.command(int(command[0]), *command[1:], desk=1)
    ]
    item = (1, 1, 0, 3, 16, 0, 1, 0.0, 0.0, 0.0, 0.0)
    for message in (
        mavlink.MAVLink_command_int_message(1, 1, 0, 192, 0, 0, 0.0, 1.0, 0.0, 0.0, 634_400_000, 104_000_000, 0.0),
        mavlink.MAVLink_set_mode_message(1, 1, 0x00010000),
        mavlink.MAVLink_param_set_message(1, 1, b"PATH_BW_SURGE", 0.5, 9),
        mavlink.MAVLink_mission_count_message(1, 1, 1, 0),
        mavlink.MAVLink_mission_item_int_message(*item, 634_400_000, 104_000_000, 0.0, 0),
        mavlink.MAVLink_mission_clear_all_message(1, 1, 255),
        mavlink.MAVLink_mission_set_current_message(1, 1, 0),
        mavlink.MAVLink_manual_control_message(1, 1000, 0, 0, 0, 0),
        mavlink.MAVLink_rc_channels_override_message(1, 1, 2000, 2000, 2000, 2000, 0, 0, 0, 0),
    ):
        sent += rig.ask(message, desk=1)
    return sent


def test_who_is_not_in_control_changes_nothing_and_is_told_why(two: Any) -> None:
    assert ack(two, TAKE, 0) == ACCEPTED
    two.supervisor.asked.clear()
    before = two.vessel.parameters["PATH_BW_SURGE"]
    answers = every_way(two)
    assert (
        two.supervisor.asked == [] and two.supervisor.sticks == [] and two.vessel.parameters["PATH_BW_SURGE"] == before
    )
    kinds = [m.get_type() for m in answers if m.get_type() != "STATUSTEXT"]
    assert kinds == ["COMMAND_ACK"] * 7 + ["PARAM_ERROR", "MISSION_ACK", "MISSION_ACK", "MISSION_ACK"]
    assert {m.result for m in answers if m.get_type() == "COMMAND_ACK"} == {DENIED}
    assert {m.type for m in answers if m.get_type() == "MISSION_ACK"} == {14}
    assert [m.error for m in answers if m.get_type() == "PARAM_ERROR"] == [3]
    assert set(texts(answers)) == {"Not obeyed: system 255 has control"}
    assert texts(two.ask(mavlink.MAVLink_manual_control_message(1, 0, 0, 0, 0, 0), desk=1)) == [], (
        "once is enough of a stream"
    )
    assert ack(two, ARM, 0) == ACCEPTED


def test_reading_and_stopping_stay_open(two: Any) -> None:
    ack(two, TAKE, 0)
    assert ack(two, (512, 148.0), 1) == ACCEPTED and ack(two, (511, 30.0, 100_000.0), 1) == ACCEPTED
    assert (
        two.ask(mavlink.MAVLink_param_request_read_message(1, 1, b"PATH_BW_SURGE", -1), desk=1)[0].get_type()
        == "PARAM_VALUE"
    )
    assert two.ask(mavlink.MAVLink_mission_request_list_message(1, 1, 0), desk=1)[0].get_type() == "MISSION_COUNT"
    two.ask(mavlink.MAVLink_param_request_list_message(1, 1), desk=1)
    cached = mavlink.MAVLink_param_set_message(1, 1, b"_HASH_CHECK", 0.0, 5)
    assert two.ask(cached, desk=1) == [], "a ground station that has the parameters wants no list"
    two.supervisor.change(armed=True)
    assert ack(two, DISARM, 1) == ACCEPTED and not two.supervisor.now.armed
    two.supervisor.change(armed=True)
    assert ack(two, TERMINATE, 1) == ACCEPTED and not two.supervisor.now.armed
    assert ack(two, (185, 0.0), 1) == DENIED and ack(two, (400, float("nan")), 1) == DENIED


@pytest.mark.parametrize("number", sorted(READING))
def test_no_reading_command_is_refused_to_who_is_not_in_control(two: Any, number: int) -> None:
    """QGroundControl asks for a camera (521) every two seconds, whoever has control."""

    def results() -> list[tuple[str, int]]:
        two.desks[1].hear()
        answers = two.command(number, 1.0, desk=1)
        assert not any("control" in text for text in texts(answers))
        return [(m.get_type(), m.result) for m in answers if m.get_type() == "COMMAND_ACK"]

    before = results()
    ack(two, TAKE, 0)
    assert results() == before


def test_a_camera_is_asked_for_in_vain_without_a_word(two: Any) -> None:
    ack(two, TAKE, 0)
    assert [ack(two, (number, 1.0), 1) for number in (521, 522, 525, 527, 2504, 2505)] == [UNSUPPORTED] * 6


def test_the_same_refusal_is_said_once_in_half_a_minute_and_acknowledged_each_time(two: Any) -> None:
    ack(two, TAKE, 0)
    said = []
    for _ in range(35):
        answers = two.command(int(ARM[0]), ARM[1], desk=1)
        assert [m.result for m in answers if m.get_type() == "COMMAND_ACK"] == [DENIED]
        said += [m for m in answers if m.get_type() == "STATUSTEXT"]
        two.run(0.5)
        two.ask(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3), desk=0)
        two.run(0.5)
    assert [(m.severity, m.text) for m in said] == [(3, "Not obeyed: system 255 has control")] * 2


def test_a_refusal_of_another_kind_and_a_refusal_to_another_are_said_at_once(make_rig: Any) -> None:
    rig = make_rig(["memory:a", "memory:b", "memory:c"])
    rig.ask(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3), desk=0)
    ack(rig, TAKE, 0)
    for desk in (1, 2):
        assert "Not obeyed: system 255 has control" in texts(rig.command(400, 1.0, desk=desk))
    ack(rig, RELEASE, 0)
    assert "the speed should be above 0" in texts(rig.command(178, 1.0, 0.0, desk=1))


def test_hand_over(two: Any) -> None:
    """Asked for, refused, told to who has it; allowed, asked for again, had; given back."""
    assert ack(two, TAKE, 0) == ACCEPTED
    two.desks[0].hear()
    assert ack(two, TAKE, 1) == FAILED
    told = two.desks[0].hear()
    (request,) = [m for m in told if m.get_type() == "COMMAND_LONG"]
    assert (request.target_system, request.command, request.param1, request.param4) == (
        255,
        REQUEST_OPERATOR_CONTROL,
        1.0,
        254.0,
    )
    assert "system 254 asks for control" in texts(told)
    assert ack(two, TAKE_OPEN, 0) == ACCEPTED
    assert ack(two, TAKE, 1) == ACCEPTED
    (status, *_) = [m for m in two.desks[0].hear() if m.get_type() == "CONTROL_STATUS"]
    assert (status.sysid_in_control, status.flags) == (254, 1)
    assert ack(two, ARM, 0) == DENIED and ack(two, ARM, 1) == ACCEPTED
    assert ack(two, RELEASE, 0) == DENIED and ack(two, RELEASE, 1) == ACCEPTED
    assert ack(two, ARM, 0) == ACCEPTED and two.supervisor.ground_stations.in_control == 0
    assert [e.text for e in two.vessel.events.drain()] == [
        "system 255 has control",
        "system 255 lets control be taken over",
        "system 254 has control",
        "system 254 released control",
    ]


def test_silence_gives_control_back(two: Any) -> None:
    ack(two, TAKE, 0)
    timeout_s = two.vessel.parameters["COM_DL_LOSS_T"]
    for _ in range(round(2.0 * timeout_s)):
        two.run(1.0)
        two.ask(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3), desk=0)
    assert ack(two, ARM, 1) == DENIED
    two.run(timeout_s + 0.2)
    assert ack(two, ARM, 1) == ACCEPTED
    assert two.supervisor.ground_stations.in_control == 0


@pytest.mark.parametrize("params", [(2.0, 0.0), (float("nan"), 0.0), (1.0, 5.0), (float("inf"), 0.0)])
def test_requests_that_make_no_sense_are_refused(two: Any, params: tuple[float, ...]) -> None:
    assert ack(two, (REQUEST_OPERATOR_CONTROL, *params), 0) == DENIED and two.supervisor.ground_stations.in_control == 0


def test_only_those_of_the_list(two: Any) -> None:
    two.supervisor.ground_stations = GroundStations([255, 100])
    answers = every_way(two)
    assert set(texts(answers)) == {"Not obeyed: system 254 may not command here"} and two.supervisor.asked == []
    assert ack(two, TAKE, 1) == DENIED and ack(two, DISARM, 1) == DENIED
    assert ack(two, (512, 148.0), 1) == ACCEPTED
    assert ack(two, ARM, 0) == ACCEPTED and ack(two, TAKE, 0) == ACCEPTED


def test_the_crew_of_the_lead_boat_steers_by_its_own_right(two: Any) -> None:
    ack(two, TAKE, 0)
    two.supervisor.remote_system = 254
    two.ask(mavlink.MAVLink_manual_control_message(1, 500, 0, 0, 0, 0), desk=1)
    assert len(two.supervisor.sticks) == 1
    assert ack(two, ARM, 1) == DENIED


def test_sticks_for_another_boat_are_not_ours_to_refuse(two: Any) -> None:
    ack(two, TAKE, 0)
    assert two.ask(mavlink.MAVLink_manual_control_message(9, 500, 0, 0, 0, 0), desk=1) == []


def test_whatever_changes_the_vessel_is_under_control(two: Any) -> None:
    """A handler of a new message has to be put on one side or the other."""
    open_to_all = {  # clocks and rates, reading, transfers under way, positions of others, corrections, keys
        "HEARTBEAT",
        "COMMAND_ACK",
        "CAMERA_IMAGE_CAPTURED",
        "REQUEST_EVENT",
        "TIMESYNC",
        "PING",
        "REQUEST_DATA_STREAM",
        "AIS_VESSEL",
        "DISTANCE_SENSOR",
        "OBSTACLE_DISTANCE",
        "AUTOPILOT_VERSION_REQUEST",
        "MISSION_ACK",
        "MISSION_REQUEST_LIST",
        "MISSION_REQUEST_PARTIAL_LIST",
        "MISSION_REQUEST_INT",
        "MISSION_REQUEST",
        "PARAM_REQUEST_LIST",
        "PARAM_REQUEST_READ",
        "FILE_TRANSFER_PROTOCOL",
        "LOG_REQUEST_LIST",
        "LOG_REQUEST_DATA",
        "LOG_REQUEST_END",
        "FOLLOW_TARGET",
        "GLOBAL_POSITION_INT",
        "GPS_RTCM_DATA",
        "GPS_INJECT_DATA",
        "SETUP_SIGNING",
        "SERIAL_CONTROL",  # the shell refuses each line that sets something
    }
    handled = {mavlink.MESSAGES[number].msgname for number in two.hub._handlers if number not in CONTROLLING}
    assert handled <= open_to_all, handled - open_to_all
