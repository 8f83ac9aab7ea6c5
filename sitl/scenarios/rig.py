"""What a scenario runs on: a vessel and its world in lockstep. `companion.cli.rig` builds it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from companion.config.devices import ThrusterConfig
from companion.config.hull import HullConfig
from companion.config.vessel import VesselConfig
from sitl.shared_sea import LeadBoatConfig
from sitl.tow import TowLeg
from sitl.world import World


class Rig(Protocol):
    """A vessel, its world and a clock that moves when told to. One MAVLink link ends here, in bytes."""

    @property
    def config(self) -> VesselConfig:
        """The vessel's file, with the conditions' additions."""
        ...

    @property
    def conditions(self) -> Conditions:
        """As the rig was built."""
        ...

    @property
    def world(self) -> World:
        """The simulated boat."""
        ...

    @property
    def now_s(self) -> float:
        """The vessel's time."""
        ...

    def step(self) -> None:
        """One tick of the vessel."""
        ...

    def pause(self, duration_s: float) -> None:
        """The vessel's process stands still for that long; the world goes on."""
        ...

    def set_clock_ahead(self, by_s: float) -> None:
        """Step the host's clock."""
        ...

    def send(self, data: bytes) -> None:
        """Bytes from the ground station to the vessel."""
        ...

    def deliver(self, data: bytes, at_s: float) -> None:
        """Bytes that reach the vessel between two ticks, at `at_s` but not before the last ones. It handles them at
        once."""
        ...

    def receive(self) -> bytes:
        """Bytes from the vessel to the ground station since the last call."""
        ...

    def identify(self) -> ControllerModel:
        """Close this rig and identify the hull from its log. The result is also written into the log's folder."""
        ...

    def rerun_with(self, model: ControllerModel, folder: str) -> Rig:
        """A new rig in the same conditions whose controller uses `model`. It logs into `folder` below this rig's."""
        ...

    def second_vessel(self, conditions: Conditions, folder: str) -> Rig:
        """Another vessel in the same sea: both see the same lead boats. Step both in turn. It logs into `folder` below
        this rig's."""
        ...

    def close(self) -> None:
        """Close the vessel and its log."""
        ...


@dataclass(frozen=True, slots=True)
class ControllerModel:
    """The hull and thrusters that the controller uses, whatever the plant is."""

    hull: HullConfig
    thrusters: tuple[ThrusterConfig, ...] | None = None  # None: as the vessel's file says


@dataclass(frozen=True, slots=True)
class Conditions:
    """How the world and the controller of a scenario are set up. None means as the vessel's file says.

    `known`: the vessel as its controller knows it, in place of the file of `vessel`. `real`: the boat as it really is,
    where it differs.
    """

    vessel: str
    seed: int = 0
    wind: str | None = None
    current: str | None = None
    gnss: str = "rtk"
    water: str | None = None  # "usual" or "rough"; None: as the vessel's file says
    waves: str | None = None  # "HS[@FROM_DEG][/TP_S]"; None: as the vessel's file says
    wave_drift: bool = True
    model_error: float = 0.0
    plant: str | None = None
    plant_error: float = (
        0.0  # share by which a jet boat's mass, thrust, nozzle and drag are wrong, each up or down by seed
    )
    windage_error: float | None = None  # share by which the true wind areas differ, each up or down by seed
    # the controller's model: the hull of the plant of that name, or this one; None: the vessel's own
    controller_model: str | ControllerModel | None = None
    push_ned_n: tuple[float, float] = (0.0, 0.0)
    wind_sensor: bool = False  # add a wind sensor
    ais: bool = False  # add an AIS receiver
    lidar: bool = False  # add a lidar that looks all around
    sounder: bool = False  # add an echo sounder
    camera: bool = False  # add a camera on a relay
    rotating: tuple[str, ...] = ()  # names of fixed thrusters that turn in this run
    faults: tuple[str, ...] = ()
    # heading from the inertial sensor's magnetometer alone: "calibrated", or "raw" without its calibration
    magnetometer: str = ""
    tow: tuple[TowLeg, ...] = ()  # towed along these legs, whatever the thrusters do
    parameters: Mapping[str, float] = field(default_factory=dict)
    start: tuple[float, float, float] | None = None  # north and east of home in m, heading in rad; None: at home
    lead_boats: tuple[LeadBoatConfig, ...] = ()
    known: VesselConfig | None = None
    real: VesselConfig | None = None
    moving_base: bool = False  # the receiver uses the lead boat's as its base
    gnss_common: float = 0.0  # share of the slow position error that all receivers have in common


class Composer(Protocol):
    """Builds a rig that records into `folder`."""

    def __call__(self, conditions: Conditions, folder: Path) -> Rig: ...
