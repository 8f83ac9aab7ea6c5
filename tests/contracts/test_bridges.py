"""Every bridge with its emulated board, calibrated askew: what any row of the table owes the vessel."""

from __future__ import annotations

import contextlib
import math
import os
import random
import select
import tty
from collections.abc import Callable
from dataclasses import replace

import pytest

from companion.allocation.feedback import ThrusterReports
from companion.config.actuators import BRIDGES
from companion.config.actuators.mavlink_servo import MavlinkBoardConfig
from companion.config.actuators.nanotec import StepperConfig
from companion.config.actuators.nmea2000 import MotorConfig
from companion.config.bridges import OutputConfig
from companion.config.devices import ActuatorConfig
from companion.config.vessel import VesselConfig, find, load
from companion.core.actuation import ActuatorCommand, ThrusterCommand, ThrusterFeedback
from companion.core.ports import Actuator
from companion.core.readings import Battery, Leak, RcInput, Reading
from companion.io.actuators import DRIVERS, open_actuator
from companion.io.transport.opener import TransportOpener
from sitl.battery import BatteryModel
from sitl.emulators import BOARDS, board
from sitl.faults import Faults
from sitl.thrusters import build
from sitl.world import World, WorldConditions
from tests.unit.io.rows import bridge_row

REVOLT = load(find("revolt"))
STOPS = math.radians(178.0)
SHARES = (
    OutputConfig(ahead=0.8, astern=-0.9, dead_band=0.05, reversed=True),
    OutputConfig(azimuth_trim_rad=0.4, azimuth_reversed=True),
    OutputConfig(dead_band=0.1),
)
PULSES = (
    OutputConfig(
        trim=1520.0,
        ahead=1900.0,
        astern=1100.0,
        dead_band=25.0,
        reversed=True,
        azimuth_min_us=2100.0,
        azimuth_max_us=900.0,
    ),
    OutputConfig(trim=1490.0),
    OutputConfig(ahead=1900.0, astern=1100.0, dead_band=40.0),
)


PODS = tuple(thruster.name for thruster in REVOLT.thrusters[:2])


def vessel(driver: str, outputs: tuple[OutputConfig, ...], *others: ActuatorConfig, **tables: object) -> VesselConfig:
    """ReVolt with that bridge, its pods between stops, its bow thruster fixed and down."""
    pods = [replace(pod, azimuth_min_rad=-STOPS, azimuth_max_rad=STOPS) for pod in REVOLT.thrusters[:2]]
    bow = replace(REVOLT.thrusters[2], retractable=False, travel_s=0.0)
    thrusters = tuple(replace(thruster, output=output) for thruster, output in zip((*pods, bow), outputs, strict=True))
    bridge = bridge_row(REVOLT.actuators[0], BRIDGES[driver].row, driver, name="bridge", **tables)
    return replace(REVOLT, thrusters=thrusters, actuators=(bridge, *others))


OVERRIDE = MavlinkBoardConfig(channels=(9, 10, 11), azimuth_channels=(12, 13, 0))
VESSELS = {
    "microcontroller": vessel("microcontroller", SHARES),
    "mavlink_servo": vessel("mavlink_servo", PULSES, mavlink=OVERRIDE),
    "mavlink_servo, do_set_servo": vessel(
        "mavlink_servo", PULSES, mavlink=replace(OVERRIDE, method="do_set_servo", unguarded=True)
    ),
    "nanotec": vessel(
        "nanotec",
        SHARES,
        replace(REVOLT.actuators[0], name="propellers"),
        thrusters=(),
        azimuths=PODS,
        drives=(StepperConfig(PODS[0], 1, 12_800.0), StepperConfig(PODS[1], 2, 4800.0)),
    ),
    "nmea2000": vessel(
        "nmea2000", SHARES, motors=tuple(MotorConfig(thruster.name, i) for i, thruster in enumerate(REVOLT.thrusters))
    ),
}
GUARDED = [name for name in VESSELS if name != "mavlink_servo, do_set_servo"]
FINENESS = {"nmea2000": 0.01}  # of a throttle: whole percent of what the drive can
WITH_RECEIVER = [name for name in VESSELS if name not in ("nanotec", "nmea2000")]
WITH_BATTERY = [name for name in VESSELS if name != "nanotec"]
NOISE = {"nmea2000": "bit rate"}
DEAF_TO_TRANSMITTERS = ["mavlink_servo"]  # an overridden board does not say when it has lost one
THROTTLES = (0.5, -0.6, 0.3)
MOVING = tuple(
    ThrusterCommand(0.0, throttle, azimuth_rad)
    for throttle, azimuth_rad in zip(THROTTLES, (0.2, -1.0, None), strict=True)
)


