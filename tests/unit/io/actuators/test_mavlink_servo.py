"""The bridge to an autopilot board: what goes over the wire, and what its health makes of a board that is set otherwise
than it should be."""

from __future__ import annotations

import math
import random
import struct
from dataclasses import replace
from itertools import pairwise
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from companion.config.actuators.mavlink_servo import MavlinkBoardConfig, MavlinkServoConfig
from companion.config.bridges import OutputConfig
from companion.config.outputs import RelayConfig, ServoConfig
from companion.config.vessel import ConfigError, VesselConfig, find, load
from companion.core.actuation import DARK, ActuatorCommand, Auxiliary, Beacon, Light, ThrusterCommand, ThrusterFeedback
from companion.core.readings import Battery, RcInput
from companion.io.actuators import open_actuator
from companion.io.mavlink.wire.framer import Packed, frame
from sitl.battery import BatteryModel
from sitl.emulators.mavlink_servo import MavlinkServoEmulator
from sitl.faults import Faults, parse
from sitl.memory import MemoryStream
from sitl.thrusters import build
from tests.unit.io.rows import bridge_row

ABOAT = load(find("aboat"))
BOW = replace(ABOAT.thrusters[0], output=OutputConfig(trim=1520.0))
VESSEL: VesselConfig = replace(ABOAT, thrusters=(BOW, ABOAT.thrusters[1]))
BOARD = MavlinkBoardConfig(channels=(9, 10), azimuth_channels=(11, 12))
HALF = (ThrusterCommand(0.0, 0.5, 0.0), ThrusterCommand(0.0, -0.5, math.radians(89.0)))


def bridge_config(**board: Any) -> MavlinkServoConfig:
    mavlink = replace(BOARD, **board)
    return bridge_row(ABOAT.actuators[0], MavlinkServoConfig, "mavlink_servo", name="pixhawk", mavlink=mavlink)


class Bench:
    """The bridge, the emulated board, and a look at what passes between them."""

    def __init__(self, vessel: VesselConfig = VESSEL, **board: object) -> None:
        self.config = bridge_config(**board)
        self.vessel = replace(vessel, actuators=(self.config,))
        self.stream = MemoryStream("pixhawk")
        self.thrusters = build(self.vessel.thrusters, 0.0, None)
        self.faults = Faults((), self.vessel)
        self.board = MavlinkServoEmulator(
            self.config, self.stream.device, self.thrusters, BatteryModel(900.0), self.faults
        )
        self.driver = open_actuator(self.config, self.vessel, self.stream)
        self.sent: list[mavlink.MAVLink_message] = []
        self.readings: list[object] = []
        self._parser = mavlink.MAVLink(None)
        write = self.stream.write
        self.stream.write = lambda data, now_s: (
            self.sent.extend(self._parser.parse_buffer(data) or ()),
            write(data, now_s),
        )  # type: ignore[method-assign]
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
    bench.run(4.0)
    message = bench.last("RC_CHANNELS_OVERRIDE")
    assert (message.get_srcSystem(), message.target_system, message.target_component) == (255, 1, 1)
    assert [getattr(message, f"chan{i}_raw") for i in range(1, 9)] == [
        0xFFFF,
        0xFFFF,
        1500,
        *[0xFFFF] * 5,
    ]  # 3: for the board's failsafe
    assert [getattr(message, f"chan{i}_raw") for i in range(9, 19)] == [1760, 1250, 1500, 1750, 0, 0, 0, 0, 0, 0]
    assert bench.text == "" and bench.board.pulses_us[9:13] == [1760.0, 1250.0, 1500.0, 1750.0]


def test_low_channels_are_left_alone_by_another_code_than_high_ones() -> None:
    bench = Bench(channels=(1, 2), azimuth_channels=(3, 4))
    bench.run(4.0)
    message = bench.last("RC_CHANNELS_OVERRIDE")
    assert [getattr(message, f"chan{i}_raw") for i in range(1, 10)] == [
        1760,
        1250,
        1500,
        1750,
        0xFFFF,
        0xFFFF,
        0xFFFF,
        0xFFFF,
        0,
    ]


def test_closing_stops_the_thrusters_and_then_a_receiver_has_them() -> None:
    bench = Bench()
    bench.board.rc_us = (1500,) * 8 + (1300,) * 8
    bench.run(4.0)
    bench.driver.close()
    assert {message.chan3_raw for message in bench.sent[-40:] if message.get_type() == "RC_CHANNELS_OVERRIDE"} == {
        0xFFFF
    }
    bench.run(0.1, armed=None)
    assert bench.board.pulses_us[9:13] == [1520.0, 1500.0, 1500.0, 1750.0]
    bench.run(0.5, armed=None)
    assert bench.board.pulses_us[9:13] == [1300.0] * 4


