"""The ULog of the ticks, read by pyulog."""

from __future__ import annotations

import io
import math
from dataclasses import replace
from pathlib import Path

import pytest
from pyulog import ULog
from pyulog.px4 import PX4ULog

from companion.core.decision import Event, ModeId, TextKind
from companion.core.readings import Battery, FixType, GnssFix
from companion.core.tick import Inputs
from companion.params.table import TABLE
from companion.record.recorder import LogFolder, Medium
from companion.record.ulog import FILE, UlogEncoder
from tests.unit.record.ticks import tick


def read(data: bytes) -> ULog:
    return ULog(io.BytesIO(data))


def written(count: int = 20) -> bytes:
    encoder = UlogEncoder(("port", "starboard"))
    parts = [
        encoder.header(
            {"sys_name": "USV companion", "ver_hw": "revolt"},
            {"WP_SPEED": 0.6, "NAV_DLL_ACT": 1.0},
            frozenset({"NAV_DLL_ACT"}),
        )
    ]
    for n in range(count):
        row = tick(0.1 * n)
        if n == 3:
            row = replace(
                row,
                inputs=Inputs(battery=Battery(0.3, "board", 12.6, None, 0.8)),
                events=(Event(0.25, TextKind.ATTENTION, "leak", "Water ö"),),
            )
        parts.append(encoder.tick(row))
        if n == 5:
            parts.append(encoder.parameter("WP_SPEED", 0.9, whole=False))
    return b"".join(parts)


def test_pyulog_reads_every_topic_with_its_values() -> None:
    log = read(written())
    topics = {(data.name, data.multi_id): data.data for data in log.data_list}
    own = {topic for topic in topics if topic[0].startswith("usv_")}
    assert own == {
        ("usv_motion", 0),
        ("usv_status", 0),
        ("usv_setpoint", 0),
        ("usv_wrench", 0),
        ("usv_thruster", 0),
        ("usv_thruster", 1),
        ("usv_battery", 0),
    }
    motion = topics[("usv_motion", 0)]
    assert motion["timestamp"].tolist() == [round(1e5 * n) for n in range(20)]
    assert motion["lat_deg"][0] == 63.4 and motion["yaw_rad"][7] == pytest.approx(0.3)
    assert math.isnan(motion["wind_speed_mps"][0]) and set(motion["position_valid"]) == {1}
    assert topics[("usv_thruster", 1)]["throttle"][0] == pytest.approx(-0.5) and math.isnan(
        topics[("usv_thruster", 1)]["azimuth_rad"][0]
    )
    assert topics[("usv_thruster", 1)]["condition"][0] == 2
    assert topics[("usv_battery", 0)]["voltage_v"].tolist() == [pytest.approx(12.6)] and math.isnan(
        topics[("usv_battery", 0)]["current_a"][0]
    )
    assert topics[("usv_wrench", 0)]["demanded_surge_n"][0] == 3.0


def test_tools_for_px4s_logs_find_its_topics() -> None:
    encoder = UlogEncoder(("port", "starboard"))
    fix = GnssFix(0.0, "gnss", 63.41, 10.41, 41.0, FixType.RTK_FIXED, 18, 0.7, 0.013)
    rows = [replace(tick(0.1 * n), readings=(fix,) if n % 2 else ()) for n in range(10)]
    rows[4] = replace(rows[4], inputs=Inputs(battery=Battery(0.4, "board", 12.6, None, 0.8)))
    log = read(b"".join([encoder.header({}, {}, frozenset()), *map(encoder.tick, rows)]))
    assert {data.name for data in log.data_list} >= {
        "vehicle_global_position", "vehicle_local_position", "vehicle_attitude", "vehicle_gps_position",
        "battery_status", "vehicle_status", "vehicle_angular_velocity",
    }  # fmt: skip
    place = log.get_dataset("vehicle_global_position").data
    assert (place["lat"][0], place["lon"][0]) == (63.4, 10.4)
    gps = log.get_dataset("vehicle_gps_position").data
    assert gps["latitude_deg"].tolist() == [63.41] * 5 and set(gps["fix_type"]) == {6}
    attitude = log.get_dataset("vehicle_attitude").data
    assert 2.0 * math.atan2(attitude["q[3]"][0], attitude["q[0]"][0]) == pytest.approx(0.3, abs=1e-6)
    status = log.get_dataset("vehicle_status")
    assert set(status.data["nav_state"]) == {4} and set(status.data["arming_state"]) == {2}
    battery = log.get_dataset("battery_status").data
    assert battery["remaining"].tolist() == [pytest.approx(0.8)] and battery["current_a"].tolist() == [-1.0]
    PX4ULog(log).add_roll_pitch_yaw()
    assert attitude["yaw"][0] == pytest.approx(0.3, abs=1e-6)


def test_every_mode_has_a_state_of_px4() -> None:
    for mode in ModeId:
        one = tick(0.0)
        one = replace(one, status=replace(one.status, mode=mode))
        encoder = UlogEncoder(("port", "starboard"))
        log = read(encoder.header({}, {}, frozenset()) + encoder.tick(one))
        assert 0 <= log.get_dataset("vehicle_status").data["nav_state"][0] < 31


def test_information_parameters_changes_and_events() -> None:
    log = read(written())
    assert log.msg_info_dict["sys_name"] == "USV companion"
    assert log.initial_parameters == {"WP_SPEED": pytest.approx(0.6), "NAV_DLL_ACT": 1}
    assert isinstance(log.initial_parameters["NAV_DLL_ACT"], int)
    assert [(name, value) for _, name, value in log.changed_parameters] == [("WP_SPEED", pytest.approx(0.9))]
    (said,) = log.logged_messages
    assert (said.message, said.log_level_str(), said.timestamp) == ("Water ö", "WARNING", 250_000)


def test_a_file_that_was_cut_off_is_read_up_to_there() -> None:
    whole = written()
    for cut in (1, 7, 33, 200):
        log = read(whole[:-cut])
        assert len(log.get_dataset("usv_motion").data["timestamp"]) >= 18


def test_the_recorder_writes_it_where_rows_are_to_be_kept(tmp_path: Path) -> None:
    for durable in (True, False):
        folder = tmp_path / str(durable)
        log = LogFolder(
            folder,
            ["port", "starboard"],
            [],
            {"version": "1", "parameters": {"WP_SPEED": 0.6}},
            TABLE,
            Medium(durable=durable, beside=durable),
        )
        for n in range(5):
            log.record(tick(0.1 * n))
        log.parameter("NAV_DLL_ACT", 2.0)
        log.close()
        assert (folder / FILE).exists() == durable
    again = ULog(str(tmp_path / "True" / FILE))
    assert len(again.get_dataset("usv_motion").data["timestamp"]) == 5
    assert [value for _, _, value in again.changed_parameters] == [2]
