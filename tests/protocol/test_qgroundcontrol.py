"""What QGroundControl sends, in its order and with its time limits, against a whole vessel in lockstep."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from companion.core.geodesy import LocalFrame
from companion.io.mavlink.wire import messages as mavlink
from companion.modes.table import DECLARATIONS
from companion.params.table import TABLE
from tests.protocol.desk import ITEM_FIELDS, Desk, of

HOLD, MISSION, RTL, MANUAL = 0x03040000, 0x04040000, 0x05040000, 0x00010000
ARM, REPOSITION, REQUEST = 400, 192, 512
NAN = math.nan
FRAME = LocalFrame(63.4389, 10.3990)


@pytest.fixture
def desk(tmp_path: Path) -> Iterator[Desk]:
    desk = Desk(tmp_path)
    desk.tick()
    yield desk
    desk.close()


def item(seq: int, command: int, north_m: float, east_m: float, *params: float, kind: int = 0, frame: int = 3) -> Any:
    lat_deg, lon_deg = FRAME.to_geodetic(north_m, east_m)
    padded = (*params, *(0.0 for _ in range(4 - len(params))))
    x, y = (0, 0) if frame == 2 else (round(1e7 * lat_deg), round(1e7 * lon_deg))
    return mavlink.MAVLink_mission_item_int_message(
        1, 1, seq, frame, command, int(seq == 0), 1, *padded, x, y, 50.0, kind
    )


def square() -> list[Any]:
    corners = ((10.0, 0.0), (10.0, 10.0), (0.0, 10.0))
    return [item(n, 16, *corner, 0.0, 0.0, 0.0, NAN) for n, corner in enumerate(corners)] + [item(3, 20, 0, 0, frame=2)]


def heartbeat_mode(messages: list[Any]) -> int | None:
    beats = of(messages, "HEARTBEAT")
    return int(beats[-1].custom_mode) if beats else None


def underway(desk: Desk) -> None:
    """Armed in Mission, by QGroundControl's own start-mission macro."""
    desk.ready()
    assert desk.upload(square()) == mavlink.MAV_MISSION_ACCEPTED
    desk.tell(mavlink.MAVLink_set_mode_message(1, 1, MISSION))
    assert desk.result(ARM, 1.0) == mavlink.MAV_RESULT_ACCEPTED
    desk.tick(10)


def test_the_connect_sequence(desk: Desk) -> None:
    """Section 3 of the contract: every answer comes before any time has passed, parameters apart."""
    desk.heartbeat()
    ack, version = [*of(desk.command(REQUEST, 148.0), "COMMAND_ACK"), desk.latest("AUTOPILOT_VERSION")]
    assert (ack.result, version is not None) == (mavlink.MAV_RESULT_ACCEPTED, True)
    assert version.capabilities & 57404 == 57404
    assert version.flight_sw_version >> 8 >= 0x010401 and version.flight_sw_version & 0xFF != 255

    names: list[str] = []
    while True:
        answer = desk.command(REQUEST, 435.0, float(len(names) + 1))
        kinds = [m.get_type() for m in answer]
        assert kinds.index("COMMAND_ACK") < kinds.index("AVAILABLE_MODES")
        mode = of(answer, "AVAILABLE_MODES")[0]
        assert mode.mode_index == len(names) + 1
        names.append(mode.mode_name)
        if mode.mode_index >= mode.number_modes:
            break
    assert names == [mode.value for mode in DECLARATIONS]

    described = of(desk.command(REQUEST, 397.0), "COMPONENT_METADATA")
    assert [m.uri for m in described] == ["mftp:///general.json"]
    assert desk.result(REQUEST, 395.0) == mavlink.MAV_RESULT_UNSUPPORTED
    before_s = desk.rig.now_s
    first, *values = of(desk.tell(mavlink.MAVLink_param_request_list_message(1, 0)), "PARAM_VALUE")
    assert first.param_id == "_HASH_CHECK" and first.param_index == 65535
    while len(values) < len(TABLE):
        values += of(desk.tick(), "PARAM_VALUE")
        assert desk.rig.now_s - before_s < 2.0
    assert sorted(v.param_index for v in values) == list(range(len(TABLE)))
    for kind in (0, 1, 2):
        counts = of(desk.tell(mavlink.MAVLink_mission_request_list_message(1, 1, kind)), "MISSION_COUNT")
        assert [(c.count, c.mission_type) for c in counts] == [(0, kind)]
    for probe in (280.0, 259.0):
        assert desk.result(REQUEST, probe) == mavlink.MAV_RESULT_UNSUPPORTED
    assert desk.result(521, 0.0) == mavlink.MAV_RESULT_UNSUPPORTED


