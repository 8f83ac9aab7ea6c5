"""What a mission has the boat do (tasks), and what it changes on the way (actions). All frozen; `seq` is the item it comes from."""

from __future__ import annotations

import math
from dataclasses import dataclass

_DAY_S = 86400


@dataclass(frozen=True, slots=True)
class RoutePoint:
    """A point to pass. `radius_m` None: the vessel's own acceptance radius; `speed_mps` towards it, None: the vessel's own.

    `yaw_rad`: heading that the item asks for, if any. `straight`: the leg towards it is one of a survey.
    """

    seq: int
    lat_deg: float
    lon_deg: float
    radius_m: float | None
    speed_mps: float | None
    yaw_rad: float | None = None
    straight: bool = False


@dataclass(frozen=True, slots=True)
class Sail:
    """Pass these points in this order, and come to rest at the last one if `stop`.

    Each one passed is told to the executor, and the task stays the same until the last. In a mission that sails laps a `seq` may occur
    several times: the order counts. `beyond`: the first points of the next task, where that sails on without a stop; they shape the path.
    """

    route: tuple[RoutePoint, ...]
    stop: bool
    beyond: tuple[RoutePoint, ...] = ()


@dataclass(frozen=True, slots=True)
class Stay:
    """Hold at this point. `yaw_rad` None: any heading; `duration_s` None: for ever."""

    seq: int
    lat_deg: float
    lon_deg: float
    yaw_rad: float | None
    duration_s: float | None


@dataclass(frozen=True, slots=True)
class Wait:
    """Hold where the boat is, for `duration_s` or until a time of day.

    `until_utc` (hour, minute, second; −1 matches any) is None for a plain duration; where it is given, `duration_s` is infinite,
    and `wait_s` says how long the wait is from a given moment.
    """

    seq: int
    duration_s: float
    until_utc: tuple[int, int, int] | None = None

    def wait_s(self, time_unix_ns: int | None) -> float:
        """Duration of the wait if it begins at `time_unix_ns`: to the next moment that matches. Infinite while the time is unknown."""
        if self.until_utc is None:
            return self.duration_s
        if time_unix_ns is None:
            return math.inf
        now_s, fraction_ns = divmod(time_unix_ns, 1_000_000_000)
        hours, minutes, seconds = (
            range(limit) if value < 0 else (value,) for value, limit in zip(self.until_utc, (24, 60, 60), strict=True)
        )
        whole_s = min((h * 3600 + m * 60 + s - now_s) % _DAY_S for h in hours for m in minutes for s in seconds)
        return whole_s - fraction_ns * 1e-9 if whole_s else 0.0


@dataclass(frozen=True, slots=True)
class Turn:
    """Turn on the spot: to `yaw_rad`, or by it if `relative`. `direction`: −1 to port, 1 to starboard, 0 the shorter way."""

    seq: int
    yaw_rad: float
    relative: bool
    direction: int


@dataclass(frozen=True, slots=True)
class ReturnHome:
    """Sail home, or to the rally point that RTL would choose."""

    seq: int


@dataclass(frozen=True, slots=True)
class Dock:
    """Come alongside the berth there, lying at `yaw_rad`."""

    seq: int
    lat_deg: float
    lon_deg: float
    yaw_rad: float


@dataclass(frozen=True, slots=True)
class Complete:
    """Nothing is left to do."""


Task = Sail | Stay | Wait | Turn | ReturnHome | Dock | Complete


@dataclass(frozen=True, slots=True)
class SetSpeed:
    """From here on sail at this speed; None: the vessel's own."""

    speed_mps: float | None


@dataclass(frozen=True, slots=True)
class SetHome:
    """Move home; None, None: to where the boat is."""

    lat_deg: float | None
    lon_deg: float | None


@dataclass(frozen=True, slots=True)
class SetStation:
    """The station on the lead boat, in its frame; None keeps what is."""

    bearing_rad: float | None
    distance_m: float | None


@dataclass(frozen=True, slots=True)
class FollowLeader:
    """Item `seq` hands over to Follow. `system_id` None: the leader that the vessel has."""

    seq: int
    system_id: int | None


@dataclass(frozen=True, slots=True)
class SetServo:
    """Give servo output `number`, from 1, this pulse; with a count, so many times for half of `cycle_s`, in between what it was before."""

    number: int
    pulse_us: float
    count: int = 0
    cycle_s: float = 0.0


@dataclass(frozen=True, slots=True)
class SetRelay:
    """Switch relay `number`, from 0; `on` None: to its other state and back, `count` times, for half of `cycle_s` each."""

    number: int
    on: bool | None
    count: int = 0
    cycle_s: float = 0.0


@dataclass(frozen=True, slots=True)
class SetActuators:
    """Servo outputs 1, 2, … as shares of their travel, −1…1; None leaves one as it is."""

    values: tuple[float | None, ...]


AuxiliaryAction = SetServo | SetRelay | SetActuators
Action = SetSpeed | SetHome | SetStation | FollowLeader | AuxiliaryAction


@dataclass(frozen=True, slots=True)
class Gate:
    """What holds back "do" items now: so many seconds from when it was met, or being so near to the next destination.

    `serial` tells one from the next, also where a lap comes by the same item again.
    """

    seq: int
    serial: int
    delay_s: float | None
    distance_m: float | None