def test_every_bridge_stands_here() -> None:
    assert {config.actuators[0].driver for config in VESSELS.values()} == set(DRIVERS) == set(BOARDS)


class Bench:
    """A world, and the driver of the bridge in question; `others` of the vessel's other bridges."""

    def __init__(self, name: str, *faults: str) -> None:
        self.config = VESSELS[name]
        self.world = World(self.config, WorldConditions(faults=faults))
        opened = [
            open_actuator(bridge, self.config, self.world.open(bridge.name, "")) for bridge in self.config.actuators
        ]
        self.driver: Actuator = opened[0]
        self.others = opened[1:]
        self.now_s = 0.0

    def run(self, seconds: float, armed: bool | None = True, step_s: float = 0.1) -> list[Reading]:
        """`armed` None: the companion has stopped."""
        readings: list[Reading] = []
        for _ in range(round(seconds / step_s)):
            self.now_s = round(self.now_s + step_s, 6)
            self.world.advance(self.now_s)
            if armed is not None:
                for driver in (self.driver, *self.others):
                    readings += driver.read(self.now_s)
                    driver.write(ActuatorCommand(self.now_s, armed, MOVING), self.now_s)
        return readings

    def close(self) -> None:
        """As the loop does."""
        for driver in (self.driver, *self.others):
            driver.write(ActuatorCommand(self.now_s, False, MOVING), self.now_s)
        for driver in (self.driver, *self.others):
            driver.close()

    @property
    def throttles(self) -> list[float]:
        return [thruster.throttle() for thruster in self.world.thrusters]

    @property
    def ok(self) -> bool:
        return self.driver.health(self.now_s).ok


def joined(readings: list[Reading]) -> dict[int, ThrusterFeedback]:
    """Of each thruster what all bridges say."""
    reports = ThrusterReports(len(REVOLT.thrusters))
    for reading in readings:
        if isinstance(reading, ThrusterFeedback):
            reports.take(reading)
    return {i: report for i, report in enumerate(reports.newest) if report is not None}


@pytest.fixture(params=list(VESSELS))
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


def test_propellers_and_azimuths_do_as_told_and_the_feedback_says_so(name: str) -> None:
    bench = Bench(name)
    readings = bench.run(6.0)
    assert bench.throttles == pytest.approx(
        THROTTLES, abs=FINENESS.get(name, 0.004)
    )  # a pulse is a whole number of microseconds
    assert [bench.world.thrusters[i].azimuth_rad for i in (0, 1)] == pytest.approx([0.2, -1.0], abs=0.004)
    newest = joined(readings)
    assert [newest[i].throttle for i in range(3)] == pytest.approx(THROTTLES, abs=FINENESS.get(name, 0.004)) and all(
        each.ok for each in newest.values()
    )
    assert [newest[i].azimuth_rad for i in (0, 1)] == pytest.approx([0.2, -1.0], abs=0.004) and newest[
        2
    ].azimuth_rad is None
    assert bench.ok, bench.driver.health(bench.now_s).text


def test_disarmed_is_neutral_and_leaves_the_azimuths(name: str) -> None:
    bench = Bench(name)
    bench.run(3.0)
    before = [thruster.azimuth_rad for thruster in bench.world.thrusters]
    readings = bench.run(3.0, armed=False)
    assert bench.throttles == pytest.approx([0.0] * 3, abs=0.02) and bench.ok  # they run out
    assert [thruster.azimuth_rad for thruster in bench.world.thrusters] == pytest.approx(before, abs=0.004)
    newest = joined(readings)
    assert [newest[i].throttle for i in range(3)] == pytest.approx([0.0] * 3, abs=0.02)


def test_before_the_first_arming_nothing_moves(name: str) -> None:
    bench = Bench(name)
    bench.run(3.0, armed=False)
    assert bench.throttles == [0.0] * 3 and bench.ok
    assert [thruster.azimuth_rad for thruster in bench.world.thrusters] == [
        each.azimuth_rad for each in bench.config.thrusters
    ]


@pytest.mark.parametrize("name", GUARDED)
def test_half_a_second_after_the_companion_stops_the_thrusters_are_neutral(name: str) -> None:
    bench = Bench(name)
    bench.run(6.0)
    bench.run(0.45, armed=None, step_s=0.05)
    assert abs(bench.throttles[0]) > 0.4
    bench.run(0.1, armed=None, step_s=0.05)
    assert [thruster.target_n for thruster in bench.world.thrusters] == [0.0] * 3


def test_closing_the_bridge_stops_the_thrusters_at_once(name: str) -> None:
    bench = Bench(name)
    bench.run(6.0)
    bench.close()
    bench.run(0.05, armed=None, step_s=0.01)
    assert [thruster.target_n for thruster in bench.world.thrusters] == [0.0] * 3


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
        assert not any(isinstance(reading, ThrusterFeedback) for reading in bench.run(0.1))
    assert NOISE.get(name, "wrong baud rate") in bench.driver.health(bench.now_s).text and bench.throttles == [0.0] * 3


