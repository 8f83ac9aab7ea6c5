"""Every bridge with its emulated board, calibrated askew: what any row of the table owes the vessel."""

from __future__ import annotations

import contextlib
import math
import os
import random
import select
import tty
from dataclasses import replace

import pytest

from companion.config import MavlinkBoardConfig, OutputConfig, VesselConfig, find, load
from companion.core.ports import Actuator
from companion.core.types import ActuatorCommand, Battery, Leak, RcInput, Reading, ThrusterCommand, ThrusterFeedback
from companion.io.actuators import DRIVERS, open_actuator
from companion.io.transport import TransportOpener
from sitl.battery import BatteryModel
from sitl.emulators import BOARDS, board
from sitl.faults import Faults
from sitl.thrusters import build
from sitl.world import World

REVOLT = load(find("revolt"))
STOPS = math.radians(178.0)
SHARES = (
    OutputConfig(ahead=0.8, astern=-0.9, dead_band=0.05, reversed=True),
    OutputConfig(azimuth_trim_rad=0.4, azimuth_reversed=True),
    OutputConfig(dead_band=0.1),
)
PULSES = (
    OutputConfig(trim=1520.0, ahead=1900.0, astern=1100.0, dead_band=25.0, reversed=True, azimuth_min_us=2100.0, azimuth_max_us=900.0),
    OutputConfig(trim=1490.0),
    OutputConfig(ahead=1900.0, astern=1100.0, dead_band=40.0),
)


def vessel(driver: str, outputs: tuple[OutputConfig, ...], mavlink: MavlinkBoardConfig | None = None) -> VesselConfig:
    """ReVolt with that bridge, its pods between stops, its bow thruster fixed and down."""
    pods = [replace(pod, azimuth_min_rad=-STOPS, azimuth_max_rad=STOPS) for pod in REVOLT.thrusters[:2]]
    bow = replace(REVOLT.thrusters[2], retractable=False, travel_s=0.0)
    thrusters = tuple(replace(thruster, output=output) for thruster, output in zip((*pods, bow), outputs, strict=True))
    bridge = replace(REVOLT.actuators[0], name="bridge", driver=driver, mavlink=mavlink)
    return replace(REVOLT, thrusters=thrusters, actuators=(bridge,))


OVERRIDE = MavlinkBoardConfig(channels=(9, 10, 11), azimuth_channels=(12, 13, 0))
VESSELS = {
    "microcontroller": vessel("microcontroller", SHARES),
    "mavlink_servo": vessel("mavlink_servo", PULSES, OVERRIDE),
    "mavlink_servo, do_set_servo": vessel("mavlink_servo", PULSES, replace(OVERRIDE, method="do_set_servo", unguarded=True)),
}
GUARDED = [name for name in VESSELS if name != "mavlink_servo, do_set_servo"]
DEAF_TO_TRANSMITTERS = ["mavlink_servo"]  # an overridden board does not say when it has lost one
THROTTLES = (0.5, -0.6, 0.3)
MOVING = tuple(ThrusterCommand(0.0, throttle, azimuth_rad) for throttle, azimuth_rad in zip(THROTTLES, (0.2, -1.0, None), strict=True))


def test_every_bridge_stands_here() -> None:
    assert {config.actuators[0].driver for config in VESSELS.values()} == set(DRIVERS) == set(BOARDS)


class Bench:
    """A world, and the driver of its one bridge."""

    def __init__(self, name: str, *faults: str) -> None:
        self.config = VESSELS[name]
        self.world = World(self.config, faults=faults)
        self.driver: Actuator = open_actuator(self.config.actuators[0], self.config, self.world.open("bridge", ""))
        self.now_s = 0.0

    def run(self, seconds: float, armed: bool | None = True, step_s: float = 0.1) -> list[Reading]:
        """`armed` None: the companion has stopped."""
        readings: list[Reading] = []
        for _ in range(round(seconds / step_s)):
            self.now_s = round(self.now_s + step_s, 6)
            self.world.advance(self.now_s)
            if armed is not None:
                readings += self.driver.read(self.now_s)
                self.driver.write(ActuatorCommand(self.now_s, armed, MOVING), self.now_s)
        return readings

    @property
    def throttles(self) -> list[float]:
        return [thruster.throttle() for thruster in self.world.thrusters]

    @property
    def ok(self) -> bool:
        return self.driver.health(self.now_s).ok


