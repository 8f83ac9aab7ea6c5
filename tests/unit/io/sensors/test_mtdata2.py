"""MTData2 messages, put together by hand, through the driver."""

from __future__ import annotations

import math
import struct
from itertools import pairwise
from typing import Literal

import pytest

from companion.config.devices import SensorConfig
from companion.core.readings import Heading, HeadingBy, Imu, MagneticField
from companion.io.sensors.mtdata2 import Mtdata2Sensor
from companion.io.sensors.sample_clock import SampleClock
from tests.wires import Wire

# packet counter 1, sample time 10000 (1 s), acceleration (0.5, −0.25, −9.75), rate of turn (0.125, 0, −0.5), status 1
BY_HAND = bytes.fromhex(
    "fa ff 36 31"
    "1020 02 0001"
    "1060 04 00002710"
    "4020 0c 3f000000 be800000 c11c0000"
    "8020 0c 3e000000 00000000 bf000000"
    "e020 04 00000001"
    "48"
)


def item(data_id: int, data: bytes) -> bytes:
    return struct.pack(">HB", data_id, len(data)) + data


def message(*items: bytes, extended: bool = False) -> bytes:
    data = b"".join(items)
    head = b"\xff\x36" + (b"\xff" + struct.pack(">H", len(data)) if extended or len(data) > 254 else bytes([len(data)]))
    return b"\xfa" + head + data + bytes([-sum(head + data) & 0xFF])


FORCE = item(0x4020, struct.pack(">3f", 0.5, -0.25, -9.75))
RATE = item(0x8020, struct.pack(">3f", 0.125, 0.0, -0.5))


def driver() -> tuple[Mtdata2Sensor, Wire]:
    line = Wire()
    return Mtdata2Sensor(SensorConfig("imu", "mtdata2", "serial:/dev/x:115200", timeout_s=0.5), line), line


def read(*chunks: bytes) -> list[Imu]:
    sensor, line = driver()
    line.chunks = [(1.0 + 0.01 * i, chunk) for i, chunk in enumerate(chunks)]
    readings = sensor.read(2.0)
    assert all(isinstance(reading, Imu) for reading in readings)
    return readings  # type: ignore[return-value]


def test_by_hand() -> None:
    assert sum(BY_HAND[1:]) % 256 == 0
    (imu,) = read(BY_HAND)
    assert (imu.t_s, imu.source) == (1.0, "imu")
    assert (imu.x_mps2, imu.y_mps2, imu.z_mps2) == (0.5, -0.25, -9.75)
    assert (imu.roll_rate_radps, imu.pitch_rate_radps, imu.yaw_rate_radps) == (0.125, 0.0, -0.5)
    assert (imu.roll_rad, imu.pitch_rad, imu.yaw_rad) == (None, None, None)


def test_euler_angles_are_degrees() -> None:
    (imu,) = read(message(FORCE, RATE, item(0x2034, struct.pack(">3f", 10.0, -5.0, 170.0))))
    assert (imu.roll_rad, imu.pitch_rad, imu.yaw_rad) == pytest.approx([math.radians(a) for a in (10.0, -5.0, 170.0)])


def test_quaternion() -> None:
    """A turn of 90° to starboard, then 30° bow up about the new y axis."""
    a, b = math.radians(45.0), math.radians(15.0)
    q = (math.cos(a) * math.cos(b), -math.sin(a) * math.sin(b), math.cos(a) * math.sin(b), math.sin(a) * math.cos(b))
    (imu,) = read(message(item(0x2014, struct.pack(">4f", *q)), FORCE, RATE))
    assert (imu.roll_rad, imu.pitch_rad, imu.yaw_rad) == pytest.approx(
        (0.0, math.radians(30.0), math.radians(90.0)), abs=1e-6
    )


