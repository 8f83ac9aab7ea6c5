"""The values that pass between two steps of a tick. All frozen; SI units and radians; NED and body x forward, y starboard, z down.

A missing value is `None`, never 0. `t_s` is vessel time: seconds since the process started, the time at which a value was valid.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum, IntEnum

from companion.core.actuation import DARK as DARK
from companion.core.actuation import ActuatorCommand as ActuatorCommand
from companion.core.actuation import Beacon as Beacon
from companion.core.actuation import Condition as Condition
from companion.core.actuation import Deployment as Deployment
from companion.core.actuation import Light as Light
from companion.core.actuation import ThrusterCommand as ThrusterCommand
from companion.core.actuation import ThrusterFeedback as ThrusterFeedback
from companion.core.leader import Leader as Leader
from companion.core.leader import LeaderState as LeaderState
from companion.core.leader import Wish as Wish
from companion.core.readings import Corrections as Corrections
from companion.core.readings import Depth as Depth
from companion.core.readings import MagneticField as MagneticField
from companion.core.readings import Measurement as Measurement
from companion.core.records import quick
from companion.core.status_parts import FenceState as FenceState
from companion.core.status_parts import Home as Home
from companion.core.traffic import AisTarget as AisTarget
from companion.core.traffic import Contact as Contact
from companion.core.traffic import TrackedTarget as TrackedTarget


class FixType(IntEnum):
    """Quality of a satellite fix; the numbers are those of MAVLink's GPS_FIX_TYPE."""

    NONE = 1
    FIX_2D = 2
    FIX_3D = 3
    DGPS = 4
    RTK_FLOAT = 5
    RTK_FIXED = 6


# --- sense: what sensors and bridges report ------------------------------------------------------------------------


@quick
@dataclass(frozen=True, slots=True)
class GnssFix:
    """Best estimate of the antenna's position by one receiver."""

    t_s: float
    source: str
    lat_deg: float
    lon_deg: float
    altitude_m: float | None
    fix: FixType
    satellites: int | None
    hdop: float | None
    position_accuracy_m: float | None = None  # one sigma, horizontal


@quick
@dataclass(frozen=True, slots=True)
class GroundVelocity:
    """Velocity of the antenna over ground."""

    t_s: float
    source: str
    north_mps: float
    east_mps: float


class HeadingBy(Enum):
    """What a heading rests on."""

    BASELINE = "baseline"  # two antennas, or a gyrocompass: true
    COMPASS = "compass"  # the Earth's magnetic field, made true by the device itself
    MAGNETIC = "magnetic"  # the same, from magnetic north: the declination is still to be added


@quick
@dataclass(frozen=True, slots=True)
class Heading:
    """Heading of the hull (antenna baseline and offsets already applied), true unless `by` is MAGNETIC."""

    t_s: float
    source: str
    yaw_rad: float
    accuracy_rad: float | None = None
    by: HeadingBy = HeadingBy.BASELINE


@quick
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
    roll_rad: float | None = None  # the device's own attitude, where it gives one
    pitch_rad: float | None = None
    yaw_rad: float | None = None


@dataclass(frozen=True, slots=True)
class TimeOfDay:
    """Absolute time as a receiver gives it, for the moment `t_s`."""

    t_s: float
    source: str
    time_unix_ns: int


@dataclass(frozen=True, slots=True)
class Wind:
    """Apparent wind: speed, and the angle it comes from, clockwise from the bow."""

    t_s: float
    source: str
    speed_mps: float
    from_rad: float


@dataclass(frozen=True, slots=True)
class Battery:
    t_s: float
    source: str
    voltage_v: float
    current_a: float | None
    remaining: float | None  # 0…1


@dataclass(frozen=True, slots=True)
class Leak:
    t_s: float
    source: str
    wet: bool


@dataclass(frozen=True, slots=True)
class RcInput:
    """Channels of the hand-held transmitter, each −1…1, in channel order. `lost`: the receiver reports no signal."""

    t_s: float
    source: str
    channels: tuple[float, ...]
    lost: bool


