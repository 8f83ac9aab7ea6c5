"""What the world needs of an emulated device, and what the devices can measure of the world."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol, runtime_checkable

from companion.config.vessel import HomeConfig
from sitl.environment import Waves, WindModel
from sitl.faults import Faults
from sitl.hull import Hull
from sitl.obstacles import Obstacles
from sitl.sensor_errors import Aboard
from sitl.sensors import CommonWander
from sitl.traffic import Traffic


class Device(Protocol):
    """One emulated device on its port. The world calls `speak` `rate_hz` times a second."""

    name: str
    rate_hz: float

    def speak(self, t_s: float) -> None:
        """Measure now, and send."""
        ...


@runtime_checkable
class RcReceiver(Protocol):
    """A device that hears a transmitter. `rc_us`: pulses of its channels; None: it is off."""

    rc_us: Sequence[int] | None


class Board(Device, Protocol):
    """An emulated board that drives thrusters. `rc_us`: pulses of a transmitter's channels; None without an RC
    receiver."""

    rc_us: Sequence[int] | None

    def listen(self, t_s: float) -> None:
        """Handle what has arrived by `t_s`, and the board's own time-outs."""
        ...


@dataclass(frozen=True, slots=True)
class SensedWorld:
    """What the sensors aboard can measure, and the conditions of the run."""

    hull: Hull
    waves: Waves
    wind: WindModel
    faults: Faults
    home: HomeConfig
    gnss: str  # grade of the receivers
    seed: int
    epoch_unix_ns: int
    step_hz: float  # no device sends more often than the world steps
    common: CommonWander | None = None  # the error that all receivers share
    aboard: Aboard | None = None  # what disturbs them aboard; None: nothing
    traffic: Traffic = field(default_factory=Traffic)
    obstacles: Obstacles = field(default_factory=Obstacles)
    boards: frozenset[str] = frozenset()  # ports of the autopilots that drive thrusters
