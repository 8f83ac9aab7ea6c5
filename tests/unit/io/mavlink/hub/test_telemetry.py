from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import pytest

from companion.core.actuation import ZERO_WRENCH
from companion.core.decision import Event, FenceState, Home, MissionProgress, MissionState, ModeId, TextKind
from companion.core.estimate import Distrust
from companion.core.readings import Battery, FixType, RcInput, Wind
from companion.core.setpoint import PathSetpoint, Point, PoseSetpoint, Progress, Setpoint, WrenchSetpoint
from companion.core.tick import Inputs
from companion.io.mavlink.telemetry.streams import STREAMS
from companion.io.mavlink.wire import messages as mavlink
from tests.unit.io.mavlink.hub.conftest import Rig

DEFAULT_HZ = {
    "HEARTBEAT": 1.0,
    "SYS_STATUS": 1.0,
    "EXTENDED_SYS_STATE": 1.0,
    "GLOBAL_POSITION_INT": 5.0,
    "GPS_RAW_INT": 2.0,
    "ATTITUDE": 10.0,
    "VFR_HUD": 4.0,
    "NAV_CONTROLLER_OUTPUT": 2.0,
    "LOCAL_POSITION_NED": 2.0,
    "HOME_POSITION": 1.0,
    "MISSION_CURRENT": 1.0,
    "CURRENT_MODE": 0.5,
    "AVAILABLE_MODES_MONITOR": 1.0 / 3.0,
    "ESTIMATOR_STATUS": 1.0,
    "SYSTEM_TIME": 1.0,
    "ACTUATOR_OUTPUT_STATUS": 1.0,
}
GYRO_ACCEL_MAG_GPS = 1 | 2 | 4 | 32
PREARM, GEOFENCE, BATTERY_BIT = 0x10000000, 0x100000, 0x2000000


def newest(rig: Rig, kind: str) -> Any:
    return [message for message in rig.desk.hear() if message.get_type() == kind][-1]


def test_rates_are_those_that_stations_expect(
    make_rig: type[Rig], named: Callable[[Sequence[Any], str], list[Any]]
) -> None:
    rig = make_rig(["memory:a", "memory:b"])
    rig.run(3.0)
    for desk in rig.desks:
        desk.hear()
    rig.run(30.0)
    for desk in rig.desks:
        heard = desk.hear()
        for kind, rate_hz in DEFAULT_HZ.items():
            assert len(named(heard, kind)) == pytest.approx(30.0 * rate_hz, abs=1), kind
        assert sum(len(message.get_msgbuf()) for message in heard) / 30.0 < 2500.0


def test_what_there_is_no_data_for_is_not_sent(rig: Rig) -> None:
    rig.run(4.0)
    kinds = {message.get_type() for message in rig.desk.hear()}
    assert kinds.isdisjoint(
        {"BATTERY_STATUS", "RC_CHANNELS", "WIND_COV", "MISSION_ITEM_REACHED", "POSITION_TARGET_GLOBAL_INT"}
    )


def test_heartbeat(rig: Rig) -> None:
    rig.run(1.0)
    beat = newest(rig, "HEARTBEAT")
    assert (beat.type, beat.autopilot, beat.custom_mode, beat.system_status) == (11, 12, 0x03040000, 3)
    assert beat.base_mode & 129 == 1
    rig.supervisor.change(armed=True, mode=ModeId.MISSION)
    rig.tick()
    beat = newest(rig, "HEARTBEAT")
    assert (beat.custom_mode, beat.system_status, beat.base_mode & 129) == (0x04040000, 4, 129)
    rig.supervisor.change(failsafes=("battery_critical",))
    rig.tick()
    assert newest(rig, "HEARTBEAT").system_status == 5