@pytest.fixture(params=list(VESSELS))
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def test_propellers_and_azimuths_do_as_told_and_the_feedback_says_so(name: str) -> None:
    bench = Bench(name)
    readings = bench.run(6.0)
    assert bench.throttles == pytest.approx(THROTTLES, abs=0.004)  # a pulse is a whole number of microseconds
    assert [bench.world.thrusters[i].azimuth_rad for i in (0, 1)] == pytest.approx([0.2, -1.0], abs=0.004)
    newest = {reading.index: reading for reading in readings if isinstance(reading, ThrusterFeedback)}
    assert [newest[i].throttle for i in range(3)] == pytest.approx(THROTTLES, abs=0.004) and all(each.ok for each in newest.values())
    assert [newest[i].azimuth_rad for i in (0, 1)] == pytest.approx([0.2, -1.0], abs=0.004) and newest[2].azimuth_rad is None
    assert bench.ok, bench.driver.health(bench.now_s).text


def test_disarmed_is_neutral_and_leaves_the_azimuths(name: str) -> None:
    bench = Bench(name)
    bench.run(3.0)
    before = [thruster.azimuth_rad for thruster in bench.world.thrusters]
    readings = bench.run(3.0, armed=False)
    assert bench.throttles == pytest.approx([0.0] * 3, abs=0.02) and bench.ok  # they run out
    assert [thruster.azimuth_rad for thruster in bench.world.thrusters] == pytest.approx(before, abs=0.004)
    newest = {reading.index: reading for reading in readings if isinstance(reading, ThrusterFeedback)}
    assert [newest[i].throttle for i in range(3)] == pytest.approx([0.0] * 3, abs=0.02)


def test_before_the_first_arming_nothing_moves(name: str) -> None:
    bench = Bench(name)
    bench.run(3.0, armed=False)
    assert bench.throttles == [0.0] * 3 and bench.ok
    assert [thruster.azimuth_rad for thruster in bench.world.thrusters] == [each.azimuth_rad for each in bench.config.thrusters]


@pytest.mark.parametrize("name", GUARDED)
def test_half_a_second_after_the_companion_stops_the_thrusters_are_neutral(name: str) -> None:
    bench = Bench(name)
    bench.run(6.0)
    bench.run(0.45, armed=None, step_s=0.05)
    assert abs(bench.throttles[0]) > 0.4
    bench.run(0.1, armed=None, step_s=0.05)
    assert [thruster._target_n for thruster in bench.world.thrusters] == [0.0] * 3


def test_closing_the_bridge_stops_the_thrusters_at_once(name: str) -> None:
    bench = Bench(name)
    bench.run(6.0)
    bench.driver.write(ActuatorCommand(bench.now_s, False, MOVING), bench.now_s)  # as the loop does before it closes
    bench.driver.close()
    bench.run(0.05, armed=None, step_s=0.01)
    assert [thruster._target_n for thruster in bench.world.thrusters] == [0.0] * 3


@pytest.mark.parametrize("fault", ["mcu_silent", "bridge_unplugged"])
def test_a_board_that_is_gone_is_missed_within_a_second_and_found_again(name: str, fault: str) -> None:
    bench = Bench(name, f"{fault}@4+6")
    bench.run(3.9)
    assert bench.ok
    bench.run(1.2)
    assert not bench.ok
    bench.run(8.0)
    assert bench.ok and bench.throttles == pytest.approx(THROTTLES, abs=0.02)