def test_azimuth_servos_begin_at_rest_and_turn_at_their_rate() -> None:
    bench = Bench()
    bench.run(1.0, armed=False)
    assert bench.board.pulses_us[11:13] == [1500.0, 1500.0]
    bench.run(1.0)
    assert bench.board.pulses_us[12] == pytest.approx(1500.0 + 45.8 / 178.0 * 500.0, abs=8.0)


def test_heartbeats_come_once_a_second_and_pulses_only_once_the_board_is_known() -> None:
    bench = Bench()
    bench.faults.active = frozenset({"mcu_silent"})
    bench.run(10.0)
    assert {message.get_type() for message in bench.sent} == {"HEARTBEAT"} and len(bench.sent) == pytest.approx(
        10, abs=1
    )
    assert {message.type for message in bench.sent} == {mavlink.MAV_TYPE_ONBOARD_CONTROLLER}
    assert "no autopilot's heartbeat yet" in bench.text


def test_do_set_servo_is_sent_on_a_change_and_twice_a_second() -> None:
    bench = Bench(method="do_set_servo", unguarded=True)
    bench.run(10.0)
    orders = [
        (message.param1, message.param2)
        for message in bench.sent
        if getattr(message, "command", 0) == mavlink.MAV_CMD_DO_SET_SERVO
    ]
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
        (
            "SERVO_RC_FS_MSK",
            256.0,
            "channel 10 would hold its last pulse when the companion is silent: set SERVO_RC_FS_MSK to 768",
        ),
        ("FS_THR_ENABLE", 0.0, "radio failsafe is off"),
        ("RC_FS_TIMEOUT", 5.0, "would notice the companion's silence after 5 s: set RC_FS_TIMEOUT to 0.5"),
        ("MAV_GCS_SYSID", 42.0, "output 9 is at 1520 µs, not 1760: SERVO9_FUNCTION should be 148, MAV_GCS_SYSID 255"),
        ("SERVO9_FUNCTION", 70.0, "output 9 is at 0 µs"),
    ],
)
def test_a_board_that_is_set_otherwise_is_complained_of_with_the_remedy(
    parameter: str, value: float, text: str
) -> None:
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


@pytest.mark.parametrize("method", ["override", "do_set_servo"])
def test_a_transmitter_is_heard_only_where_its_loss_would_be(method: str) -> None:
    bench = Bench(method=method, unguarded=True)
    bench.board.rc_us = (1500,) * 16
    bench.run(2.0)
    received = [reading for reading in bench.readings if isinstance(reading, RcInput)]
    assert bool(received) is (method == "do_set_servo")
    bench.readings.clear()
    bench.faults.active = frozenset({"rc_lost"})
    bench.run(2.0)
    assert all(reading.lost for reading in [reading for reading in bench.readings if isinstance(reading, RcInput)][-1:])


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


def test_messages_of_the_boards_own_dialect_are_not_noise() -> None:
    bench = Bench()
    number, payload = 11039, bytes(range(1, 200))  # of ardupilotmega.xml
    head = struct.pack("<BBBBBBBHB", 0xFD, len(payload), 0, 0, 0, 1, 1, number & 0xFFFF, number >> 16)
    for _ in range(100):
        bench.stream.device.send((head + payload + b"\x12\x34") * 5, bench.now_s)
        bench.run(0.05)
        assert "wrong baud rate" not in bench.text
    assert bench.text == ""