def test_a_change_by_command_is_told_between_two_ticks(
    make_rig: type[Rig], named: Callable[[Sequence[Any], str], list[Any]]
) -> None:
    rig = make_rig(["memory:a", "memory:b?dialect=ardupilot"])
    rig.run(1.0)
    rig.desks[1].hear()
    heard = rig.command(400, 1.0)
    assert [message.get_type() for message in heard] == [
        "COMMAND_ACK",
        "HEARTBEAT",
        "EXTENDED_SYS_STATE",
        "CURRENT_MODE",
    ]
    assert heard[1].base_mode & 128
    assert heard[2].landed_state == mavlink.MAV_LANDED_STATE_IN_AIR
    others = rig.desks[1].hear()
    assert named(others, "HEARTBEAT")[0].base_mode & 128
    rig.tick()
    assert named(rig.desk.hear(), "HEARTBEAT") == []  # said once


def test_the_persona_is_the_endpoints(make_rig: type[Rig], named: Callable[[Sequence[Any], str], list[Any]]) -> None:
    rig = make_rig(["memory:a", "memory:b?dialect=ardupilot", "memory:c?dialect=generic"])
    rig.supervisor.change(mode=ModeId.MISSION, mission=MissionProgress(MissionState.ACTIVE, 1, 3))
    rig.run(1.5)
    heard = [desk.hear() for desk in rig.desks]
    beats = [named(messages, "HEARTBEAT")[-1] for messages in heard]
    assert [(beat.autopilot, beat.custom_mode) for beat in beats] == [(12, 0x04040000), (3, 10), (0, 0x04040000)]
    assert [named(messages, "MISSION_CURRENT")[-1].seq for messages in heard] == [1, 2, 1]
    assert [named(messages, "CURRENT_MODE")[-1].custom_mode for messages in heard] == [0x04040000, 10, 0x04040000]


def test_position_and_motion(rig: Rig) -> None:
    rig.run(1.0)
    heard = {message.get_type(): message for message in rig.desk.hear()}
    position = heard["GLOBAL_POSITION_INT"]
    assert (position.lat, position.lon, position.alt, position.relative_alt) == (634400000, 104000000, 1500, 500)
    assert (position.vx, position.vy, position.vz) == (30, 40, 0)
    assert position.hdg == round(math.degrees(1.0) * 100)
    raw = heard["GPS_RAW_INT"]
    assert (raw.fix_type, raw.satellites_visible, raw.eph, raw.vel, raw.h_acc) == (6, 17, 80, 50, 50)
    assert raw.cog == round(math.degrees(math.atan2(0.4, 0.3)) * 100)
    assert raw.hdg_acc == round(math.degrees(0.01) * 1e5)
    local = heard["LOCAL_POSITION_NED"]
    assert (local.x, local.y, local.z) == (3.0, -4.0, 0.0)
    attitude = heard["ATTITUDE"]
    assert (attitude.roll, attitude.pitch, attitude.yaw) == pytest.approx((0.01, -0.02, 1.0))
    hud = heard["VFR_HUD"]
    assert (hud.groundspeed, hud.heading, hud.throttle) == (pytest.approx(0.5), 57, 30)
    outputs = heard["ACTUATOR_OUTPUT_STATUS"]
    assert list(outputs.actuator[:4]) == pytest.approx([0.2, -0.4, 0.5 / math.pi, 0.0])
    assert outputs.active == 0  # disarmed


def test_home(rig: Rig, named: Callable[[Sequence[Any], str], list[Any]]) -> None:
    rig.run(2.0)
    home = newest(rig, "HOME_POSITION")
    assert (home.latitude, home.longitude, home.altitude) == (634400000, 104000000, 1000)
    assert 2.0 * math.atan2(home.q[3], home.q[0]) == pytest.approx(0.5)
    assert home.x == pytest.approx(
        math.radians(0.01) * 6.3866e6, rel=1e-4
    )  # north of the origin, by the meridian's radius there
    rig.supervisor.change(home=Home(63.0, 10.0, 0.0))
    rig.tick()
    (home,) = named(rig.desk.hear(), "HOME_POSITION")
    assert home.latitude == 630000000
    assert math.isnan(home.q[0])
    rig.supervisor.change(home=None)
    rig.desk.hear()
    rig.run(3.0)
    assert named(rig.desk.hear(), "HOME_POSITION") == []