@pytest.mark.parametrize(
    ("data_id", "numbers", "expected_deg"),
    [
        (0x2010, (0.0, math.sqrt(0.5), math.sqrt(0.5), 0.0), (0.0, 0.0, 0.0)),
        (0x2010, (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 90.0)),
        (0x2018, (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 0.0)),
        (0x2018, (0.0, math.sqrt(0.5), math.sqrt(0.5), 0.0), (0.0, 0.0, -90.0)),
        (0x2030, (180.0, 0.0, 0.0), (0.0, 0.0, 90.0)),
        (0x2030, (-170.0, 0.0, 90.0), (10.0, 0.0, 0.0)),
        (0x2038, (180.0, 5.0, 30.0), (0.0, -5.0, -30.0)),
    ],
)
@pytest.mark.parametrize("alone", [True, False], ids=["first", "of a known layout"])
def test_an_attitude_to_east_north_up_or_north_west_up(
    data_id: int, numbers: tuple[float, ...], expected_deg: tuple[float, ...], alone: bool
) -> None:
    """An MTi comes with ENU, and says so in its identifiers. x is ahead, y to starboard, z down in each case."""
    whole = message(item(data_id, struct.pack(f">{len(numbers)}f", *numbers)), FORCE, RATE)
    imu = read(whole if alone else whole * 2)[-1]
    assert imu.roll_rad is not None and imu.pitch_rad is not None and imu.yaw_rad is not None
    found_deg = [math.degrees(angle) for angle in (imu.roll_rad, imu.pitch_rad, imu.yaw_rad)]
    assert found_deg == pytest.approx(expected_deg, abs=1e-4)


@pytest.mark.parametrize(
    "data_id, data",
    [
        (0x4023, struct.pack(">3d", 0.5, -0.25, -9.75)),
        (0x4021, struct.pack(">3i", 1 << 19, -(1 << 18), -9 * (1 << 20) - 3 * (1 << 18))),
        (0x4022, b"\x80\x00\x00\x00\x00\x00" + b"\xc0\x00\x00\x00\xff\xff" + b"\x40\x00\x00\x00\xff\xf6"),
    ],
    ids=["double", "12.20", "16.32"],
)
def test_precisions(data_id: int, data: bytes) -> None:
    (imu,) = read(message(item(data_id, data), RATE))
    assert (imu.x_mps2, imu.y_mps2, imu.z_mps2) == (0.5, -0.25, -9.75)


def test_magnetic_field_with_and_without_the_rest() -> None:
    """Measured values of C020 (magnetic field), in the device's own unit, at the time of their message."""
    sensor, line = driver()
    field = item(0xC020, struct.pack(">3f", 0.25, -0.5, 0.75))
    line.chunks = [(1.0, message(field, FORCE, RATE)), (1.1, message(field))]
    first, imu, second = sensor.read(2.0)
    assert first == MagneticField(1.0, sensor.name, 0.25, -0.5, 0.75) and isinstance(imu, Imu) and imu.t_s == 1.0
    assert second == MagneticField(1.1, sensor.name, 0.25, -0.5, 0.75)


def test_extended_length_and_unknown_items() -> None:
    filler = [item(0x5040, bytes(250)), item(0xC010, struct.pack(">3f", 0.1, 0.2, 0.3))]
    assert len(read(message(*filler, FORCE, RATE))) == 1
    assert len(read(message(FORCE, RATE, extended=True))) == 1


def test_resynchronises_over_rubbish_at_every_split() -> None:
    stream = b"\xfa\xff\x36\x20garbage\xfa" + BY_HAND + b"\xfa\xfa\xff" + BY_HAND[:30] + BY_HAND + BY_HAND
    for at in range(len(stream)):
        assert len(read(stream[:at], stream[at:])) == 3
    assert len(read(*(stream[i : i + 1] for i in range(len(stream))))) == 3


@pytest.mark.parametrize("at", range(len(BY_HAND)))
def test_a_flipped_bit_is_seen(at: int) -> None:
    spoilt = bytearray(BY_HAND)
    spoilt[at] ^= 0x10
    assert read(bytes(spoilt)) == []


def test_items_that_lie_about_their_size() -> None:
    assert read(message(item(0x4020, bytes(8)), RATE)) == []
    assert read(message(FORCE, RATE, b"\x40\x20\x30\x00")) == []
    assert read(message(item(0x4020, struct.pack(">3f", math.nan, 0.0, 0.0)), RATE)) == []
    assert read(message(RATE)) == []


