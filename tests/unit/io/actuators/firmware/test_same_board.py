"""The emulated board and the firmware are two writings of one text: told the same, they do the same. And what no board
may ever do."""

from __future__ import annotations

import random
from dataclasses import replace

from companion.config.outputs import RelayConfig, ServoConfig
from companion.config.vessel import find
from companion.config.vessel import load as load_vessel
from companion.core.actuation import Light
from companion.core.microcontroller_auxiliary import AuxiliaryDemand, AuxiliaryState
from companion.core.microcontroller_frame import BoardCommand, BoardStatus, Message, ThrusterDemand, encode
from sitl.battery import BatteryModel
from sitl.emulators.microcontroller import MicrocontrollerEmulator
from sitl.faults import Faults
from sitl.memory import MemoryStream
from sitl.thrusters import build
from tests.unit.io.actuators.firmware.host import Board, DriveConfig

REVOLT = load_vessel(find("revolt"))
STEP_MS, TRAVEL_MS = 20, 800
LAG = 3  # steps by which one may be behind the other


def vessel_thrusters() -> tuple[object, ...]:
    strong = [replace(t, max_n=t.ahead_n, min_n=-t.astern_n) for t in REVOLT.thrusters]
    return build((*strong[:2], replace(strong[2], travel_s=TRAVEL_MS / 1000.0)), 0.0, None)


class Pair:
    """Both boards, with their mechanics, told the same at the same time."""

    def __init__(self) -> None:
        config = replace(REVOLT.actuators[0], servos=("winch",), relays=("pump", "lamp"))
        vessel = replace(REVOLT, servos=(ServoConfig("winch"),), relays=(RelayConfig("pump"), RelayConfig("lamp")))
        self.stream = MemoryStream("microcontroller")
        self.thrusters = vessel_thrusters()
        self.emulator = MicrocontrollerEmulator(
            config, self.stream.device, self.thrusters, BatteryModel(900.0), Faults((), vessel)
        )  # type: ignore[arg-type]
        pod = DriveConfig(trim_us=1500, ahead_us=2000, astern_us=1000, azimuth=2, azimuth_rate=26180)
        bow = DriveConfig(trim_us=1500, ahead_us=2000, astern_us=1000, travel_ms=TRAVEL_MS, end_switches=True)
        self.board = Board([pod, pod, bow], relays=2, servos=1)
        self._down_ms = TRAVEL_MS
        self.said = [message for message in self.board.said() if isinstance(message, BoardStatus)]
        self.outputs: list[AuxiliaryState] = []
        self.board.inputs.thruster[2].switch_down = True

    def step(self, *messages: Message | bytes) -> None:
        for message in messages:
            data = message if isinstance(message, bytes) else encode(message)
            self.stream.write(data, self.board.now_ms / 1000.0)
            self.board.hear(data)
        self.board.step(STEP_MS)
        t_s = self.board.now_ms / 1000.0
        self.emulator.listen(t_s)
        for thruster in self.thrusters:
            thruster.step(STEP_MS / 1000.0)  # type: ignore[attr-defined]
        out, inputs = self.board.outputs.thruster[2], self.board.inputs.thruster[2]
        self._down_ms = min(TRAVEL_MS, max(0, self._down_ms + STEP_MS * out.travel))
        inputs.switch_down, inputs.switch_up = self._down_ms == TRAVEL_MS, self._down_ms == 0
        for said in self.board.said():
            if isinstance(said, BoardStatus):
                self.said.append(said)
            elif isinstance(said, AuxiliaryState):
                self.outputs.append(said)

    def differences(self) -> set[str]:
        """What the two say differently of themselves."""
        status, other = self.emulator.status(), self.said[-1]
        found = {name for name in ("sequence", "neutral_by_watchdog") if getattr(status, name) != getattr(other, name)}
        for i, (one, two) in enumerate(zip(status.thrusters, other.thrusters, strict=True)):
            if abs(one.throttle - two.throttle) > 2e-4:
                found.add(f"throttle {i}")
            if one.deployment is not two.deployment:
                found.add(f"deployment {i}")
        lamps = self.emulator.beacon
        for colour in ("red", "yellow", "green"):
            light, lit = getattr(lamps, colour), getattr(self.board.outputs, colour)
            if light is not Light.BLINK and lit is not (light is Light.STEADY):
                found.add(colour)
        if self.outputs and (self.outputs[-1].servos_us, self.outputs[-1].relays) != (
            self.emulator.outputs.servos_us,
            self.emulator.outputs.relays,
        ):
            found.add("outputs")
        return found


def random_messages(rng: random.Random, sequence: int) -> list[Message | bytes]:
    messages: list[Message | bytes] = []
    count = 3 if rng.random() < 0.9 else rng.randrange(6)
    demands = tuple(
        [ThrusterDemand(rng.choice((0.0, rng.uniform(-1.0, 1.0))), rng.uniform(-3.14, 3.14)) for _ in range(count)]
    )
    lights = [rng.choice(list(Light)) for _ in range(3)]
    messages.append(
        BoardCommand(sequence, rng.random() < 0.8, demands, rng.choice((None, None, None, True, True, False)), *lights)
    )
    if rng.random() < 0.3:
        relays = tuple([rng.random() < 0.5 for _ in range(2 if rng.random() < 0.9 else 1)])
        messages.append(AuxiliaryDemand(sequence, (rng.choice((None, 1000.0, 2500.0)),), relays))
    if rng.random() < 0.2:
        messages.append(rng.randbytes(rng.randrange(40)))
    rng.shuffle(messages)
    return messages


def test_told_the_same_both_boards_do_the_same() -> None:
    rng, pair = random.Random(11), Pair()
    since: dict[str, int] = {}  # steps for which something has been said differently
    silent = rest = 0
    command: list[Message | bytes] = []
    for n in range(6000):
        if silent > 0:
            silent -= 1
            pair.step()
        elif rest > 0:
            rest -= 1
            pair.step(*(command if n % 5 == 0 else ()))
        else:
            command = random_messages(rng, n % 256)
            pair.step(*command)
            rest = rng.choice((0, 0, 5, 20, 60))
            silent = rng.choice((0, 0, 0, 0, 10, 40)) if rest == 0 else 0
        found = pair.differences() if pair.said else set()
        since = {name: since.get(name, 0) + 1 for name in found}
        assert all(steps <= LAG for steps in since.values()), f"after {pair.board.now_ms} ms: {since}"


def test_whatever_comes_no_output_leaves_its_bounds_and_no_propeller_turns_unbidden() -> None:
    rng, pair = random.Random(12), Pair()
    armed_ms = -10000
    for n in range(6000):
        messages = (
            random_messages(rng, n % 256)
            if rng.random() < 0.25
            else [rng.randbytes(rng.randrange(60))]
            if rng.random() < 0.3
            else []
        )
        for message in messages:
            if isinstance(message, BoardCommand) and len(message.thrusters) == 3:
                armed_ms = pair.board.now_ms if message.armed else -10000
        pair.step(*messages)
        pulses = pair.board.pulses
        assert all(1000 <= pulse_us <= 2000 for pulse_us in pulses)
        if pair.board.now_ms - armed_ms >= 500:
            assert pulses == [1500, 1500, 1500]
        if pair.board.outputs.thruster[2].travel != 0:
            assert pulses[2] == 1500