def test_a_board_that_does_not_hear_says_it_or_is_seen_not_to_follow(name: str) -> None:
    bench = Bench(name, "mcu_deaf@4+6")
    bench.run(4.0)
    bench.run(3.5, armed=False)
    if name in GUARDED:
        assert bench.throttles == pytest.approx([0.0] * 3, abs=0.02)
    else:
        assert not bench.ok  # it holds what it was told last
    bench.run(8.0)
    assert bench.ok


def test_garbage_on_the_line_moves_nothing_and_is_told_from_silence(name: str) -> None:
    bench, rng = Bench(name, "mcu_silent@0"), random.Random(2)
    for _ in range(40):
        bench.world.babble("bridge", rng.randbytes(60))
        assert bench.run(0.1) == []
    assert "wrong baud rate" in bench.driver.health(bench.now_s).text and bench.throttles == [0.0] * 3


def test_battery_transmitter_and_leak_come_in_on_it(name: str) -> None:
    bench = Bench(name, "rc_lost@4", "battery_low@4", "leak@4")
    readings = bench.run(3.9)
    battery = [reading for reading in readings if isinstance(reading, Battery)][-1]
    assert (battery.voltage_v, battery.remaining) == (pytest.approx(bench.world.battery.voltage_v, abs=0.1), pytest.approx(1.0, abs=0.02))
    assert battery.current_a == pytest.approx(bench.world.battery.current_a, abs=2.0)
    received = [reading for reading in readings if isinstance(reading, RcInput)]
    assert bool(received) is (name not in DEAF_TO_TRANSMITTERS)
    for reading in received[-1:]:
        assert reading.channels[:8] == (0.0, 0.0, 0.0, 0.0, -1.0, -1.0, -1.0, -1.0) and not reading.lost
    assert {reading.wet for reading in readings if isinstance(reading, Leak)} == {False}
    readings = bench.run(2.0)
    assert all(reading.lost for reading in [reading for reading in readings if isinstance(reading, RcInput)][-1:])
    assert [reading for reading in readings if isinstance(reading, Leak)][-1].wet
    assert [reading for reading in readings if isinstance(reading, Battery)][-1].remaining == pytest.approx(0.08, abs=0.005)


class Pty:
    """The emulated board's end of a real line."""

    def __init__(self) -> None:
        self.end, self._far = os.openpty()
        tty.setraw(self._far)
        os.set_blocking(self.end, False)
        self.url = f"serial:{os.ttyname(self._far)}:115200"

    def send(self, data: bytes, t_s: float) -> None:
        with contextlib.suppress(BlockingIOError):
            os.write(self.end, data)

    def receive(self, now_s: float) -> list[tuple[float, bytes]]:
        with contextlib.suppress(BlockingIOError):
            return [(now_s, os.read(self.end, 4096))]
        return []

    def close(self) -> None:
        os.close(self.end)
        os.close(self._far)


def test_it_works_over_a_real_line(name: str) -> None:
    config, line = VESSELS[name], Pty()
    thrusters = build(config.thrusters, 0.0, None)
    emulated = board(config.actuators[0], line, thrusters, BatteryModel(900.0), Faults((), config))  # type: ignore[arg-type]
    driver = open_actuator(config.actuators[0], config, TransportOpener().open("bridge", line.url))
    descriptor = driver.fileno()
    assert descriptor is not None
    newest: dict[int, float] = {}
    for step in range(600):
        now_s = 0.05 * step
        emulated.listen(now_s)
        emulated.speak(now_s)
        select.select([descriptor], [], [], 0.02)
        newest |= {each.index: each.throttle for each in driver.read(now_s) if isinstance(each, ThrusterFeedback)}
        driver.write(ActuatorCommand(now_s, True, MOVING), now_s)
        for thruster in thrusters:
            thruster.step(0.05)
        if [newest.get(i, 0.0) for i in range(3)] == pytest.approx(THROTTLES, abs=0.004) and driver.health(now_s).ok:
            break
    else:
        raise AssertionError(driver.health(now_s).text)
    driver.close()
    line.close()
