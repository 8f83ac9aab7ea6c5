"""Thrusters on NMEA 2000: frames byte by byte as the standard lays them out, and what the bridge makes of a network
that is not quite as it should be."""

from __future__ import annotations

import builtins
import math
import random
import struct
from dataclasses import replace
from typing import Any

import pytest

from companion.config.actuators.nmea2000 import MotorConfig, Nmea2000Config
from companion.config.vessel import ConfigError, VesselConfig, find, load
from companion.core.actuation import ActuatorCommand, ThrusterCommand, ThrusterFeedback
from companion.core.can_frame import SIZE, TROUBLE, pack, unpack
from companion.core.readings import Battery, Reading
from companion.io.actuators import open_actuator
from companion.io.actuators.nmea2000 import Nmea2000Bridge
from companion.io.actuators.nmea2000_node import Node, header
from sitl.world import World
from tests.unit.io.rows import bridge_row

ABOAT = load(find("aboat"))
MOTORS = (MotorConfig("bow", 3), MotorConfig("stern", 7, sensor_instance=9))
BRIDGE = bridge_row(ABOAT.actuators[0], Nmea2000Config, "nmea2000", name="motors", port="can:can0", motors=MOTORS)
VESSEL: VesselConfig = replace(ABOAT, actuators=(BRIDGE,))
BOW, STERN = 0x16, 0x1A  # addresses of the motors


class Bus:
    """A bus whose other end is the test; `sent` as (identifier, data)."""

    name = "bus"

    def __init__(self) -> None:
        self.incoming: list[tuple[float, bytes]] = []
        self.sent: list[tuple[int, bytes]] = []
        self.trouble: str | None = None

    def write(self, data: bytes, now_s: float) -> None:
        frames, others = unpack(data)
        assert others == 0 and len(data) % SIZE == 0
        self.sent += frames

    def read(self, now_s: float) -> list[tuple[float, bytes]]:
        taken, self.incoming = self.incoming, []
        return taken

    def hear(self, identifier: int, text: str, t_s: float) -> None:
        self.incoming.append((t_s, pack(identifier, bytes.fromhex(text))))

    def fault(self) -> str | None:
        return self.trouble

    def fileno(self) -> int | None:
        return None

    def close(self) -> None: ...

    def of(self, pgn: int) -> list[tuple[int, bytes]]:
        return [frame for frame in self.sent if header(frame[0])[0] == pgn]


def identifier(pgn: int, priority: int, source: int, destination: int = 255) -> int:
    return priority << 26 | (pgn << 8 if pgn >> 8 & 0xFF >= 240 else (pgn | destination) << 8) | source


def command(throttle: float = 0.0, azimuth_rad: float | None = 0.0, armed: bool = True) -> ActuatorCommand:
    return ActuatorCommand(0.0, armed, (ThrusterCommand(0.0, throttle, azimuth_rad), ThrusterCommand(0.0, 0.0, 0.0)))


class Talk:
    """The bridge, ticked, with both motors on the bus unless they are taken off it."""

    def __init__(self, *, motors: str = "both") -> None:
        self.bus = Bus()
        driver = open_actuator(BRIDGE, VESSEL, self.bus)
        assert isinstance(driver, Nmea2000Bridge)
        self.bridge, self.now_s, self.motors = driver, 0.0, motors
        self.readings: list[Reading] = []

    def tick(self, demand: ActuatorCommand | None = None, count: int = 1) -> list[Reading]:
        self.readings = []
        for _ in range(count):
            self.now_s = round(self.now_s + 0.1, 6)
            if self.motors == "both":
                self.bus.hear(identifier(128006, 2, BOW), "ff03000000461027", self.now_s)
                self.bus.hear(identifier(128006, 2, STERN), "ff0700000046ffff", self.now_s)
            self.readings += self.bridge.read(self.now_s)
            self.bridge.write(demand or command(armed=False), self.now_s)
        return self.readings


def of_thruster(readings: list[Reading], index: int) -> ThrusterFeedback:
    return [reading for reading in readings if isinstance(reading, ThrusterFeedback) and reading.index == index][-1]


# --- frames
# ------------------------------------------------------------------------------------------------------------


def test_a_frame_is_the_kernels_and_what_is_none_is_counted() -> None:
    assert pack(0x1DF40616, b"\x01\x02\x03") == struct.pack("<IB3x8s", 0x9DF40616, 3, b"\x01\x02\x03")
    frame = pack(0x0EF, bytes(8))
    standard, remote = struct.pack("<IB3x8s", 0x123, 8, bytes(8)), struct.pack("<IB3x8s", 0xC0000123, 0, b"")
    assert unpack(frame + standard + remote + TROUBLE + frame + b"\x00" * 5) == (
        [(0xEF, bytes(8)), (0xEF, bytes(8))],
        4,
    )
    for wrong in ((1 << 29, b""), (1, bytes(9))):
        with pytest.raises(ValueError, match="not a CAN frame"):
            pack(*wrong)


