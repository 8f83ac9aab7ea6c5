"""Formats told from each other by the bytes of real devices."""

from __future__ import annotations

import random

import pytest
from pymavlink.dialects.v20 import common as mavlink

from companion.config.devices import ActuatorConfig, SensorConfig
from companion.config.vessel import find, load
from companion.core.microcontroller_frame import BoardStatus, ThrusterState, encode
from companion.io.actuators import open_actuator
from companion.io.formats import LineFormat
from companion.io.recognise import Recogniser
from companion.io.rtcm import crc24q
from companion.io.sensors import open_sensor
from tests.unit.io.sensors.test_vectornav import VNINS
from tests.wires import Wire

GNSS = b"$GPGGA,092725.00,4717.11399,N,00833.91590,E,1,08,1.01,499.6,M,48.0,M,,*5B\r\n"
WIND = b"$WIMWV,214.8,R,0.1,K,A*28\r\n"
AIS = b"!AIVDM,1,1,,B,177KQJ5000G?tO`K>RA1wUbN0TKH,0*5C\r\n"
MTDATA2 = bytes.fromhex(
    "faff36311020020001106004000027104020 0c3f000000be800000c11c0000 80200c3e00000000000000bf000000 e0200400000001 48".replace(
        " ", ""
    )
)
XSENS_CONFIG = bytes.fromhex("faff3e00c3")  # WakeUp, as after power-up
RTCM_1005 = bytes.fromhex("d300133ed7d30202980edeef34b4bd62ac0941986f33360b98")  # the example of RTCM 10403
UBX_ACK = bytes.fromhex("b5620501020006010f38")
HEARTBEAT = mavlink.MAVLink_heartbeat_message(2, 3, 0, 0, 4, 3).pack(mavlink.MAVLink(None, srcSystem=1, srcComponent=1))
BOARD = encode(BoardStatus(7, False, False, False, False, 24.1, 1.5, 0.8, (0,) * 8, (ThrusterState(0.0),) * 3))
DEVICES = {
    "gnss": (GNSS, LineFormat.NMEA, "GPGGA", "the GNSS receiver"),
    "wind": (WIND, LineFormat.NMEA, "WIMWV", "the wind sensor"),
    "ais": (AIS, LineFormat.AIS, "AIVDM", "the AIS receiver"),
    "imu": (MTDATA2, LineFormat.MTDATA2, "acceleration, rate of turn", "the inertial sensor"),
    "xsens": (XSENS_CONFIG, LineFormat.XSENS, "message 3E", "the inertial sensor"),
    "vectornav": (VNINS, LineFormat.NMEA, "VNINS", "the inertial sensor"),
    "rtcm": (RTCM_1005, LineFormat.RTCM, "1005", "the radio with the corrections"),
    "ubx": (UBX_ACK, LineFormat.UBX, "05 01", "the GNSS receiver"),
    "mavlink": (HEARTBEAT, LineFormat.MAVLINK, "HEARTBEAT", "a telemetry radio or an autopilot"),
    "board": (BOARD, LineFormat.BOARD, "status", "the thruster board"),
}


def test_crc24q_against_the_standards_own_example() -> None:
    assert crc24q(RTCM_1005[:-3]) == 0x360B98


@pytest.mark.parametrize("device", list(DEVICES))
@pytest.mark.parametrize("piece", [1, 7, 4096])
def test_each_is_told_however_its_bytes_come_in(device: str, piece: int) -> None:
    data, kind, name, called = DEVICES[device]
    line, recogniser = random.Random(5).randbytes(40) + b"\0" + 20 * data, Recogniser()
    for at in range(0, len(line), piece):
        recogniser.feed(line[at : at + piece])
    verdict = recogniser.verdict
    assert verdict is not None and (verdict.format, verdict.device) == (kind, called)
    assert verdict.kinds[0] == (name, 20), "each message counts once"


def test_a_receiver_that_passes_corrections_on_is_a_receiver() -> None:
    recogniser = Recogniser()
    for _ in range(10):
        recogniser.feed(5 * GNSS + UBX_ACK + RTCM_1005)
    assert recogniser.verdict is not None and recogniser.verdict.format is LineFormat.NMEA


def test_noise_is_nothing() -> None:
    recogniser, noise = Recogniser(), random.Random(1)
    for _ in range(100):
        recogniser.feed(noise.randbytes(2000))
    assert recogniser.verdict is None and recogniser.guess == ""


def test_damaged_messages_are_nothing() -> None:
    for data, *_ in DEVICES.values():
        recogniser = Recogniser()
        for at in range(2, len(data.rstrip())):
            recogniser.feed(data[:at] + bytes((data[at] ^ 0x04,)) + data[at + 1 :])
        assert recogniser.verdict is None, data


@pytest.mark.parametrize(
    ("data", "says"),
    [
        (b"$GPGGA,092725.00,4717.1,N,00833.9,E*00\r\n", "with wrong checksums"),
        (b"ypr: 12.1 -3.4 0.7\r\n", "text, but no NMEA 0183 with checksums: '"),
        (XSENS_CONFIG, "MT Manager"),
        (UBX_ACK, "have it send NMEA 0183"),
    ],
)
def test_what_can_be_said_of_the_rest(data: bytes, says: str) -> None:
    recogniser = Recogniser()
    recogniser.feed(30 * data)
    assert says in recogniser.guess


def wire_with(data: bytes) -> Wire:
    """The bytes in pieces of 64, ten a second."""
    return Wire([(0.1 * k, data[64 * k : 64 * k + 64]) for k in range(len(data) // 64)])


@pytest.mark.parametrize("plugged", ["gnss", "ais", "imu", "rtcm", "mavlink", "board"])
@pytest.mark.parametrize("expected", ["nmea0183", "mtdata2", "ais", "microcontroller"])
def test_a_device_in_another_ones_port_is_named(plugged: str, expected: str) -> None:
    data, kind, name, called = DEVICES[plugged]
    if (plugged, expected) in {
        ("gnss", "nmea0183"),
        ("ais", "nmea0183"),
        ("imu", "mtdata2"),
        ("ais", "ais"),
        ("board", "microcontroller"),
    }:
        return
    wire, vessel = wire_with(data * (4500 // len(data))), load(find("revolt"))
    if expected == "microcontroller":
        row = ActuatorConfig(
            "mcu", expected, "serial:/dev/usv-mcu:115200", tuple(thruster.name for thruster in vessel.thrusters)
        )
        driver = open_actuator(row, vessel, wire)
    else:
        driver = open_sensor(SensorConfig("device", expected, "serial:/dev/usv-x:115200"), wire)  # type: ignore[assignment]
    driver.read(10.0)
    text = driver.health(10.0).text
    assert text.startswith("4,4") and f"looks like {kind.value} ({name}): is {called} plugged in here?" in text, text