def test_mission_progress_is_told_as_it_happens(rig: Rig, named: Callable[[Sequence[Any], str], list[Any]]) -> None:
    rig.run(1.0)
    rig.desk.hear()
    rig.supervisor.now = replace(
        rig.supervisor.now,
        mode=ModeId.MISSION,
        mission=MissionProgress(MissionState.ACTIVE, 2, 3, reached_seq=1, reached=1),
    )
    rig.tick()
    heard = rig.desk.hear()
    (current,) = named(heard, "MISSION_CURRENT")
    assert (current.seq, current.total, current.mission_state, current.mission_mode) == (2, 3, 3, 1)
    assert [message.seq for message in named(heard, "MISSION_ITEM_REACHED")] == [1]
    rig.run(1.0)
    assert named(rig.desk.hear(), "MISSION_ITEM_REACHED") == []
    rig.supervisor.now = replace(
        rig.supervisor.now, mission=MissionProgress(MissionState.ACTIVE, 2, 3, reached_seq=1, reached=2)
    )
    rig.tick()  # the same item again, by a jump
    assert len(named(rig.desk.hear(), "MISSION_ITEM_REACHED")) == 1
    rig.supervisor.now = replace(rig.supervisor.now, mission=MissionProgress(MissionState.NO_MISSION, 0, 0))
    rig.tick()
    assert newest(rig, "MISSION_CURRENT").total == 65535


def test_sensor_bits_tell_the_truth(rig: Rig) -> None:
    def bits(**nav: Any) -> int:
        tick = rig.tick()
        rig.desk.hear()
        rig.run(1.0, nav=replace(tick.nav, **nav))
        status = newest(rig, "SYS_STATUS")
        assert status.onboard_control_sensors_present & GYRO_ACCEL_MAG_GPS == GYRO_ACCEL_MAG_GPS
        return int(status.onboard_control_sensors_health)

    assert bits() & GYRO_ACCEL_MAG_GPS == GYRO_ACCEL_MAG_GPS
    assert bits(imu_age_s=5.0) & GYRO_ACCEL_MAG_GPS == 4 | 32
    assert bits(imu_age_s=math.inf) & GYRO_ACCEL_MAG_GPS == GYRO_ACCEL_MAG_GPS  # a boat without one
    assert bits(heading_valid=False) & GYRO_ACCEL_MAG_GPS == 1 | 2 | 32
    assert bits(position_valid=False) & GYRO_ACCEL_MAG_GPS == 7
    assert bits(fix=FixType.NONE) & 32 == 0


@pytest.mark.parametrize(
    ("sense", "ill"),
    [
        ("position", 32),
        ("velocity", 32),
        ("heading", 4),
        ("IMU", 1 | 2),
        ("gyro", 1),
        ("accelerometer", 2),
        ("wind", 0),
        ("time", 0),
        ("", 0),
    ],
)
def test_the_bit_of_a_sensor_that_lies(rig: Rig, sense: str, ill: int) -> None:
    lies = (Distrust(sense, "gnss", "repeats", 0.0, True, False),) if sense else ()
    rig.run(2.0, nav=replace(rig.tick().nav, distrusted=lies))
    health = newest(rig, "SYS_STATUS").onboard_control_sensors_health
    assert health & GYRO_ACCEL_MAG_GPS == GYRO_ACCEL_MAG_GPS & ~ill


def test_readiness_and_fence_bits(rig: Rig) -> None:
    def health() -> int:
        rig.desk.hear()
        rig.run(1.0)
        return int(newest(rig, "SYS_STATUS").onboard_control_sensors_health)

    assert health() & PREARM and health() & GEOFENCE
    rig.supervisor.change(arming_refusals=("No position",))
    assert not health() & PREARM
    rig.supervisor.change(armed=True)
    assert health() & PREARM
    rig.supervisor.change(fence=FenceState(False, 0, None, False))
    assert health() & GEOFENCE
    rig.supervisor.change(fence=FenceState(True, 1, 0.5, False))
    assert not health() & GEOFENCE