def test_identifiers_are_taken_apart_as_iso_11783_does() -> None:
    assert header(0x19F51322) == (128275, 0x22, 255)  # a broadcast: the whole of the PGN
    assert header(0x18EA2301) == (59904, 0x01, 0x23)  # to one device
    assert header(0x09ED1632) == (126208, 0x32, 0x16)


def test_a_claim_goes_out_first_and_nothing_else_until_it_has_stood() -> None:
    talk = Talk()
    talk.tick(count=2)
    assert [frame[0] for frame in talk.bus.sent] == [0x18EEFF32] and len(talk.bus.sent[0][1]) == 8
    name = int.from_bytes(talk.bus.sent[0][1], "little")
    assert (name >> 21 & 0x7FF, name >> 40 & 0xFF, name >> 49 & 0x7F, name >> 60 & 7, name >> 63) == (
        2046,
        130,
        25,
        4,
        1,
    )
    talk.tick(count=3)
    beats = talk.bus.of(126993)
    assert [(frame[0], frame[1].hex()) for frame in beats] == [(0x1DF01132, "60ea01ccffffffff")]  # 60 000 ms
    talk.tick(count=600)
    assert len(talk.bus.of(126993)) == 2 and talk.bus.of(126993)[1][1][2] == 2, "once a minute, counted"


@pytest.mark.parametrize(
    ("demand", "fields"),
    [
        (command(0.57, math.radians(-90.0)), ("0203", "0303", "0401", "0639", "0864", "0914b8")),  # 4.7124 rad
        (command(-0.5, 1.0), ("0203", "0302", "0401", "0632", "0864", "091027")),
        (command(0.004, None), ("0203", "0301", "0401", "0600", "0864")),
        (command(0.9, 1.0, armed=False), ("0203", "0300", "0400", "0600", "0864")),
        (command(math.nan, math.nan), ("0203", "0301", "0401", "0600", "0864")),
        (command(7.0, 0.0), ("0203", "0303", "0401", "0664", "0864", "090000")),
    ],
)
def test_a_command_byte_by_byte(demand: ActuatorCommand, fields: tuple[str, ...]) -> None:
    talk = Talk()
    talk.tick(count=6)
    talk.bus.sent.clear()
    talk.tick(demand)
    frames = [data for where, data in talk.bus.sent if where == identifier(126208, 2, 0x32, BOW)]
    content = (
        bytes.fromhex("0106f401f8") + bytes([len(fields)]) + bytes.fromhex("".join(fields))
    )  # command, 128006, priority as it is
    whole = bytes([len(content)]) + content
    assert [data[1:] for data in frames] == [whole[at : at + 7].ljust(7, b"\xff") for at in range(0, len(whole), 7)]
    assert [data[0] & 31 for data in frames] == list(range(len(frames))) and len({data[0] >> 5 for data in frames}) == 1
    assert [where for where, _ in talk.bus.sent if where == identifier(126208, 2, 0x32, STERN)], "the other has its own"


def test_motors_that_nobody_has_heard_are_asked_for_and_told_nothing() -> None:
    talk = Talk(motors="none")
    talk.tick(command(0.5), count=25)
    assert [(frame[0], frame[1].hex()) for frame in talk.bus.of(59904)] == [(0x18EAFF32, "06f401")] * 3
    assert (
        talk.bus.of(126208) == []
        and "nothing received yet: check the network's power, its two terminators" in talk.bridge.health(2.5).text
    )


# --- what every device owes the others
# ---------------------------------------------------------------------------------


def answers(node: Node, pgn: int, source: int, destination: int, data: bytes) -> list[tuple[int, bytes]]:
    return unpack(node.heard(pgn, source, destination, data, 1.0))[0]


def settled() -> tuple[Node, int]:
    node = Node(50, "aboat/motors", "1.2.3")
    ((_, claim),), _ = unpack(node.start(0.0))
    node.tick(0.3)
    assert node.address == 50
    return node, int.from_bytes(claim, "little")


def test_an_address_is_kept_against_a_higher_name_and_left_to_a_lower_one() -> None:
    node, own = settled()
    assert (
        answers(node, 60928, 50, 255, (own + 1).to_bytes(8, "little"))[0][1] == own.to_bytes(8, "little")
        and node.address == 50
    )
    assert answers(node, 60928, 51, 255, (own - 7).to_bytes(8, "little")) == []
    (claim,) = answers(node, 60928, 50, 255, (own - 1).to_bytes(8, "little"))
    assert claim == (0x18EEFF34, own.to_bytes(8, "little")), "51 is taken: 52"
    assert node.address is None and node.wanted == 52
    node.tick(1.2)
    assert node.address is None, "not before it has stood for 250 ms"
    node.tick(1.3)
    assert node.address == 52
    assert answers(node, 60928, 52, 255, own.to_bytes(8, "little")) == [], "its own claim, come back from an adapter"


