"""Values of the step decide: the vessel's mode and state, its answers to requests, and what it announces."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum, IntEnum
from typing import Protocol

from companion.core.actuation import ZERO_WRENCH, Wrench
from companion.core.estimate import Contact, Leader, NavState, TrackedTarget
from companion.core.named import Named
from companion.core.readings import ManualInput


class ModeId(Named):
    """The modes of the vessel; the value is the name that people see. Logs count them in this order: a new one comes
    last."""

    MANUAL = "Manual"
    FORCES = "Forces"
    HEADING = "Heading"
    HOLD = "Hold"
    MISSION = "Mission"
    RTL = "RTL"
    DOCK = "Dock"
    FOLLOW = "Follow"
    OFFBOARD = "Offboard"
    CIRCLE = "Circle"
    TRIAL = "Trial"
    RATE = "Rate"


class Severity(IntEnum):
    """Severity of an event; the numbers are those of MAVLink's MAV_SEVERITY."""

    EMERGENCY = 0
    ALERT = 1
    CRITICAL = 2
    ERROR = 3
    WARNING = 4
    NOTICE = 5
    INFO = 6
    DEBUG = 7


class TextKind(Enum):
    """The kinds of texts that the boat sends, each with its severity: who announces chooses a kind, never a severity.

    Ground stations go by the severity: QGroundControl opens a window for ERROR and worse, speaks NOTICE and worse, and
    keeps the rest quietly in its list. So NOTICE is not used.
    """

    ROUTINE = Severity.INFO, "what was asked is done, or all is as it should be"
    HINT = Severity.INFO, "why a program's request to read, or for a message rate, is not fulfilled"
    ATTENTION = Severity.WARNING, "something that nobody asked for, and that a person should know"
    REFUSAL = Severity.ERROR, "what an operator asked for is not done, now or when the mission comes to it"
    FAULT = Severity.ERROR, "a part of the program failed; the rest goes on"
    ALARM = Severity.CRITICAL, "the boat cannot do what it should, or a failsafe acts"
    DANGER = Severity.ALERT, "a person must act at once"

    @property
    def severity(self) -> Severity:
        """As ground stations get it."""
        return self.value[0]

    @property
    def meaning(self) -> str:
        """For the documentation."""
        return self.value[1]


class Need(Named):
    """What a mode cannot do without."""

    POSITION = "position"
    HEADING = "heading"
    LEADER = "leader"
    SIDEWAYS_THRUST = "sideways thrust"


SELF_STEERED_NEEDS = frozenset({Need.POSITION, Need.HEADING})


@dataclass(frozen=True, slots=True)
class LossFailsafe:
    """The failsafe of one mode: what it steers by is lost. It lasts as long as the loss, while the boat is in the mode
    or would be without the failsafe.

    `name` and `kind` are those of the event. `action` names the parameter with the action. `prefix` begins the
    announcement, the reason follows; `ends` announces the end. `back_after` names the parameter with the seconds for
    which the source must be good before the boat returns to the mode; None: it does not return by itself.
    """

    name: str
    kind: TextKind
    action: str
    ends: str
    prefix: str = ""
    back_after: str | None = None


@dataclass(frozen=True, slots=True)
class KnownRefusal:
    """A reason for which a mode cannot be entered, as ground stations list it beside the arming checks.

    `pattern`: regular expression that the whole reason matches. `text`: the reason without its values. `remedy`: what
    to do; a name between <param> and </param> is a parameter that QGroundControl opens.
    """

    pattern: str
    text: str
    remedy: str


class Order(Protocol):
    """What an operator asks of one mode when choosing it. Each such mode has its own frozen class."""

    @property
    def mode(self) -> ModeId:
        """The mode."""


@dataclass(frozen=True, slots=True)
class ModeDeclaration:
    """What the rest of the program needs to know of a mode. One declaration stands in each mode's file.

    `text`: for people. `again`: what happens when it is chosen again, for people. `px4`: PX4's `custom_mode`, main <<
    16 | sub << 24; the generic persona sends the same. `rover`: ArduPilot Rover's mode number; `rover_aliases`,
    `px4_aliases`: numbers that are understood too; `rover_orders`: how the mode is then to be sailed. `standard_mode`:
    MAV_STANDARD_MODE by which the mode can be asked for (0: none); `shows_standard`: it is reported too. `by_stick`:
    sticks steer, and their silence is a failure. `slows`: it slows down by itself ahead of the
    fence while the heading is known. `allocates`: the allocation drives the thrusters, and retractable ones
    are down. `early`: it may be chosen while disarmed although it cannot be entered yet; arming asks again.
    `selectable`: ground stations offer it; `advanced`: to experts only. `has_plan`: it leads somewhere by itself
    (MAV_MODE_FLAG_AUTO). `commands`: MAV_CMD numbers of its own. `refusals`: why it cannot be entered; the first whose
    pattern matches is listed.
    """

    id: ModeId
    text: str
    px4: int
    rover: int
    again: str = "nothing changes"
    rover_aliases: tuple[int, ...] = ()
    rover_orders: Mapping[int, Order] = field(default_factory=dict)
    px4_aliases: tuple[int, ...] = ()
    standard_mode: int = 0
    shows_standard: bool = False
    by_stick: bool = False
    slows: bool = False
    allocates: bool = True
    needs: frozenset[Need] = SELF_STEERED_NEEDS
    early: bool = False
    selectable: bool = True
    advanced: bool = False
    has_plan: bool = True
    failsafe: LossFailsafe | None = None
    commands: tuple[int, ...] = ()
    refusals: tuple[KnownRefusal, ...] = ()