def test_fence_status(rig: Rig) -> None:
    rig.run(2.0)
    assert "FENCE_STATUS" not in {message.get_type() for message in rig.desk.hear()}, "no fence, nothing to say"
    rig.supervisor.change(fence=FenceState(False, 0, None, True))
    rig.run(0.2)
    told = newest(rig, "FENCE_STATUS")
    assert (told.breach_status, told.breach_count, told.breach_type, told.breach_time, told.breach_mitigation) == (
        0,
        0,
        0,
        0,
        2,
    )
    rig.supervisor.change(fence=FenceState(True, 3, 12.5, False))
    rig.run(0.2)
    told = newest(rig, "FENCE_STATUS")
    assert (told.breach_status, told.breach_count, told.breach_type, told.breach_time, told.breach_mitigation) == (
        1,
        3,
        3,
        12500,
        1,
    )


def test_each_pack_has_a_number_and_a_silent_one_leaves_its_own_free(rig: Rig) -> None:
    fore, house = Battery(0.1, "fore", 24.0, None, 0.5), Battery(0.1, "house", 12.0, 1.0, 0.9)
    rig.run(2.0, inputs=Inputs(battery=fore, batteries=(fore, None, house)))
    heard = [message for message in rig.desk.hear() if message.get_type() == "BATTERY_STATUS"]
    assert {(one.id, one.voltages[0], one.battery_remaining) for one in heard} == {(0, 24000, 50), (2, 12000, 90)}


def test_battery(rig: Rig) -> None:
    pack = Battery(0.1, "b", 80.0, 12.5, 0.2)
    rig.run(2.0, inputs=Inputs(battery=pack, batteries=(pack,)))
    heard = {message.get_type(): message for message in rig.desk.hear()}
    battery, status = heard["BATTERY_STATUS"], heard["SYS_STATUS"]
    assert sum(cell for cell in battery.voltages if cell != 65535) == 80000
    assert (battery.current_battery, battery.battery_remaining, battery.charge_state) == (1250, 20, 2)
    assert list(battery.voltages_ext) == [0, 0, 0, 0]
    assert (status.current_battery, status.battery_remaining) == (1250, 20)
    assert not status.onboard_control_sensors_health & BATTERY_BIT
    pack = Battery(0.1, "b", 24.0, None, None)
    rig.run(2.0, inputs=Inputs(battery=pack, batteries=(pack,)))
    heard = {message.get_type(): message for message in rig.desk.hear()}
    assert (
        heard["BATTERY_STATUS"].current_battery,
        heard["BATTERY_STATUS"].battery_remaining,
        heard["SYS_STATUS"].voltage_battery,
    ) == (
        -1,
        -1,
        24000,
    )


def test_transmitter_and_wind(rig: Rig) -> None:
    tick = rig.tick()
    nav = replace(tick.nav, wind_speed_mps=5.0, wind_from_rad=math.radians(90.0))
    rig.run(
        2.0, nav=nav, inputs=Inputs(rc=RcInput(0.1, "rc", (0.0, 1.0, -1.0, 0.5), False), wind=Wind(0.1, "w", 6.0, 0.0))
    )
    heard = {message.get_type(): message for message in rig.desk.hear()}
    rc, wind = heard["RC_CHANNELS"], heard["WIND_COV"]
    assert (rc.chancount, rc.chan1_raw, rc.chan2_raw, rc.chan3_raw, rc.chan4_raw, rc.chan5_raw) == (
        4,
        1500,
        2000,
        1000,
        1750,
        65535,
    )
    assert (wind.wind_x, wind.wind_y) == pytest.approx((0.0, -5.0), abs=1e-6)  # from the east, so it blows west
    assert heard["VFR_HUD"].airspeed == pytest.approx(6.0)


