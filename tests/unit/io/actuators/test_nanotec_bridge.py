"""Stepper drives on one line: what is said and when, by hand, and what comes of it on drives that behave and on drives
that do not."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import pytest

from companion.config.actuators.nanotec import NanotecConfig, StepperConfig
from companion.config.bridges import OutputConfig
from companion.config.vessel import ConfigError, VesselConfig, find, load
from companion.core.actuation import ActuatorCommand, ThrusterCommand, ThrusterFeedback
from companion.io.actuators import open_actuator
from companion.io.actuators.nanotec import NanotecBridge
from sitl.emulators.nanotec import NanotecEmulator
from sitl.world import World, WorldConditions
from tests.unit.io.rows import bridge_row

REVOLT = load(find("revolt"))
PODS = ("stern_port", "stern_starboard")
SETUP = ["|1", "J0", "g8", "p2", "W1", "u100", "o2000", ":ramp_mode=0", ":accel=20000", ":decel=20000", "C"]


def vessel(
    *drives: StepperConfig, stops_deg: float | None = None, outputs: tuple[OutputConfig | None, ...] = (None, None)
) -> VesselConfig:
    stops = None if stops_deg is None else math.radians(stops_deg)
    low = None if stops is None else -stops
    pods = [
        replace(pod, azimuth_min_rad=low, azimuth_max_rad=stops, output=output)
        for pod, output in zip(REVOLT.thrusters[:2], outputs, strict=True)
    ]
    bridge = bridge_row(
        REVOLT.actuators[0],
        NanotecConfig,
        "nanotec",
        name="azimuths",
        thrusters=(),
        azimuths=tuple(d.thruster for d in drives),
        drives=drives,
    )
    return replace(REVOLT, thrusters=(*pods, REVOLT.thrusters[2]), actuators=(bridge, REVOLT.actuators[0]))


DRIVES = tuple(StepperConfig(name, 1 + i, 4800.0, ramp_radps2=math.radians(1500.0)) for i, name in enumerate(PODS))
PLAIN = vessel(*DRIVES)


class Wire:
    """A half-duplex line whose other end is the test: it fails at once where a second request goes out before the first
    is answered."""

    name = "wire"

    def __init__(self) -> None:
        self.asked: list[str] = []
        self.incoming: list[tuple[float, bytes]] = []
        self.trouble: str | None = None
        self.closed = False
        self.open_requests = 0

    def write(self, data: bytes, now_s: float) -> None:
        assert data.startswith(b"#") and data.endswith(b"\r") and data.count(b"\r") == 1
        self.asked.append(data[1:-1].decode())
        self.open_requests += 1

    def read(self, now_s: float) -> list[tuple[float, bytes]]:
        taken, self.incoming = self.incoming, []
        return taken

    def answer(self, data: bytes, t_s: float) -> None:
        self.incoming.append((t_s, data))

    def fault(self) -> str | None:
        return self.trouble

    def fileno(self) -> int | None:
        return 5

    def close(self) -> None:
        self.closed = True


def command(azimuth_rad: float = 0.0, armed: bool = True, t_s: float = 0.0) -> ActuatorCommand:
    return ActuatorCommand(
        t_s,
        armed,
        (
            ThrusterCommand(0.0, 0.0, azimuth_rad),
            ThrusterCommand(0.0, 0.0, azimuth_rad),
            ThrusterCommand(0.0, 0.0, None),
        ),
    )


def opened(config: VesselConfig = PLAIN) -> tuple[NanotecBridge, Wire]:
    wire = Wire()
    bridge = open_actuator(config.actuators[0], config, wire)
    assert isinstance(bridge, NanotecBridge)
    return bridge, wire


class Talk:
    """Answers one request after the other, as a drive in order does: values from `says`, everything else as it came."""

    def __init__(self, bridge: NanotecBridge, wire: Wire, **says: str) -> None:
        self.bridge, self.wire, self.says = bridge, wire, {"$": "$161", "C": "C+0", **says}
        self.once: dict[str, str] = {}
        self.now_s, self.heard = 0.0, 0
        self.readings: list[ThrusterFeedback] = []

    def step(
        self, azimuth_rad: float = 0.0, armed: bool = True, rounds: int = 40, silent: frozenset[str] = frozenset()
    ) -> None:
        """A control step of 0.1 s; after it, what has come is read as it comes."""
        self.now_s = round(self.now_s + 0.1, 6)
        self.bridge.write(command(azimuth_rad, armed, self.now_s), self.now_s)
        for _ in range(rounds):
            if self.heard == len(self.wire.asked):
                break
            asked = self.wire.asked[self.heard]
            assert len(self.wire.asked) == self.heard + 1, "one at a time"
            self.heard += 1
            if asked[0] not in silent:
                if asked[1] == "s":
                    self.says["Zs"] = f"Zs{int(asked[2:]):+d}"
                said = self.once.pop(asked[1:], None) or self.says.get(asked[1:], asked[1:])
                self.wire.answer(f"{asked[0]}{said}\r".encode(), self.now_s)
            self.readings += [r for r in self.bridge.read(self.now_s) if isinstance(r, ThrusterFeedback)]


def test_each_drive_is_set_up_in_its_turn_and_nothing_is_said_before_the_answer() -> None:
    bridge, wire = opened()
    bridge.write(command(0.5, True), 0.0)
    assert wire.asked == ["1$"]
    for _ in range(5):
        bridge.write(command(0.5, True), 0.05)
        bridge.read(0.05)
    assert wire.asked == ["1$"], "not before the answer, nor the time that it may take"
    wire.answer(b"001$161\r", 0.06)
    bridge.read(0.06)
    assert wire.asked == ["1$", "2$"]
    wire.answer(b"002$161\r", 0.07)
    bridge.read(0.07)
    talk = Talk(bridge, wire)
    talk.heard = 2
    talk.step(0.5, rounds=60)
    of_first = [asked[1:] for asked in wire.asked if asked[0] == "1"]
    assert of_first[:12] == ["$", *SETUP] and of_first[12:14] == ["s382", "A"]  # 0.5 rad of 4800 steps a turn
    assert {asked[0] for asked in wire.asked[2:6]} == {"1", "2"}, "in turns"
    assert bridge.health(talk.now_s).ok


def test_the_bytes_on_the_line() -> None:
    bridge, wire = opened()
    sent: list[bytes] = []
    wire.write = lambda data, now_s: sent.append(data)  # type: ignore[method-assign]
    bridge.write(command(), 0.0)
    wire.answer(b"001$161\r", 0.0)
    bridge.read(0.0)
    assert sent == [b"#1$\r", b"#2$\r"]


def test_an_answer_may_come_in_pieces_behind_an_echo_and_noise() -> None:
    bridge, wire = opened()
    bridge.write(command(), 0.0)
    for piece in (b"#1$\r", b"\xff\x00x\r", b"2$161\r", b"1C+5\r", b"00", b"1$1", b"61"):
        wire.answer(piece, 0.01)
        bridge.read(0.01)
        assert wire.asked == ["1$"]
    wire.answer(b"\r", 0.01)
    bridge.read(0.01)
    assert wire.asked == ["1$", "2$"] and "3 bad" in bridge.health(0.01).text


def test_a_garbled_echo_is_no_confirmation() -> None:
    bridge, wire = opened()
    talk = Talk(bridge, wire)
    talk.step(0.0)
    talk.says["s382"] = "s3820"
    talk.step(0.5)
    assert wire.asked.count("1s382") == 1 and wire.asked.count("1A") == 1, (
        "it is not started towards what nobody has asked for"
    )
    del talk.says["s382"]
    talk.step(0.5)
    talk.step(0.5)
    assert wire.asked.count("1s382") == 2 and wire.asked.count("1A") == 2


def test_a_position_with_a_wrong_digit_is_not_believed_until_it_comes_twice() -> None:
    bridge, wire = opened()
    talk = Talk(bridge, wire)
    talk.step(0.0)
    talk.readings.clear()
    talk.says["C"] = "C+10"
    talk.once["C"] = "C+40010"
    talk.step(0.0)
    assert len(talk.readings) == 2 and all(
        reading.azimuth_rad == pytest.approx(10 / 4800 * math.tau) for reading in talk.readings
    )
    assert wire.asked.count("1C") + wire.asked.count("2C") == 5, "it is asked once more"
    talk.says["C"] = "C+40010"
    for _ in range(3):
        talk.step(0.0)
    assert "it lost its angle with its power" in bridge.health(talk.now_s).text, "what comes twice is true"


def test_a_drive_that_does_not_answer_is_lost_alone_and_found_again() -> None:
    bridge, wire = opened()
    talk = Talk(bridge, wire)
    talk.step(0.1)
    for _ in range(10):
        talk.step(0.1, silent=frozenset("2"))
    lost = [reading for reading in talk.readings if not reading.ok]
    assert {reading.index for reading in lost} == {1} and len(lost) >= 1 and lost[0].azimuth_rad is None
    health = bridge.health(talk.now_s)
    assert health.ok and "drive 2 of stern_starboard does not answer" in health.text
    asked = len([text for text in wire.asked if text[0] == "2"])
    for _ in range(10):
        talk.step(0.1, silent=frozenset("2"))
    assert len([text for text in wire.asked if text[0] == "2"]) - asked == 1, (
        "it is tried once a second: the other has the line"
    )
    talk.readings.clear()
    for _ in range(12):
        talk.step(0.1)
    assert [reading.ok for reading in talk.readings if reading.index == 1][-1]
    assert wire.asked.count("2p2") == 2, "it is set up anew"


def test_no_drive_at_all_is_a_bridge_that_is_not_well() -> None:
    bridge, wire = opened()
    assert "no drive has answered yet" in bridge.health(0.0).text
    talk = Talk(bridge, wire)
    talk.step()
    for _ in range(20):
        talk.step(silent=frozenset("12"))
    health = bridge.health(talk.now_s)
    assert not health.ok and "no drive has answered for 2.0 s" in health.text and "they hold their angle" in health.text
    for _ in range(20):
        wire.answer(b"\x80\x81\x82\x83\x84\x85\x86", talk.now_s)
        bridge.read(talk.now_s)
    assert "wrong baud rate" in bridge.health(talk.now_s).text
    wire.trouble = "serial:/dev/usv-azimuths: no such device"
    assert bridge.health(talk.now_s).text.startswith("serial:/dev/usv-azimuths: no such device")


def test_disarmed_it_is_stopped_and_told_no_target() -> None:
    bridge, wire = opened()
    talk = Talk(bridge, wire)
    talk.step(1.0)
    wire.asked.clear()
    talk.heard = 0
    for _ in range(5):
        talk.step(2.0, armed=False)
    assert wire.asked.count("1S1") == wire.asked.count("2S1") == 1
    assert not any(text[1] in "sA" for text in wire.asked)
    talk.step(1.0)
    assert "1A" in wire.asked, "and turns on once it is armed again"
    wire.asked.clear()
    bridge.close()
    assert wire.closed and wire.asked == ["*S1"]


def test_a_drive_that_refuses_what_it_needs_is_not_used() -> None:
    bridge, wire = opened()
    talk = Talk(bridge, wire, g8="g8?", **{":ramp_mode=0": ":ramp_mode=0?"})
    for _ in range(3):
        talk.step(0.5)
    assert not any(text[1] in "sA" for text in wire.asked)
    assert "refuses 'g8'" in bridge.health(talk.now_s).text and not bridge.health(talk.now_s).ok


@pytest.mark.parametrize(
    ("change", "text"),
    [
        ({"thrusters": ("bow",)}, "drives azimuths only: name 'bow' in 'azimuths'"),
        ({"drives": DRIVES[:1]}, r"needs an \[\[actuator.drive\]\] for 'stern_starboard'"),
        (
            {"drives": (DRIVES[0], replace(DRIVES[1], speed_radps=3000.0))},
            "speed_dps makes 2291831 steps a second, the drive takes 1 to 1000000",
        ),
    ],
)
def test_what_cannot_be_is_refused_with_the_remedy(change: dict[str, object], text: str) -> None:
    config = replace(PLAIN.actuators[0], **change)  # type: ignore[arg-type]
    with pytest.raises(ConfigError, match=text):
        open_actuator(config, PLAIN, Wire())


# --- on drives
# ---------------------------------------------------------------------------------------------------------


class Bench:
    """Drives in a world, and their bridge."""

    def __init__(self, config: VesselConfig = PLAIN, *faults: str) -> None:
        self.world = World(config, WorldConditions(faults=faults))
        self.bridge = open_actuator(config.actuators[0], config, self.world.open("azimuths", ""))
        (self.emulator,) = [board for board in self.world.boards if isinstance(board, NanotecEmulator)]
        self.now_s = 0.0
        self.newest: dict[int, ThrusterFeedback] = {}

    def run(self, seconds: float, azimuth_rad: float = 0.0, armed: bool = True, turn_radps: float = 0.0) -> float:
        for _ in range(round(seconds * 10)):
            self.now_s = round(self.now_s + 0.1, 6)
            self.world.advance(self.now_s)
            self.newest |= {r.index: r for r in self.bridge.read(self.now_s) if isinstance(r, ThrusterFeedback)}
            azimuth_rad += 0.1 * turn_radps
            self.bridge.write(command(azimuth_rad, armed), self.now_s)
        return azimuth_rad

    @property
    def text(self) -> str:
        return self.bridge.health(self.now_s).text


def off_rad(a: float, b: float) -> float:
    return abs(math.remainder(a - b, math.tau))


@pytest.mark.parametrize("reversed_", [False, True])
def test_endless_turning_counts_the_turns_and_knows_the_angle(reversed_: bool) -> None:
    bench = Bench(vessel(*DRIVES, outputs=(OutputConfig(azimuth_reversed=reversed_, azimuth_trim_rad=0.3), None)))
    demanded = bench.run(60.0, turn_radps=1.5)
    demanded = bench.run(3.0, demanded)
    first, second = (bench.emulator.drives[i].counter / 4800.0 for i in (1, 2))
    assert abs(first) > 14.0 and second > 14.0 and math.copysign(1.0, first) == (-1.0 if reversed_ else 1.0)
    for i in (0, 1):
        assert off_rad(bench.newest[i].azimuth_rad or 0.0, demanded) < math.radians(0.4)
        assert off_rad(bench.world.thrusters[i].azimuth_rad, demanded) < math.radians(0.4)
    bench.run(5.0, 0.0)
    assert abs(bench.emulator.drives[2].counter / 4800.0 - second) < 0.51, "back by the shorter way"


def test_long_before_the_counter_ends_whole_turns_are_taken_off_it() -> None:
    bench = Bench()
    drive = bench.emulator.drives[1]
    drive.obey("D50400000")  # it has turned 10500 times since it had its power
    bench.run(3.0, 0.7)
    assert abs(drive.counter) < 4800.0 and off_rad(bench.world.thrusters[0].azimuth_rad, 0.7) < math.radians(0.3)
    bench.run(3.0, -0.4)
    assert bench.newest[0].azimuth_rad == pytest.approx(-0.4, abs=0.006) == bench.world.thrusters[0].azimuth_rad


def test_between_stops_it_goes_the_way_that_there_is() -> None:
    bench = Bench(vessel(*DRIVES, stops_deg=170.0))
    bench.run(3.0, math.radians(160.0))
    bench.run(0.5, math.radians(-160.0))
    assert 0.0 < bench.world.thrusters[0].azimuth_rad < math.radians(159.0), "not across the back"
    bench.run(3.0, math.radians(-160.0))
    assert bench.newest[0].azimuth_rad == pytest.approx(math.radians(-160.0), abs=0.005)
    bench.run(3.0, math.radians(179.0))
    assert abs(bench.world.thrusters[0].azimuth_rad) <= math.radians(170.1)


def test_speed_and_ramp_are_those_of_the_file() -> None:
    slow = replace(DRIVES[1], speed_radps=math.radians(30.0), ramp_radps2=math.radians(60.0))
    bench = Bench(vessel(DRIVES[0], slow))
    bench.run(0.2)
    bench.run(1.0, math.radians(120.0))
    fast, slowly = (math.degrees(bench.world.thrusters[i].azimuth_rad) for i in (0, 1))
    assert fast == pytest.approx(120.0, abs=1.0) and slowly == pytest.approx(30.0 * (0.9 - 0.25), abs=3.0)
    settings = bench.emulator.drives[2].settings
    assert (settings["o"], settings[":accel"], settings[":decel"], settings["g"], settings["p"]) == (
        400,
        800,
        800,
        8,
        2,
    )


def test_homing_turns_once_to_the_switch_and_not_again_while_the_drive_knows_its_angle() -> None:
    config = vessel(
        DRIVES[0],
        replace(DRIVES[1], homing="switch"),
        outputs=(None, OutputConfig(azimuth_trim_rad=math.radians(40.0))),
    )
    bench = Bench(config)
    bench.run(1.0, armed=False)
    assert (
        not bench.bridge.health(bench.now_s).ok
        and "drive 2 of stern_starboard turns to its reference switch" in bench.text
    )
    bench.run(17.0, armed=False)
    assert bench.bridge.health(bench.now_s).ok, bench.text
    assert off_rad(bench.world.thrusters[1].azimuth_rad, math.radians(-40.0)) < 0.01, (
        "the switch stands where its drive shows 0"
    )
    bench.run(3.0, 0.5)
    assert off_rad(bench.world.thrusters[1].azimuth_rad, 0.5) < 0.005
    again = open_actuator(config.actuators[0], config, bench.world.open("azimuths", ""))
    bench.bridge = again
    bench.run(0.5, armed=False)
    assert again.health(bench.now_s).ok, "another start: the drive has had power all along"


def test_a_switch_that_never_comes_is_told() -> None:
    bench = Bench(vessel(DRIVES[0], replace(DRIVES[1], homing="switch")), "thruster_stern_starboard_stuck@0")
    bench.world.thrusters[1].azimuth_rad = 1.0
    bench.run(40.0, armed=False)
    assert (
        "stern_starboard" in bench.text and "does not follow" in bench.text and not bench.bridge.health(bench.now_s).ok
    )


def test_a_blocked_azimuth_is_told_with_the_drives_own_word_and_tried_again() -> None:
    bench = Bench(PLAIN, "thruster_stern_port_stuck@2+6")
    bench.run(1.9)
    bench.run(2.0, 1.0)
    assert not bench.newest[0].ok and bench.newest[1].ok
    assert (
        "drive 1 of stern_port: does not follow: blocked, or its encoder" in bench.text
        and bench.bridge.health(bench.now_s).ok
    )
    bench.run(8.0, 1.0)
    assert bench.newest[0].ok and bench.newest[0].azimuth_rad == pytest.approx(1.0, abs=0.005)


def test_power_lost_for_a_moment_leaves_a_homed_drive_searching_and_another_one_alone() -> None:
    bench = Bench(vessel(DRIVES[0], replace(DRIVES[1], homing="switch")))
    bench.run(2.0)
    bench.run(3.0, 1.0)
    for drive in bench.emulator.drives.values():
        drive.power_up()
    bench.run(3.0, 1.0)
    assert not bench.newest[0].ok and not bench.newest[1].ok
    assert (
        "drive 1 of stern_port cannot be used: it lost its angle with its power: put the thruster straight"
        in bench.text
    )
    assert "drive 2 of stern_starboard turns to its reference switch" in bench.text
    bench.run(25.0, 1.0)
    assert bench.newest[1].ok and off_rad(bench.world.thrusters[1].azimuth_rad, 1.0) < 0.005 and not bench.newest[0].ok


def test_ten_thousand_garbled_lines_each_way_move_nothing_and_stop_nothing() -> None:
    rng = random.Random(6)
    bench = Bench()
    bench.run(1.0, 0.3)
    alphabet = b"#*0123456789sACSDEZ$IpgoJWv|:+-=? \r\r\xff\x00"
    for _ in range(100):
        bench.world.babble(
            "azimuths", b"".join(bytes(rng.choices(alphabet, k=rng.randrange(1, 14))) + b"\r" for _ in range(100))
        )
        bench.run(0.1, 0.3)
    assert (
        off_rad(bench.world.thrusters[0].azimuth_rad, 0.3) < 0.005
        and off_rad(bench.world.thrusters[1].azimuth_rad, 0.3) < 0.005
    )
    bench.run(4.0, 0.3)
    assert all(reading.ok for reading in bench.newest.values()) and bench.bridge.health(bench.now_s).ok, bench.text
    stream = bench.world.open("azimuths", "")
    for _ in range(10_000):
        line = bytes(rng.choices(alphabet, k=rng.randrange(1, 14)))
        if not any(
            line[i : i + 1] == b"#" and line[i + 1 : i + 2] in b"12*" for i in range(len(line))
        ):  # noise that is no command of ours
            stream.write(line + b"\r", bench.now_s)
    bench.run(3.0, 0.3)
    assert off_rad(bench.world.thrusters[0].azimuth_rad, 0.3) < 0.005 and bench.bridge.health(bench.now_s).ok, (
        bench.text
    )
