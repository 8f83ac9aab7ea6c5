"""Settings of the bridge `nmea2000`: electric thrusters on an NMEA 2000 network."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from pydantic import Field

from companion.config.actuators.parts import part_problems
from companion.config.devices import ActuatorConfig
from companion.config.fields import STRICT, Name, means
from companion.config.kinds import Equipment, Place, Problem


@dataclass(frozen=True, slots=True)
class MotorConfig:
    """A thruster on an NMEA 2000 network."""

    __pydantic_config__ = STRICT
    thruster: Annotated[Name, means("Thruster that this motor drives.")]
    instance: Annotated[int, Field(ge=0, le=252), means("Instance that its messages carry.")]
    sensor_instance: Annotated[
        int | None,
        Field(ge=0, le=252),
        means("Instance of its angle sensor. Left out: the same."),
    ] = None


@dataclass(frozen=True, slots=True)
class Nmea2000Config(ActuatorConfig):
    """A network of electric thrusters, each known by its instance."""

    motors: Annotated[
        tuple[MotorConfig, ...],
        Field(alias="motor"),
        means("Motors on the network: one for each thruster."),
    ] = ()


def nmea2000_problems(bridge: Nmea2000Config, at: Place, equipment: Equipment) -> list[Problem]:
    """What must be true beside the types: one motor for each thruster, none that retracts."""
    motors = [(motor.thruster, "instance", motor.instance) for motor in bridge.motors]
    retractable = [one.name for one in equipment.thrusters if one.retractable and one.name in bridge.thrusters]
    return part_problems(bridge, at, "motor", motors) + [
        ((*at, "thrusters"), f"'{name}' is retractable, which this bridge cannot move") for name in retractable
    ]