@dataclass(frozen=True, slots=True)
class Event:
    """Something to announce. `name` is stable, for programs; `text` is for people."""

    t_s: float
    kind: TextKind
    name: str
    text: str

    @property
    def severity(self) -> Severity:
        """The severity of its kind."""
        return self.kind.severity


class Result(Enum):
    """Answer to a request; the names are those of MAVLink's MAV_RESULT."""

    ACCEPTED = 0
    TEMPORARILY_REJECTED = 1
    DENIED = 2
    UNSUPPORTED = 3
    FAILED = 4
    IN_PROGRESS = 5


@dataclass(frozen=True, slots=True)
class Outcome:
    """Answer to a request, with the reason if it is refused."""

    result: Result
    reason: str = ""

    @property
    def accepted(self) -> bool:
        """Whether the request is granted."""
        return self.result is Result.ACCEPTED


ACCEPTED = Outcome(Result.ACCEPTED)


@dataclass(frozen=True, slots=True)
class Home:
    """The place that RTL returns to. `yaw_rad` None: no heading was given with it."""

    lat_deg: float
    lon_deg: float
    altitude_m: float
    yaw_rad: float | None = None


class MissionState(IntEnum):
    """State of the mission; the numbers are those of MAVLink's MISSION_STATE."""

    NO_MISSION = 1
    NOT_STARTED = 2
    ACTIVE = 3
    PAUSED = 4
    COMPLETE = 5


@dataclass(frozen=True, slots=True)
class MissionProgress:
    """State of the mission: the current item `seq` of `count`. `reached` counts the items reached since the process
    started, `reached_seq` is the last of them."""

    state: MissionState
    seq: int
    count: int
    reached_seq: int | None = None
    reached: int = 0


@dataclass(frozen=True, slots=True)
class FenceState:
    """State of the fence in force. `breaches` counts since it came into force; the last breach began at `breach_s`."""

    breached: bool
    breaches: int
    breach_s: float | None
    slowed: bool  # the speed is limited, so that the boat can stop inside


@dataclass(frozen=True, slots=True)
class OrbitState:
    """The circle that is sailed. `radius_m`: negative counter-clockwise, as in MAVLink."""

    north_m: float
    east_m: float
    radius_m: float


@dataclass(frozen=True, slots=True)
class Status:
    """The supervisor's decision in one tick.

    `arming_refusals`: why arming would be refused; empty if it would be accepted. `fence`: None while no fence is in
    force. `traffic`: the vessels around, in the order of their MMSI. `leader`: None while no lead boat is heard.
    `orbit`: the circle that the mode sails, if any. `landed`: armed, but Land or Dock is done, or the mission that
    ended at home or a berth. `trial_left_s`: time until a sea trial is over; None while none is sailed. `guided`: the
    mode is Hold because somebody chose ArduPilot's Guided.
    """

    t_s: float
    mode: ModeId
    intended_mode: ModeId  # the mode last requested; differs from `mode` while a failsafe has chosen another
    armed: bool
    arming_refusals: tuple[str, ...]
    failsafes: tuple[str, ...]  # names of the active failsafes
    home: Home | None
    mission: MissionProgress
    speed_override_mps: float | None = None
    fence: FenceState | None = None
    traffic: tuple[TrackedTarget, ...] = ()
    leader: Leader | None = None
    orbit: OrbitState | None = None
    landed: bool = False
    trial_left_s: float | None = None
    guided: bool = False


@dataclass(frozen=True, slots=True)
class ModeInputs:
    """What a mode gets in each tick. `manual`: live sticks with authority, else None. `speed_mps`: the speed for modes
    that steer by themselves.

    `achieved`: the wrench that the thrusters gave in the last cycle, of the one `demanded`. `failed`: indices of failed
    thrusters; `up`: indices of those not lowered. `steers_late_s`: by how much the boat answers its helm later than its
    file says, since its steering is slow; `turn_resistance`: how many times as hard as the file says the water resists
    a turn. `leader`: None while no lead boat is heard; `leader_fault`: why it cannot be followed now. `station`: the
    follow position, (distance_m, bearing_rad in the leader's frame, π astern).
    """

    nav: NavState
    manual: ManualInput | None
    home: Home | None
    speed_mps: float
    now_s: float
    dt_s: float
    achieved: Wrench = ZERO_WRENCH
    demanded: Wrench = ZERO_WRENCH
    steers_late_s: float = 0.0
    turn_resistance: float = 1.0
    failed: frozenset[int] = frozenset()
    up: frozenset[int] = frozenset()
    leader: Leader | None = None
    leader_fault: str | None = None
    station: tuple[float, float] = (20.0, math.pi)
    order: Order | None = None  # with which the mode is chosen now
    contacts: tuple[Contact, ...] = ()  # vessels around, only for a mode that looks out for itself