@dataclass(frozen=True, slots=True)
class ManualInput:
    """Sticks of a ground station or a transmitter, each −1…1; `None` for an axis that is not there."""

    t_s: float
    source: str
    surge: float | None
    sway: float | None
    yaw: float | None
    buttons: int = 0


Instrument = Depth | Corrections | Measurement  # what does not steer the boat
Reading = GnssFix | GroundVelocity | Heading | Imu | MagneticField | TimeOfDay | Wind | Battery | Leak | RcInput | ThrusterFeedback | ManualInput | AisTarget | Instrument


# --- estimate ------------------------------------------------------------------------------------------------------


@quick
@dataclass(frozen=True, slots=True)
class NavState:
    """Best estimate of the boat's motion at `t_s`, of its origin (the IMU or hull reference point), with its own doubts.

    `position_valid` and `heading_valid` say whether control may use them; the ages say since when no measurement came in.
    Before the first fix the positions are 0 and invalid. `origin_*` is where north_m, east_m are 0.
    """

    t_s: float
    position_valid: bool
    heading_valid: bool
    lat_deg: float
    lon_deg: float
    altitude_m: float
    north_m: float
    east_m: float
    roll_rad: float
    pitch_rad: float
    yaw_rad: float
    surge_mps: float
    sway_mps: float
    north_mps: float
    east_mps: float
    roll_rate_radps: float
    pitch_rate_radps: float
    yaw_rate_radps: float
    position_accuracy_m: float
    velocity_accuracy_mps: float
    heading_accuracy_rad: float
    position_age_s: float
    heading_age_s: float
    imu_age_s: float
    fix: FixType
    satellites: int | None
    hdop: float | None
    time_unix_ns: int | None  # absolute time from a receiver, for this tick
    wind_speed_mps: float | None = None  # true wind
    wind_from_rad: float | None = None
    current_north_mps: float | None = None  # velocity of the water over ground, as far as thrust and motion tell it
    current_east_mps: float | None = None
    current_accuracy_mps: float | None = None  # one sigma on the worse axis


# --- decide --------------------------------------------------------------------------------------------------------


class ModeId(Enum):
    """The modes of the vessel, with no number of any dialect."""

    MANUAL = "Manual"
    FORCES = "Forces"
    HEADING = "Heading"
    HOLD = "Hold"
    MISSION = "Mission"
    RTL = "RTL"
    DOCK = "Dock"
    FOLLOW = "Follow"
    OFFBOARD = "Offboard"


class Severity(IntEnum):
    """As MAVLink's MAV_SEVERITY."""

    EMERGENCY = 0
    ALERT = 1
    CRITICAL = 2
    ERROR = 3
    WARNING = 4
    NOTICE = 5
    INFO = 6
    DEBUG = 7


@dataclass(frozen=True, slots=True)
class Event:
    """Something that a person should know. `name` is stable for programs, `text` is for people."""

    t_s: float
    severity: Severity
    name: str
    text: str


class Result(Enum):
    """What became of a request; the names are those of MAVLink's MAV_RESULT."""

    ACCEPTED = 0
    TEMPORARILY_REJECTED = 1
    DENIED = 2
    UNSUPPORTED = 3
    FAILED = 4


@dataclass(frozen=True, slots=True)
class Outcome:
    """Answer to a request, with the reason where it was refused."""

    result: Result
    reason: str = ""

    @property
    def accepted(self) -> bool:
        return self.result is Result.ACCEPTED


ACCEPTED = Outcome(Result.ACCEPTED)


class MissionState(IntEnum):
    """As MAVLink's MISSION_STATE."""

    NO_MISSION = 1
    NOT_STARTED = 2
    ACTIVE = 3
    PAUSED = 4
    COMPLETE = 5


@dataclass(frozen=True, slots=True)
class MissionProgress:
    """Where the mission stands. `reached` counts item arrivals since the process started, `reached_seq` is the last one."""

    state: MissionState
    seq: int
    count: int
    reached_seq: int | None = None
    reached: int = 0


