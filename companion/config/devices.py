"""Thrusters, sensors and bridges, as a vessel's file describes them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from companion.config.bridges import MavlinkBoardConfig, OutputConfig
from companion.config.fields import (
    FROM_DEGREES,
    FROM_DEGREES_OR_NONE,
    SECTORS_FROM_DEGREES,
    STRICT,
    VECTOR_FROM_DEGREES_OR_NONE,
    Name,
    NonNegative,
    Positive,
    Vector,
)

UNIT_MATRIX = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True, slots=True)
class JetConfig:
    """A water jet: T = ρA V_j (V_j − intake_share·U), with V_j = idle_mps + span_mps·u^exponent, u the throttle 0…1 and U the speed ahead through the water.

    ρA is the water's density times the nozzle's area; `intake_share` the part of the boat's speed with which water comes in.
    """

    __pydantic_config__ = STRICT
    density_area_kgpm: Positive
    idle_mps: Positive
    span_mps: Positive
    exponent: Positive = 1.0
    intake_share: Annotated[float, Field(ge=0.0, le=1.0)] = 1.0

    def bollard_n(self, throttle: float) -> float:
        """Thrust of the boat at rest, impeller turning."""
        exit_mps = self.idle_mps + self.span_mps * math.pow(max(0.0, throttle), self.exponent)
        return self.density_area_kgpm * exit_mps * exit_mps


@dataclass(frozen=True, slots=True)
class NozzleConfig:
    """What really turns a nozzle, as SITL's plant: a position servo that closes the difference with a time constant, no faster than its rate."""

    __pydantic_config__ = STRICT
    rate_radps: Annotated[float, Field(alias="rate_dps", gt=0.0), FROM_DEGREES]
    lag_s: NonNegative = 0.0


@dataclass(frozen=True, slots=True)
class ThrusterConfig:
    """One thruster. Force F = ahead_n·u|u| (u ≥ 0) or astern_n·u|u| (u < 0), u the throttle −1…1, within [min_n, max_n].

    `azimuth_rad` is its direction at rest: the way it pushes the boat, clockwise from the bow. Kind "azimuth" turns at most
    `azimuth_rate_radps`, within [azimuth_min_rad, azimuth_max_rad] where those are given, else endlessly, and gives no thrust in a sector of
    `forbidden_rad`, each clockwise from its first to its second direction. A `retractable` one takes `travel_s` between up and down.
    Kind "jet" is steered by its nozzle, whose direction is its azimuth; its thrust follows `jet`, with `ahead_n` the pull at full throttle of the
    boat at rest. Below `dead_band` its impeller stands; from there on it pushes at least as `jet.idle_mps` says.
    """

    __pydantic_config__ = STRICT
    name: Name
    kind: Literal["azimuth", "fixed", "jet"]
    x_m: float
    y_m: float
    max_n: Positive
    min_n: Annotated[float, Field(le=0.0)]
    ahead_n: Positive
    astern_n: Positive
    force_rate_nps: Positive
    azimuth_rad: Annotated[float, Field(alias="azimuth_deg", ge=-360.0, le=360.0), FROM_DEGREES] = 0.0
    azimuth_rate_radps: Annotated[float, Field(alias="azimuth_rate_dps", ge=0.0), FROM_DEGREES] = 0.0
    azimuth_min_rad: Annotated[float | None, Field(alias="azimuth_min_deg"), FROM_DEGREES_OR_NONE] = None
    azimuth_max_rad: Annotated[float | None, Field(alias="azimuth_max_deg"), FROM_DEGREES_OR_NONE] = None
    forbidden_rad: Annotated[tuple[tuple[float, float], ...], Field(alias="forbidden_deg"), SECTORS_FROM_DEGREES] = ()
    manual_azimuth_rad: Annotated[float, Field(alias="manual_azimuth_deg", ge=0.0, le=180.0), FROM_DEGREES] = 0.0
    dead_band: Annotated[float, Field(ge=0.0, lt=0.5)] = 0.0  # throttle below which nothing turns
    retractable: bool = False
    travel_s: NonNegative = 0.0
    jet: JetConfig | None = None
    output: OutputConfig | None = None  # None: the drive takes throttle and azimuth as they are

    @property
    def turns(self) -> bool:
        """Whether its push can be given a direction."""
        return self.kind != "fixed"


