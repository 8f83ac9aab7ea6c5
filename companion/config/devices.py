"""Thrusters, sensors and bridges, as a vessel's file describes them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, Any, Literal

from pydantic import Field

from companion.config.bridges import OutputConfig
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
    derived,
    means,
)
from companion.config.rudder import RudderConfig
from companion.config.sail import SailConfig

_ABEAM_RAD = 0.5 * math.pi
OTHER_KEYS = "keys of other drivers"  # what no file can have as a key
Others = Annotated[
    tuple[tuple[str, Any], ...],
    Field(alias=OTHER_KEYS),
    means("Keys of the row that are not its driver's, with their values: those of another driver, or of a plug-in."),
]
UNIT_MATRIX = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True, slots=True)
class JetConfig:
    """A water jet: T = ρA V_j (V_j − intake_share·U), with V_j = idle_mps + span_mps·u^exponent, u the throttle 0…1 and
    U the speed ahead through the water.

    ρA is the density of the water times the area of the nozzle; `intake_share` the share of the boat's speed with which
    water enters.
    """

    __pydantic_config__ = STRICT
    density_area_kgpm: Annotated[Positive, derived("Density of the water times the area of the nozzle, ρA.")]
    idle_mps: Annotated[Positive, derived("Speed of the jet at the lowest throttle at which the impeller turns.")]
    span_mps: Annotated[Positive, derived("Speed of the jet that full throttle adds to `idle_mps`.")]
    exponent: Annotated[
        Positive,
        means("Exponent of the throttle in the speed of the jet: `idle_mps` + `span_mps` · u^`exponent`."),
    ] = 1.0
    intake_share: Annotated[
        float,
        Field(ge=0.0, le=1.0),
        means("Share of the boat's speed with which water enters the intake."),
    ] = 1.0

    def bollard_n(self, throttle: float) -> float:
        """Thrust in N with the boat at rest and the impeller turning, for a throttle 0…1."""
        exit_mps = self.idle_mps + self.span_mps * math.pow(max(0.0, throttle), self.exponent)
        return self.density_area_kgpm * exit_mps * exit_mps

    def full_n(self, ahead_mps: float) -> float:
        """Thrust in N at full throttle, at that speed ahead through the water."""
        exit_mps = self.idle_mps + self.span_mps
        return max(0.0, self.density_area_kgpm * exit_mps * (exit_mps - self.intake_share * ahead_mps))


@dataclass(frozen=True, slots=True)
class NozzleConfig:
    """What really turns a nozzle, as the plant of SITL: a position servo that closes the difference with a time
    constant, no faster than its rate."""

    __pydantic_config__ = STRICT
    rate_radps: Annotated[float, Field(alias="rate_dps", gt=0.0), FROM_DEGREES, means("Fastest turn of the nozzle.")]
    lag_s: Annotated[
        NonNegative,
        means("Time constant with which the nozzle closes the difference to the commanded angle. 0: no lag."),
    ] = 0.0


@dataclass(frozen=True, slots=True)
class ThrusterConfig:
    """One thruster. Force F = ahead_n·u|u| (u ≥ 0) or astern_n·u|u| (u < 0), u the throttle −1…1, within [min_n,
    max_n].

    Kind "azimuth" turns at most `azimuth_rate_radps`, within its stops where those are given, else endlessly. Kind
    "jet" is steered by its nozzle, whose direction is its azimuth. Its thrust follows `jet`, with `ahead_n` the pull at
    full throttle of the boat at rest. Below `dead_band` its impeller stands; from there on it pushes at least as
    `jet.idle_mps` says. Kind "rudder" is a fixed propeller with a rudder behind it. Its azimuth is the blade's angle,
    with the sign of the push: positive pushes the stern to starboard. Kind "sail" is a rig with a rudder: its throttle
    is the sheet, 0 free to 1 hauled in, or the angle of a wing to the wind, and its azimuth the blade's angle.
    """

    __pydantic_config__ = STRICT
    name: Annotated[Name, means("Name of the thruster. Bridges, logs and messages use it.")]
    kind: Annotated[
        Literal["azimuth", "fixed", "jet", "rudder", "sail"],
        means(
            "`azimuth` turns, `fixed` does not, `jet` is a water jet with a steered nozzle, `rudder` a fixed propeller "
            "with a rudder behind it, `sail` a sail with a sheet, or a wing, and a rudder."
        ),
    ]
    x_m: Annotated[float, means("Position ahead of the middle of the boat.")]
    y_m: Annotated[float, means("Position to starboard of the middle of the boat.")]
    max_n: Annotated[Positive, derived("Largest thrust ahead that the allocation uses.")]
    min_n: Annotated[
        float,
        Field(le=0.0),
        derived(
            "Largest thrust astern that the allocation uses, as a negative number. 0 for a thruster that "
            "cannot reverse."
        ),
    ]
    ahead_n: Annotated[
        Positive,
        derived("Thrust at full throttle ahead with the boat at rest. Thrust is `ahead_n` · u² at throttle u."),
    ]
    astern_n: Annotated[Positive, derived("Thrust at full throttle astern with the boat at rest, without sign.")]
    force_rate_nps: Annotated[Positive, derived("Fastest change of thrust that the allocation uses.")]
    azimuth_rad: Annotated[
        float,
        Field(alias="azimuth_deg", ge=-360.0, le=360.0),
        FROM_DEGREES,
        means(
            "Direction at rest: the way that the thruster pushes the boat, clockwise from the bow. A tunnel "
            "thruster that pushes to starboard has 90."
        ),
    ] = 0.0
    azimuth_rate_radps: Annotated[
        float,
        Field(alias="azimuth_rate_dps", ge=0.0),
        FROM_DEGREES,
        means("Fastest turn of the azimuth. Above 0 for a thruster that turns."),
    ] = 0.0
    azimuth_min_rad: Annotated[
        float | None,
        Field(alias="azimuth_min_deg"),
        FROM_DEGREES_OR_NONE,
        means("Stop of the azimuth, counter-clockwise. Leave both stops out for a pod that turns endlessly."),
    ] = None
    azimuth_max_rad: Annotated[
        float | None,
        Field(alias="azimuth_max_deg"),
        FROM_DEGREES_OR_NONE,
        means("Stop of the azimuth, clockwise."),
    ] = None
    forbidden_rad: Annotated[
        tuple[tuple[float, float], ...],
        Field(alias="forbidden_deg"),
        SECTORS_FROM_DEGREES,
        means("Sectors in which the thruster gives no thrust, each as `[from, to]`, clockwise."),
    ] = ()
    manual_azimuth_rad: Annotated[
        float,
        Field(alias="manual_azimuth_deg", ge=0.0, le=180.0),
        FROM_DEGREES,
        means("Turn of the azimuth at full yaw stick in Manual. 0: yaw does not turn this thruster."),
    ] = 0.0
    dead_band: Annotated[float, Field(ge=0.0, lt=0.5), means("Throttle below which nothing turns.")] = 0.0
    retractable: Annotated[bool, means("The thruster can be lowered and retracted.")] = False
    travel_s: Annotated[NonNegative, means("Time between up and down. Only for a retractable thruster.")] = 0.0
    jet: Annotated[JetConfig | None, derived("Curve of a water jet. Only for kind `jet`.")] = None
    rudder: Annotated[
        RudderConfig | None,
        derived("The blade of a rudder. Only for kinds `rudder` and `sail`."),
    ] = None
    sail: Annotated[SailConfig | None, means("The sail. Only for kind `sail`.")] = None
    output: Annotated[
        OutputConfig | None,
        means("Calibration of the drive. Without it the drive takes throttle and azimuth as they are."),
    ] = None
    motor: Annotated[
        str | None,
        means("Motor whose published thrust counts where none is given: `T200`, `Travel 1103`, `trolling 55 lb` …"),
    ] = None
    voltage_v: Annotated[Positive | None, means("Voltage at the motor. Left out: the highest one in the table.")] = None
    power_w: Annotated[
        Positive | None,
        means("Electric power at full throttle. With `propeller_m` it gives the thrust where nothing better is known."),
    ] = None
    propeller_m: Annotated[
        Positive | None,
        means("Diameter of the propeller. It says how much thrust is lost with speed."),
    ] = None
    full_a: Annotated[
        Positive | None,
        means(
            "Current of the motor from its supply at full throttle with the boat at rest. With it, and a bridge that "
            "reports the motor's current, a blocked, fouled or lost propeller is found."
        ),
    ] = None

    @property
    def turns(self) -> bool:
        """Whether its push can have another direction."""
        return self.kind != "fixed"

    @property
    def turns_round(self) -> bool:
        """Whether it can push astern by its direction: a pod that turns far enough, no jet and no rudder."""
        low, high = self.azimuth_min_rad, self.azimuth_max_rad
        reaches = low is None or high is None or high > _ABEAM_RAD or low < -_ABEAM_RAD
        return self.kind == "azimuth" and reaches

    @property
    def pushes_astern(self) -> bool:
        """Whether it can push astern, by reversing or by turning round."""
        return self.kind != "sail" and (self.min_n < 0.0 or self.turns_round)


@dataclass(frozen=True, slots=True)
class FixErrors:
    """Errors of one kind of fix of a receiver, one sigma on each axis."""

    __pydantic_config__ = STRICT
    noise_m: Annotated[Positive | None, means("As `position_noise_m`, of this kind of fix.")] = None
    wander_m: Annotated[NonNegative | None, means("As `position_wander_m`, of this kind of fix.")] = None
    wander_s: Annotated[Positive | None, means("As `position_wander_s`, of this kind of fix.")] = None
    velocity_mps: Annotated[
        Positive | None,
        means("Error of velocity with this kind of fix. Left out: 0.3 of `velocity_accuracy_mps`."),
    ] = None


@dataclass(frozen=True, slots=True)
class SensorConfig:
    """One sensor: its driver (a row of the table of sensor drivers), its port, where it sits in body axes, and how good
    it is.

    Accuracies and noise densities are one sigma, as the filter weighs this sensor. Wanders are slow errors that
    averaging does not remove. What is None depends on the kind of sensor. A driver with keys of its own has a subclass
    of this in `companion.config.sensors`.
    """

    __pydantic_config__ = STRICT
    name: Annotated[Name, means("Name of the sensor. Logs and messages use it.")]
    driver: Annotated[str, means("Protocol that the sensor speaks: one of the drivers listed below.")]
    port: Annotated[
        str,
        means(
            "Where the bytes come from: `serial:/dev/…:115200`, `udpin:0.0.0.0:5000`, "
            "`tcpout:192.168.1.20:4001` and so on. Sensors behind one multiplexer give the same port."
        ),
    ]
    x_m: Annotated[float, means("Position of the antenna or device ahead of the middle of the boat.")] = 0.0
    y_m: Annotated[float, means("Position to starboard of the middle of the boat.")] = 0.0
    z_m: Annotated[float, means("Position below the middle of the boat; negative above it.")] = 0.0
    heading_offset_rad: Annotated[
        float,
        Field(alias="heading_offset_deg", ge=-360.0, le=360.0),
        FROM_DEGREES,
        means(
            "Angle that is added to the heading that the sensor reports, for antennas or a compass that do "
            "not point ahead."
        ),
    ] = 0.0
    rate_hz: Annotated[
        Positive,
        means(
            "Rate at which the sensor sends. The boat reports a slower one. With `configure` the sensor is set to it."
        ),
    ] = 10.0
    timeout_s: Annotated[Positive, means("Silence after which the sensor counts as lost.")] = 2.0
    antennas: Annotated[Literal[1, 2], means("Antennas of a satellite receiver. Two give a heading.")] = 2
    latency_s: Annotated[
        NonNegative,
        means(
            "Time from the moment of validity to the arrival of the bytes; for messages with a time, that of "
            "the promptest one."
        ),
    ] = 0.0
    latency_accuracy_s: Annotated[
        NonNegative,
        means("How far `latency_s` of a receiver may be wrong, one sigma, until the boat's motion shows it."),
    ] = 0.15
    talkers: Annotated[
        tuple[Annotated[str, Field(pattern=r"^[A-Z][A-Z0-9]$")], ...],
        means('Talkers of NMEA sentences to accept, such as `["GP", "GN"]`. Empty: all.'),
    ] = ()
    rtcm: Annotated[bool, means("This receiver is given the RTCM corrections.")] = False
    moving_base: Annotated[
        bool,
        means(
            "On the follower: this receiver is given the RTCM of the leader module, and none else, and sends the "
            "vector between both antennas as UBX-NAV-RELPOSNED. On the leader module: the RTCM that this receiver "
            "sends goes to the followers."
        ),
    ] = False
    configure: Annotated[bool, means("Tell an MTi or a VectorNav at the start what to send, at `rate_hz`.")] = False
    rotation_rad: Annotated[
        Vector | None,
        Field(alias="rotation_deg"),
        VECTOR_FROM_DEGREES_OR_NONE,
        means(
            "Roll, pitch and yaw of the axes of an MTi in the boat. It is written to the device. Label up "
            "and x ahead: `[180, 0, 0]`."
        ),
    ] = None
    heading: Annotated[
        Literal["none", "magnetic", "true", "ahrs"],
        means(
            "What the yaw of an inertial sensor is worth as a compass. `ahrs`: the heading is made of its "
            "raw magnetic field."
        ),
    ] = "none"
    heading_with: Annotated[
        Name | None,
        means(
            "Of a receiver: name of another one, whose antenna stands elsewhere. While both have carrier phase, "
            "their two positions give the heading."
        ),
    ] = None
    mag_offset: Annotated[
        Vector,
        means(
            "Hard iron, in the unit of the magnetometer: true field = `mag_matrix` · (measured − "
            "`mag_offset`). `companion calibrate` gives it."
        ),
    ] = (0.0, 0.0, 0.0)
    mag_matrix: Annotated[
        tuple[Vector, Vector, Vector],
        means("Soft iron, row by row. `companion calibrate` gives it."),
    ] = UNIT_MATRIX
    depth_ahead_m: Annotated[
        NonNegative,
        means(
            "Of a sounder that looks ahead: how far before the middle of the boat the depth is that it gives. 0: it "
            "looks down."
        ),
    ] = 0.0
    accuracy_floor_m: Annotated[
        Positive,
        means(
            "Smallest error of position, one sigma, that the filter accepts from this receiver, for timing "
            "and mounting."
        ),
    ] = 0.02
    position_wander_m: Annotated[
        NonNegative | None,
        means(
            "Slow error of a plain fix that averaging does not remove. Left out: 0.7 of the accuracy. Fixes with "
            "carrier phase have their own in `rtk_float` and `rtk_fixed`; left out: 0.7 of the accuracy of a float "
            "solution, 8 mm of a fixed one."
        ),
    ] = None
    position_wander_s: Annotated[
        Positive | None,
        means("Time constant of the slow error of a plain fix. Left out: 300 s; with carrier phase 100 s."),
    ] = None
    position_noise_m: Annotated[
        Positive | None,
        means(
            "Error of a plain position from fix to fix. Left out: 0.3 of the accuracy; of a fixed solution with "
            "carrier phase the accuracy."
        ),
    ] = None
    rtk_float: Annotated[FixErrors | None, means("Errors of a float solution with carrier phase.")] = None
    rtk_fixed: Annotated[FixErrors | None, means("Errors of a fixed solution with carrier phase.")] = None
    velocity_accuracy_mps: Annotated[
        Positive,
        means(
            "Error of velocity of a plain fix, one sigma. With corrections half of it counts, with carrier "
            "phase 0.3 of it."
        ),
    ] = 0.06
    velocity_lasts_s: Annotated[
        NonNegative | None,
        means(
            "How long an error of velocity lasts; 0: each velocity errs by itself. Left out: 0 with carrier phase, "
            "else 0.5 s."
        ),
    ] = None
    heading_accuracy_rad: Annotated[
        float | None,
        Field(alias="heading_accuracy_deg", gt=0.0, le=45.0),
        FROM_DEGREES_OR_NONE,
        means("Error of heading, one sigma. Left out: 0.4° from two antennas, 3° from a compass."),
    ] = None
    heading_noise_rad: Annotated[
        float | None,
        Field(alias="heading_noise_deg", gt=0.0, le=45.0),
        FROM_DEGREES_OR_NONE,
        means(
            "Error of heading from one to the next. Left out: its accuracy; three times that from a compass, whose "
            "errors last for a second."
        ),
    ] = None
    heading_wander_rad: Annotated[
        float | None,
        Field(alias="heading_wander_deg", ge=0.0, le=45.0),
        FROM_DEGREES_OR_NONE,
        means(
            "Slow error of heading that averaging does not remove. Left out: 0.1° from two antennas, 2° from "
            "a compass, 15° from a magnetometer that is not calibrated."
        ),
    ] = None
    heading_wander_s: Annotated[
        Positive | None,
        means("Time constant of the slow error of heading. Left out: 60 s from two antennas, 300 s from a compass."),
    ] = None
    accelerometer_noise_mps2_rthz: Annotated[
        Positive,
        means("Noise density of the accelerometers, one sigma. On a hull that vibrates: a few times the data sheet's."),
    ] = 0.004
    gyro_noise_radps_rthz: Annotated[
        float,
        Field(alias="gyro_noise_dps_rthz", gt=0.0),
        FROM_DEGREES,
        means("Noise density of the gyros, one sigma."),
    ] = 2.0e-4
    accelerometer_bias_mps2: Annotated[
        Positive | None,
        means(
            "Bias of the accelerometers, one sigma of a sensor of this kind. Left out: 0.05 at switch-on, and 0.01 of "
            "wander."
        ),
    ] = None
    gyro_bias_radps: Annotated[
        float | None,
        Field(alias="gyro_bias_dps", gt=0.0),
        FROM_DEGREES_OR_NONE,
        means("Bias of the gyros, one sigma of a sensor of this kind. Left out: 0.2 at switch-on, and 0.03 of wander."),
    ] = None
    bias_s: Annotated[
        Positive | None,
        means("Time after which the biases are others. Left out: 600 s of the accelerometers, 1000 s of the gyros."),
    ] = None
    others: Others = ()


@dataclass(frozen=True, slots=True)
class ActuatorConfig:
    """One bridge: its driver (a row of the table of bridge drivers), its port, and what it drives, by name.

    A driver with keys of its own has a subclass of this in `companion.config.actuators`.
    """

    __pydantic_config__ = STRICT
    name: Annotated[Name, means("Name of the bridge. Logs and messages use it.")]
    driver: Annotated[str, means("Protocol of the bridge: one of the drivers listed below.")]
    port: Annotated[str, means("Where the bridge is reached, as for a sensor; `can:can0` for NMEA 2000.")]
    thrusters: Annotated[
        tuple[Name, ...],
        means(
            "Names of the thrusters whose throttle it drives. It also turns those among them that turn, "
            "unless another bridge names them in `azimuths`."
        ),
    ] = ()
    azimuths: Annotated[tuple[Name, ...], means("Names of the thrusters whose azimuth alone it turns.")] = ()
    timeout_s: Annotated[Positive, means("Silence after which the bridge counts as lost.")] = 1.0
    servos: Annotated[tuple[Name, ...], means("Names of the servo outputs that it drives.")] = ()
    relays: Annotated[tuple[Name, ...], means("Names of the relays that it drives.")] = ()
    address: Annotated[int, Field(ge=0, le=251), means("Own address on a network that has addresses.")] = 50
    others: Others = ()

    @property
    def starts_in_s(self) -> float:
        """Longest time that its drives need after the start, beside what an answer takes: for a turn to a switch."""
        return 0.0
