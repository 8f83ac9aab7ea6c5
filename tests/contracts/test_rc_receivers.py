"""Serial RC receivers: each emulator with its driver, and with a whole vessel."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from companion.cli.rig import LockstepRig
from companion.config.devices import SensorConfig
from companion.config.vessel import find, load
from companion.core.readings import RcInput
from companion.io.sensors import open_sensor
from sitl.scenarios.rig import Conditions
from sitl.world import World, WorldConditions
from tests.protocol.desk import Desk

OTTER = load(find("otter"))
PULSES = (1000, 2000, 1250, 1500, 988, 2012, 1500, 1500, 1750, 1100, 1500, 1500, 1500, 1500, 1500, 2000)
DRIVERS = pytest.mark.parametrize("driver", ["sbus", "crsf"])


def row(driver: str) -> SensorConfig:
    return SensorConfig(name="rc", driver=driver, port="memory:rc", rate_hz=50.0)


class Radio:
    """A world with that RC receiver, and the driver at it."""

    def __init__(self, driver: str, *faults: str) -> None:
        self.world = World(
            replace(OTTER, sensors=(*OTTER.sensors, row(driver))), WorldConditions(seed=3, faults=faults)
        )
        self.sensor: Any = open_sensor(row(driver), self.world.open("rc", "memory:rc"))
        self.now_s = 0.0

    def sail(self, duration_s: float) -> list[RcInput]:
        found: list[RcInput] = []
        for _ in range(round(duration_s * 20)):
            self.now_s = round(self.now_s + 0.05, 6)
            self.world.advance(self.now_s)
            found += self.sensor.read(self.now_s)
        return found


@DRIVERS
def test_all_sixteen_channels_come_through(driver: str) -> None:
    radio = Radio(driver)
    radio.world.set_transmitter(PULSES)
    rc = radio.sail(1.0)[-1]
    assert not rc.lost and radio.sensor.health(radio.now_s).ok
    assert rc.channels == pytest.approx([(pulse_us - 1500) / 500 for pulse_us in PULSES], abs=2e-3)
    assert radio.sensor.counts[1] == 0


@DRIVERS
def test_a_lost_transmitter_is_told_and_comes_back(driver: str) -> None:
    radio = Radio(driver, "rc_lost@2+3")
    assert not radio.sail(1.9)[-1].lost
    assert radio.sail(1.0)[-1].lost
    assert not radio.sail(3.0)[-1].lost
    assert radio.sensor.health(radio.now_s).ok


@DRIVERS
def test_a_bad_wire_never_throws_a_switch(driver: str) -> None:
    """One byte in ten is spoilt: whatever comes through is what the transmitter sends."""
    radio = Radio(driver, "rc_garbled@1")
    radio.world.set_transmitter(PULSES)
    found = radio.sail(60.0)
    assert radio.sensor.counts[1] > 0
    wrong = [rc for rc in found if rc.channels != pytest.approx([(us - 1500) / 500 for us in PULSES], abs=2e-3)]
    assert not wrong
    assert found[-1].lost, "a line as bad as that is a lost transmitter"


@pytest.fixture(params=["sbus", "crsf"])
def desk(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[Desk]:
    config = replace(OTTER, sensors=(*OTTER.sensors, row(request.param)))
    rig = LockstepRig(Conditions("otter", seed=3, known=config), tmp_path / "log", link="memory:desk")
    desk = Desk(tmp_path, rig)
    desk.tick()
    yield desk
    desk.close()


def throw(desk: Desk, *pulses_us: int) -> None:
    desk.rig.world.set_transmitter(pulses_us)
    desk.heartbeat()
    desk.tick(round(1.5 / desk.vessel.period_s))


def test_arm_steer_and_kill_by_a_channel_beyond_the_eighth(desk: Desk) -> None:
    parameters = desk.vessel.parameters
    for name, value in {"MAN_RC_SAFE_CH": 0, "RC9_OPTION": 153, "RC10_OPTION": 31}.items():
        assert parameters.set(name, value) is None
    sticks = (1500, 1500, 1500, 1500, 1000, 1000, 1000, 1000)
    throw(desk, *sticks, 1000, 1000)
    desk.ready()
    throw(desk, *sticks, 1000, 1000)
    throw(desk, *sticks, 2000, 1000)
    assert "Armed" in desk.texts()
    throw(desk, 1500, 1900, *sticks[2:], 2000, 1000)
    tick = desk.vessel.last_tick
    assert tick is not None and any(thruster.throttle > 0.1 for thruster in tick.command.thrusters)
    assert desk.latest("RC_CHANNELS").chancount == 16 and desk.latest("RC_CHANNELS").chan2_raw == 1900
    throw(desk, *sticks, 2000, 2000)
    assert "Kill switch is on: thrusters stopped" in desk.texts()


def test_a_transmitter_that_is_switched_off_is_a_failsafe(desk: Desk) -> None:
    desk.vessel.parameters.set("NAV_RCL_ACT", 1)
    throw(desk, *(1500,) * 8)
    desk.ready()
    throw(desk, *(1500,) * 8)
    assert desk.result(400, 1.0) == 0
    desk.rig.world.set_transmitter(None)
    desk.until("Hold", lambda: desk.latest("HEARTBEAT").custom_mode == 0x03040000, 20.0)


def test_the_transmitters_screen_shows_the_boat(desk: Desk) -> None:
    receiver: Any = desk.rig.world.sensors[-1]
    if not hasattr(receiver, "telemetry"):
        pytest.skip("SBUS has no way back")
    desk.ready()
    desk.tick(60)
    assert set(receiver.telemetry) >= {0x02, 0x1E, 0x21} and receiver.telemetry[0x21] == b"Manual*\0"


def test_a_receiver_on_the_board_gets_the_telemetry_through_it(tmp_path: Path) -> None:
    rig = LockstepRig(Conditions("revolt", seed=3), tmp_path / "log", link="memory:desk")
    desk = Desk(tmp_path, rig)
    board: Any = rig.world.boards[0]
    desk.ready()
    assert board.telemetry == {}, "there is no receiver"
    rig.world.set_transmitter((1500,) * 8)
    desk.tick(60)
    assert set(board.telemetry) >= {0x02, 0x08, 0x1E, 0x21} and board.telemetry[0x21] == b"Manual*\0"
    desk.close()
