"""A tick as the log keeps it for a replay, whatever file it stands in."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from operator import attrgetter

from companion.core.actuation import ZERO_WRENCH, ThrusterCommand, Wrench
from companion.core.readings import Reading
from companion.core.setpoint import (
    NO_PROGRESS,
    HeadingSetpoint,
    NeutralSetpoint,
    PathSetpoint,
    Point,
    PoseSetpoint,
    Progress,
    Setpoint,
    ThrusterSetpoint,
    WrenchSetpoint,
    desired_motion,
)
from companion.core.tick import DeviceHealth, Tick

_POSE = ("north_m", "east_m", "yaw_rad", "surge_mps", "sway_mps", "yaw_rate_radps")
_SETPOINT = (*_POSE, "surge_mps2", "sway_mps2", "yaw_radps2")
_WRENCH = ("surge_n", "sway_n", "yaw_nm")
TICK_COLUMNS = (
    "t_s",
    *_POSE,
    "armed",
    "setpoint_kind",
    *(f"setpoint_{name}" for name in _SETPOINT),
    *(f"setpoint_{name}" for name in _WRENCH),
    *(f"demanded_{name}" for name in _WRENCH),
    *(f"achieved_{name}" for name in _WRENCH),
)
_KINDS = (NeutralSetpoint, PoseSetpoint, PathSetpoint, HeadingSetpoint, WrenchSetpoint, ThrusterSetpoint)
_NUMBER_OF = {kind: number for number, kind in enumerate(_KINDS)}
_NAN3 = (math.nan, math.nan, math.nan)
_of_nav = attrgetter(*_POSE)
_of_motion = attrgetter(*_SETPOINT[3:])
_of_wrench = attrgetter(*_WRENCH)


@dataclass(frozen=True, slots=True)
class RecordedPacket:
    """A MAVLink packet that came in: when it was handled, its endpoint, and the persona of that endpoint
    (`persona`)."""

    t_s: float
    persona: str
    endpoint: str
    data: bytes


@dataclass(frozen=True, slots=True)
class RecordedTick:
    """A tick from the log. `pose` is north_m, east_m, yaw_rad, surge_mps, sway_mps, yaw_rate_radps of the estimate."""

    t_s: float
    pose: tuple[float, float, float, float, float, float]
    armed: bool
    setpoint: Setpoint
    demanded: Wrench
    achieved: Wrench
    readings: tuple[Reading, ...]
    parameters: tuple[tuple[str, float], ...]  # changed since the tick before
    packets: tuple[RecordedPacket, ...] = ()  # since the tick before, and those that the tick itself began with
    health: tuple[DeviceHealth, ...] = ()  # of devices that are otherwise than at the tick before


def tick_values(tick: Tick) -> tuple[float, ...]:
    """The values of TICK_COLUMNS, NaN for what is missing."""
    setpoint = tick.setpoint
    desired = desired_motion(setpoint)
    place = (math.nan, math.nan) if desired.place is None else (desired.place.north_m, desired.place.east_m)
    wrench = _of_wrench(setpoint.wrench) if isinstance(setpoint, HeadingSetpoint | WrenchSetpoint) else _NAN3
    return (
        tick.nav.t_s,
        *_of_nav(tick.nav),
        float(tick.status.armed),
        float(_NUMBER_OF[type(setpoint)]),
        *place,
        math.nan if desired.yaw_rad is None else desired.yaw_rad,
        *_of_motion(desired),
        *wrench,
        *_of_wrench(tick.wrench),
        *_of_wrench(tick.allocation.achieved),
    )


def unsteered_values(t_s: float) -> tuple[float, ...]:
    """The values of TICK_COLUMNS of a tick in which nothing is steered and no pose is told."""
    armed, kind = 0.0, float(_NUMBER_OF[NeutralSetpoint])
    return (t_s, *[math.nan] * len(_POSE), armed, kind, *[math.nan] * (len(TICK_COLUMNS) - len(_POSE) - 3))


def thruster_values(tick: Tick) -> tuple[list[float], list[float]]:
    """Throttles and azimuths where the setpoint sets them; NaN for a thruster that does not turn."""
    commands = tick.setpoint.thrusters if isinstance(tick.setpoint, ThrusterSetpoint) else ()
    azimuths = [math.nan if t.azimuth_rad is None else t.azimuth_rad for t in commands]
    return [t.throttle for t in commands], azimuths


def tick_of(
    values: Sequence[float],
    throttles: Sequence[float],
    azimuths: Sequence[float],
    readings: tuple[Reading, ...],
    changes: tuple[tuple[str, float], ...],
) -> RecordedTick:
    """The tick of `tick_values`, `thruster_values`, its readings, and the parameters changed since the tick before.
    Raises ValueError for values that are no tick."""
    if len(values) != len(TICK_COLUMNS):
        raise ValueError(f"{len(values)} values, a tick has {len(TICK_COLUMNS)}")
    t_s, n, e, yaw, u, v, r, armed, kind = values[:9]
    thrusters = tuple(
        ThrusterCommand(0.0, throttle, None if math.isnan(azimuth) else azimuth)
        for throttle, azimuth in zip(throttles, azimuths, strict=True)
    )
    setpoint = _setpoint_of(int(kind), values[9:21], thrusters)
    return RecordedTick(
        t_s,
        (n, e, yaw, u, v, r),
        bool(armed),
        setpoint,
        Wrench(*values[21:24]),
        Wrench(*values[24:27]),
        readings,
        changes,
    )


def _setpoint_of(kind: int, values: Sequence[float], thrusters: tuple[ThrusterCommand, ...]) -> Setpoint:
    kind_type = _KINDS[kind]
    sn, se, syaw = (None if math.isnan(value) else value for value in values[:3])
    su, sv, sr, au, av, ar = values[3:9]
    wrench = ZERO_WRENCH if math.isnan(values[9]) else Wrench(*values[9:12])
    progress = NO_PROGRESS if sn is None or se is None else Progress(place=Point(sn, se))
    if kind_type is PoseSetpoint:
        return PoseSetpoint(sn or 0.0, se or 0.0, syaw or 0.0, su, sv, sr, au, av, ar)
    if kind_type is PathSetpoint:
        return PathSetpoint(syaw or 0.0, su, sv, sr, au, progress, av, ar)
    if kind_type is HeadingSetpoint:
        return HeadingSetpoint(syaw or 0.0, wrench, sr, progress)
    if kind_type is WrenchSetpoint:
        return WrenchSetpoint(wrench, replace(progress, yaw_rad=syaw))
    if kind_type is ThrusterSetpoint:
        return ThrusterSetpoint(thrusters, progress)
    return NeutralSetpoint(progress)