def test_setpoint(rig: Rig) -> None:
    setpoint = PoseSetpoint(
        10.0,
        20.0,
        math.pi / 2,
        surge_mps=0.5,
        progress=Progress(target=Point(103.0, -4.0), cross_track_error_m=-1.5),
    )
    rig.run(2.0, setpoint=setpoint)
    heard = {message.get_type(): message for message in rig.desk.hear()}
    target, output = heard["POSITION_TARGET_GLOBAL_INT"], heard["NAV_CONTROLLER_OUTPUT"]
    north_m, east_m = rig.vessel.frame.to_ned(target.lat_int * 1e-7, target.lon_int * 1e-7)
    assert (north_m, east_m) == pytest.approx((10.0, 20.0), abs=0.02)
    assert (target.vx, target.vy, target.yaw) == pytest.approx((0.0, 0.5, math.pi / 2), abs=1e-6)
    assert target.type_mask & 0b110000011011 == 0
    assert (output.target_bearing, output.wp_dist, output.nav_bearing, output.xtrack_error) == (0, 100, 90, -1.5)


def test_the_origin_of_the_local_plane_on_request(rig: Rig, named: Callable[[Sequence[Any], str], list[Any]]) -> None:
    """MAVSDK asks for it (`get_gps_global_origin`), to turn places into the metres of its setpoints."""
    rig.tick()
    (origin,) = named(rig.command(512, 49.0), "GPS_GLOBAL_ORIGIN")
    frame = rig.vessel.frame
    assert (origin.latitude, origin.longitude) == (round(frame.lat_deg * 1e7), round(frame.lon_deg * 1e7))


def test_setpoint_in_the_local_plane_on_request(rig: Rig, named: Callable[[Sequence[Any], str], list[Any]]) -> None:
    """The mask leaves what is meant of each kind: a path of velocities has no place, a boat without thrust no
    setpoint."""

    def told(setpoint: Setpoint) -> Any:
        rig.tick(setpoint=setpoint)
        return named(rig.command(512, 85.0), "POSITION_TARGET_LOCAL_NED")

    (whole,) = told(PoseSetpoint(10.0, 20.0, math.pi / 2, surge_mps=0.5, sway_mps2=0.1, yaw_rate_radps=0.2))
    assert (whole.coordinate_frame, whole.type_mask) == (1, 0b100100100) and (whole.x, whole.y) == (10.0, 20.0)
    assert (whole.vx, whole.vy, whole.afx, whole.afy) == pytest.approx((0.0, 0.5, -0.1, 0.0), abs=1e-6)
    assert (whole.yaw, whole.yaw_rate) == pytest.approx((math.pi / 2, 0.2))
    (course,) = told(PathSetpoint(yaw_rad=0.0, surge_mps=2.0))
    assert course.type_mask == 0b100100100 | 0b111 | 0b111000000 and course.vx == 2.0
    assert told(WrenchSetpoint(ZERO_WRENCH)) == []


def test_numbers_that_are_none_stop_nothing(rig: Rig) -> None:
    tick = rig.tick()
    names = [name for name in tick.nav.__slots__ if isinstance(getattr(tick.nav, name), float) and name != "t_s"]
    for value in (math.nan, math.inf, -math.inf, 1e30):
        rig.desk.hear()
        setpoint = PoseSetpoint(
            value, value, value, progress=Progress(target=Point(value, value), distance_to_go_m=value)
        )
        rig.run(3.2, nav=replace(tick.nav, **dict.fromkeys(names, value)), setpoint=setpoint, load=value)
        kinds = {message.get_type() for message in rig.desk.hear()}
        assert {"HEARTBEAT", "SYS_STATUS", "GLOBAL_POSITION_INT"} <= kinds


def test_events_become_texts(rig: Rig, named: Callable[[Sequence[Any], str], list[Any]]) -> None:
    rig.tick(events=(Event(0.1, TextKind.ATTENTION, "x", "short"), Event(0.1, TextKind.ALARM, "y", "z" * 120)))
    texts = named(rig.desk.hear(), "STATUSTEXT")
    assert (texts[0].severity, texts[0].text, texts[0].id) == (4, "short", 0)
    assert "".join(message.text for message in texts[1:]) == "z" * 120
    assert {message.severity for message in texts[1:]} == {2}
    assert len({message.id for message in texts[1:]}) == 1


