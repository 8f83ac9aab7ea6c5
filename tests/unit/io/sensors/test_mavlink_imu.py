"""A Pixhawk's IMU messages, packed by pymavlink, through the driver; and what it asks for."""

from __future__ import annotations

import math
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from companion.config.devices import SensorConfig
from companion.core.readings import Heading, HeadingBy, Imu, MagneticField
from companion.io.sensors import open_sensor
from tests.wires import Listening

G = 9.80665


def packed(message: Any, system: int = 7, component: int = 1, v1: bool = False) -> bytes:
    data: bytes = message.pack(mavlink.MAVLink(None, srcSystem=system, srcComponent=component), force_mavlink1=v1)
    return data


def heartbeat(autopilot: int = 12, kind: int = 10) -> Any:
    return mavlink.MAVLink_heartbeat_message(kind, autopilot, 0, 0, 4, 3)


def scaled(boot_ms: int) -> Any:
    return mavlink.MAVLink_scaled_imu_message(boot_ms, 51, -26, -994, 125, -250, 500, 200, -50, 400)


HEARTBEAT = packed(heartbeat())
HIGHRES = packed(
    mavlink.MAVLink_highres_imu_message(
        5_000_000, 0.5, -0.25, -9.75, 0.125, -0.25, 0.5, 0.2, -0.05, 0.4, 1013.0, 0, 0, 20, 0x1FF
    )
)
ATTITUDE = packed(mavlink.MAVLink_attitude_message(5000, 0.02, -0.03, 2.0, 0.0, 0.0, 0.0))


def driver(**more: Any) -> tuple[Any, Listening]:
    line = Listening()
    return open_sensor(SensorConfig("imu", "mavlink_imu", "serial:/dev/x:921600", rate_hz=100.0, **more), line), line


def read(*chunks: bytes, **more: Any) -> list[Any]:
    sensor, line = driver(**more)
    line.chunks = [(1.0, chunk) for chunk in chunks]
    return list(sensor.read(1.0))


def written(line: Listening) -> list[Any]:
    codec = mavlink.MAVLink(None)
    return [m for _, data in line.sent for m in codec.parse_buffer(data) or ()]


def test_highres_by_hand() -> None:
    (imu,) = read(HEARTBEAT + HIGHRES)
    assert imu == Imu(1.0, "imu", 0.5, -0.25, -9.75, 0.125, -0.25, 0.5)


def test_scaled_by_hand() -> None:
    """mG and mrad/s."""
    (imu,) = read(HEARTBEAT + packed(scaled(100)))
    assert (imu.x_mps2, imu.y_mps2, imu.z_mps2) == pytest.approx((0.051 * G, -0.026 * G, -0.994 * G))
    assert (imu.roll_rate_radps, imu.pitch_rate_radps, imu.yaw_rate_radps) == pytest.approx((0.125, -0.25, 0.5))


def test_raw_only_of_ardupilot_and_only_without_better() -> None:
    raw = packed(mavlink.MAVLink_raw_imu_message(100_000, 51, -26, -994, 125, -250, 500, 200, -50, 400), v1=True)
    assert read(HEARTBEAT + raw) == []
    (imu,) = read(packed(heartbeat(autopilot=3)) + raw)
    assert imu.z_mps2 == pytest.approx(-0.994 * G)
    assert len(read(packed(heartbeat(autopilot=3)) + packed(scaled(100)) + raw)) == 1
    assert len(read(packed(heartbeat(autopilot=3)) + HIGHRES + packed(scaled(100)) + raw)) == 1


def test_attitude_goes_with_the_sample() -> None:
    (imu,) = read(HEARTBEAT + ATTITUDE + HIGHRES)
    assert (imu.roll_rad, imu.pitch_rad, imu.yaw_rad) == pytest.approx((0.02, -0.03, 2.0))
    heading, imu = read(HEARTBEAT + ATTITUDE + HIGHRES, heading="true", heading_offset_rad=0.1)
    assert heading == Heading(1.0, "imu", pytest.approx(2.1), None, HeadingBy.COMPASS)
    field, imu = read(HEARTBEAT + ATTITUDE + HIGHRES, heading="ahrs")
    assert field == MagneticField(
        1.0, "imu", pytest.approx(0.2), pytest.approx(-0.05), pytest.approx(0.4)
    ) and isinstance(imu, Imu)


