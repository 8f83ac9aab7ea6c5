"""Settings of the bridge `nanotec`: stepper drives on an RS485 line that turn azimuths."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from companion.config.actuators.parts import part_problems
from companion.config.devices import ActuatorConfig, ThrusterConfig
from companion.config.fields import FROM_DEGREES, FROM_DEGREES_OR_NONE, STRICT, Name, means
from companion.config.kinds import Equipment, Place, Problem

_MOST_HZ, _MOST_HZPS = 1_000_000, 3_000_000


@dataclass(frozen=True, slots=True)
class StepperConfig:
    """The stepper drive that turns the azimuth of one thruster: its address on the bus and how its steps make an angle.

    `[thruster.output]` says what the angle that it shows is of the thruster's azimuth.
    """

    __pydantic_config__ = STRICT
    thruster: Annotated[Name, means("Thruster whose azimuth this drive turns.")]
    address: Annotated[int, Field(ge=1, le=254), means("Address of the drive on the RS485 line.")]
    steps_per_turn: Annotated[
        float,
        Field(ge=20.0, le=10_000_000.0),
        means("Steps in one turn of the thruster, with belts, gears and `step_mode`."),
    ]
    step_mode: Annotated[Literal[1, 2, 4, 5, 8, 10, 16, 32, 64], means("Microsteps in a full step.")] = 8
    speed_radps: Annotated[
        float | None,
        Field(alias="speed_dps", gt=0.0),
        FROM_DEGREES_OR_NONE,
        means("Speed of the thruster's turn. Left out: as fast as `azimuth_rate_dps` of the thruster."),
    ] = None
    ramp_radps2: Annotated[
        float,
        Field(alias="ramp_dps2", gt=0.0),
        FROM_DEGREES,
        means("Acceleration of the thruster's turn."),
    ] = math.radians(1500.0)
    homing: Annotated[
        Literal["here", "switch"],
        means(
            "Where the angle is zero. `here`: where the drive stands at power-up. `switch`: at its reference "
            "switch, to which it turns slowly at the start."
        ),
    ] = "here"
    homing_radps: Annotated[
        float,
        Field(alias="homing_dps", gt=0.0),
        FROM_DEGREES,
        means("Speed of the turn to the reference switch."),
    ] = math.radians(20.0)

    def frequency(self, radps: float) -> int:
        """Steps a second for a speed of the thruster's turn; steps a second squared for an acceleration."""
        return round(radps * self.steps_per_turn / math.tau)

    def turning_radps(self, thruster: ThrusterConfig) -> float:
        """Speed of that thruster's turn."""
        return thruster.azimuth_rate_radps if self.speed_radps is None else self.speed_radps


@dataclass(frozen=True, slots=True)
class NanotecConfig(ActuatorConfig):
    """A line of stepper drives, each of which turns the azimuth of one thruster."""

    drives: Annotated[
        tuple[StepperConfig, ...],
        Field(alias="drive"),
        means("Stepper drives: one for each azimuth."),
    ] = ()

    @property
    def starts_in_s(self) -> float:
        """One turn of the slowest drive that homes to a switch."""
        return max((math.tau / drive.homing_radps for drive in self.drives if drive.homing == "switch"), default=0.0)


def nanotec_problems(bridge: NanotecConfig, at: Place, equipment: Equipment) -> list[Problem]:
    """What must be true beside the types: one drive for each azimuth, no throttle."""
    drives = [(drive.thruster, "address", drive.address) for drive in bridge.drives]
    problems = part_problems(bridge, at, "drive", drives)
    by_name = {thruster.name: thruster for thruster in equipment.thrusters}
    for k, drive in enumerate(bridge.drives):
        if drive.thruster in by_name:
            found = frequency_problems(drive, by_name[drive.thruster])
            problems += [((*at, "drive", k, key), text) for key, text in found]
    if bridge.thrusters:
        text = "this bridge drives azimuths alone: name them in 'azimuths', and another bridge for the propellers"
        problems.append(((*at, "thrusters"), text))
    return problems


def frequency_problems(drive: StepperConfig, thruster: ThrusterConfig) -> list[tuple[str, str]]:
    """Keys whose speeds and ramps the drive of that thruster does not have, with the reasons."""
    asked = (
        ("speed_dps", drive.turning_radps(thruster), _MOST_HZ),
        ("homing_dps", drive.homing_radps, _MOST_HZ),
        ("ramp_dps2", drive.ramp_radps2, _MOST_HZPS),
    )
    return [
        (key, f"makes {steps} steps a second, the drive takes 1 to {most}: check it, and steps_per_turn")
        for key, radps, most in asked
        if not 1 <= (steps := drive.frequency(radps)) <= most
    ]
