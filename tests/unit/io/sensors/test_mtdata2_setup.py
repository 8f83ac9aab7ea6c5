"""An MTi told at the start what to send and how it is mounted: by the bytes of its protocol, and against an emulated
one that answers."""

from __future__ import annotations

import math
import struct
from dataclasses import replace

import pytest

from companion.config.devices import SensorConfig
from companion.config.vessel import find, load, parse
from companion.core.readings import Imu, MagneticField
from companion.io.sensors import open_sensor
from companion.io.sensors.mtdata2 import Mtdata2Sensor
from sitl.world import World, WorldConditions
from tests.unit.io.sensors.test_mtdata2 import BY_HAND, FORCE, RATE, item, message
from tests.wires import Listening

REVOLT = load(find("revolt"))
ROTATION = (math.radians(180.0), math.radians(10.0), math.radians(-90.0))


def told(**more: object) -> tuple[Mtdata2Sensor, Listening]:
    line = Listening()
    return Mtdata2Sensor(
        SensorConfig("imu", "mtdata2", "serial:/dev/x", rate_hz=100.0, configure=True, **more), line
    ), line  # type: ignore[arg-type]


def answer(number: int, data: bytes = b"") -> bytes:
    body = bytes((0xFF, number, len(data))) + data
    return b"\xfa" + body + bytes((-sum(body) & 0xFF,))


def step(sensor: Mtdata2Sensor, line: Listening, now_s: float, data: bytes = b"") -> bytes:
    """What it writes after hearing `data`."""
    line.sent.clear()
    line.chunks = [(now_s, data)] if data else []
    sensor.read(now_s)
    return b"".join(sent for _, sent in line.sent)


def test_the_commands_by_hand() -> None:
    """Bytes as the protocol's documentation has them: GoToConfig is FA FF 30 00 D1, GoToMeasurement FA FF 10 00 F1."""
    sensor, line = told(rotation_rad=(math.pi, 0.0, 0.0))
    assert step(sensor, line, 0.0) == bytes.fromhex("faff3000d1")
    output = step(sensor, line, 0.1, bytes.fromhex("faff3100d0"))
    assert output[:4] == bytes.fromhex("faffc018") and sum(output[1:]) % 256 == 0
    assert output[4:-1] == bytes.fromhex("1020ffff 1060ffff 20140064 40200064 80200064 e020ffff")
    alignment = step(sensor, line, 0.2, answer(0xC1, output[4:-1]))
    assert alignment[:5] == bytes.fromhex("faffec1100")
    assert struct.unpack(">4f", alignment[5:-1]) == pytest.approx((0.0, 1.0, 0.0, 0.0), abs=1e-7)
    assert step(sensor, line, 0.3, answer(0xED)) == bytes.fromhex("faff1000f1")
    assert not sensor.health(0.3).ok and "GoToMeasurement" in sensor.health(0.3).text
    assert step(sensor, line, 0.4, answer(0x11)) == b""
    line.chunks = [(0.5, BY_HAND)]
    assert len(sensor.read(0.5)) == 1 and sensor.health(0.5).ok


def test_raw_field_for_an_ahrs_of_our_own() -> None:
    sensor, line = told(heading="ahrs")
    step(sensor, line, 0.0)
    assert step(sensor, line, 0.1, answer(0x31))[4:-1] == bytes.fromhex(
        "1020ffff 1060ffff 40200064 80200064 c0200032 e020ffff"
    )


def test_nothing_is_believed_before_it_is_configured() -> None:
    sensor, line = told()
    assert step(sensor, line, 0.0, BY_HAND * 5) != b"" and "being configured" in sensor.health(0.0).text


def test_a_deaf_device_is_asked_again_and_said() -> None:
    sensor, line = told()
    sent = [k / 10 for k in range(150) if step(sensor, line, k / 10, BY_HAND)]
    assert sent == pytest.approx([0.0, 0.5, 1.0, 1.5, 7.0, 7.5, 8.0, 8.5, 14.0, 14.5], abs=0.11)
    assert "does not acknowledge GoToConfig" in sensor.health(15.0).text and not sensor.health(15.0).ok


