"""ArduPilot's JSON interface by a client written from its documentation."""

from __future__ import annotations

import json
import math
import struct
from typing import Any

import pytest

from companion.config.vessel import ConfigError, find, load
from companion.core.geodesy import LocalFrame
from sitl.json_physics import JsonPhysics, ThrusterChannels, parse_outputs, read_packet, without_boards
from sitl.world import World, WorldConditions

OTTER, REVOLT, BLUEBOAT, ABOAT = (load(find(name)) for name in ("otter", "revolt", "blueboat", "aboat"))
RATE_HZ = 100


def packet(count: int, *pulses_us: int, rate_hz: int = RATE_HZ, channels: int = 16) -> bytes:
    magic = {16: 18458, 32: 29569}[channels]
    return struct.pack(f"<HHI{channels}H", magic, rate_hz, count, *pulses_us, *[0] * (channels - len(pulses_us)))


def physics(vessel: Any, outputs: str = "", **conditions: Any) -> JsonPhysics:
    world = World(without_boards(vessel), WorldConditions(**conditions))
    return JsonPhysics(world, vessel, parse_outputs(outputs, vessel))


def state(reply: bytes | None) -> dict[str, Any]:
    assert reply is not None and reply.startswith(b"\n") and reply.endswith(b"\n")
    assert not set(reply[1:-1]) & set(b" \t\r\n")  # as in the documentation's example: ArduPilot looks for `"gyro":[`
    found: dict[str, Any] = json.loads(reply)
    assert {"timestamp", "imu", "position", "attitude", "velocity"} <= found.keys()
    return found


def test_ahead_is_ahead_and_a_frame_is_a_step() -> None:
    boat = physics(BLUEBOAT, "port=1,starboard=3")
    for count in range(500):
        seen = state(boat.answer(packet(count, 1900, 0, 1900)))
    assert seen["timestamp"] == pytest.approx(5.0) and boat.world.t_s == pytest.approx(5.0)
    north_m, east_m, down_m = seen["position"]
    assert north_m > 3.0 and abs(east_m) < 0.2 and down_m == 0.0
    assert seen["velocity"][0] == pytest.approx(boat.world.truth.surge_mps, abs=0.05)
    assert seen["imu"]["accel_body"][2] == pytest.approx(-9.8, abs=0.05)


def test_degrees_that_ardupilot_makes_of_its_metres_are_the_true_ones() -> None:
    boat, home = physics(ABOAT), ABOAT.home
    boat.world.set_state(250.0, 400.0)
    north_m, east_m, _ = state(boat.answer(packet(0)))["position"]
    lat_deg = home.lat_deg + north_m / 111_318.845  # m of a degree on its sphere
    lon_deg = home.lon_deg + east_m / (111_318.845 * math.cos(math.radians(0.5 * (lat_deg + home.lat_deg))))
    found = LocalFrame(home.lat_deg, home.lon_deg).to_ned(lat_deg, lon_deg)
    assert found == pytest.approx((250.0, 400.0), abs=0.005)


def test_port_thrust_turns_to_starboard_and_the_gyro_tells_it() -> None:
    boat = physics(BLUEBOAT, "port=1,starboard=3")
    for count in range(200):
        seen = state(boat.answer(packet(count, 1700, 0, 1300)))
    assert seen["attitude"][2] > 0.2 and seen["imu"]["gyro"][2] > 0.1


def test_a_thruster_that_turns_takes_its_azimuth_from_a_second_channel() -> None:
    name = REVOLT.thrusters[0].name
    others = ",".join(
        f"{row.name}={5 + 2 * i}" + (f"/{6 + 2 * i}" if row.turns else "") for i, row in enumerate(REVOLT.thrusters[1:])
    )
    boat = physics(REVOLT, f"{name}=1/2,{others}")
    for count in range(400):
        boat.answer(packet(count, 1700, 1600))
    row, thruster = REVOLT.thrusters[0], boat.world.thrusters[0]
    most_rad = row.azimuth_rad + math.pi if row.azimuth_max_rad is None else row.azimuth_max_rad
    assert thruster.azimuth_rad == pytest.approx(row.azimuth_rad + 0.25 * (most_rad - row.azimuth_rad), abs=0.01)
    assert thruster.asked == pytest.approx(0.5) and thruster.force_n > 0.0


def test_the_same_pulses_without_the_interface_give_the_same_track() -> None:
    weather = {"wind": "4@30", "current": "0.2@90"}
    boat, alone = physics(OTTER, **weather), World(without_boards(OTTER), WorldConditions(**weather))
    for count in range(300):
        boat.answer(packet(count, 1650, 1550))
    jet = alone.thrusters
    for tick in range(300):
        for thruster, throttle in zip(jet, (0.375, 0.125), strict=True):
            thruster.demand(throttle, None)
        alone.advance((tick + 1) / RATE_HZ)
    assert boat.world.truth == alone.truth


def test_a_frame_sent_again_is_answered_again_without_a_step() -> None:
    boat = physics(BLUEBOAT)
    first = boat.answer(packet(0, 1900, 1900))
    assert boat.answer(packet(0, 1900, 1900)) == first and boat.world.t_s == pytest.approx(0.01)


def test_an_autopilot_that_starts_again_goes_on_with_the_boat() -> None:
    boat = physics(BLUEBOAT)
    for count in range(100):
        before = state(boat.answer(packet(count, 1900, 1900)))
    after = state(boat.answer(packet(0)))
    assert after["timestamp"] > before["timestamp"]
    assert after["position"][0] == pytest.approx(before["position"][0], abs=0.1)


@pytest.mark.parametrize("data", [b"", b"\x1a\x48", packet(1)[:-1], b"\0" * 40, packet(1) + b"\0", b"{}"])
def test_what_is_no_packet_is_not_answered(data: bytes) -> None:
    boat = physics(BLUEBOAT)
    assert boat.answer(data) is None and boat.world.t_s == 0.0


def test_a_packet_of_32_channels_is_read() -> None:
    read = read_packet(packet(7, *range(1000, 1032), channels=32))
    assert read is not None and read.count == 7 and read.pulses_us[31] == 1031


@pytest.mark.parametrize("rate_hz", [0, 65535])
def test_an_absurd_rate_neither_stops_nor_leaps(rate_hz: int) -> None:
    boat = physics(BLUEBOAT)
    boat.answer(packet(0, 1900, rate_hz=rate_hz))
    assert 0.0 <= boat.world.t_s <= 0.02


def test_outputs_default_to_the_order_of_the_file() -> None:
    assert parse_outputs("", BLUEBOAT) == {"port": ThrusterChannels(1), "starboard": ThrusterChannels(2)}
    assert next(iter(parse_outputs("", REVOLT).values())) == ThrusterChannels(1, 2)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("port=1", "'starboard' needs NAME=THROTTLE"),
        ("port=1,starbord=3", "did you mean 'starboard'"),
        ("port=0,starboard=3", "1 to 32"),
        ("port=1/2,starboard=3", "'port' needs NAME=THROTTLE"),
        ("port=one,starboard=3", "1 to 32"),
    ],
)
def test_outputs_that_do_not_fit_are_said(text: str, words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        parse_outputs(text, BLUEBOAT)