def test_refusals_to_arm_are_repeated_every_half_minute(
    rig: Rig, named: Callable[[Sequence[Any], str], list[Any]]
) -> None:
    rig.supervisor.change(arming_refusals=("No position", "Leak"))
    rig.run(59.0)
    texts = [message.text for message in named(rig.desk.hear(), "STATUSTEXT")]
    assert texts == ["PreArm: No position", "PreArm: Leak"] * 2
    rig.supervisor.change(armed=True)
    rig.run(40.0)
    assert named(rig.desk.hear(), "STATUSTEXT") == []


def test_intervals_are_each_endpoints_own(
    make_rig: type[Rig], named: Callable[[Sequence[Any], str], list[Any]]
) -> None:
    rig = make_rig(["memory:a", "memory:b"])
    rig.run(1.0)
    rig.command(511, 30.0, 500000.0)
    rig.command(511, 33.0, -1.0)
    for desk in rig.desks:
        desk.hear()
    rig.run(10.0)
    heard = [desk.hear() for desk in rig.desks]
    assert [len(named(messages, "ATTITUDE")) for messages in heard] == pytest.approx([20, 100], abs=1)
    assert [len(named(messages, "GLOBAL_POSITION_INT")) for messages in heard] == [0, 50]
    rig.command(511, 30.0, 0.0)
    rig.desk.hear()
    rig.run(10.0)
    assert len(named(rig.desk.hear(), "ATTITUDE")) == pytest.approx(100, abs=1)


def test_a_data_stream_request_leaves_explicit_intervals_alone(
    rig: Rig, named: Callable[[Sequence[Any], str], list[Any]]
) -> None:
    rig.run(1.0)
    rig.command(511, 30.0, 500000.0)
    rig.ask(mavlink.MAVLink_request_data_stream_message(1, 1, mavlink.MAV_DATA_STREAM_ALL, 4, 1))
    rig.desk.hear()
    rig.run(10.0)
    heard = rig.desk.hear()
    assert len(named(heard, "ATTITUDE")) == pytest.approx(20, abs=1)
    assert len(named(heard, "GLOBAL_POSITION_INT")) == pytest.approx(40, abs=7)  # ticks are a tenth of a second apart
    assert len(named(heard, "HEARTBEAT")) == 10
    rig.ask(mavlink.MAVLink_request_data_stream_message(1, 1, mavlink.MAV_DATA_STREAM_POSITION, 4, 0))
    rig.desk.hear()
    rig.run(5.0)
    assert named(rig.desk.hear(), "GLOBAL_POSITION_INT") == []


def test_a_slow_line_gets_less_and_never_loses_its_heartbeat(
    rig: Rig, named: Callable[[Sequence[Any], str], list[Any]]
) -> None:
    endpoint = rig.desk.endpoint
    endpoint.bytes_per_s = 960.0
    rig.run(60.0)
    heard = rig.desk.hear()
    assert sum(len(message.get_msgbuf()) for message in heard) / 60.0 < 0.65 * 960.0
    assert len(named(heard, "HEARTBEAT")) >= 60
    assert len(named(heard, "GLOBAL_POSITION_INT")) > 20


def test_the_modes_monitor_moves_when_the_modes_do(rig: Rig) -> None:
    rig.run(4.0)
    before = newest(rig, "AVAILABLE_MODES_MONITOR").seq
    rig.run(4.0)
    assert newest(rig, "AVAILABLE_MODES_MONITOR").seq == before
    rig.supervisor.modes = rig.supervisor.modes[:-1]
    rig.run(4.0)
    assert newest(rig, "AVAILABLE_MODES_MONITOR").seq == before + 1


@pytest.mark.parametrize("number", STREAMS)
def test_nothing_is_made_up_before_the_first_tick(rig: Rig, number: int) -> None:
    """Only what needs no estimate can be asked for; nothing fails."""
    message = rig.hub.telemetry.message(number, rig.desk.endpoint.persona, 0.0)
    assert message is None or message.get_msgId() == number
    assert rig.vessel.events.drain() == ()
