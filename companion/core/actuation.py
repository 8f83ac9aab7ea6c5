"""What passes between the vessel and its thrusters: commands and lamps out, feedback and condition back. `core.types` offers these names too."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntEnum

from companion.core.auxiliary import NO_AUXILIARY, Auxiliary
from companion.core.records import quick


@quick
@dataclass(frozen=True, slots=True)
class ThrusterCommand:
    """Demand on one thruster. `throttle` −1…1 follows from `force_n` by the thruster's curve; azimuth None where it is fixed."""

    force_n: float
    throttle: float
    azimuth_rad: float | None


class Light(IntEnum):
    """State of one lamp of the beacon."""

    OFF = 0
    STEADY = 1
    BLINK = 2


@dataclass(frozen=True, slots=True)
class Beacon:
    """The lamps that tell people on the shore what the boat is about."""

    red: Light = Light.OFF
    yellow: Light = Light.OFF
    green: Light = Light.OFF


DARK = Beacon()


@dataclass(frozen=True, slots=True)
class ActuatorCommand:
    """What goes to the bridges, after the last gate. `armed` False: bridges drive neutral whatever the rest says.

    `lower`: retractable thrusters go down, or up; None: they stay where they are.
    """

    t_s: float
    armed: bool
    thrusters: tuple[ThrusterCommand, ...]
    gated: tuple[str, ...] = ()  # names of the limits that changed the demand
    lower: bool | None = None
    beacon: Beacon = DARK
    auxiliary: Auxiliary = NO_AUXILIARY


class Deployment(IntEnum):
    """Where a retractable thruster stands."""

    RETRACTED = 1
    MOVING = 2
    LOWERED = 3


@quick
@dataclass(frozen=True, slots=True)
class ThrusterFeedback:
    """What one thruster really does, as its bridge reports it. None: not measured, or not this bridge's; `deployment`: or it does not retract."""

    t_s: float
    source: str
    index: int
    throttle: float | None  # −1…1
    azimuth_rad: float | None
    ok: bool = True
    deployment: Deployment | None = None


class Condition(Enum):
    """What may be expected of one thruster. Only a ready one is allocated."""

    READY = "ready"
    RETRACTED = "retracted"
    MOVING = "moving"  # between up and down
    FAILED = "failed"  # reported by its board, or by what it does against what it is told