@dataclass(frozen=True, slots=True)
class SensorConfig:
    """One sensor: its driver (a row of `companion/io/sensors`), its port, where it sits in body axes, and how good it is.

    Accuracies and noise densities are one sigma, as the filter is to weigh this sensor; wanders are slow errors that averaging does not
    take away. None: by kind; headings 0.4° with a wander of 0.1° from an antenna baseline, 3° with 2° from a compass (15° from a raw magnetometer that nobody has calibrated); positions wander
    8 mm with carrier phase, else by 0.7 of their accuracy.
    """

    __pydantic_config__ = STRICT
    name: Name
    driver: str
    port: str
    x_m: float = 0.0
    y_m: float = 0.0
    z_m: float = 0.0
    heading_offset_rad: Annotated[float, Field(alias="heading_offset_deg", ge=-360.0, le=360.0), FROM_DEGREES] = 0.0
    rate_hz: Positive = 10.0
    timeout_s: Positive = 2.0
    antennas: Literal[1, 2] = 2  # of a satellite receiver; two give a heading
    latency_s: NonNegative = 0.0  # from the moment of validity to the arrival of the bytes; of the promptest where the messages bear a time
    talkers: tuple[Annotated[str, Field(pattern=r"^[A-Z][A-Z0-9]$")], ...] = ()  # of NMEA sentences to listen to; none: all
    rtcm: bool = False  # a satellite receiver that is given the corrections
    configure: bool = False  # an inertial sensor that is told at the start what to send, at rate_hz
    rotation_rad: Annotated[Vector | None, Field(alias="rotation_deg"), VECTOR_FROM_DEGREES_OR_NONE] = None  # roll, pitch, yaw of its axes in the boat's
    heading: Literal["none", "magnetic", "true", "ahrs"] = "none"  # what an inertial sensor's own yaw is worth as a compass; ahrs: its raw field is used
    mag_offset: Vector = (0.0, 0.0, 0.0)  # hard iron, in the magnetometer's unit; true field = mag_matrix · (measured − mag_offset)
    mag_matrix: tuple[Vector, Vector, Vector] = UNIT_MATRIX  # soft iron, row by row
    accuracy_floor_m: Positive = 0.02  # timing and mounting are no better, whatever the receiver says of its positions
    position_wander_m: NonNegative | None = None
    velocity_accuracy_mps: Positive = 0.06  # of a plain fix; with corrections half of that, with carrier phase 0.3
    heading_accuracy_rad: Annotated[float | None, Field(alias="heading_accuracy_deg", gt=0.0, le=45.0), FROM_DEGREES_OR_NONE] = None
    heading_wander_rad: Annotated[float | None, Field(alias="heading_wander_deg", ge=0.0, le=45.0), FROM_DEGREES_OR_NONE] = None
    accelerometer_noise_mps2_rthz: Positive = 0.004  # on a hull that shakes: a few times the data sheet's
    gyro_noise_radps_rthz: Annotated[float, Field(alias="gyro_noise_dps_rthz", gt=0.0), FROM_DEGREES] = 2.0e-4


@dataclass(frozen=True, slots=True)
class StepperConfig:
    """The stepper drive that turns one thruster's azimuth: its address on the bus and how its steps make an angle.

    `steps_per_turn` of the thruster, belts and gears and `step_mode` (microsteps a full step) included. The angle that it shows is 0 at the zero of
    its counter; where it gets that: `homing` "switch", by a slow turn to its reference switch at the start; "here", it stands there at power-up.
    What that angle is of the thruster's azimuth stands in `[thruster.output]`. `speed_radps` None: as fast as the thruster turns.
    """

    __pydantic_config__ = STRICT
    thruster: Name
    address: Annotated[int, Field(ge=1, le=254)]
    steps_per_turn: Annotated[float, Field(ge=20.0, le=10_000_000.0)]
    step_mode: Literal[1, 2, 4, 5, 8, 10, 16, 32, 64] = 8
    speed_radps: Annotated[float | None, Field(alias="speed_dps", gt=0.0), FROM_DEGREES_OR_NONE] = None
    ramp_radps2: Annotated[float, Field(alias="ramp_dps2", gt=0.0), FROM_DEGREES] = math.radians(1500.0)
    homing: Literal["here", "switch"] = "here"
    homing_radps: Annotated[float, Field(alias="homing_dps", gt=0.0), FROM_DEGREES] = math.radians(20.0)


@dataclass(frozen=True, slots=True)
class MotorConfig:
    """A thruster on an NMEA 2000 network, by the `instance` that its messages carry, and that of its angle sensor (None: the same)."""

    __pydantic_config__ = STRICT
    thruster: Name
    instance: Annotated[int, Field(ge=0, le=252)]
    sensor_instance: Annotated[int | None, Field(ge=0, le=252)] = None


@dataclass(frozen=True, slots=True)
class ActuatorConfig:
    """One bridge: its driver (a row of `companion/io/actuators`), its port, and the thrusters, servos and relays it drives, by name.

    It drives the throttle of `thrusters`, and the azimuth of those among them that turn unless another bridge names them in its `azimuths`.
    `drives` and `motors` are for the drivers that know them; `address`: its own on a network that has addresses.
    """

    __pydantic_config__ = STRICT
    name: Name
    driver: str
    port: str
    thrusters: tuple[Name, ...] = ()
    azimuths: tuple[Name, ...] = ()
    timeout_s: Positive = 1.0
    servos: tuple[Name, ...] = ()
    relays: tuple[Name, ...] = ()
    drives: Annotated[tuple[StepperConfig, ...], Field(alias="drive")] = ()
    motors: Annotated[tuple[MotorConfig, ...], Field(alias="motor")] = ()
    address: Annotated[int, Field(ge=0, le=251)] = 50
    mavlink: MavlinkBoardConfig | None = None
