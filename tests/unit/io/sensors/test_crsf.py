"""CRSF frames through the driver, and the telemetry that goes back."""

from __future__ import annotations

import math
import struct
from collections.abc import Mapping
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from companion.core.decision import ModeId
from companion.core.readings import Battery
from companion.core.tick import Inputs
from companion.io.crsf_telemetry import CrsfTelemetry
from tests.unit.estimates import AT_REST
from tests.unit.io.sensors.rc_line import ANY_STREAM, HIGH, LOW, Line, cut, in_shares, packed
from tests.unit.io.sensors.test_sbus import CENTRED
from tests.wires import Listening

CHANNELS, LINK, PING = 0x16, 0x14, 0x28


def crc(data: bytes) -> int:
    """CRC-8 with polynomial 0xD5, bit by bit."""
    value = 0
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = ((value << 1) ^ 0xD5) & 0xFF if value & 0x80 else value << 1
    return value


def frame(kind: int, payload: bytes, address: int = 0xC8) -> bytes:
    body = bytes((kind,)) + payload
    return bytes((address, len(body) + 1)) + body + bytes((crc(body),))


def sticks(*values: int) -> bytes:
    return frame(CHANNELS, packed(values))


def link(quality: int) -> bytes:
    return frame(LINK, bytes((50, 50, quality, 8, 0, 4, 3, 50, quality, 8)))


def line(**more: Any) -> Line:
    """A driver that has heard two frames: the third in a row counts."""
    found = Line("crsf", **more)
    found.period_s = 0.02
    found.hear(*[frame(PING, b"\x00\xea")] * 2)
    return found


def test_a_frame_by_hand() -> None:
    centred = frame(CHANNELS, CENTRED[1:23])
    assert centred[:3] == bytes.fromhex("c8 18 16") and crc(b"123456789") == 0xBC  # the check value of DVB-S2
    (rc,) = line().hear(centred)
    assert rc.channels == (0.0,) * 16 and not rc.lost


def test_sticks_and_addresses() -> None:
    for address in (0xC8, 0xEA, 0xEE):
        (rc,) = line().hear(frame(CHANNELS, sticks(LOW, HIGH)[3:25], address))
        assert rc.channels[:3] == pytest.approx((-1.0, 1.0, 0.0))


def test_a_dead_radio_link_is_a_lost_transmitter() -> None:
    radio = line()
    assert not radio.hear(link(100), sticks(HIGH))[-1].lost
    assert radio.hear(link(0))[-1].lost, "without channels, as ExpressLRS"
    assert radio.hear(sticks(LOW))[-1].lost, "with the receiver's own channels, as Crossfire"
    assert not radio.hear(link(70), sticks(HIGH))[-1].lost
    assert not radio.hear(*[sticks(HIGH)] * 3)[-1].lost


def test_silence_is_a_lost_transmitter_and_no_fault() -> None:
    radio = line(timeout_s=1.0)
    assert radio.sensor.health(5.0).ok, "a receiver whose transmitter is off says nothing"
    radio.hear(sticks(HIGH))
    (gone,) = radio.sensor.read(radio.now_s + 1.5)
    assert gone.lost and radio.sensor.health(radio.now_s + 1.5).ok
    assert not radio.hear(sticks(HIGH))[-1].lost


def test_other_frames_and_bad_checksums_are_passed_over() -> None:
    radio = line()
    spoilt = bytearray(sticks(HIGH))
    spoilt[10] ^= 1
    assert not radio.hear(frame(PING, b"\x00\xea"), bytes(spoilt))
    assert radio.sensor.counts == (0, 1)
    assert not radio.hear(sticks(LOW), sticks(LOW)), "not trusted yet"
    assert radio.hear(sticks(LOW))[-1].channels[0] == -1.0


def test_a_wrong_baud_rate_is_explained() -> None:
    radio = line()
    radio.hear(*[bytes((7, 13, 29)) * 20] * 30)
    assert "baud rate 420000" in radio.sensor.health(radio.now_s).text and not radio.sensor.health(radio.now_s).ok


@settings(deadline=None, derandomize=True, max_examples=60)
@given(**ANY_STREAM)
def test_any_channels_come_through_after_any_noise(values: list[int], noise: bytes, sizes: list[int]) -> None:
    found = line().hear(*cut(noise + sticks(*values) * 5, sizes))
    assert found and found[-1].channels == pytest.approx(in_shares(values))


# --- telemetry -----------------------------------------------------------------------------------------------------


def tick(t_s: float, armed: bool = True, nav: Mapping[str, Any] | None = None) -> Any:
    battery = Battery(t_s, "battery", 25.24, 12.5, 0.81)
    status = SimpleNamespace(mode=ModeId.MISSION, armed=armed)
    return SimpleNamespace(
        t_s=t_s, nav=replace(AT_REST, t_s=t_s, **(nav or {})), status=status, inputs=Inputs(battery=battery)
    )


def told(*ticks: Any) -> dict[int, bytes]:
    wire = Listening()
    telemetry = CrsfTelemetry(wire)
    for one in ticks:
        telemetry.record(one)
    found = {}
    for _, data in wire.sent:
        assert data[0] == 0xC8 and data[1] == len(data) - 2 and data[-1] == crc(data[2:-1])
        found[data[2]] = data[3:-1]
    return found


def test_place_battery_attitude_and_mode_in_turn() -> None:
    motion: dict[str, Any] = {
        "north_mps": 3.0,
        "east_mps": 4.0,
        "yaw_rad": math.radians(-90.0),
        "roll_rad": 0.1,
        "pitch_rad": -0.2,
    }
    motion |= {"satellites": 14, "altitude_m": -3.0}
    found = told(*(tick(0.1 * n, nav=motion) for n in range(4)))
    assert set(found) == {0x02, 0x08, 0x1E, 0x21}
    lat, lon, speed, heading, altitude, satellites = struct.unpack(">iiHHHB", found[0x02])
    assert (lat * 1e-7, lon * 1e-7) == pytest.approx((AT_REST.lat_deg, AT_REST.lon_deg), abs=1e-6)
    assert (speed, heading, altitude, satellites) == (180, 27000, 997, 14), "0.1 km/h, 0.01 deg, m above −1000 m"
    assert struct.unpack(">HH", found[0x08][:4]) == (252, 125) and found[0x08][4:] == bytes((0, 0, 0, 81))
    assert struct.unpack(">hhh", found[0x1E]) == (-2000, 1000, -15708)
    assert found[0x21] == b"Mission\0"


def test_what_is_unknown_is_left_out_and_disarmed_has_a_star() -> None:
    unknown = {"position_valid": False, "heading_valid": False}
    found = told(*(tick(0.1 * n, armed=False, nav=unknown) for n in range(4)))
    assert set(found) == {0x08, 0x21} and found[0x21] == b"Mission*\0"


def test_one_frame_in_a_tenth_of_a_second() -> None:
    wire = Listening()
    telemetry = CrsfTelemetry(wire)
    for n in range(100):
        telemetry.record(tick(0.02 * n))
    assert len(wire.sent) == 20


@settings(deadline=None, derandomize=True, max_examples=60)
@given(
    st.fixed_dictionaries(
        dict.fromkeys(("north_mps", "yaw_rad", "roll_rad", "altitude_m", "lat_deg"), st.floats(width=32))
    )
)
def test_no_number_stops_the_telemetry(nav: dict[str, float]) -> None:
    assert set(told(*(tick(0.1 * n, nav=nav) for n in range(4)))) >= {0x02, 0x08, 0x21}
