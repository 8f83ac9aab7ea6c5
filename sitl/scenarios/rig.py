"""What a scenario stands on: a composed vessel in lockstep. The command line composes it; scenarios know only this face."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from companion.config import HullConfig, ThrusterConfig, VesselConfig
from sitl.tow import Leg
from sitl.waters import OtherBoat
from sitl.world import World


class Rig(Protocol):
    """A vessel, its plant and a clock that moves when told to. One MAVLink link ends here, in bytes."""

    @property
    def config(self) -> VesselConfig: ...

    @property
    def conditions(self) -> Conditions: ...

    @property
    def world(self) -> World: ...

    @property
    def now_s(self) -> float: ...

    def step(self) -> None:
        """One tick of the vessel."""
        ...

    def send(self, data: bytes) -> None:
        """Bytes from the ground station to the vessel."""
        ...

    def hear(self, data: bytes, at_s: float) -> None:
        """Bytes that reach the vessel between two ticks, at that time and not before the last ones; it takes them in at once."""
        ...

    def receive(self) -> bytes:
        """Bytes from the vessel to the ground station since the last call."""
        ...

    def identify(self) -> Believed:
        """What the companion identifies from the log of this rig, which it closes; written into the log's folder too."""
        ...

    def again(self, believed: Believed, folder: str) -> Rig:
        """A new rig in the same conditions, whose controller believes in another hull. It logs into `folder` under this rig's own."""
        ...

    def beside(self, conditions: Conditions, folder: str) -> Rig:
        """Another vessel in the same waters: it sees the same boats, which move once. Step both in turn; it logs into `folder` under this rig's own."""
        ...

    def close(self) -> None: ...


@dataclass(frozen=True, slots=True)
class Believed:
    """A hull and thrusters that a controller believes in, whatever the plant is."""

    hull: HullConfig
    thrusters: tuple[ThrusterConfig, ...] | None = None  # None: as the vessel's file says


@dataclass(frozen=True, slots=True)
class Conditions:
    """What a scenario asks of its world and its controller."""

    vessel: str
    seed: int = 0
    wind: str | None = None
    current: str | None = None
    gnss: str = "rtk"
    waves_m: float = 0.0
    model_error: float = 0.0
    plant: str | None = None
    plant_error: float = 0.0  # of a jet boat's mass, thrust, nozzle and drag, up or down by the seed
    hull: str | Believed | None = None  # what the controller believes: the hull of the plant of that name, or this; None: the vessel's own
    push_ned_n: tuple[float, float] = (0.0, 0.0)
    wind_sensor: bool = False  # a wind sensor aboard, on a vessel without one
    ais: bool = False  # an AIS receiver aboard, on a vessel without one
    rotating: tuple[str, ...] = ()  # fixed thrusters that turn in this run
    faults: tuple[str, ...] = ()
    magnetometer: str = ""  # heading by the inertial sensor's raw magnetometer alone: "calibrated", or "raw" for a controller that does not know the iron
    tow: tuple[Leg, ...] = ()  # the boat is led along these, whatever its thrusters do
    parameters: Mapping[str, float] = field(default_factory=dict)
    start: tuple[float, float, float] | None = None  # north and east of home in m, heading in rad; None: at home
    others: tuple[OtherBoat, ...] = ()  # lead boats in the same waters
    gnss_common: float = 0.0  # share of the slow position error that all receivers have alike


class Composer(Protocol):
    """Builds a rig that records into `folder`."""

    def __call__(self, conditions: Conditions, folder: Path) -> Rig: ...