def test_times_are_those_of_the_samples() -> None:
    """Samples of 10 ms that arrive in bunches every 50 ms, and once 80 ms late: spaced 10 ms, never after their
    arrival."""
    sensor, line = driver()
    found = []
    for k in range(200):
        arrival = 5.0 + 0.05 * (k // 5 + 1) + (0.08 if 100 <= k < 105 else 0.0)
        line.chunks = [
            (arrival, message(item(0x1060, struct.pack(">I", (2**32 - 700 + 100 * k) % 2**32)), FORCE, RATE))
        ]
        (imu,) = sensor.read(arrival)
        assert imu.t_s <= arrival
        found.append(imu.t_s)
    steps = [b - a for a, b in pairwise(found[10:])]
    assert steps == pytest.approx([0.01] * len(steps), abs=2e-5)


def test_clock_follows_drift_and_starts_anew_after_a_jump() -> None:
    clock = SampleClock(latency_s=0.02)
    times = [clock.time_s(100 * k, 0.010001 * k + 1.0) for k in range(10000)]
    assert times[-1] == pytest.approx(0.010001 * 9999 + 0.98, abs=1e-6)
    assert clock.time_s(5, 200.0) == pytest.approx(199.98)  # the device was switched off and on
    assert clock.time_s(105, 200.01) == pytest.approx(199.99)


def test_health() -> None:
    sensor, line = driver()
    line.chunks = [(1.0, BY_HAND)]
    sensor.read(1.0)
    assert sensor.health(1.1).ok
    line.chunks = [(1.2, message(FORCE, RATE, item(0xE020, b"\x00\x00\x00\x00")))]
    sensor.read(1.2)
    assert "self-test" in sensor.health(1.2).text
    line.chunks = [(3.0, b"\x55" * 900)]
    sensor.read(3.0)
    assert "wrong baud rate" in sensor.health(3.0).text


@pytest.mark.parametrize(
    ("worth", "by"), [("magnetic", HeadingBy.MAGNETIC), ("true", HeadingBy.COMPASS), ("none", None)]
)
def test_the_devices_own_yaw_as_a_compass(worth: Literal["none", "magnetic", "true"], by: HeadingBy | None) -> None:
    """Ten a second of a hundred, with the mounting offset, and only where the file says what it is worth."""
    line = Wire()
    config = SensorConfig(
        "imu", "mtdata2", "serial:/dev/x:115200", heading=worth, heading_offset_rad=math.radians(20.0)
    )
    sensor = Mtdata2Sensor(config, line)
    euler = item(0x2034, struct.pack(">3f", 0.0, 0.0, 170.0))
    line.chunks = [
        (1.0 + 0.01 * k, message(item(0x1060, struct.pack(">I", 100 * k)), FORCE, RATE, euler)) for k in range(100)
    ]
    headings = [reading for reading in sensor.read(3.0) if isinstance(reading, Heading)]
    assert len(headings) == (10 if by else 0)
    assert all(heading.by is by and heading.yaw_rad == pytest.approx(math.radians(-170.0)) for heading in headings)
    assert [heading.t_s for heading in headings[:2]] == pytest.approx([1.0, 1.1][: len(headings)])


def test_a_device_without_acceleration_is_not_well() -> None:
    """As an MTi comes: it sent attitudes, counted as an inertial sensor, and was none."""
    line = Wire()
    sensor = Mtdata2Sensor(SensorConfig("imu", "mtdata2", "serial:/dev/x:115200"), line)
    attitude = item(0x2010, struct.pack(">4f", 0.0, 1.0, 0.0, 0.0))
    line.chunks = [(0.1 * k, message(attitude)) for k in range(30)]
    assert sensor.read(3.0) == []
    health = sensor.health(3.0)
    assert not health.ok and health.text.startswith("sends no acceleration and rate of turn: configure = true")
    line.chunks = [(3.1, message(attitude)), (3.1, message(FORCE, RATE))]
    assert len(sensor.read(3.1)) == 1 and sensor.health(3.1).ok