def test_mode_table_invariants(desk: Desk) -> None:
    modes = of(desk.command(REQUEST, 435.0, 0.0), "AVAILABLE_MODES")
    numbers = {m.custom_mode for m in modes}
    assert {HOLD, MISSION, RTL, MANUAL} <= numbers and len(numbers) == len(modes)
    assert len({m.mode_name for m in modes}) == len(modes)
    assert not {m.mode_name for m in modes} & {"Return", "Land", "Takeoff", "Orbit", "VTOL Takeoff"}
    for mode in modes:
        assert mode.standard_mode in (0, 6) and len(mode.mode_name) <= 34
        assert struct.unpack("f", struct.pack("f", mode.custom_mode))[0] == mode.custom_mode
    assert desk.result(REQUEST, 435.0, 99.0) == mavlink.MAV_RESULT_DENIED


@pytest.mark.parametrize("base_mode", [1, 9, 129, 137])
def test_set_mode_never_arms_nor_disarms(desk: Desk, base_mode: int) -> None:
    desk.ready()
    answer = desk.tell(mavlink.MAVLink_set_mode_message(1, base_mode, HOLD))
    assert heartbeat_mode(answer) == HOLD, "a HEARTBEAT at once"
    assert not of(answer, "HEARTBEAT")[-1].base_mode & 128
    desk.result(ARM, 1.0)
    desk.tell(mavlink.MAVLink_set_mode_message(1, base_mode & ~128, MANUAL))
    assert of(desk.tick(12), "HEARTBEAT")[-1].base_mode & 128


def test_start_mission_macro(desk: Desk) -> None:
    desk.ready()
    assert desk.upload(square()) == mavlink.MAV_MISSION_ACCEPTED
    assert heartbeat_mode(desk.tell(mavlink.MAVLink_set_mode_message(1, 1, MISSION))) == MISSION
    answer = desk.command(ARM, 1.0)
    assert of(answer, "HEARTBEAT")[-1].base_mode & 128
    assert of(answer, "EXTENDED_SYS_STATE")[-1].landed_state == mavlink.MAV_LANDED_STATE_IN_AIR
    desk.until("sailing", lambda: desk.rig.world.truth.surge_mps > 0.2)


def test_mission_mode_without_a_mission_is_refused_with_the_reason(desk: Desk) -> None:
    desk.ready()
    assert heartbeat_mode(desk.tell(mavlink.MAVLink_set_mode_message(1, 1, MISSION))) in (None, MANUAL)
    desk.tick(2)
    assert any("no mission" in text.lower() for text in desk.texts())


def test_the_pause_pair_leaves_the_point_where_the_first_put_it(desk: Desk) -> None:
    underway(desk)
    answer = desk.command(REPOSITION, -1.0, 1.0, 0.0, NAN, NAN, NAN, NAN)
    assert of(answer, "COMMAND_ACK")[0].result == mavlink.MAV_RESULT_ACCEPTED and heartbeat_mode(answer) == HOLD
    desk.tick(10)
    first = desk.latest("POSITION_TARGET_GLOBAL_INT")
    assert desk.result(REPOSITION, -1.0, 1.0, 0.0, NAN, NAN, NAN, 2.0) == mavlink.MAV_RESULT_ACCEPTED
    desk.tick(10)
    second = desk.latest("POSITION_TARGET_GLOBAL_INT")
    held = desk.vessel.last_tick
    assert held is not None and held.setpoint.progress.target.north_m is not None
    assert (second.lat_int, second.lon_int) == pytest.approx((first.lat_int, first.lon_int), abs=100)


def test_go_here_as_command_int_and_as_command_long(desk: Desk) -> None:
    underway(desk)
    lat_deg, lon_deg = FRAME.to_geodetic(-15.0, 5.0)
    targets = []
    for as_int in (True, False):
        if as_int:
            answer = desk.tell(
                mavlink.MAVLink_command_int_message(
                    1, 1, 0, REPOSITION, 0, 0, -1.0, 1.0, 0.0, NAN, round(lat_deg * 1e7), round(lon_deg * 1e7), 1.0
                )
            )
        else:
            answer = desk.command(REPOSITION, -1.0, 1.0, 0.0, NAN, lat_deg, lon_deg, 1.0)
        assert [ack.result for ack in of(answer, "COMMAND_ACK")] == [mavlink.MAV_RESULT_ACCEPTED]
        desk.tick(12)
        target = desk.latest("POSITION_TARGET_GLOBAL_INT")
        targets.append(FRAME.to_ned(target.lat_int * 1e-7, target.lon_int * 1e-7))
        assert desk.latest("HEARTBEAT").custom_mode == HOLD
    assert math.dist(*targets) < 1.0
    tick = desk.vessel.last_tick
    assert tick is not None and tick.setpoint.progress.target.north_m == pytest.approx(-15.0, abs=0.5)


def test_choosing_hold_again_cancels_the_go_to(desk: Desk) -> None:
    underway(desk)
    desk.command(REPOSITION, -1.0, 1.0, 0.0, NAN, *FRAME.to_geodetic(-40.0, 0.0), 1.0)
    desk.tick(20)
    desk.tell(mavlink.MAVLink_set_mode_message(1, 137, HOLD))
    desk.tick(10)
    tick = desk.vessel.last_tick
    assert tick is not None and tick.setpoint.progress.target.north_m is not None
    assert abs(tick.setpoint.progress.target.north_m - tick.nav.north_m) < 5.0


