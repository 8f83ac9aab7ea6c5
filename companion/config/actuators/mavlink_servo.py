"""Settings of the bridge `mavlink_servo`: an autopilot board whose servo outputs drive the thrusters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Literal

from pydantic import Field

from companion.config.devices import ActuatorConfig, ThrusterConfig
from companion.config.driving import azimuths_of
from companion.config.fields import STRICT, means
from companion.config.kinds import Equipment, Place, Problem

_Relay = Annotated[int, Field(ge=0, le=15)]


@dataclass(frozen=True, slots=True)
class MavlinkBoardConfig:
    """The outputs of an autopilot board.

    Servos and relays stay as they are when the companion is silent, except for servos by override.
    """

    __pydantic_config__ = STRICT
    channels: Annotated[
        tuple[Annotated[int, Field(ge=1, le=16)], ...],
        means("Output channel of each of the bridge's thrusters, in their order."),
    ]
    azimuth_channels: Annotated[
        tuple[Annotated[int, Field(ge=0, le=16)], ...],
        means("Channel of each thruster's azimuth servo, in the order of the thrusters. 0: it does not turn."),
    ] = ()
    servo_channels: Annotated[
        tuple[Annotated[int, Field(ge=1, le=16)], ...],
        means("Channel of each of the bridge's servos."),
    ] = ()
    relays: Annotated[tuple[_Relay, ...], means("Relay of the board for each of the bridge's relays, from 0.")] = ()
    lamps: Annotated[
        tuple[_Relay, ...],
        Field(max_length=3),
        means("Relays of the beacon's red, yellow and green."),
    ] = ()
    method: Annotated[
        Literal["override", "do_set_servo"],
        means(
            "`override`: RC_CHANNELS_OVERRIDE; the board lets go of the channels when the companion is "
            "silent. `do_set_servo`: the board keeps its last pulses for ever."
        ),
    ] = "override"
    unguarded: Annotated[
        bool,
        means("Needed for `do_set_servo`: the owner knows it, and something else stops the thrusters."),
    ] = False
    system: Annotated[
        int,
        Field(ge=1, le=255),
        means("System id from which the board takes orders (MAV_GCS_SYSID of ArduPilot)."),
    ] = 255

    def with_another_relay(self) -> MavlinkBoardConfig:
        """The same with the first free relay of the board for one more of the bridge's."""
        taken = {*self.relays, *self.lamps}
        return replace(self, relays=(*self.relays, next(number for number in range(16) if number not in taken)))


@dataclass(frozen=True, slots=True)
class MavlinkServoConfig(ActuatorConfig):
    """An autopilot board, such as a Pixhawk with ArduPilot."""

    mavlink: Annotated[MavlinkBoardConfig | None, means("Outputs of the board.")] = None


def mavlink_servo_problems(bridge: MavlinkServoConfig, at: Place, equipment: Equipment) -> list[Problem]:
    """What must be true beside the types: a channel for each output, none twice, and outputs that stop in silence."""
    board = bridge.mavlink
    if board is None:
        return [((*at, "driver"), "needs a table [actuator.mavlink] with the channels")]
    indices = azimuths_of(bridge, equipment.thrusters, equipment.bridges)
    turned = {equipment.thrusters[k].name for k in indices}
    by_name = {thruster.name: thruster for thruster in equipment.thrusters}
    driven = [by_name[name] for name in bridge.thrusters if name in by_name]
    found = [
        *_channel_problems(bridge, board, [thruster.name in turned for thruster in driven]),
        *_twice(board),
        *_thruster_problems(driven, turned),
        *_silence_problems(board),
    ]
    return [((*at, *place), text) for place, text in found] + _pulse_problems(bridge, board, equipment)


def _channel_problems(bridge: MavlinkServoConfig, board: MavlinkBoardConfig, turns: Sequence[bool]) -> list[Problem]:
    """One channel or relay for each output. `turns`: whether the bridge turns each of its thrusters."""
    problems: list[Problem] = []
    if len(board.channels) != len(bridge.thrusters):
        text = f"needs {len(bridge.thrusters)} channels, one for each of the bridge's thrusters"
        problems.append((("mavlink", "channels"), text))
    problems += [
        (("azimuths",), f"'{name}' is not among its thrusters")
        for name in bridge.azimuths
        if name not in bridge.thrusters
    ]
    if [channel > 0 for channel in board.azimuth_channels or (0,) * len(turns)] != turns:
        text = "needs one for each of the bridge's thrusters, 0 for those that it does not turn"
        problems.append((("mavlink", "azimuth_channels"), text))
    outputs = (
        ("servo_channels", "servos", board.servo_channels, bridge.servos),
        ("relays", "relays", board.relays, bridge.relays),
    )
    for key, what, numbers, names in outputs:
        if len(numbers) != len(names):
            problems.append((("mavlink", key), f"needs {len(names)}, one for each of the bridge's {what}"))
    return problems


def _twice(board: MavlinkBoardConfig) -> list[Problem]:
    channels = [channel for channel in (*board.channels, *board.azimuth_channels, *board.servo_channels) if channel]
    problems: list[Problem] = []
    for key, what, numbers in (("relays", "relay", [*board.relays, *board.lamps]), ("channels", "channel", channels)):
        problems += [
            (("mavlink", key), f"{what} {number} is used twice")
            for number in sorted({number for number in numbers if numbers.count(number) > 1})
        ]
    return problems


def _thruster_problems(driven: Sequence[ThrusterConfig], turned: set[str]) -> list[Problem]:
    problems: list[Problem] = []
    for thruster in driven:
        if thruster.name in turned and (thruster.azimuth_min_rad is None or thruster.azimuth_max_rad is None):
            text = f"a servo turns '{thruster.name}' between stops: give it azimuth_min_deg and azimuth_max_deg"
            problems.append((("mavlink", "azimuth_channels"), text))
        if thruster.retractable:
            problems.append((("thrusters",), f"'{thruster.name}' is retractable, which this bridge cannot move"))
    return problems


def _silence_problems(board: MavlinkBoardConfig) -> list[Problem]:
    """Outputs that stay on when the companion is silent need an owner who says that it is safe."""
    if board.unguarded:
        return []
    problems: list[Problem] = []
    if board.relays:
        text = (
            "the board leaves its relays as they are when the companion is silent: "
            "set unguarded = true if that hurts nobody"
        )
        problems.append((("mavlink", "relays"), text))
    if board.method == "do_set_servo":
        text = (
            "with DO_SET_SERVO the board holds its last pulses when the companion is silent: "
            "use 'override', or set unguarded = true"
        )
        problems.append((("mavlink", "method"), text))
    return problems


def _pulse_problems(bridge: MavlinkServoConfig, board: MavlinkBoardConfig, equipment: Equipment) -> list[Problem]:
    """An overridden channel always has pulses, so its servo needs a pulse at rest."""
    if board.method != "override":
        return []
    return [
        (("servo", j, "name"), "an overridden channel cannot be without pulses: give it rest_us")
        for j, servo in enumerate(equipment.servos)
        if servo.name in bridge.servos and servo.rest_us is None
    ]
