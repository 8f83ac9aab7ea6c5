"""The tasks of a mission, and the actions on the way. All are frozen; `seq` is the mission item that they come from."""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.core.payload import Forward

_DAY_S = 86400


@dataclass(frozen=True, slots=True)
class RoutePoint:
    """A point to pass. `radius_m` None: the vessel's acceptance radius. `speed_mps`: on the leg to it; None: the
    vessel's speed.

    `yaw_rad`: the heading that the item asks for, or None. `straight`: the leg to it belongs to a survey.
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

    The mode reports each passed point to the executor; the task stays the same until the last one. With laps a `seq`
    may occur several times: the order counts. `beyond`: the first points of the next task if the boat sails on without
    a stop; they shape the path. `astern`: stern first.
    """

    route: tuple[RoutePoint, ...]
    stop: bool
    beyond: tuple[RoutePoint, ...] = ()
    astern: bool = False


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

    `until_utc` (hour, minute, second; −1 matches any) is None for a plain duration. Otherwise `duration_s` is infinite,
    and `wait_s` gives the wait from a given moment.
    """

    seq: int
    duration_s: float
    until_utc: tuple[int, int, int] | None = None

    def wait_s(self, time_unix_ns: int | None) -> float:
        """The wait in s from `time_unix_ns` to the next moment that matches; infinite while the time is unknown
        (None)."""
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
    """Turn on the spot, to `yaw_rad`, or by that angle if `relative`. `direction`: −1 to port, 1 to starboard, 0 the
    shorter way."""

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
    """Come alongside the berth at that position, with the heading `yaw_rad`. None: no berth is there, hold there."""

    seq: int
    lat_deg: float
    lon_deg: float
    yaw_rad: float | None


@dataclass(frozen=True, slots=True)
class Orbit:
    """Circle this point `turns` times. `radius_m` None: CIRC_RADIUS; `clockwise` None: CIRC_DIR. `speed_mps`: as in
    `RoutePoint`.

    `leave_to` (lat_deg, lon_deg): after the turns the boat continues round the circle until it points there; None: it
    leaves at once.
    """

    seq: int
    lat_deg: float
    lon_deg: float
    radius_m: float | None
    clockwise: bool | None
    turns: float
    speed_mps: float | None
    leave_to: tuple[float, float] | None = None


@dataclass(frozen=True, slots=True)
class SeaTrial:
    """Sail a sea trial round the place where the boat is. `radius_m` of its circle; None: TRIAL_RADIUS."""

    seq: int
    radius_m: float | None


@dataclass(frozen=True, slots=True)
class Complete:
    """Nothing is left to do."""


Task = Sail | Stay | Wait | Turn | ReturnHome | Dock | Orbit | SeaTrial | Complete


@dataclass(frozen=True, slots=True)
class SetSpeed:
    """Sail at this speed from here on; None: the vessel's speed."""

    speed_mps: float | None


@dataclass(frozen=True, slots=True)
class SetHome:
    """Move home to a position; None, None: to the boat's position."""

    lat_deg: float | None
    lon_deg: float | None


@dataclass(frozen=True, slots=True)
class SwitchFence:
    """The fence off, or on again."""

    on: bool


@dataclass(frozen=True, slots=True)
class SetFollowPosition:
    """Change the follow position, in the leader's frame; None keeps the present value."""

    bearing_rad: float | None
    distance_m: float | None


@dataclass(frozen=True, slots=True)
class FollowLeader:
    """Change to Follow at item `seq`. `system_id` None: the present leader."""

    seq: int
    system_id: int | None


@dataclass(frozen=True, slots=True)
class BeginTrial:
    """Change to Trial at item `seq`; the mission goes on with the next item when the trial is complete. `radius_m`: as
    in `SeaTrial`."""

    seq: int
    radius_m: float | None


@dataclass(frozen=True, slots=True)
class SetServo:
    """Set servo output `number` (from 1) to this pulse. With a `count`, do it so many times for half of `cycle_s` each,
    with the former pulse in between."""

    number: int
    pulse_us: float
    count: int = 0
    cycle_s: float = 0.0


@dataclass(frozen=True, slots=True)
class SetRelay:
    """Switch relay `number` (from 0). `on` None: toggle it and back, `count` times, for half of `cycle_s` each."""

    number: int
    on: bool | None
    count: int = 0
    cycle_s: float = 0.0


@dataclass(frozen=True, slots=True)
class SetActuators:
    """Set servo outputs 1, 2, … to shares of their travel, −1…1; None leaves an output as it is."""

    values: tuple[float | None, ...]


AuxiliaryAction = SetServo | SetRelay | SetActuators


@dataclass(frozen=True, slots=True)
class TakePicture:
    """One picture now. `camera`: its number from 1, 0 for all, as in all actions on cameras. `sequence`: of the
    request, 0 for none; the same one again is a repetition."""

    camera: int = 0
    sequence: int = 0


@dataclass(frozen=True, slots=True)
class ByDistance:
    """A picture every `spacing_m` along the boat's track, 0 to stop. `at_once`: and one now."""

    camera: int
    spacing_m: float
    at_once: bool = False


@dataclass(frozen=True, slots=True)
class ByTime:
    """A picture now and every `interval_s`, `count` in all; None: until it is stopped."""

    camera: int
    interval_s: float
    count: int | None = None


@dataclass(frozen=True, slots=True)
class StopPictures:
    """No more pictures by distance or time."""

    camera: int = 0


@dataclass(frozen=True, slots=True)
class TriggerControl:
    """Switch the triggers of all cameras on or off, or pause them, as they are; None changes nothing. `reset`: number
    the pictures from 1 again."""

    enable: bool | None
    pause: bool | None
    reset: bool = False


@dataclass(frozen=True, slots=True)
class TriggerAsBefore:
    """The mission begins at, or jumps to, another item: cameras do what the items before it say; None: nothing."""

    trigger: ByDistance | ByTime | None


CameraAction = TakePicture | ByDistance | ByTime | StopPictures | TriggerControl | TriggerAsBefore
PayloadAction = CameraAction | Forward
Setting = SetSpeed | SetHome | SwitchFence | SetFollowPosition
Action = Setting | FollowLeader | BeginTrial | AuxiliaryAction | PayloadAction


@dataclass(frozen=True, slots=True)
class DoCondition:
    """A condition that delays "do" items: `delay_s` from its start, or until the boat is within `distance_m` of the
    next destination.

    `serial` distinguishes it from later ones, also if a lap comes to the same item again.
    """

    seq: int
    serial: int
    delay_s: float | None
    distance_m: float | None