def test_a_refusal_is_said_with_its_reason_and_tried_again() -> None:
    sensor, line = told()
    step(sensor, line, 0.0)
    step(sensor, line, 0.1, answer(0x31))
    assert step(sensor, line, 0.2, answer(0x42, b"\x21")) == b""
    assert "refuses SetOutputConfiguration: invalid parameter" in sensor.health(0.3).text
    assert step(sensor, line, 5.3) == bytes.fromhex("faff3000d1")


def test_a_rate_that_the_device_cannot_give_is_said() -> None:
    sensor, line = told()
    step(sensor, line, 0.0)
    step(sensor, line, 0.1, answer(0x31))
    step(sensor, line, 0.2, answer(0xC1, bytes.fromhex("4020003280200032")))
    step(sensor, line, 0.3, answer(0x11))
    line.chunks = [(0.4, message(FORCE, RATE, item(0xE020, b"\x00\x00\x00\x01")))]
    sensor.read(0.4)
    assert sensor.health(0.4).ok and "gives 50 Hz, not the 100 asked for" in sensor.health(0.4).text


def test_configured_again_when_it_was_unplugged_or_without_power() -> None:
    for how in ("unplugged", "silent"):
        sensor, line = told()
        for k, reply in enumerate((b"", answer(0x31), answer(0xC1), answer(0x11))):
            step(sensor, line, 0.1 * k, reply)
        assert step(sensor, line, 0.5, BY_HAND) == b""
        if how == "unplugged":
            line.broken = "no such device"
            step(sensor, line, 0.6)
            line.broken = None
            assert step(sensor, line, 0.7, BY_HAND) == bytes.fromhex("faff3000d1")
        else:
            assert step(sensor, line, 3.4) == b""
            assert step(sensor, line, 4.0) == bytes.fromhex("faff3000d1")


@pytest.mark.parametrize("heading", ["magnetic", "ahrs"])
def test_an_emulated_device_turns_its_axes_as_told(heading: str) -> None:
    """Mounted upside down, tilted and across, configured by the driver: it measures what one mounted straight does."""
    found = []
    for rotation in (None, ROTATION):
        gnss, imu = REVOLT.sensors
        row = replace(imu, rate_hz=50.0, heading=heading, rotation_rad=rotation, configure=rotation is not None)
        world = World(replace(REVOLT, sensors=(gnss, row)), WorldConditions(seed=3))
        world.set_state(yaw_rad=1.0)
        sensor, readings = open_sensor(row, world.open("imu", "")), []
        for k in range(200):
            world.advance(0.05 * k)
            readings += sensor.read(0.05 * k)
        assert sensor.health(9.95).ok, sensor.health(9.95).text
        assert sum(isinstance(reading, Imu) for reading in readings) > 450
        found.append(
            {
                reading.t_s: reading
                for reading in readings
                if isinstance(reading, Imu if heading == "magnetic" else MagneticField)
            }
        )
    straight, turned = found
    names = (
        ("x_mps2", "y_mps2", "z_mps2", "roll_rate_radps", "yaw_rate_radps", "roll_rad", "pitch_rad", "yaw_rad")
        if heading == "magnetic"
        else ("x", "y", "z")
    )
    for t_s in sorted(turned)[:: max(1, len(turned) // 20)]:
        near = straight[min(straight, key=lambda other: abs(other - t_s))]
        for name in names:
            assert getattr(turned[t_s], name) == pytest.approx(getattr(near, name), abs=2e-5)


def test_the_file_says_it_in_degrees(tmp_path: object) -> None:
    text = (
        find("revolt")
        .read_text(encoding="utf-8")
        .replace('driver = "mtdata2"', 'driver = "mtdata2"\nconfigure = true\nrotation_deg = [180, 0, -90]')
    )
    row = parse(text, "x").sensors[1]
    assert row.configure and row.rotation_rad == pytest.approx((math.pi, 0.0, -0.5 * math.pi))