@pytest.mark.parametrize("name", WITH_BATTERY)
def test_the_battery_comes_in_on_it(name: str) -> None:
    bench = Bench(name, "battery_low@4")
    readings = bench.run(3.9)
    battery = [reading for reading in readings if isinstance(reading, Battery)][-1]
    assert (battery.voltage_v, battery.remaining) == (
        pytest.approx(bench.world.battery.voltage_v, abs=0.1),
        pytest.approx(1.0, abs=0.02),
    )
    assert battery.current_a == pytest.approx(bench.world.battery.current_a, abs=2.0)
    readings = bench.run(3.1)
    assert [reading for reading in readings if isinstance(reading, Battery)][-1].remaining == pytest.approx(
        0.08, abs=0.005
    )


@pytest.mark.parametrize("name", WITH_RECEIVER)
def test_transmitter_and_leak_come_in_on_it(name: str) -> None:
    bench = Bench(name, "rc_lost@4", "leak@4")
    readings = bench.run(3.9)
    received = [reading for reading in readings if isinstance(reading, RcInput)]
    assert bool(received) is (name not in DEAF_TO_TRANSMITTERS)
    for reading in received[-1:]:
        assert reading.channels[:8] == (0.0, 0.0, 0.0, 0.0, -1.0, -1.0, -1.0, -1.0) and not reading.lost
    assert {reading.wet for reading in readings if isinstance(reading, Leak)} == {False}
    readings = bench.run(2.0)
    assert all(reading.lost for reading in [reading for reading in readings if isinstance(reading, RcInput)][-1:])
    assert [reading for reading in readings if isinstance(reading, Leak)][-1].wet


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


class CanBus:
    """The emulated devices' end of a CAN bus: the kernel's virtual one, else frames in UDP multicast, else within the
    process. `url` says which."""

    def __init__(self) -> None:
        port = 20_000 + os.getpid() % 20_000
        for self.url in (
            "can:vcan0",
            f"can:239.74.163.2:{port}?interface=udp_multicast",
            f"can:test{port}?interface=virtual",
        ):
            self._line = TransportOpener().open("devices", self.url)
            if self._line.fault() is None:
                return
            self._line.close()

    def send(self, data: bytes, t_s: float) -> None:
        self._line.write(data, t_s)

    def receive(self, now_s: float) -> list[tuple[float, bytes]]:
        return list(self._line.read(now_s))

    def close(self) -> None:
        self._line.close()


def test_it_works_over_a_real_line(name: str, record_property: Callable[[str, object], None]) -> None:
    config = VESSELS[name]
    line: Pty | CanBus = CanBus() if name == "nmea2000" else Pty()
    record_property("line", line.url)
    print(f"{name} over {line.url}")
    thrusters = build(config.thrusters, 0.0, None)
    by_name = {each.name: thruster for each, thruster in zip(config.thrusters, thrusters, strict=True)}
    emulated = board(config.actuators[0], line, by_name, BatteryModel(900.0), Faults((), config))  # type: ignore[arg-type]
    driver = open_actuator(config.actuators[0], config, TransportOpener().open("bridge", line.url))
    descriptor = driver.fileno()
    assert descriptor is not None or "virtual" in line.url
    newest: dict[int, ThrusterFeedback] = {}
    for step in range(600):
        now_s = 0.05 * step
        driver.write(ActuatorCommand(now_s, True, MOVING), now_s)
        for _ in range(20):  # of a line that is asked and answers in turn
            emulated.listen(now_s)
            if not select.select([descriptor] if descriptor else [], [], [], 0.001)[0]:
                break
            newest |= joined(list(driver.read(now_s)))
        emulated.speak(now_s)
        select.select([descriptor] if descriptor else [], [], [], 0.02)
        newest |= joined(list(driver.read(now_s)))
        for thruster in thrusters:
            thruster.step(0.05)
        if _there(name, newest) and driver.health(now_s).ok:
            break
    else:
        raise AssertionError(f"{driver.health(now_s).text}, {newest}")
    driver.close()
    line.close()


def _there(name: str, newest: dict[int, ThrusterFeedback]) -> bool:
    if name == "nanotec":
        return [newest[i].azimuth_rad if i in newest else None for i in (0, 1)] == pytest.approx([0.2, -1.0], abs=0.004)
    throttles = [newest[i].throttle if i in newest else 0.0 for i in range(3)]
    return throttles == pytest.approx(THROTTLES, abs=FINENESS.get(name, 0.004))
