"""Heading from the positions of two receivers, whose antennas stand at known places of the hull.

The direction from one antenna to the other, less its direction in the hull, is the heading. Over a baseline of L it is
as good as √2 σ/L: only carrier phase helps, 2 cm over 2 m are 0.8°. The filter's gyro averages it from fix to fix, as
it does with any heading. A receiver with two antennas of its own does better, since it solves for the baseline alone.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from companion.config.devices import SensorConfig
from companion.core.angles import wrap_pi
from companion.core.readings import FixType, GnssFix, Heading, HeadingBy
from companion.nav.lever_arms import Vector, relative

_APART_SHARE = 0.6  # of the interval between fixes: further apart in time they are not of one moment
_WORST_RAD = math.radians(5.0)  # one sigma from which on a heading is of no use
_LENGTH_SIGMAS, _LENGTH_M = 4.0, 0.05  # by which the baseline may be too long or too short: a wrong fix makes it so
_CARRIER_WANDER_M = 0.008


@dataclass(frozen=True, slots=True)
class _Seen:
    """One end of the baseline: place and velocity of an antenna in NED."""

    t_s: float
    north_m: float
    east_m: float
    north_mps: float
    east_mps: float
    sigma_m: float


def pair_name(row: SensorConfig) -> str:
    """Name of the heading that a receiver gives with another."""
    return f"{row.name}+{row.heading_with}"


class AntennaPair:
    """Call `take` for each fix of either receiver. Remembers the last one of each that is not used up."""

    def __init__(self, row: SensorConfig, other: SensorConfig) -> None:
        self.name = pair_name(row)
        self.timeout_s = max(row.timeout_s, other.timeout_s)
        self._names = row.name, other.name
        self._baseline: Vector = relative((other.x_m, other.y_m, other.z_m), (row.x_m, row.y_m, row.z_m))
        self._apart_s = _APART_SHARE / max(row.rate_hz, other.rate_hz)
        wanders = [_CARRIER_WANDER_M if w is None else w for w in (row.position_wander_m, other.position_wander_m)]
        self.wander_rad = math.hypot(*wanders) / math.hypot(self._baseline[0], self._baseline[1])
        self._seen: dict[str, _Seen] = {}

    def take(
        self,
        fix: GnssFix,
        place_m: tuple[float, float],
        velocity_mps: tuple[float, float],
        tilt_rad: tuple[float, float],
        sigma_m: float,
    ) -> Heading | None:
        """The heading that a fix completes. `place_m`, `velocity_mps`: of its antenna in NED; `tilt_rad`: roll and
        pitch; `sigma_m`: of the fix on each axis."""
        if fix.source not in self._names or fix.fix < FixType.RTK_FLOAT:
            return None
        self._seen[fix.source] = _Seen(fix.t_s, *place_m, *velocity_mps, sigma_m)
        first, second = (self._seen.get(name) for name in self._names)
        if first is None or second is None or abs(first.t_s - second.t_s) > self._apart_s:
            return None
        self._seen.clear()
        return self._heading(first, second, tilt_rad)

    def _heading(self, first: _Seen, second: _Seen, tilt_rad: tuple[float, float]) -> Heading | None:
        later_s = second.t_s - first.t_s
        north = second.north_m - first.north_m - 0.5 * later_s * (first.north_mps + second.north_mps)
        east = second.east_m - first.east_m - 0.5 * later_s * (first.east_mps + second.east_mps)
        ahead, starboard = _levelled(self._baseline, *tilt_rad)
        length_m, sigma_m = math.hypot(ahead, starboard), math.hypot(first.sigma_m, second.sigma_m)
        sigma_rad = sigma_m / max(length_m, 1e-3)
        if abs(math.hypot(north, east) - length_m) > _LENGTH_M + _LENGTH_SIGMAS * sigma_m or sigma_rad > _WORST_RAD:
            return None
        yaw_rad = wrap_pi(math.atan2(east, north) - math.atan2(starboard, ahead))
        return Heading(max(first.t_s, second.t_s), self.name, yaw_rad, sigma_rad, HeadingBy.BASELINE)


def antenna_pairs(sensors: Iterable[SensorConfig]) -> tuple[AntennaPair, ...]:
    """Of all receivers that name another for their heading."""
    rows: Mapping[str, SensorConfig] = {row.name: row for row in sensors}
    return tuple(
        AntennaPair(row, rows[row.heading_with])
        for row in rows.values()
        if row.heading_with is not None and row.heading_with in rows
    )


def _levelled(vector: Vector, roll_rad: float, pitch_rad: float) -> tuple[float, float]:
    """Ahead and to starboard in the level frame with the hull's heading, of a vector in body axes."""
    x, y, z = vector
    down = math.sin(roll_rad) * y + math.cos(roll_rad) * z
    return (
        math.cos(pitch_rad) * x + math.sin(pitch_rad) * down,
        math.cos(roll_rad) * y - math.sin(roll_rad) * z,
    )
