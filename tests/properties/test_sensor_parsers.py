"""Whatever comes down the line, the parsers do not raise, do not grow, and believe no bad checksum."""

from __future__ import annotations

import random
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common as mavlink

from companion.config.devices import SensorConfig
from companion.io.sensors import DRIVERS, open_sensor
from tests.remembered import remembered
from tests.unit.io.sensors.test_ais import CLASS_A, CLASS_A_SLOW, CLASS_B
from tests.unit.io.sensors.test_crsf import sticks
from tests.unit.io.sensors.test_mavlink_imu import HEARTBEAT, HIGHRES, packed
from tests.unit.io.sensors.test_mtdata2 import BY_HAND
from tests.unit.io.sensors.test_nmea0183 import GGA, HDT, VTG
from tests.unit.io.sensors.test_sbus import HIGH, LOW
from tests.unit.io.sensors.test_sbus import frame as sbus_frame
from tests.unit.io.sensors.test_vectornav import VNYMR
from tests.wires import Wire

_CM = [65535] * 70 + [300, 4000]
SECTORS = packed(mavlink.MAVLink_obstacle_distance_message(0, 0, _CM, 5, 20, 4000, 5.0, 0.0, 12))
WHOLE = {
    "nmea0183": GGA + HDT + VTG,
    "mtdata2": BY_HAND * 3,
    "vectornav": VNYMR * 3,
    "mavlink_imu": HEARTBEAT + HIGHRES * 3,
    "mavlink_range": HEARTBEAT + SECTORS * 3,
    "ais": CLASS_A + CLASS_A_SLOW + CLASS_B,
    "sbus": sbus_frame(LOW, HIGH) * 12,
    "crsf": sticks(LOW, HIGH) * 3,
}
NEWEST_ONLY = {"sbus", "crsf"}  # of what comes in one read


def driver(name: str) -> tuple[Any, Wire]:
    line = Wire()
    return open_sensor(SensorConfig("sensor", name, "serial:/dev/x:9600"), line), line


@pytest.mark.parametrize("name", DRIVERS)
def test_random_bytes(name: str) -> None:
    generator = random.Random(4)
    alphabet = b"$*,.0123456789ABCDEFGHINPTVZ\r\n\xfa\xff\x36"
    sensor, line = driver(name)
    for k in range(400):
        noise = generator.randbytes(125) + bytes(generator.choices(alphabet, k=125))
        line.chunks = [(0.01 * k, noise)]
        assert sensor.read(0.01 * k) == []
        assert remembered(sensor) < 6000
    assert sensor.counts[0] == 0
    assert not sensor.health(4.0).ok
    line.chunks = [(5.0, bytes(3000) + WHOLE[name])]
    assert len(sensor.read(5.0)) == (1 if name in NEWEST_ONLY else 3)


@pytest.mark.parametrize("name", DRIVERS)
@settings(deadline=None, derandomize=True, max_examples=60)
@given(data=st.data())
def test_one_spoilt_byte_never_gives_a_wrong_reading(name: str, data: st.DataObject) -> None:
    stream = bytearray(WHOLE[name])
    at = data.draw(st.integers(0, len(stream) - 1))
    stream[at] = data.draw(st.integers(0, 255))
    cut = data.draw(st.integers(0, len(stream)))
    clean, clean_line = driver(name)
    clean_line.chunks = [(1.0, WHOLE[name])]
    expected = [repr(reading) for reading in clean.read(1.0)]
    sensor, line = driver(name)
    line.chunks = [(1.0, bytes(stream[:cut])), (1.0, bytes(stream[cut:]))]
    assert all(repr(reading) in expected for reading in sensor.read(1.0))


@pytest.mark.parametrize(
    "kind",
    [
        "GGA",
        "GNS",
        "GLL",
        "RMC",
        "VTG",
        "HDT",
        "THS",
        "HDG",
        "ZDA",
        "GST",
        "GSA",
        "GSV",
        "MWV",
        "VWR",
        "ROT",
        "DBT",
        "DPT",
        "VHW",
        "VBW",
        "RSA",
        "XDR",
        "TTM",
        "TLL",
    ],
)
@settings(deadline=None, derandomize=True, max_examples=40)
@given(
    fields=st.lists(
        st.one_of(
            st.sampled_from(["", "A", "N", "E", "R", "K", "120000.5", "-1", "1e999", "280511"]),
            st.text("0123456789.-+eEnaNif", max_size=9),
        ),
        max_size=16,
    )
)
def test_any_fields_under_a_good_checksum(kind: str, fields: list[str]) -> None:
    body = f"GP{kind},{','.join(fields)}".encode()
    total = 0
    for byte in body:
        total ^= byte
    sensor, line = driver("nmea0183")
    line.chunks = [(1.0, b"$%s*%02X\r\n" % (body, total))]
    sensor.read(1.0)
