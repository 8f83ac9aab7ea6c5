"""The bridge to an autopilot board: what goes over the wire, and what its health makes of a board that is set otherwise than it should be."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from pymavlink.dialects.v20 import common as mavlink

from companion.config import ActuatorConfig, ConfigError, MavlinkBoardConfig, OutputConfig, VesselConfig, find, load
from companion.core.types import ActuatorCommand, RcInput, ThrusterCommand, ThrusterFeedback
from companion.io.actuators import open_actuator
from sitl.battery import BatteryModel
from sitl.emulators.mavlink_servo import MavlinkServoEmulator
from sitl.faults import Faults
from sitl.memory import MemoryStream
from sitl.thrusters import build

ABOAT = load(find("aboat"))
BOW = replace(ABOAT.thrusters[0], output=OutputConfig(trim=1520.0))
VESSEL: VesselConfig = replace(ABOAT, thrusters=(BOW, ABOAT.thrusters[1]))
BOARD = MavlinkBoardConfig(channels=(9, 10), azimuth_channels=(11, 12))
HALF = (ThrusterCommand(0.0, 0.5, 0.0), ThrusterCommand(0.0, -0.5, math.radians(89.0)))


def bridge_config(**board: object) -> ActuatorConfig:
    return replace(ABOAT.actuators[0], name="pixhawk", driver="mavlink_servo", mavlink=replace(BOARD, **board))  # type: ignore[arg-type]


class Bench:
    """The bridge, the emulated board, and a look at what passes between them."""

    def __init__(self, **board: object) -> None:
        self.config = bridge_config(**board)
        self.vessel = replace(VESSEL, actuators=(self.config,))
        self.stream = MemoryStream("pixhawk")
        self.thrusters = build(self.vessel.thrusters, 0.0, None)
        self.faults = Faults((), self.vessel)
        self.board = MavlinkServoEmulator(self.config, self.stream.device, self.thrusters, BatteryModel(900.0), self.faults)
        self.driver = open_actuator(self.config, self.vessel, self.stream)
        self.sent: list[mavlink.MAVLink_message] = []
        self.readings: list[object] = []
        self._parser = mavlink.MAVLink(None)
        write = self.stream.write
        self.stream.write = lambda data, now_s: (self.sent.extend(self._parser.parse_buffer(data) or ()), write(data, now_s))  # type: ignore[method-assign]
        self.now_s = 0.0

    def run(self, seconds: float, armed: bool | None = True, thrusters: tuple[ThrusterCommand, ...] = HALF) -> None:
        """`armed` None: the companion has stopped."""
        for _ in range(round(seconds * 20)):
            self.now_s = round(self.now_s + 0.05, 6)
            self.board.listen(self.now_s)
            self.board.speak(self.now_s)
            if armed is not None:
                self.readings += self.driver.read(self.now_s)
                self.driver.write(ActuatorCommand(self.now_s, armed, thrusters), self.now_s)

    def last(self, kind: str) -> mavlink.MAVLink_message:
        return [message for message in self.sent if message.get_type() == kind][-1]

    @property
    def text(self) -> str:
        health = self.driver.health(self.now_s)
        return "" if health.ok else health.text


def test_an_override_names_its_channels_and_no_other() -> None:
    bench = Bench()
    bench.run(2.0)
    message = bench.last("RC_CHANNELS_OVERRIDE")
    assert (message.get_srcSystem(), message.target_system, message.target_component) == (255, 1, 1)
    assert [getattr(message, f"chan{i}_raw") for i in range(1, 9)] == [0xFFFF] * 8
    assert [getattr(message, f"chan{i}_raw") for i in range(9, 19)] == [1760, 1250, 1500, 1750, 0, 0, 0, 0, 0, 0]
    assert bench.text == "" and bench.board.pulses_us[9:13] == [1760.0, 1250.0, 1500.0, 1750.0]


def test_low_channels_are_overridden_and_released_by_the_other_codes() -> None:
    bench = Bench(channels=(1, 2), azimuth_channels=(3, 4))
    bench.run(2.0)
    message = bench.last("RC_CHANNELS_OVERRIDE")
    assert [getattr(message, f"chan{i}_raw") for i in range(1, 10)] == [1760, 1250, 1500, 1750, 0xFFFF, 0xFFFF, 0xFFFF, 0xFFFF, 0]
    bench.driver.close()
    neutral, release = [message for message in bench.sent if message.get_type() == "RC_CHANNELS_OVERRIDE"][-2:]
    assert [getattr(neutral, f"chan{i}_raw") for i in range(1, 6)] == [1520, 1500, 0xFFFF, 0xFFFF, 0xFFFF]
    assert [getattr(release, f"chan{i}_raw") for i in range(1, 6)] == [0, 0, 0, 0, 0xFFFF]


def test_closing_hands_high_channels_back_to_the_receiver() -> None:
    bench = Bench()
    bench.board.rc_us = (1500,) * 8 + (1300,) * 8
    bench.run(2.0)
    bench.driver.close()
    release = bench.last("RC_CHANNELS_OVERRIDE")
    assert [getattr(release, f"chan{i}_raw") for i in range(9, 14)] == [0xFFFE, 0xFFFE, 0xFFFE, 0xFFFE, 0]
    bench.run(0.1, armed=None)
    assert bench.board.pulses_us[9:13] == [1300.0] * 4


def test_heartbeats_come_once_a_second_and_pulses_only_once_the_board_is_known() -> None:
    bench = Bench()
    bench.faults.active = frozenset({"mcu_silent"})
    bench.run(10.0)
    assert {message.get_type() for message in bench.sent} == {"HEARTBEAT"} and len(bench.sent) == pytest.approx(10, abs=1)
    assert {message.type for message in bench.sent} == {mavlink.MAV_TYPE_ONBOARD_CONTROLLER}
    assert "no autopilot's heartbeat yet" in bench.text


def test_do_set_servo_is_sent_on_a_change_and_twice_a_second() -> None:
    bench = Bench(method="do_set_servo", unguarded=True)
    bench.run(10.0)
    orders = [(message.param1, message.param2) for message in bench.sent if getattr(message, "command", 0) == mavlink.MAV_CMD_DO_SET_SERVO]
    assert bench.text == "" and bench.board.pulses_us[9:13] == [1760.0, 1250.0, 1500.0, 1750.0]
    assert orders.count((9, 1760.0)) == pytest.approx(20, abs=2)
    bench.run(0.05, thrusters=(ThrusterCommand(0.0, 0.75, 0.0), HALF[1]))
    bench.run(0.05, armed=None)
    assert bench.board.pulses_us[9] == 1880.0
    bench.board.parameters["SERVO9_FUNCTION"] = 70.0
    bench.run(1.0)
    assert "refuses DO_SET_SERVO: set SERVOn_FUNCTION" in bench.text
    bench.faults.active = frozenset({"mcu_silent"})
    bench.run(2.0)
    assert "IT HOLDS ITS LAST PULSES" in bench.text


@pytest.mark.parametrize(
    ("parameter", "value", "text"),
    [
        ("RC_OVERRIDE_TIME", 3.0, "holds an override for 3 s: set its RC_OVERRIDE_TIME to 0.5"),
        ("RC_OVERRIDE_TIME", -1.0, "for ever"),
        ("RC_OVERRIDE_TIME", 0.0, "not at all"),
        ("SERVO_RC_FS_MSK", 256.0, "channel 10 would hold its last pulse when the companion falls silent: set SERVO_RC_FS_MSK to 768"),
        ("MAV_GCS_SYSID", 42.0, "output 9 is at 1520 µs, not 1760: SERVO9_FUNCTION should be 148, MAV_GCS_SYSID 255"),
        ("SERVO9_FUNCTION", 70.0, "output 9 is at 0 µs"),
    ],
)
def test_a_board_that_is_set_otherwise_is_complained_of_with_the_remedy(parameter: str, value: float, text: str) -> None:
    bench = Bench()
    bench.board.parameters[parameter] = value
    bench.run(5.0)
    assert text in bench.text


def test_a_setting_put_right_is_seen() -> None:
    bench = Bench()
    bench.board.parameters["RC_OVERRIDE_TIME"] = 3.0
    bench.run(3.0)
    assert "RC_OVERRIDE_TIME" in bench.text
    bench.board.parameters["RC_OVERRIDE_TIME"] = 0.5
    bench.run(11.0)
    assert bench.text == ""


def test_the_safety_switch_is_named() -> None:
    bench = Bench()
    bench.run(2.0)
    bench.board.safety_on = True
    bench.run(2.0)
    assert "safety switch is on" in bench.text
    assert [reading.throttle for reading in bench.readings if isinstance(reading, ThrusterFeedback)][-1] == 0.0


def test_a_slow_azimuth_is_not_taken_for_an_output_astray() -> None:
    bench = Bench()
    bench.run(3.0)
    there, back = math.radians(170.0), math.radians(-170.0)
    for azimuth_rad in (there, back):
        for _ in range(160):
            bench.run(0.05, thrusters=(ThrusterCommand(0.0, 0.5, azimuth_rad), ThrusterCommand(0.0, 0.5, azimuth_rad)))
            assert bench.text == ""


def test_a_transmitter_is_not_heard_through_channels_that_are_overridden() -> None:
    for channels, heard in (((9, 10), True), ((8, 9), False)):
        bench = Bench(channels=channels, azimuth_channels=(11, 12))
        bench.board.rc_us = (1500,) * 16
        bench.run(2.0)
        assert any(isinstance(reading, RcInput) for reading in bench.readings) is heard


def test_another_system_on_the_line_is_not_the_board() -> None:
    bench = Bench()
    bench.run(2.0)
    stranger = mavlink.MAVLink(None, srcSystem=7, srcComponent=1)
    beat = mavlink.MAVLink_heartbeat_message(mavlink.MAV_TYPE_QUADROTOR, mavlink.MAV_AUTOPILOT_PX4, 0, 0, 4, 3)
    outputs = mavlink.MAVLink_servo_output_raw_message(0, 0, *[2000] * 16)
    bench.faults.active = frozenset({"mcu_silent"})
    bench.readings.clear()
    for _ in range(40):
        bench.stream.device.send(beat.pack(stranger) + outputs.pack(stranger), bench.now_s)
        bench.run(0.05)
    assert bench.readings == [] and "silent for" in bench.text and bench.last("RC_CHANNELS_OVERRIDE").target_system == 1


def test_without_its_table_it_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"needs a table \[actuator.mavlink\]"):
        open_actuator(replace(bridge_config(), mavlink=None), VESSEL, MemoryStream("pixhawk"))


# --- the board, as ArduPilot is -----------------------------------------------------------------------------------


@pytest.mark.parametrize(("mask", "left_us"), [(65535.0, 1520.0), (0.0, 1760.0)])
def test_as_it_comes_the_board_holds_an_override_for_three_seconds(mask: float, left_us: float) -> None:
    """And then for ever, unless its mask sends the output to trim."""
    bench = Bench()
    bench.board.parameters.update(RC_OVERRIDE_TIME=3.0, SERVO_RC_FS_MSK=mask)
    bench.run(2.0)
    bench.run(2.9, armed=None)
    assert bench.board.pulses_us[9] == 1760.0
    bench.run(0.2, armed=None)
    assert bench.board.pulses_us[9] == left_us


def test_a_receiver_gets_the_channels_when_the_companion_falls_silent() -> None:
    bench = Bench()
    bench.board.rc_us = (1500,) * 8 + (1400,) * 8
    bench.run(2.0)
    assert bench.board.pulses_us[9] == 1760.0
    bench.run(0.6, armed=None)
    assert bench.board.pulses_us[9] == 1400.0