def test_whatever_a_board_says_in_sound_frames_the_bridge_goes_on() -> None:
    """Random payloads with the right checksum, of every message that the bridge reads."""
    bench, rng = Bench(), random.Random(6)
    bench.run(2.0)
    kinds = [mavlink.mavlink_map[number] for number in (0, 1, 22, 36, 65, 77, 251, 252)]
    for _ in range(400):
        kind = rng.choice(kinds)
        payload = bytearray(rng.randbytes(kind.unpacker.size))
        if kind.id in (22, 251, 252) and rng.random() < 0.7:
            name = rng.choice((b"RC_OVERRIDE_TIME", b"SERVO_RC_FS_MSK\0", b"leak" + b"\0" * 12))[
                : 16 if kind.id == 22 else 10
            ]
            payload[8 : 8 + len(name)] = name
            payload[0 if kind.id == 22 else 4 : 4 if kind.id == 22 else 8] = struct.pack(
                "<f", rng.choice((math.nan, math.inf, -math.inf, 1e30, -5.0, 0.5))
            )
        bench.stream.device.send(frame(Packed(kind.id, bytes((kind.crc_extra,)), bytes(payload)), 0, 1, 1), bench.now_s)
        bench.run(0.05)
        assert isinstance(bench.text, str)
    for reading in bench.readings:
        if isinstance(reading, ThrusterFeedback):
            assert -1.0 <= reading.throttle <= 1.0 and (
                reading.azimuth_rad is None or abs(reading.azimuth_rad) <= math.pi
            )
        elif isinstance(reading, Battery):
            assert 0.0 < reading.voltage_v < 65.6 and (reading.remaining is None or 0.0 <= reading.remaining <= 1.0)
    bench.run(12.0)
    assert bench.text == ""


def test_a_pause_of_our_own_is_not_the_boards_fault() -> None:
    bench = Bench()
    bench.run(4.0)
    assert bench.text == ""
    bench.run(3.0, armed=None)
    bench.board.listen(bench.now_s)
    for _ in range(40):
        bench.run(0.05)
        assert bench.text == "", "it has let go meanwhile, and takes the pulses up again"
    bench.board.parameters["MAV_GCS_SYSID"] = 1.0
    bench.run(3.0)
    assert "output 9 is at" in bench.text


def test_a_deaf_board_is_not_taken_for_well_because_both_stand_still() -> None:
    fixed = tuple(replace(one, kind="fixed") for one in VESSEL.thrusters)
    bench = Bench(vessel=replace(VESSEL, thrusters=fixed), azimuth_channels=(0, 0))
    bench.run(4.0)
    bench.faults.add(parse("mcu_deaf@4+12", bench.vessel))
    bench.faults.update(bench.now_s)
    bench.run(2.5)
    assert "output" in bench.text
    bench.run(3.0, armed=False)
    assert "does not answer" in bench.text
    bench.faults.update(20.0)
    bench.run(12.0, armed=False)
    assert bench.text == ""


def test_currents_of_motor_controllers_belong_to_their_channels() -> None:
    metered = replace(VESSEL, thrusters=(replace(VESSEL.thrusters[0], full_a=40.0), VESSEL.thrusters[1]))
    bench = Bench(vessel=metered)
    bench.run(3.0)
    bench.thrusters[0].step(0.05)  # it has no lag
    bench.run(1.0)
    reports = [reading for reading in bench.readings if isinstance(reading, ThrusterFeedback)]
    newest = {report.index: report.current_a for report in reports}
    assert newest == {0: pytest.approx(40.0 * 0.5**3, abs=0.1), 1: None}
    asked = {round(m.param1) for m in bench.sent if m.get_type() == "COMMAND_LONG" and m.command == 511}
    assert 11032 in asked and not asked & {11030, 11031, 11040}, "channels 9 to 12 alone"
    bench.board.esc_telemetry = False
    bench.run(1.0)
    assert bench.readings[-1].current_a is None, "old currents are none"  # type: ignore[attr-defined]


def test_a_board_is_not_asked_for_currents_that_no_thruster_needs() -> None:
    bench = Bench()
    bench.run(2.0)
    asked = {round(m.param1) for m in bench.sent if m.get_type() == "COMMAND_LONG" and m.command == 511}
    assert not asked & {11030, 11031, 11032, 11040}


def test_without_its_table_it_is_refused() -> None:
    with pytest.raises(ConfigError, match=r"needs a table \[actuator.mavlink\]"):
        open_actuator(replace(bridge_config(), mavlink=None), VESSEL, MemoryStream("pixhawk"))


# --- the board, as ArduPilot is -----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("settings", "left_us"),
    [
        ({}, 1520.0),
        ({"SERVO_RC_FS_MSK": 0.0}, 1760.0),  # for ever
        ({"FS_THR_ENABLE": 0.0}, 1760.0),
    ],
)
def test_without_a_receiver_the_boards_failsafe_frees_the_outputs_if_it_is_set_to(
    settings: dict[str, float], left_us: float
) -> None:
    bench = Bench()
    bench.board.parameters.update(
        {"RC_OVERRIDE_TIME": 3.0, "RC_FS_TIMEOUT": 1.0, **settings}
    )  # but for `settings` as it comes
    bench.run(2.0)
    bench.run(0.9, armed=None)
    assert bench.board.pulses_us[9] == 1760.0
    bench.run(0.2, armed=None)
    assert bench.board.pulses_us[9] == left_us
    bench.run(9.0, armed=None)
    assert bench.board.pulses_us[9] == left_us