def test_requests_are_answered() -> None:
    node, own = settled()
    ask = {pgn: pgn.to_bytes(3, "little") for pgn in (60928, 126993, 126996, 129025)}
    assert answers(node, 59904, 9, 255, ask[60928]) == [(0x18EEFF32, own.to_bytes(8, "little"))]
    assert answers(node, 59904, 9, 50, ask[126993])[0][0] == 0x1DF01132
    product = answers(node, 59904, 9, 50, ask[126996])
    text = b"".join(data[1:] for _, data in product)[1:]
    assert (
        len(product) == 20
        and text[:4] == struct.pack("<HH", 2100, 1)
        and text[4:17] == b"USV companion"
        and text[36:41] == b"1.2.3"
    )
    assert answers(node, 59904, 9, 50, ask[129025]) == [(0x18E80932, bytes.fromhex("01ffffffff01f801"))], (
        "not available, to who asked"
    )
    assert answers(node, 59904, 9, 255, ask[129025]) == [] == answers(node, 59904, 9, 51, ask[60928])


# --- what it hears
# -----------------------------------------------------------------------------------------------------


def test_what_a_motor_says_is_its_feedback() -> None:
    talk = Talk(motors="none")
    talk.bus.hear(identifier(128006, 2, BOW), "ff03123200461027", 0.1)  # to port, 50 %, 1 rad
    report = of_thruster(talk.tick(), 0)
    assert report == ThrusterFeedback(0.1, "motors", 0, -0.5, pytest.approx(1.0), True)
    talk.bus.hear(identifier(128006, 2, BOW), "ff0313320046409c", 0.2)  # to starboard; 4 rad
    assert of_thruster(talk.tick(), 0) == ThrusterFeedback(0.2, "motors", 0, 0.5, pytest.approx(4.0 - math.tau), True)


def test_an_angle_sensor_counts_before_the_motors_own_word() -> None:
    talk = Talk()
    talk.tick()
    talk.bus.hear(identifier(127245, 2, 60), "09f8ff7ff0d8ffff", 0.15)  # sensor 9: −1 rad
    talk.bus.hear(identifier(127245, 2, 60), "07f8ff7f0000ffff", 0.15)  # 7 is the motor's number, not its sensor's
    assert of_thruster(talk.tick(), 1).azimuth_rad == pytest.approx(-1.0) and of_thruster(
        talk.readings, 0
    ).azimuth_rad == pytest.approx(1.0)
    talk.tick(count=8)
    assert of_thruster(talk.readings, 1).azimuth_rad is None, (
        "the sensor has gone, and the motor says nothing of its angle"
    )


def test_a_motor_that_has_cut_out_fails_and_says_why() -> None:
    talk = Talk()
    talk.tick(count=3)
    talk.bus.hear(identifier(128008, 2, STERN), "ff0712ffffffffff", 0.35)  # over-current and low voltage
    talk.bus.hear(identifier(128008, 2, BOW), "ff0304ffffffffff", 0.35)  # low oil is a warning
    talk.tick()
    assert not of_thruster(talk.readings, 1).ok and of_thruster(talk.readings, 0).ok
    health = talk.bridge.health(talk.now_s)
    assert health.ok and "motor stern: too much current, low voltage" in health.text
    talk.bus.hear(identifier(128008, 2, STERN), "ff0700ffffffffff", 0.45)
    assert of_thruster(talk.tick(), 1).ok


def test_a_motor_that_refuses_or_obeys_another_is_told() -> None:
    talk = Talk()
    talk.tick(count=3)
    for at, part in enumerate(("200a0206f4010306", "21000000ffffffff")):
        talk.bus.hear(identifier(126208, 3, BOW, 0x32), part, 0.35 + 0.001 * at)
    talk.tick()
    assert (
        not of_thruster(talk.readings, 0).ok
        and "motor bow: refuses commands (error 3)" in talk.bridge.health(talk.now_s).text
    )
    talk.tick(count=12)
    assert of_thruster(talk.readings, 0).ok
    talk.bus.hear(identifier(128006, 2, BOW), "ff03000001461027", talk.now_s)
    talk.motors = "none"
    talk.tick()
    assert "motor bow: another device on the network controls it" in talk.bridge.health(talk.now_s).text