def test_change_of_speed_and_set_waypoint(desk: Desk) -> None:
    underway(desk)
    assert desk.result(178, 1.0, 0.4, -1.0) == mavlink.MAV_RESULT_ACCEPTED
    answer = desk.tell(mavlink.MAVLink_mission_set_current_message(1, 1, 2))
    assert of(answer, "MISSION_CURRENT")[-1].seq == 2


def test_emergency_stop_and_force_arm(desk: Desk) -> None:
    underway(desk)
    answer = desk.command(ARM, 0.0, 21196.0)
    assert of(answer, "COMMAND_ACK")[0].result == mavlink.MAV_RESULT_ACCEPTED
    desk.tick()
    assert desk.vessel.last_tick is not None
    assert all(thruster.throttle == 0.0 for thruster in desk.vessel.last_tick.command.thrusters)


def test_arming_too_early_says_why(tmp_path: Path) -> None:
    desk = Desk(tmp_path)
    desk.tick()
    assert desk.result(ARM, 1.0) in (mavlink.MAV_RESULT_TEMPORARILY_REJECTED, mavlink.MAV_RESULT_DENIED)
    desk.tick(2)
    assert any(text.startswith("PreArm: ") for text in desk.texts())
    desk.close()


def test_unknown_commands_are_unsupported_at_once(desk: Desk) -> None:
    for number in (35, 242, 311, 2510, 31337, 65535):
        assert desk.result(number, *(NAN for _ in range(7))) == mavlink.MAV_RESULT_UNSUPPORTED
        answer = desk.tell(mavlink.MAVLink_command_int_message(1, 1, 0, number, 0, 0, NAN, NAN, NAN, NAN, 0, 0, NAN))
        assert [ack.result for ack in of(answer, "COMMAND_ACK")] == [mavlink.MAV_RESULT_UNSUPPORTED]


def test_a_file_that_is_not_there_is_refused_at_once(desk: Desk) -> None:
    payload = bytes([7, 0, 0, 4, 5, 0, 0, 0, 0, 0, 0, 0]) + b"/p.js" + bytes(234)
    answer = of(
        desk.tell(mavlink.MAVLink_file_transfer_protocol_message(0, 1, 1, list(payload))), "FILE_TRANSFER_PROTOCOL"
    )
    assert len(answer) == 1 and (answer[0].payload[0], answer[0].payload[3], answer[0].payload[5]) == (8, 129, 4)


def test_a_whole_plan_comes_back_as_it_was_sent(desk: Desk) -> None:
    fence = [
        item(n, 5002, *corner, 3.0, kind=1, frame=0)
        for n, corner in enumerate(((90.0, 90.0), (90.0, 95.0), (95.0, 90.0)))
    ]
    fence.append(item(3, 5003, 0.0, 0.0, 200.0, kind=1, frame=0))
    rally = [item(0, 5100, 3.0, -3.0, kind=2)]
    for kind, items in ((0, square()), (1, fence), (2, rally)):
        assert desk.upload(items, kind) == mavlink.MAV_MISSION_ACCEPTED
        assert of(desk.tell(mavlink.MAVLink_mission_request_list_message(1, 1, kind)), "MISSION_COUNT")[0].count == len(
            items
        )
        for sent in items:
            back = of(desk.tell(mavlink.MAVLink_mission_request_int_message(1, 1, sent.seq, kind)), "MISSION_ITEM_INT")[
                0
            ]
            for name in ITEM_FIELDS:
                assert getattr(back, name) == pytest.approx(getattr(sent, name), nan_ok=True), name


def test_streams_at_the_rates_of_the_contract(desk: Desk) -> None:
    desk.heartbeat()
    desk.ready()
    messages = desk.tick(200)
    seconds = 200 * desk.vessel.period_s
    for kind, low_hz, high_hz in (
        ("HEARTBEAT", 0.9, 1.6),
        ("SYS_STATUS", 0.9, 1.2),
        ("GLOBAL_POSITION_INT", 4.5, 10.5),
        ("GPS_RAW_INT", 1.9, 5.5),
        ("ATTITUDE", 9.0, 10.5),
        ("VFR_HUD", 3.2, 5.1),
        ("HOME_POSITION", 0.45, 1.2),
        ("BATTERY_STATUS", 0.45, 1.2),
        ("MISSION_CURRENT", 0.9, 1.2),
        ("CURRENT_MODE", 0.4, 0.6),
        ("AVAILABLE_MODES_MONITOR", 0.25, 0.45),
        ("EXTENDED_SYS_STATE", 0.9, 1.2),
        ("LOCAL_POSITION_NED", 1.9, 5.5),
        ("ESTIMATOR_STATUS", 0.9, 1.2),
        ("SYSTEM_TIME", 0.9, 1.2),
    ):
        rate_hz = len(of(messages, kind)) / seconds
        assert low_hz <= rate_hz <= high_hz, f"{kind}: {rate_hz:.2f} Hz"
