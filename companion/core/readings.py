"""Values of the step sense: what sensors, bridges, other vessels and a lead boat report, as the drivers pass it on.

All are frozen, in SI units and radians; NED, and body axes x forward, y starboard, z down. A missing value is `None`,
never 0. `t_s` is the vessel time (seconds since the process started) at which the value was valid. `source` is the
device's name in the vessel's file.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Annotated, Protocol

from companion.core.actuation import ThrusterFeedback
from companion.core.named import Named

Int64 = Annotated[int, "int64"]
"""A whole number that a float64 cannot hold exactly; the log keeps it as an int64."""


class FixType(IntEnum):
    """Quality of a satellite fix; the numbers are those of MAVLink's GPS_FIX_TYPE."""

    NONE = 1
    FIX_2D = 2
    FIX_3D = 3
    DGPS = 4
    RTK_FLOAT = 5
    RTK_FIXED = 6


@dataclass(frozen=True, slots=True)
class GnssFix:
    """Position of the antenna as one receiver gives it."""

    t_s: float
    source: str
    lat_deg: float
    lon_deg: float
    altitude_m: float | None
    fix: FixType
    satellites: int | None
    hdop: float | None
    position_accuracy_m: float | None = None  # one sigma, horizontal


@dataclass(frozen=True, slots=True)
class RelativeFix:
    """Vector from a moving base's antenna, aboard a lead boat, to the antenna of a receiver aboard that uses its
    observations, in NED. `fix` RTK_FIXED or RTK_FLOAT; with NONE there is no solution, and the vector is NaN.

    `base`: station number in the base's messages.
    """

    t_s: float
    source: str
    north_m: float
    east_m: float
    down_m: float
    fix: FixType
    accuracy_m: float | None  # one sigma on each horizontal axis
    base: int | None = None


@dataclass(frozen=True, slots=True)
class GroundVelocity:
    """Velocity of the antenna over ground."""

    t_s: float
    source: str
    north_mps: float
    east_mps: float


class HeadingBy(Named):
    """What a heading rests on."""

    BASELINE = "baseline"  # two antennas, or a gyrocompass: true heading
    COMPASS = "compass"  # the Earth's magnetic field; true heading: the device has added the declination
    MAGNETIC = "magnetic"  # the Earth's magnetic field; magnetic heading: the declination is still to be added


@dataclass(frozen=True, slots=True)
class Heading:
    """Heading of the hull, mounting offsets applied; true unless `by` is MAGNETIC."""

    t_s: float
    source: str
    yaw_rad: float
    accuracy_rad: float | None = None
    by: HeadingBy = HeadingBy.BASELINE


@dataclass(frozen=True, slots=True)
class Imu:
    """Specific force and angular rate in body axes."""

    t_s: float
    source: str
    x_mps2: float
    y_mps2: float
    z_mps2: float
    roll_rate_radps: float
    pitch_rate_radps: float
    yaw_rate_radps: float
    roll_rad: float | None = None  # the device's own attitude, if it gives one
    pitch_rad: float | None = None
    yaw_rad: float | None = None


@dataclass(frozen=True, slots=True)
class MagneticField:
    """Magnetic field in body axes as measured, in the device's unit, before calibration (`mag_offset`,
    `mag_matrix`)."""

    t_s: float
    source: str
    x: float
    y: float
    z: float


@dataclass(frozen=True, slots=True)
class TimeOfDay:
    """Absolute time at `t_s`, as a receiver gives it."""

    t_s: float
    source: str
    time_unix_ns: Int64


@dataclass(frozen=True, slots=True)
class Wind:
    """Apparent wind: its speed, and the direction that it comes from, clockwise from the bow."""

    t_s: float
    source: str
    speed_mps: float
    from_rad: float


@dataclass(frozen=True, slots=True)
class Battery:
    """Voltage, current out of the battery, and share of charge left; None if not measured."""

    t_s: float
    source: str
    voltage_v: float
    current_a: float | None
    remaining: float | None  # 0…1


@dataclass(frozen=True, slots=True)
class Leak:
    """State of the leak sensor."""

    t_s: float
    source: str
    wet: bool


@dataclass(frozen=True, slots=True)
class RcInput:
    """Channels of the hand-held transmitter, in channel order: −1 is a pulse of 1000 µs, 1 one of 2000 µs; some reach
    a little further. `lost`: the RC receiver reports no signal."""

    t_s: float
    source: str
    channels: tuple[float, ...]
    lost: bool


@dataclass(frozen=True, slots=True)
class ManualInput:
    """Sticks of a ground station or a transmitter, each −1…1; None for an axis that is missing."""

    t_s: float
    source: str
    surge: float | None
    sway: float | None
    yaw: float | None
    buttons: int = 0


@dataclass(frozen=True, slots=True)
class Depth:
    """Depth of water below the transducer. `offset_m`: from the transducer up to the surface (positive) or down to the
    keel (negative), if the sounder knows it."""

    t_s: float
    source: str
    below_transducer_m: float
    offset_m: float | None = None
    range_m: float | None = None  # the largest depth that it can measure now


@dataclass(frozen=True, slots=True)
class DepthAhead:
    """Depth of water at a place ahead of the boat, as a forward-looking sounder measures it. `ahead_m`: from the middle
    of the boat along the bow. `below_m`: below the transducer."""

    t_s: float
    source: str
    below_m: float
    ahead_m: float


