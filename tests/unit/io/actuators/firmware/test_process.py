"""The firmware as a process of its own on a pty: the Python driver talks to it over a serial port, as on the boat."""

from __future__ import annotations

import os
import random
import select
import signal
import subprocess
import sys
import tty
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from companion.config.outputs import RelayConfig, ServoConfig
from companion.config.vessel import VesselConfig, find
from companion.config.vessel import load as load_vessel
from companion.core.actuation import (
    ActuatorCommand,
    Auxiliary,
    Beacon,
    Deployment,
    Light,
    ThrusterCommand,
    ThrusterFeedback,
)
from companion.core.microcontroller_frame import BoardCommand, ThrusterDemand, encode
from companion.core.readings import Battery, Leak, RcInput, Reading
from companion.core.tick import DeviceHealth
from companion.io.actuators import open_actuator
from companion.io.transport.opener import TransportOpener
from tests.unit.io.actuators.firmware.host import ENVIRONMENT
from tests.waiting import CAP_S, wait_until

REVOLT = load_vessel(find("revolt"))
VESSEL: VesselConfig = replace(
    REVOLT, servos=(ServoConfig("winch"),), relays=(RelayConfig("lamp"), RelayConfig("pump"))
)
BRIDGE = replace(REVOLT.actuators[0], servos=("winch",), relays=("lamp", "pump"))
NEUTRAL, HALF = (
    [1500, 1500, 1520],
    [1700, 1700, 1290],
)  # the bow's ESC is reversed, with a dead band of 20 µs about 1520
FORWARD = tuple([ThrusterCommand(1.0, 0.5, azimuth_rad) for azimuth_rad in (0.3, -0.3, None)])

# A companion reduced to its bridge: armed commands at 10 Hz for ever.
WRITER = """
import sys, time
from companion.config.vessel import find, load
from companion.core.actuation import ActuatorCommand, ThrusterCommand
from companion.io.actuators import open_actuator
from companion.io.transport.opener import TransportOpener
vessel = load(find("revolt"))
bridge = open_actuator(vessel.actuators[0], vessel, TransportOpener().open("microcontroller", sys.argv[1]))
thrusters = (ThrusterCommand(1.0, 0.5, 0.3), ThrusterCommand(1.0, 0.5, -0.3), ThrusterCommand(1.0, 0.5, None))
while True:
    now_s = time.monotonic()
    bridge.read(now_s)
    bridge.write(ActuatorCommand(now_s, True, thrusters), now_s)
    time.sleep(0.1)
"""


@dataclass
class Line:
    """One line of the board's own account."""

    ms: int
    kind: str
    values: list[int]


class Firmware:
    """The process, and what it tells."""

    def __init__(self, program: Path) -> None:
        self.line, slave = os.openpty()
        tty.setraw(slave)
        self.url = f"serial:{os.ttyname(slave)}:115200"
        self._slave = slave  # held, so that the line stays when the other end closes
        pipe = subprocess.PIPE
        self.process = subprocess.Popen(
            [str(program), str(self.line)], stdin=pipe, stdout=pipe, pass_fds=(self.line,), env=ENVIRONMENT
        )
        assert self.process.stdout is not None
        self._output = self.process.stdout.fileno()
        os.set_blocking(self._output, False)
        self._rest = b""
        self.lines: list[Line] = []

    def measure(self, text: str) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(f"{text}\n".encode())
        self.process.stdin.flush()

    def gather(self) -> None:
        """Take in what it has told."""
        if select.select([self._output], [], [], 0.0)[0]:
            *whole, self._rest = (self._rest + os.read(self._output, 65536)).split(b"\n")
            for text in whole:
                ms, kind, *values = text.decode().replace("|", "").split()
                self.lines.append(Line(int(ms), kind, [int(value) for value in values]))

    def wait_for(self, condition: Callable[[], bool], what: str) -> None:
        def come() -> bool:
            self.gather()
            return condition()

        wait_until(come, f"the board: {what}")

    def outs(self) -> list[Line]:
        return [line for line in self.lines if line.kind == "out"]

    def pulses(self) -> list[int]:
        outs = self.outs()
        return outs[-1].values[:3] if outs else NEUTRAL

    def last_silence(self) -> tuple[int, int] | None:
        """Of the last time that it went from half throttle to neutral, by its own clock: ms from the last command that
        it had heard until it looked for the last time before, and until it was neutral. None while it is not."""
        if self.pulses() != NEUTRAL or not self.outs():
            return None
        at = self.lines.index(self.outs()[-1])
        heard_ms = max(line.ms for line in self.lines[:at] if line.kind == "heard")
        return self.lines[at].values[-1] - heard_ms, self.lines[at].ms - heard_ms

    def close(self) -> None:
        self.process.kill()
        self.process.wait(CAP_S)
        for stream in (self.process.stdin, self.process.stdout):
            assert stream is not None
            stream.close()
        os.close(self.line)
        os.close(self._slave)


@pytest.fixture
def firmware(host_board: Path) -> Iterator[Firmware]:
    board = Firmware(host_board)
    yield board
    board.close()


