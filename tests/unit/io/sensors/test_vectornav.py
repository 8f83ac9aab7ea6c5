"""VNYMR messages as devices have printed them, through the driver; and the commands that it writes."""

from __future__ import annotations

import math
from typing import Any

import pytest

from companion.config.devices import SensorConfig
from companion.core.readings import Heading, HeadingBy, Imu, MagneticField
from companion.io.sensors import open_sensor
from tests.unit.io.sensors.test_nmea0183 import sentence
from tests.wires import Listening

# recorded of VN-100s by other projects, with their checksums
VNYMR = b"$VNYMR,+100.949,-007.330,+000.715,-00.0049,-00.2449,+00.5397,-01.258,-00.100,-09.701,-00.000018,+00.001122,-00.000551*69\r\n"
TILTED = b"$VNYMR,-078.104,+005.642,+023.096,+00.0125,+00.1252,-00.1042,+00.878,-03.762,-08.854,-00.010387,-00.028062,-00.061305*68\r\n"


def driver(**more: Any) -> tuple[Any, Listening]:
    line = Listening()
    return open_sensor(SensorConfig("imu", "vectornav", "serial:/dev/x:115200", **more), line), line


def read(*chunks: bytes, **more: Any) -> list[Any]:
    sensor, line = driver(**more)
    line.chunks = [(1.0 + 0.1 * k, chunk) for k, chunk in enumerate(chunks)]
    return list(sensor.read(9.0))


def test_by_hand() -> None:
    (imu,) = read(VNYMR)
    assert isinstance(imu, Imu)
    assert (imu.t_s, imu.source, imu.x_mps2, imu.y_mps2, imu.z_mps2) == (1.0, "imu", -1.258, -0.1, -9.701)
    assert (imu.roll_rate_radps, imu.pitch_rate_radps, imu.yaw_rate_radps) == (-0.000018, 0.001122, -0.000551)
    assert (imu.roll_rad, imu.pitch_rad, imu.yaw_rad) == pytest.approx(
        [math.radians(a) for a in (0.715, -7.33, 100.949)]
    )


def test_attitude_and_specific_force_are_of_the_same_axes() -> None:
    """At rest the force is −g in the axes of the attitude: x g sin pitch, y −g cos pitch sin roll, z −g cos pitch cos
    roll."""
    for imu in read(VNYMR, TILTED):
        g = math.hypot(imu.x_mps2, imu.y_mps2, imu.z_mps2)
        assert g == pytest.approx(9.8, abs=0.15)
        pitch, roll = math.asin(imu.x_mps2 / g), math.atan2(-imu.y_mps2, -imu.z_mps2)
        assert (pitch, roll) == pytest.approx((imu.pitch_rad, imu.roll_rad), abs=math.radians(0.8))


def test_field_and_heading_where_the_file_asks_for_them() -> None:
    field, imu = read(VNYMR, heading="ahrs")
    assert field == MagneticField(1.0, "imu", -0.0049, -0.2449, 0.5397) and isinstance(imu, Imu)
    imu, heading = read(VNYMR, heading="magnetic", heading_offset_rad=0.1)
    assert heading == Heading(1.0, "imu", pytest.approx(math.radians(100.949) + 0.1), None, HeadingBy.MAGNETIC)


@pytest.mark.parametrize(
    "bad",
    [
        VNYMR.replace(b"*69", b"*68"),
        sentence("VNYMR,1,2,3"),
        sentence("VNYMR" + ",1" * 11 + ",x"),
        sentence("VNYMR" + ",1" * 11 + ","),
        b"$VN*18\r\n",
    ],
)
def test_bad_messages_give_nothing(bad: bytes) -> None:
    assert read(bad) == []


def test_every_split_gives_the_same() -> None:
    whole = b"\xfa$VN" + VNYMR + TILTED
    for at in range(1, len(whole)):
        assert len(read(whole[:at], whole[at:])) == 2


