"""Values of the steps control, allocate, gate and act: the wrench, the thruster demands, the other outputs, and what
the bridges report back."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from companion.core.named import Named


@dataclass(frozen=True, slots=True)
class Wrench:
    """Force and moment on the hull in body axes (x forward, y starboard, z down)."""

    surge_n: float
    sway_n: float
    yaw_nm: float


ZERO_WRENCH = Wrench(0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class ThrusterCommand:
    """Demand on one thruster. `throttle` (−1…1) gives `force_n` by the thruster's curve. `azimuth_rad`: the direction
    in which it pushes the boat, clockwise from the bow; None for a fixed thruster."""

    force_n: float
    throttle: float
    azimuth_rad: float | None


@dataclass(frozen=True, slots=True)
class Allocation:
    """Thruster demands, in the order of the vessel's file, and the wrench that they give. `limited`: whether surge,
    sway and yaw fall short of the demand."""

    thrusters: tuple[ThrusterCommand, ...]
    achieved: Wrench
    limited: tuple[bool, bool, bool]


class Light(IntEnum):
    """State of one lamp of the beacon."""

    OFF = 0
    STEADY = 1
    BLINK = 2


@dataclass(frozen=True, slots=True)
class Beacon:
    """The lamps that show people ashore what the boat is doing."""

    red: Light = Light.OFF
    yellow: Light = Light.OFF
    green: Light = Light.OFF


DARK = Beacon()


@dataclass(frozen=True, slots=True)
class Auxiliary:
    """Outputs beside the thrusters, in the order of the vessel's file: pulse widths of the servos (None: no pulses),
    and which relays are on."""

    servos_us: tuple[float | None, ...] = ()
    relays: tuple[bool, ...] = ()


NO_AUXILIARY = Auxiliary()


@dataclass(frozen=True, slots=True)
class ActuatorCommand:
    """What goes to the bridges, after the last gate. While `armed` is False the bridges drive neutral, whatever the
    other fields hold.

    `lower`: True lowers the retractable thrusters, False retracts them, None leaves them where they are.
    """

    t_s: float
    armed: bool
    thrusters: tuple[ThrusterCommand, ...]
    gated: tuple[str, ...] = ()  # names of the limits that changed the demand
    lower: bool | None = None
    beacon: Beacon = DARK
    auxiliary: Auxiliary = NO_AUXILIARY

    def lit(self, beacon: Beacon) -> ActuatorCommand:
        """With other lamps. `dataclasses.replace` looks all fields up by name, which is much for each tick."""
        return ActuatorCommand(self.t_s, self.armed, self.thrusters, self.gated, self.lower, beacon, self.auxiliary)


class Deployment(IntEnum):
    """Position of a retractable thruster."""

    RETRACTED = 1
    MOVING = 2
    LOWERED = 3


@dataclass(frozen=True, slots=True)
class ThrusterFeedback:
    """What one thruster does, as measured and reported by its bridge.

    None: the bridge does not measure it. `index` counts from 0 in the order of the vessel's file. `deployment` is None
    too for a thruster that does not retract. `current_a`: what its motor draws from the supply.
    """

    t_s: float
    source: str
    index: int
    throttle: float | None  # −1…1
    azimuth_rad: float | None
    ok: bool = True
    deployment: Deployment | None = None
    current_a: float | None = None


class ThrusterCondition(Named):
    """Whether a thruster can be used. The allocation uses only those that are ready."""

    READY = "ready"
    RETRACTED = "retracted"
    MOVING = "moving"  # between retracted and lowered
    FAILED = "failed"  # as its board reports, or because it does not follow its command