@dataclass(frozen=True, slots=True)
class Ranges:
    """Nearest distances around a sensor, sector by sector, as a lidar, radar or sonar measures them.

    `first_rad`: bearing of the middle of the first sector, clockwise from the bow, or from north where `from_north`;
    `step_rad`: width of each sector. A distance is NaN where nothing is known, infinite where nothing is up to
    `most_m`. `x_m`, `y_m`: place of the sensor in body axes.
    """

    t_s: float
    source: str
    first_rad: float
    step_rad: float
    least_m: float
    most_m: float
    from_north: bool
    x_m: float
    y_m: float
    distances_m: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class RadarTarget:
    """A target that a radar tracks. Its place is either (`distance_m`, `bearing_rad`) from the boat or (`lat_deg`,
    `lon_deg`). `from_bow`: the bearing counts from the bow, else from north. `relative`: course and speed are relative
    to the boat. `lost`: the radar has lost it."""

    t_s: float
    source: str
    number: int
    distance_m: float | None
    bearing_rad: float | None
    from_bow: bool
    lat_deg: float | None
    lon_deg: float | None
    course_rad: float | None
    speed_mps: float | None
    relative: bool
    lost: bool
    name: str | None = None


@dataclass(frozen=True, slots=True)
class Corrections:
    """The corrections that a receiver's fix rests on, as the receiver reports them."""

    t_s: float
    source: str
    age_s: float
    station: int | None  # number of the reference station


@dataclass(frozen=True, slots=True)
class Measurement:
    """A measurement for the log alone. `name` carries the unit: `rudder_rad`, `water_surge_mps`,
    `rate_of_turn_radps`."""

    t_s: float
    source: str
    value: float
    name: str


@dataclass(frozen=True, slots=True)
class AisTarget:
    """The content of one AIS message about another vessel; None for what the message lacks. `t_s`: time of the
    position, as far as the receiver knows it.

    A motion report has a position; a static report (size and names) has none. `bow_m` … `starboard_m` are distances
    from the ship's position antenna. `status`, `kind`: navigational status and ship type as AIS numbers (ITU-R M.1371).
    """

    t_s: float
    source: str
    mmsi: int
    lat_deg: float | None = None
    lon_deg: float | None = None
    course_rad: float | None = None  # over ground
    speed_mps: float | None = None  # over ground
    heading_rad: float | None = None
    turn_rate_radps: float | None = None
    status: int | None = None
    kind: int | None = None
    bow_m: float | None = None
    stern_m: float | None = None
    port_m: float | None = None
    starboard_m: float | None = None
    callsign: str | None = None
    name: str | None = None


LEADER_MODULE = 0x55535600
"""FOLLOW_TARGET.custom_state of a leader module: these three bytes mark it; the low byte holds the `Wish`, bits 32 to
39 the count of presses, bits 40 to 43 the `FixType` of its receiver (0: not said); the bits above are 0."""


class Wish(IntEnum):
    """What the crew of the lead boat requests from the follower."""

    NONE = 0
    MANUAL = 1  # its own crew or transmitter steers
    REMOTE = 2  # the sticks aboard the lead boat steer
    AUTONOMOUS = 3  # it follows


@dataclass(frozen=True, slots=True)
class LeaderState:
    """The content of one message about a lead boat; None for what the message lacks. `t_s`: vessel time at which it was
    valid; `heard_s`: time of arrival.

    `lat_deg`, `lon_deg` None: the leader has no fix. `wish` None: the sender is not a leader module but a phone, a
    ground station or another vehicle. `presses`: counts the crew's requests since the module started (255 is followed
    by 1). `lost`: messages of this link lost since the previous one.
    """

    t_s: float
    heard_s: float
    source: str
    system_id: int
    lat_deg: float | None
    lon_deg: float | None
    north_mps: float | None = None
    east_mps: float | None = None
    yaw_rad: float | None = None
    yaw_rate_radps: float | None = None
    accuracy_m: float | None = None  # one sigma, horizontal
    wish: Wish | None = None
    lost: int = 0
    presses: int = 0
    fix: FixType | None = None  # of its receiver; None: not said


class Reading(Protocol):
    """What every reading has: the time at which it was valid, and the name of the device that it comes from."""

    @property
    def t_s(self) -> float:
        """Vessel time at which it was valid."""
        ...

    @property
    def source(self) -> str:
        """Name of the device."""
        ...


KINDS: Mapping[str, type[Reading]] = {
    "imu": Imu,
    "gnss": GnssFix,
    "velocity": GroundVelocity,
    "heading": Heading,
    "field": MagneticField,
    "wind": Wind,
    "battery": Battery,
    "leak": Leak,
    "feedback": ThrusterFeedback,
    "manual": ManualInput,
    "rc": RcInput,
    "time": TimeOfDay,
    "depth": Depth,
    "corrections": Corrections,
    "measurement": Measurement,
    "ais": AisTarget,
    "depth_ahead": DepthAhead,
    "ranges": Ranges,
    "radar": RadarTarget,
    "relative": RelativeFix,
}
"""Every kind of reading that the log keeps, by its name there. A new kind is its dataclass and its row."""