class Driven:
    """The bridge on the board's port, written to and read from until something holds; its time is a count of turns."""

    def __init__(self, firmware: Firmware) -> None:
        self.firmware = firmware
        self.bridge = open_actuator(BRIDGE, VESSEL, TransportOpener().open("microcontroller", firmware.url))
        self.readings: list[Reading] = []
        self.now_s = 0.0

    @property
    def health(self) -> DeviceHealth:
        return self.bridge.health(self.now_s)

    def until(self, condition: Callable[[], bool], command: ActuatorCommand, what: str) -> None:
        def come() -> bool:
            self.firmware.gather()
            if condition():
                return True
            self.now_s += 0.01
            self.readings += self.bridge.read(self.now_s)
            self.bridge.write(replace(command, t_s=self.now_s), self.now_s)
            return False

        self.readings.clear()
        wait_until(come, what)

    def said(self, reading: object) -> Callable[[], bool]:
        """Whether such a reading has come; its time does not count."""
        return lambda: any(type(each) is type(reading) and replace(each, t_s=0.0) == reading for each in self.readings)  # type: ignore[type-var]


ARMED = ActuatorCommand(0.0, True, FORWARD)


def test_the_board_answers_the_driver_in_everything_that_the_frame_says(firmware: Firmware) -> None:
    driven, name = Driven(firmware), BRIDGE.name
    until, said = driven.until, driven.said
    until(lambda: firmware.pulses() == HALF, ARMED, "half throttle")
    until(lambda: firmware.outs()[-1].values[3:6] == [3000, -3000, 15708], ARMED, "azimuths")
    until(said(ThrusterFeedback(0.0, name, 1, 0.5, -0.3)), ARMED, "feedback")
    until(said(ThrusterFeedback(0.0, name, 2, 0.5, None, True, Deployment.LOWERED)), ARMED, "deployment")
    until(lambda: "host board firmware 1.1.0" in driven.health.text, ARMED, "identity")
    until(said(Leak(0.0, name, False)), ARMED, "no leak")
    firmware.measure("leak 1")
    until(said(Leak(0.0, name, True)), ARMED, "a leak")
    firmware.measure("battery 12345 2500 127")
    until(said(Battery(0.0, name, 12.345, 2.5, 0.5)), ARMED, "battery")
    firmware.measure("rc 1000 1500 2000 1750 0 0 0 0")
    until(said(RcInput(0.0, name, (-1.0, 0.0, 1.0, 0.5), False)), ARMED, "transmitter")
    until(said(RcInput(0.0, name, (), True)), ARMED, "transmitter lost")
    outputs = replace(ARMED, auxiliary=Auxiliary((1250.0,), (True, False)))
    until(lambda: driven.health.ok, outputs, "servos and relays answered for")
    lamps = replace(ARMED, beacon=Beacon(Light.STEADY, Light.OFF, Light.STEADY))
    until(lambda: [line.values for line in firmware.lines if line.kind == "lamps"][-1:] == [[1, 0, 1]], lamps, "lamps")
    firmware.measure("switch none")
    until(
        said(ThrusterFeedback(0.0, name, 2, 0.0, None, True, Deployment.MOVING)),
        replace(ARMED, lower=False),
        "on its way up",
    )
    firmware.measure("switch up")
    until(
        said(ThrusterFeedback(0.0, name, 2, 0.0, None, True, Deployment.RETRACTED)), replace(ARMED, lower=False), "up"
    )
    assert firmware.pulses() == [*HALF[:2], NEUTRAL[2]]
    until(lambda: firmware.pulses() == NEUTRAL, replace(ARMED, armed=False), "neutral")
    driven.bridge.close()


@pytest.mark.parametrize("how", ["killed", "closed"])
def test_half_a_second_after_the_companion_is_gone_the_board_is_neutral(how: str, firmware: Firmware) -> None:
    """By the board's own clock, from the last command it heard."""
    if how == "killed":
        with subprocess.Popen([sys.executable, "-c", WRITER, firmware.url]) as writer:
            firmware.wait_for(lambda: firmware.pulses() == HALF, "half throttle")
            writer.send_signal(signal.SIGKILL)
    else:
        driven = Driven(firmware)
        driven.until(lambda: firmware.pulses() == HALF, ARMED, "half throttle")
        driven.bridge.close()  # without a last command: as if the process had ended there
    firmware.wait_for(lambda: firmware.last_silence() is not None, "neutral")
    silence_ms = firmware.last_silence()
    assert silence_ms is not None
    looked_ms, neutral_ms = silence_ms
    print(f"neutral {neutral_ms} ms after the last command; looked {looked_ms} ms after it before")
    assert (
        looked_ms < 500 <= neutral_ms
    )  # in its first turn after half a second, however long this machine makes a turn


def test_a_flood_of_garbage_never_moves_an_output(firmware: Firmware) -> None:
    rng = random.Random(3)
    armed = encode(BoardCommand(1, True, (ThrusterDemand(1.0, 1.0),) * 3))
    for _ in range(300):
        kind = rng.randrange(4)
        if kind == 0:
            data = rng.randbytes(400)
        elif kind == 1:
            data = armed[: rng.randrange(3, len(armed) - 3)] + b"\0" + armed[rng.randrange(3, len(armed) - 3) :]
        elif kind == 2:
            data = b"$GPGGA,120000.00,6326.334,N,01023.940,E,4,12,0.8,10.0,M,40.0,M,,*5A\r\n" * 4
        else:
            at = rng.randrange(2, len(armed) - 2)
            data = armed[:at] + bytes((armed[at] ^ 1 << rng.randrange(8),)) + armed[at + 1 :]
        _ = os.write(firmware._slave, data + b"\0")
        firmware.gather()
    _ = os.write(firmware._slave, encode(BoardCommand(77, False, (ThrusterDemand(0.0),) * 3)))
    firmware.wait_for(lambda: any(line.kind == "heard" for line in firmware.lines), "the frame after the flood")
    assert [line.values for line in firmware.lines if line.kind == "heard"] == [[77]] and firmware.outs() == []
