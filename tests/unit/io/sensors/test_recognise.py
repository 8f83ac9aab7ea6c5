"""The wrong device on a port is named by what it says."""

from __future__ import annotations

import random
import struct
from typing import Any

import pytest

from companion.config import SensorConfig
from companion.core.microcontroller_frame import IdentRequest, encode
from companion.io.sensors import open_sensor
from companion.io.sensors.recognise import Voice, recognise
from tests.unit.io.sensors.test_ais import CLASS_A
from tests.unit.io.sensors.test_mavlink_imu import HEARTBEAT
from tests.unit.io.sensors.test_mtdata2 import BY_HAND
from tests.unit.io.sensors.test_mtdata2_setup import Listening
from tests.unit.io.sensors.test_nmea0183 import GGA, HDT, sentence
from tests.unit.io.sensors.test_vectornav import VNYMR
from tests.unit.io.test_rtcm import STATION

VOICES = [
    (GGA + HDT, Voice("NMEA 0183", "nmea0183", "GPGGA, GPHDT")),
    (CLASS_A, Voice("AIS", "ais")),
    (VNYMR, Voice("VectorNav ASCII", "vectornav")),
    (BY_HAND, Voice("Xsens MTData2", "mtdata2")),
    (HEARTBEAT, Voice("MAVLink", "mavlink_imu", "HEARTBEAT")),
    (STATION, Voice("RTCM 3", None, "[[corrections]]")),
    (encode(IdentRequest()), Voice("the microcontroller protocol of this project", None, "an [[actuator]]")),
    (b"", None),
]


def ubx(kind: int, data: bytes) -> bytes:
    body = struct.pack("<BBH", 1, kind, len(data)) + data
    a = b = 0
    for byte in body:
        a = a + byte & 0xFF
        b = b + a & 0xFF
    return b"\xb5\x62" + body + bytes((a, b))


@pytest.mark.parametrize(("data", "voice"), VOICES)
def test_each_by_its_own_bytes(data: bytes, voice: Voice | None) -> None:
    noise = random.Random(3).randbytes(50)
    assert recognise(data) == voice
    if voice is not None:
        assert recognise(noise + b"\0" + data + noise) == voice
        assert recognise(data[: len(data) - 3]) != voice


def test_ubx() -> None:
    assert recognise(b"\xb5\x62\x01" + ubx(7, bytes(92))) == Voice("u-blox UBX", None, "switch its NMEA output on")


def test_noise_is_nothing() -> None:
    generator = random.Random(4)
    assert [recognise(generator.randbytes(400)) for _ in range(50)] == [None] * 50


def test_a_health_text_names_the_device_that_is_there() -> None:
    def text(driver: str, data: bytes) -> str:
        line = Listening()
        sensor = open_sensor(SensorConfig("sensor", driver, "serial:/dev/x:9600", timeout_s=1.0), line)
        for k in range(60):
            line.chunks = [(0.1 * k, data)]
            sensor.read(0.1 * k)
        health: Any = sensor.health(6.0)
        assert not health.ok
        return str(health.text)

    assert """the device on 'serial:/dev/x:9600' speaks Xsens MTData2: driver = "mtdata2\"""" in text("nmea0183", BY_HAND)
    assert 'speaks NMEA 0183 (GPGGA): driver = "nmea0183"' in text("mtdata2", GGA)
    assert "speaks RTCM 3 ([[corrections]])" in text("nmea0183", STATION)
    assert "speaks MAVLink (HEARTBEAT)" in text("vectornav", HEARTBEAT)
    assert "sends no sentence that is used here, but VNYMR" in text("nmea0183", VNYMR)
    assert "sends no sentence that is used here, but PASHR" in text("nmea0183", sentence("PASHR,1.0,2.0"))
    assert "but AIS" in text("nmea0183", CLASS_A)
    assert "wrong baud rate in 'serial:/dev/x:9600'" in text("nmea0183", b"\x80\xf8" * 40)
