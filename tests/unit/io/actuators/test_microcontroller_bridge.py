"""The bridge to the board: commands out, readings in, and what its health says."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import pytest

from companion.config.devices import ActuatorConfig
from companion.config.outputs import RelayConfig, ServoConfig
from companion.config.vessel import ConfigError, VesselConfig, find, load
from companion.core.actuation import (
    ActuatorCommand,
    Auxiliary,
    Beacon,
    Deployment,
    Light,
    ThrusterCommand,
    ThrusterFeedback,
)
from companion.core.microcontroller_auxiliary import AuxiliaryDemand, AuxiliaryState
from companion.core.microcontroller_frame import (
    BoardCommand,
    BoardStatus,
    FrameDecoder,
    Ident,
    IdentRequest,
    ThrusterState,
    encode,
)
from companion.core.ports import Actuator
from companion.core.readings import Battery, Leak, RcInput
from companion.io.actuators import DRIVERS, open_actuator

VESSEL = load(find("revolt"))
BRIDGE = VESSEL.actuators[0]
STATUS = BoardStatus(
    sequence=1,
    neutral_by_watchdog=False,
    leak_wet=False,
    rc_present=True,
    rc_lost=False,
    voltage_v=12.5,
    current_a=3.25,
    remaining=0.5,
    rc_us=(1000, 1500, 2000, 1750, 900, 0, 0, 0),
    thrusters=(ThrusterState(0.1, 0.2), ThrusterState(0.3, 0.4), ThrusterState(0.5, None)),
)
FORWARD = (ThrusterCommand(10.0, 0.6, 0.1), ThrusterCommand(10.0, 0.7, -0.1), ThrusterCommand(1.0, 0.25, None))


class Wire:
    """A port whose other end is the test."""

    name = "wire"

    def __init__(self) -> None:
        self.incoming: list[tuple[float, bytes]] = []
        self.sent: list[bytes] = []
        self.trouble: str | None = None
        self.closed = False

    def read(self, now_s: float) -> list[tuple[float, bytes]]:
        taken, self.incoming = self.incoming, []
        return taken

    def write(self, data: bytes, now_s: float) -> None:
        self.sent.append(data)

    def fault(self) -> str | None:
        return self.trouble

    def fileno(self) -> int | None:
        return 5

    def close(self) -> None:
        self.closed = True

    def commands(self) -> list[BoardCommand]:
        messages = FrameDecoder().feed(b"".join(self.sent))
        return [message for message in messages if isinstance(message, BoardCommand)]


def bridge(config: ActuatorConfig = BRIDGE, vessel: VesselConfig = VESSEL) -> tuple[Actuator, Wire]:
    wire = Wire()
    return open_actuator(config, vessel, wire), wire


def heard(actuator: Actuator, wire: Wire, status: BoardStatus, t_s: float) -> list[object]:
    wire.incoming.append((t_s, encode(status)))
    return list(actuator.read(t_s))


def test_unknown_driver_names_the_known_ones() -> None:
    with pytest.raises(
        ConfigError, match=r"actuator 'microcontroller': no driver 'telepathy'; known: .*microcontroller"
    ):
        open_actuator(replace(BRIDGE, driver="telepathy"), VESSEL, Wire())
    assert "microcontroller" in DRIVERS


def test_unknown_thruster_is_refused() -> None:
    with pytest.raises(ConfigError, match="no thruster named 'keel'"):
        bridge(replace(BRIDGE, thrusters=("keel",)))


def test_armed_command_carries_throttle_and_azimuth() -> None:
    actuator, wire = bridge()
    actuator.write(ActuatorCommand(0.0, True, FORWARD), 0.0)
    (command,) = wire.commands()
    assert command.armed and command.lower is None
    assert [(each.throttle, each.azimuth_rad) for each in command.thrusters] == [(0.6, 0.1), (0.7, -0.1), (0.25, None)]


def test_disarmed_command_has_no_throttle() -> None:
    actuator, wire = bridge()
    actuator.write(ActuatorCommand(0.0, False, FORWARD), 0.0)
    (command,) = wire.commands()
    assert not command.armed
    assert [each.throttle for each in command.thrusters] == [0.0, 0.0, 0.0]


def test_sequence_counts_and_wraps() -> None:
    actuator, wire = bridge()
    for n in range(300):
        actuator.write(ActuatorCommand(0.1 * n, True, FORWARD), 0.1 * n)
    sequences = [command.sequence for command in wire.commands()]
    assert all((after - before) % 256 == 1 for before, after in pairwise(sequences))


def test_identity_is_asked_for_until_known() -> None:
    actuator, wire = bridge()
    for n in range(25):
        actuator.write(ActuatorCommand(0.1 * n, False, FORWARD), 0.1 * n)
    requests = [message for message in FrameDecoder().feed(b"".join(wire.sent)) if isinstance(message, IdentRequest)]
    assert len(requests) == 3
    wire.sent.clear()
    wire.incoming.append((2.5, encode(Ident((1, 4, 2), 3, "board"))))
    actuator.read(2.5)
    actuator.write(ActuatorCommand(9.0, False, FORWARD), 9.0)
    assert len(FrameDecoder().feed(b"".join(wire.sent))) == 1
    assert "board firmware 1.4.2" in actuator.health(9.0).text


def test_status_becomes_readings() -> None:
    actuator, wire = bridge()
    readings = heard(actuator, wire, STATUS, 3.0)
    assert Leak(3.0, "microcontroller", False) in readings
    assert Battery(3.0, "microcontroller", 12.5, 3.25, 0.5) in readings
    assert RcInput(3.0, "microcontroller", (-1.0, 0.0, 1.0, 0.5, -1.2), False) in readings
    feedback = [reading for reading in readings if isinstance(reading, ThrusterFeedback)]
    assert [(each.index, each.throttle, each.azimuth_rad) for each in feedback] == [
        (0, 0.1, 0.2),
        (1, 0.3, 0.4),
        (2, 0.5, None),
    ]


def test_feedback_index_is_the_vessels() -> None:
    actuator, wire = bridge(replace(BRIDGE, thrusters=("bow", "stern_port")))
    readings = heard(actuator, wire, replace(STATUS, thrusters=STATUS.thrusters[:2]), 0.0)
    assert [reading.index for reading in readings if isinstance(reading, ThrusterFeedback)] == [2, 0]
    actuator.write(ActuatorCommand(0.0, True, FORWARD), 0.0)
    assert [each.throttle for each in wire.commands()[0].thrusters] == [0.25, 0.6]


def test_what_is_not_measured_gives_no_reading() -> None:
    actuator, wire = bridge()
    readings = heard(actuator, wire, replace(STATUS, voltage_v=None, rc_present=False), 0.0)
    assert not any(isinstance(reading, Battery | RcInput) for reading in readings)


def test_newest_of_several_statuses_counts() -> None:
    actuator, wire = bridge()
    wire.incoming = [(1.0, encode(replace(STATUS, leak_wet=True))), (1.05, encode(STATUS))]
    leaks = [reading for reading in actuator.read(1.1) if isinstance(reading, Leak)]
    assert leaks == [Leak(1.05, "microcontroller", False)]


def test_health_over_a_life() -> None:
    actuator, wire = bridge()
    never = actuator.health(0.0)
    assert not never.ok and never.age_s is None and "power, cable" in never.text
    heard(actuator, wire, STATUS, 1.0)
    assert actuator.health(1.0 + BRIDGE.timeout_s).ok
    silent = actuator.health(1.0 + BRIDGE.timeout_s + 0.01)
    assert not silent.ok and "silent for 1.0 s" in silent.text
    heard(actuator, wire, STATUS, 5.0)
    assert actuator.health(5.0).ok
    wire.trouble = "serial:/dev/usv-mcu: no such device"
    assert actuator.health(5.0).text.startswith("serial:/dev/usv-mcu: no such device")


@pytest.mark.parametrize(
    ("status", "text"),
    [
        (replace(STATUS, neutral_by_watchdog=True), "TX"),
        (replace(STATUS, safe_mode=True), "safe-mode switch"),
        (replace(STATUS, thrusters=STATUS.thrusters[:2]), "drives 2 thrusters"),
    ],
)
def test_what_the_board_reports_is_said(status: BoardStatus, text: str) -> None:
    actuator, wire = bridge()
    for n in range(12):
        actuator.write(ActuatorCommand(0.1 * n, True, FORWARD), 0.1 * n)
    heard(actuator, wire, status, 1.1)
    health = actuator.health(1.1)
    assert not health.ok and text in health.text


def test_watchdog_before_the_first_commands_is_no_complaint() -> None:
    actuator, wire = bridge()
    heard(actuator, wire, replace(STATUS, neutral_by_watchdog=True), 0.1)
    actuator.write(ActuatorCommand(0.1, False, FORWARD), 0.1)
    assert actuator.health(0.2).ok


def test_wrong_language_is_told_from_silence() -> None:
    actuator, wire = bridge()
    wire.incoming.append((0.0, b"$GPGGA,nonsense*00\r\n" * 50))
    assert list(actuator.read(0.0)) == []
    assert "1,000 bytes and no valid frame: sentences of NMEA 0183 with wrong checksums" in actuator.health(0.0).text
    actuator, wire = bridge()
    wire.incoming.append((0.0, bytes((0x80, 0xF8, 0x98)) * 200))
    actuator.read(0.0)
    assert "wrong baud rate in" in actuator.health(0.0).text


def test_beacon_and_retraction_are_passed_on() -> None:
    actuator, wire = bridge()
    actuator.write(
        ActuatorCommand(0.0, False, FORWARD, lower=False, beacon=Beacon(Light.STEADY, Light.BLINK, Light.STEADY)), 0.0
    )
    (command,) = wire.commands()
    assert (command.red, command.yellow, command.green) == (Light.STEADY, Light.BLINK, Light.STEADY)
    assert command.lower is False


def test_where_a_retractable_thruster_stands_is_reported() -> None:
    actuator, wire = bridge()
    states = (*STATUS.thrusters[:2], ThrusterState(0.0, None, True, Deployment.MOVING))
    feedback = [
        reading
        for reading in heard(actuator, wire, replace(STATUS, thrusters=states), 0.1)
        if isinstance(reading, ThrusterFeedback)
    ]
    assert [each.deployment for each in feedback] == [None, None, Deployment.MOVING]


def test_the_port_is_passed_on() -> None:
    actuator, wire = bridge()
    assert actuator.fileno() == 5
    actuator.close()
    assert wire.closed


def test_servos_and_relays_of_this_bridge_are_sent_and_their_answer_is_minded() -> None:
    vessel = replace(
        VESSEL,
        servos=(ServoConfig("other"), ServoConfig("winch")),
        relays=(RelayConfig("lamp"), RelayConfig("pump"), RelayConfig("horn")),
    )
    wire = Wire()
    actuator = open_actuator(replace(BRIDGE, servos=("winch",), relays=("horn", "lamp")), vessel, wire)
    outputs = Auxiliary((1100.0, 1900.0), (True, False, False))
    for n in range(12):
        actuator.write(ActuatorCommand(0.1 * n, True, FORWARD, auxiliary=outputs), 0.1 * n)
    sent = [
        message for data in wire.sent for message in FrameDecoder().feed(data) if isinstance(message, AuxiliaryDemand)
    ]
    assert (
        len(sent) == 12
        and {message.servos_us for message in sent} == {(1900.0,)}
        and {message.relays for message in sent} == {(False, True)}
    )
    heard(actuator, wire, STATUS, 1.1)
    assert "does not report its servos and relays: update its firmware" in actuator.health(1.1).text
    wire.incoming.append((1.2, encode(STATUS) + encode(AuxiliaryState(12, (1900.0,), (False, True)))))
    actuator.read(1.2)
    assert actuator.health(1.2).ok
    wire.incoming.append((1.3, encode(STATUS) + encode(AuxiliaryState(12, (), (False,)))))
    actuator.read(1.3)
    assert "has 0 servos and 1 relays, the vessel's file gives it 1 and 2" in actuator.health(1.3).text


def test_without_a_demand_they_rest() -> None:
    wire = Wire()
    vessel = replace(VESSEL, servos=(ServoConfig("winch"),), relays=(RelayConfig("pump"),))
    actuator = open_actuator(replace(BRIDGE, servos=("winch",), relays=("pump",)), vessel, wire)
    actuator.write(ActuatorCommand(0.0, True, FORWARD), 0.0)
    sent = [
        message for data in wire.sent for message in FrameDecoder().feed(data) if isinstance(message, AuxiliaryDemand)
    ]
    assert [(message.servos_us, message.relays) for message in sent] == [((None,), (False,))]


def test_a_program_that_stood_still_does_not_blame_the_wire() -> None:
    actuator, wire = bridge()
    for n in range(12):
        actuator.write(ActuatorCommand(0.1 * n, True, FORWARD), 0.1 * n)
    heard(actuator, wire, replace(STATUS, neutral_by_watchdog=True), 4.1)  # of while no commands came
    assert actuator.health(4.1).ok
    for n in range(12):
        actuator.write(ActuatorCommand(4.1 + 0.1 * n, True, FORWARD), 4.1 + 0.1 * n)
    heard(actuator, wire, replace(STATUS, neutral_by_watchdog=True), 5.3)
    assert not actuator.health(5.3).ok, "and still blames it where commands do not arrive"