def test_it_is_told_type_and_rate() -> None:
    sensor, line = driver(configure=True, rate_hz=60.0)
    line.chunks = [(0.0, VNYMR)]
    assert sensor.read(0.0) == () and line.sent == [(0.0, sentence("VNWRG,06,14"))]
    line.chunks = [(0.1, sentence("VNWRG,06,14"))]
    sensor.read(0.1)
    assert line.sent[-1] == (0.1, sentence("VNWRG,07,50"))
    line.chunks = [(0.2, sentence("VNERR,06"))]
    sensor.read(0.2)
    assert "refuses output rate: error 06" in sensor.health(0.2).text
    for now_s, reply in ((5.3, b""), (5.4, sentence("VNWRG,06,14")), (5.5, sentence("VNWRG,07,50")), (5.6, VNYMR)):
        line.chunks = [(now_s, reply)]
        readings = sensor.read(now_s)
    assert len(readings) == 1 and sensor.health(5.6).ok


# of the VN-200's manual: 137 bytes, and what it sends unless it is told otherwise
VNINS = sentence(
    "VNINS,333811.902862,1694,0004,+009.500,-004.754,-000.225,+32.95602815,-096.71415700,+00171.195,"
    "-000.840,-000.396,-000.109,07.8,01.6,0.23"
)


def test_a_device_that_sends_another_message_is_not_well() -> None:
    sensor, line = driver(rate_hz=50.0)
    line.chunks = [(0.1 * k, VNINS) for k in range(30)]
    assert sensor.read(3.0) == [] and sensor.counts == (30, 0)
    assert not sensor.health(3.0).ok
    assert sensor.health(3.0).text.startswith("sends VNINS, not VNYMR: configure = true, or set its register 6 to 14")
    line.chunks = [(3.1, VNINS + VNYMR)]
    assert len(sensor.read(3.1)) == 1 and sensor.health(3.1).ok


def test_a_device_that_has_lost_its_settings_is_configured_again() -> None:
    sensor, line = driver(configure=True, rate_hz=50.0)
    told = ((0.0, VNINS), (0.1, sentence("VNWRG,06,14")), (0.2, sentence("VNWRG,07,50")), (0.3, VNYMR))
    for now_s, reply in told:
        line.chunks = [(now_s, reply)]
        sensor.read(now_s)
    assert sensor.health(0.3).ok and len(line.sent) == 2
    for k in range(35):
        line.chunks = [(0.4 + 0.1 * k, VNINS)]
        sensor.read(0.4 + 0.1 * k)
    assert line.sent[2] == (pytest.approx(3.5), sentence("VNWRG,06,14"))


def test_a_device_that_was_without_power_for_a_moment_is_configured_again() -> None:
    """It comes back with VNYMR, at the rate that is stored in it: 40 Hz as it comes from the maker."""
    sensor, line = driver(configure=True, rate_hz=100.0)
    told = ((0.0, VNYMR), (0.1, sentence("VNWRG,06,14")), (0.2, sentence("VNWRG,07,100")), (0.3, VNYMR), (0.7, VNYMR))
    for now_s, reply in told:
        line.chunks = [(now_s, reply)]
        sensor.read(now_s)
    assert sensor.health(0.7).ok and len(line.sent) == 2
    line.chunks = [(2.0, VNYMR)]
    assert sensor.read(2.0) == () and line.sent[2:] == [(2.0, sentence("VNWRG,06,14"))]
    line.chunks = [(2.02, sentence("VNWRG,06,14"))]
    sensor.read(2.02)
    line.chunks = [(2.04, sentence("VNWRG,07,100") + VNYMR)]
    assert len(sensor.read(2.04)) == 1 and line.sent[3:] == [(2.02, sentence("VNWRG,07,100"))]


def test_a_slow_device_is_not_configured_again_at_each_message() -> None:
    sensor, line = driver(configure=True, rate_hz=1.0)
    told = ((0.0, VNYMR), (0.1, sentence("VNWRG,06,14")), (0.2, sentence("VNWRG,07,1")), (1.2, VNYMR), (2.2, VNYMR))
    for now_s, reply in told:
        line.chunks = [(now_s, reply)]
        sensor.read(now_s)
    assert sensor.health(2.2).ok and len(line.sent) == 2