def test_silence_of_one_is_a_thruster_of_all_a_bridge() -> None:
    talk = Talk()
    talk.tick(count=5)
    assert talk.bridge.health(talk.now_s).ok
    talk.motors, said = "none", []
    for _ in range(15):
        talk.bus.hear(identifier(128006, 2, BOW), "ff03000000461027", talk.now_s + 0.1)
        said += talk.tick()
    assert [report.ok for report in said if isinstance(report, ThrusterFeedback) and report.index == 1] == [False]
    assert "motor stern silent for" in talk.bridge.health(talk.now_s).text and talk.bridge.health(talk.now_s).ok
    talk.tick(count=12)
    health = talk.bridge.health(talk.now_s)
    assert not health.ok and "no motor heard for" in health.text and "motors stop by themselves" in health.text
    talk.motors = "both"
    talk.tick()
    assert talk.bridge.health(talk.now_s).ok and of_thruster(talk.readings, 1).ok


def test_a_network_without_the_vessels_motors_and_one_of_errors_are_told_apart() -> None:
    strangers, errors = Talk(motors="none"), Talk(motors="none")
    for _ in range(300):
        strangers.bus.hear(identifier(130306, 2, 8), "ff0000000000ffff", 0.0)
        errors.bus.incoming.append((0.0, TROUBLE))
    strangers.tick()
    errors.tick()
    assert "the network is alive but has none of the vessel's thrusters" in strangers.bridge.health(0.1).text
    assert "wrong bit rate (NMEA 2000 has 250000)" in errors.bridge.health(0.1).text
    errors.bus.trouble = "can:can0: no such CAN interface"
    assert errors.bridge.health(0.1).text.startswith("can:can0: no such CAN interface")


def test_the_battery_monitor_is_read() -> None:
    talk = Talk()
    talk.bus.hear(identifier(127506, 6, 61), "400bff000055ffff", 0.0)
    talk.bus.hear(identifier(127506, 6, 61), "41ffffffffffffff", 0.0)
    talk.bus.hear(identifier(127508, 6, 61), "00e4047dfeffffff", 0.0)  # 12.52 V, −38.7 A: out of it
    talk.bus.hear(identifier(127508, 6, 61), "01e4047dfeffffff", 0.0)  # another battery
    batteries = [reading for reading in talk.tick() if isinstance(reading, Battery)]
    assert batteries == [Battery(0.0, "motors", pytest.approx(12.52), pytest.approx(38.7), pytest.approx(0.85))]


def test_what_is_missing_is_refused_with_the_remedy(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ConfigError, match=r"actuator 'motors': needs an \[\[actuator.motor\]\] for 'stern'"):
        open_actuator(replace(BRIDGE, motors=MOTORS[:1]), VESSEL, Bus())
    real = builtins.__import__

    def without(name: str, *arguments: Any, **more: Any) -> Any:
        if name.partition(".")[0] == "nmea2000":
            raise ModuleNotFoundError("No module named 'nmea2000'", name="nmea2000")
        return real(name, *arguments, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    with pytest.raises(ConfigError, match=r"nmea2000 is not installed: pip install 'usv-companion\[can\]'"):
        open_actuator(BRIDGE, VESSEL, Bus())


# --- noise
# -------------------------------------------------------------------------------------------------------------


def test_ten_thousand_fuzzed_frames_each_way_move_nothing_and_stop_nothing() -> None:
    rng = random.Random(4)
    world = World(VESSEL)
    bridge, stream = open_actuator(BRIDGE, VESSEL, world.open("motors", "")), world.open("motors", "")
    pgns = (59904, 60928, 126208, 127245, 127506, 127508, 128008, 126996, 130306)
    now_s = 0.0
    for step in range(130):
        now_s = round(now_s + 0.1, 6)
        for _ in range(100):
            where = identifier(
                rng.choice(pgns),
                rng.randrange(8),
                rng.choice((rng.randrange(256), 23, 27)),
                rng.choice((255, 50, rng.randrange(256))),
            )
            data = rng.randbytes(rng.choice((8, 8, 8, 0, 3, 5)))
            world.babble("motors", pack(where, data) if rng.random() < 0.9 else rng.randbytes(rng.randrange(40)))
            if step > 20:
                stream.write(pack(where, data) if rng.random() < 0.9 else rng.randbytes(rng.randrange(40)), now_s)
        world.advance(now_s)
        bridge.read(now_s)
        bridge.write(command(0.0, 0.0), now_s)
    assert [thruster.throttle() for thruster in world.thrusters] == [0.0, 0.0]
    for _ in range(40):
        now_s = round(now_s + 0.1, 6)
        world.advance(now_s)
        readings = bridge.read(now_s)
        bridge.write(command(0.6, 0.5), now_s)
    health = bridge.health(now_s)
    assert health.ok, health.text
    assert world.thrusters[0].throttle() == pytest.approx(0.6, abs=0.01) and world.thrusters[
        0
    ].azimuth_rad == pytest.approx(0.5, abs=0.001)
    assert of_thruster(list(readings), 0).throttle == pytest.approx(0.6, abs=0.01)