def test_with_a_receiver_an_override_lasts_for_three_seconds_as_it_comes() -> None:
    bench = Bench()
    bench.board.rc_us = (1500,) * 8 + (1400,) * 8
    bench.board.parameters["RC_OVERRIDE_TIME"] = 3.0
    bench.run(2.0)
    bench.run(2.9, armed=None)
    assert bench.board.pulses_us[9] == 1760.0
    bench.run(0.2, armed=None)
    assert bench.board.pulses_us[9] == 1400.0


def test_a_channel_that_the_receiver_lacks_is_full_astern_and_that_is_said_before() -> None:
    bench = Bench()
    bench.board.rc_us = (1500,) * 8
    bench.run(3.0)
    assert "has 8 channels and lacks 10" in bench.text
    bench.run(0.6, armed=None)
    assert bench.board.pulses_us[9] == 1000.0


def test_a_receiver_gets_the_channels_when_the_companion_falls_silent() -> None:
    bench = Bench()
    bench.board.rc_us = (1500,) * 8 + (1400,) * 8
    bench.run(2.0)
    assert bench.board.pulses_us[9] == 1760.0
    bench.run(0.6, armed=None)
    assert bench.board.pulses_us[9] == 1400.0


# --- servos, relays, lamps ----------------------------------------------------------------------------------------


class Equipped(Bench):
    """With a winch on channel 13, a pump on relay 3, and the beacon on relays 0 to 2."""

    def __init__(self, **board: object) -> None:
        wiring = {"servo_channels": (13,), "relays": (3,), "lamps": (0, 1, 2), "unguarded": True, **board}
        super().__init__(**wiring)
        self.vessel = replace(
            self.vessel,
            servos=(ServoConfig("winch", rest_us=1500.0 if self.config.mavlink.method == "override" else None),),
            relays=(RelayConfig("pump"),),
        )
        self.driver = open_actuator(replace(self.config, servos=("winch",), relays=("pump",)), self.vessel, self.stream)

    def do(self, seconds: float, auxiliary: Auxiliary, beacon: Beacon = DARK) -> list[list[bool]]:
        """What its relays did meanwhile."""
        seen = []
        for _ in range(round(seconds * 20)):
            self.run(0.05, armed=None)
            self.driver.read(self.now_s)
            self.driver.write(ActuatorCommand(self.now_s, True, HALF, auxiliary=auxiliary, beacon=beacon), self.now_s)
            seen.append(list(self.board.relays[:4]))
        return seen


@pytest.mark.parametrize("method", ["override", "do_set_servo"])
def test_servos_relays_and_lamps_on_it_obey(method: str) -> None:
    bench = Equipped(method=method)
    seen = bench.do(10.0, Auxiliary((1900.0,), (True,)), Beacon(Light.STEADY, Light.OFF, Light.BLINK))[40:]
    assert bench.text == "" and bench.board.pulses_us[13] == 1900.0
    assert {(red, yellow, pump) for red, yellow, _, pump in seen} == {(True, False, True)}
    assert sum(green for _, _, green, _ in seen) == pytest.approx(len(seen) / 2, abs=3)
    assert sum(a[2] is not b[2] for a, b in pairwise(seen)) == pytest.approx(16, abs=1)
    bench.do(0.2, Auxiliary())  # no demand: at rest
    assert bench.board.relays == [False] * 6
    assert bench.board.pulses_us[13] == (1500.0 if method == "override" else 0.0)
    bench.do(0.2, Auxiliary((1200.0,), (True,)), Beacon(Light.STEADY))
    bench.driver.close()
    bench.run(0.1, armed=None)
    assert bench.board.relays == [False] * 6


def test_a_relay_is_ordered_when_it_changes_and_once_a_second() -> None:
    bench = Equipped()
    bench.do(10.0, Auxiliary((None,), (True,)))
    orders = [
        message.param1 for message in bench.sent if getattr(message, "command", 0) == mavlink.MAV_CMD_DO_SET_RELAY
    ]
    assert {number: orders.count(float(number)) for number in range(4)} == pytest.approx(
        dict.fromkeys(range(4), 10), abs=1
    )


def test_a_relay_that_the_board_does_not_have_is_named() -> None:
    bench = Equipped(relays=(9,))
    bench.do(3.0, Auxiliary((None,), (True,)))
    assert "refuses DO_SET_RELAY" in bench.text