def test_an_old_attitude_does_not() -> None:
    sensor, line = driver()
    line.chunks = [(1.0, HEARTBEAT + ATTITUDE), (1.2, HIGHRES)]
    (imu,) = sensor.read(1.2)
    assert imu.roll_rad is None


def test_other_systems_on_the_line_are_not_the_imu() -> None:
    station = packed(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3), system=255, component=190)
    other = HIGHRES.replace(
        HIGHRES, packed(mavlink.MAVLink_highres_imu_message(1, 9, 9, 9, 9, 9, 9, 0, 0, 0, 0, 0, 0, 0, 0x1FF), system=8)
    )
    assert read(station + HIGHRES) == []
    assert read(station + HEARTBEAT + other) == []
    assert len(read(station + HEARTBEAT + other + HIGHRES)) == 1


def test_samples_that_are_none() -> None:
    nan = packed(mavlink.MAVLink_highres_imu_message(1, math.nan, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x1FF))
    stale = packed(mavlink.MAVLink_highres_imu_message(1, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0x1C0))
    assert read(HEARTBEAT + nan + stale) == []


def test_times_are_those_of_the_samples() -> None:
    sensor, line = driver()
    line.chunks = [(0.9, HEARTBEAT)]
    sensor.read(0.9)
    times = []
    for k in range(100):
        arrival_s = 1.0 + 0.01 * k + (0.03 if k % 7 == 4 else 0.0)
        line.chunks = [(arrival_s, packed(scaled(500 + 10 * k)))]
        times += [imu.t_s for imu in sensor.read(arrival_s)]
    assert times == pytest.approx([1.0 + 0.01 * k for k in range(100)], abs=1e-4)


def test_it_asks_for_what_does_not_come() -> None:
    sensor, line = driver()
    sensor.read(0.5)
    assert line.sent == [], "nobody is there to ask"
    line.chunks = [(1.0, HEARTBEAT)]
    sensor.read(1.0)
    beat, *asked = written(line)
    assert (beat.get_type(), beat.get_srcSystem(), beat.get_srcComponent(), beat.type, beat.autopilot) == (
        "HEARTBEAT",
        7,
        191,
        18,
        8,
    )
    assert [(m.command, int(m.param1), m.param2, m.target_system, m.target_component) for m in asked] == [
        (511, 105, 10_000.0, 7, 1), (511, 26, 10_000.0, 7, 1), (511, 30, 50_000.0, 7, 1)
    ]  # fmt: skip
    line.sent.clear()
    line.chunks = [(2.0, HIGHRES + ATTITUDE)]
    sensor.read(2.0)
    assert [m.get_type() for m in written(line)] == ["HEARTBEAT"]
    line.sent.clear()
    line.chunks = [(3.5, ATTITUDE)]
    sensor.read(3.5)
    assert [int(m.param1) for m in written(line) if m.get_type() == "COMMAND_LONG"] == [105, 26]


def test_health() -> None:
    sensor, line = driver(timeout_s=0.5)
    line.chunks = [(1.0, packed(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3), system=255))]
    sensor.read(1.0)
    assert "no autopilot's heartbeat" in sensor.health(1.0).text
    line.chunks = [(1.1, HEARTBEAT)]
    sensor.read(1.1)
    assert not sensor.health(1.1).ok and "does not send the IMU messages" in sensor.health(1.1).text
    line.chunks = [(1.2, HIGHRES)]
    sensor.read(1.2)
    assert sensor.health(1.3).ok
    line.chunks = [(2.5, HEARTBEAT)]
    sensor.read(2.5)
    assert not sensor.health(2.5).ok
    assert "silent for" in sensor.health(9.0).text or "wrong baud" not in sensor.health(9.0).text
    line.chunks = [(9.0, b"\x55" * 700)]
    sensor.read(9.0)
    assert "wrong baud rate" in sensor.health(9.0).text