@quick
@dataclass(frozen=True, slots=True)
class Status:
    """What the vessel has decided to be. `arming_refusals` is empty when arming would be accepted; `fence` is None while none is in force;
    `traffic`: the vessels around, by MMSI; `leader`: the lead boat, None while none has been heard."""

    t_s: float
    mode: ModeId
    intended_mode: ModeId  # the mode last asked for; differs from `mode` while a failsafe holds another
    armed: bool
    arming_refusals: tuple[str, ...]
    failsafes: tuple[str, ...]  # names of the failsafes now active
    home: Home | None
    mission: MissionProgress
    speed_override_mps: float | None = None
    fence: FenceState | None = None
    traffic: tuple[TrackedTarget, ...] = ()
    leader: Leader | None = None


# --- guide ---------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Wrench:
    """Force and moment on the hull in body axes."""

    surge_n: float
    sway_n: float
    yaw_nm: float


ZERO_WRENCH = Wrench(0.0, 0.0, 0.0)


class SetpointKind(Enum):
    NEUTRAL = "neutral"  # no thrust
    POSE = "pose"  # dynamic positioning: position, heading, velocity and acceleration all meant
    PATH = "path"  # sail: yaw_rad, yaw_rate_radps and surge_mps are meant, position is where the path is
    HEADING = "heading"  # yaw_rad held, wrench.surge_n and wrench.sway_n from the stick
    WRENCH = "wrench"  # wrench as demanded
    THRUSTERS = "thrusters"  # thrusters as demanded, past the allocation


@quick
@dataclass(frozen=True, slots=True)
class Setpoint:
    """What the boat should do now. Velocities and accelerations are of the reference, in its own body axes."""

    kind: SetpointKind
    north_m: float | None = None
    east_m: float | None = None
    yaw_rad: float | None = None
    surge_mps: float = 0.0
    sway_mps: float = 0.0
    yaw_rate_radps: float = 0.0
    surge_mps2: float = 0.0
    sway_mps2: float = 0.0
    yaw_radps2: float = 0.0
    wrench: Wrench | None = None
    thrusters: tuple[ThrusterCommand, ...] | None = None
    target_north_m: float | None = None  # where this leads to: the go-to point, the next waypoint
    target_east_m: float | None = None
    cross_track_error_m: float | None = None  # positive to starboard of the path
    course_rad: float | None = None  # of the path here
    distance_to_go_m: float | None = None  # to the target, along the path


NEUTRAL_SETPOINT = Setpoint(SetpointKind.NEUTRAL)


# --- allocate, gate ------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Allocation:
    """Thruster demands, the wrench they will give, and per axis whether that falls short of what was asked."""

    thrusters: tuple[ThrusterCommand, ...]
    achieved: Wrench
    limited: tuple[bool, bool, bool]


# --- record --------------------------------------------------------------------------------------------------------


@quick
@dataclass(frozen=True, slots=True)
class DeviceHealth:
    """One sensor, bridge or link as seen by its driver. `age_s` since the last good message; None before the first."""

    name: str
    ok: bool
    age_s: float | None
    text: str = ""


@quick
@dataclass(frozen=True, slots=True)
class Inputs:
    """The newest slow readings, kept by the loop for telemetry."""

    battery: Battery | None = None
    leak: Leak | None = None
    rc: RcInput | None = None
    manual: ManualInput | None = None
    wind: Wind | None = None
    depth: Depth | None = None
    corrections: Corrections | None = None


@dataclass(frozen=True, slots=True)
class Tick:
    """One cycle of the loop, whole. Log, telemetry and displays are made from this and nothing else."""

    t_s: float
    time_unix_ns: int
    nav: NavState
    status: Status
    setpoint: Setpoint
    wrench: Wrench
    allocation: Allocation
    command: ActuatorCommand
    inputs: Inputs
    feedback: tuple[ThrusterFeedback | None, ...]
    health: tuple[DeviceHealth, ...]
    events: tuple[Event, ...] = field(default=())
    load: float = 0.0  # share of the tick's period spent computing
    readings: Sequence[Reading] = ()  # what the estimator was given
    conditions: tuple[Condition, ...] = ()  # of the thrusters
