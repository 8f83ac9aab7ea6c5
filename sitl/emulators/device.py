"""What an emulated device is to the world, and what of the world it can feel."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

from companion.config import HomeConfig
from sitl.environment import Waves, Wind
from sitl.faults import Faults
from sitl.hull import Hull
from sitl.sensors import CommonWander
from sitl.traffic import Traffic


class Device(Protocol):
    """One emulated device on its port. `rate_hz` is how often it speaks."""

    name: str
    rate_hz: float

    def speak(self, t_s: float) -> None:
        """Measure now, and send."""
        ...


class Board(Device, Protocol):
    """An emulated board that drives thrusters. `rc_us`: pulses of a transmitter's channels, None where there is no receiver."""

    rc_us: Sequence[int] | None

    def listen(self, t_s: float) -> None:
        """Take what has arrived by `t_s`, and mind its own time-outs."""
        ...


@dataclass(frozen=True, slots=True)
class Surroundings:
    """What sensors on board measure, and the conditions of the run."""

    hull: Hull
    waves: Waves
    wind: Wind
    faults: Faults
    home: HomeConfig
    gnss: str  # grade of the receivers
    seed: int
    epoch_unix_ns: int
    step_hz: float  # no device speaks faster than the world steps
    common: CommonWander | None = None  # of the receivers' errors
    traffic: Traffic = field(default_factory=Traffic)
