"""Several inertial sensors: each brought to what the filter knows of the biases, and a vote among three or more.

The filter learns the biases of one unit. Another one has others, so that a plain switch would turn and tilt the
estimate by their difference for a minute. So each unit has an offset, its mean difference from what the filter gets,
and the filter gets samples less that. Units that sit apart from each other feel other forces in a turn, at its begin
and when the boat rolls: what these make of their places is no offset. Of three units or more it gets the median of each
axis: one that lies has no part in it, from its first sample on, before anything has found that it lies
(`integrity/imu_apart.py`). Of two, neither knows which is right: the filter gets the one in use.

ArduPilot and PX4 run a whole filter for each unit instead, and choose the one with the smaller innovations. That costs
a filter a unit, and notices a lie only by what it has done to one of them.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from statistics import median

from companion.config.devices import SensorConfig
from companion.config.sensors import is_inertial
from companion.core.readings import Imu
from companion.nav.lever_arms import ZERO, Vector, centripetal_mps2, cross, lever_arms, relative

_MEAN_S = 30.0  # over which an offset is averaged
_KNOWN_S = 5.0  # from when on it counts
_FRESH_S = 0.03  # age of a sample up to which it votes
_GAP_S = 0.5  # after a longer silence a unit begins anew
_VOTED_S = 1.0
_ANGULAR_S = 0.05  # over which the gyros' rates are compared for the angular acceleration
_SILENT_SAMPLES, _LEAST_SILENCE_S = 5.0, 0.05  # after which another unit takes over

Six = tuple[float, ...]
_ZERO: Six = (0.0,) * 6


@dataclass(slots=True)
class _Unit:
    """Its last sample, and its offset since when."""

    since_s: float
    t_s: float
    values: Six
    offset: Six = _ZERO
    bound: bool = False  # the offset is known: it counts from now on

    @property
    def aligned(self) -> Six:
        return tuple([value - off for value, off in zip(self.values, self.offset, strict=True)])


class InertialUnits:
    """Call `take` for each sample of each unit that is trusted. Remembers the units, what the filter got last, as of
    the boat's origin, and the angular acceleration by that."""

    def __init__(self, levers_m: Mapping[str, Vector] | None = None) -> None:
        """`levers_m`: from the boat's origin to each unit; None: they sit at one place."""
        self._levers_m = levers_m or {}
        self._units: dict[str, _Unit] = {}
        self._given: tuple[float, Six] | None = None
        self._voted_s = -math.inf
        self._mean_radps: Vector = ZERO
        self._angular_radps2: Vector = ZERO

    def drop(self, source: str) -> None:
        """A unit that is not trusted, or has been calibrated anew, begins again."""
        self._units.pop(source, None)

    def voted(self, now_s: float) -> bool:
        """Whether what the filter got lately was a vote: then no single unit can have spoilt it."""
        return now_s - self._voted_s <= _VOTED_S

    def take(self, imu: Imu, used: bool) -> Imu:
        """The sample for the filter, if the unit is the one in use; else of no meaning."""
        unit, values = self._units.get(imu.source), _values(imu)
        if unit is None or imu.t_s - unit.t_s > _GAP_S:
            kept = _ZERO if unit is None else unit.offset
            unit = self._units[imu.source] = _Unit(imu.t_s, imu.t_s, values, kept, bound=not self._runs(imu.t_s))
        dt_s, lever_m, angular = imu.t_s - unit.t_s, self._levers_m.get(imu.source, ZERO), self._angular_radps2
        rates = relative(_rates(values), _rates(unit.offset))
        unit.t_s, unit.values = imu.t_s, _moved(values, rates, angular, lever_m, -1.0)
        if used:
            self._give(imu.t_s, self._vote(unit))
        self._align(unit, dt_s)
        if not used or self._given is None:
            return imu
        given = self._given[1]
        x, y, z, p, q, r = _moved(given, _rates(given), angular, lever_m, 1.0)
        return replace(imu, x_mps2=x, y_mps2=y, z_mps2=z, roll_rate_radps=p, pitch_rate_radps=q, yaw_rate_radps=r)

    def aligned(self, imu: Imu) -> Imu:
        """A sample less the offset of its unit."""
        unit = self._units.get(imu.source)
        if unit is None or unit.offset == _ZERO:
            return imu
        x, y, z, p, q, r = (value - off for value, off in zip(_values(imu), unit.offset, strict=True))
        return replace(imu, x_mps2=x, y_mps2=y, z_mps2=z, roll_rate_radps=p, pitch_rate_radps=q, yaw_rate_radps=r)

    def _give(self, t_s: float, given: Six) -> None:
        """The filter gets that. The angular acceleration is the slope of its rates."""
        rates, before = _rates(given), self._given
        self._given = t_s, given
        dt_s = math.inf if before is None else t_s - before[0]
        if not 0.0 < dt_s <= _GAP_S:
            self._mean_radps, self._angular_radps2 = rates, ZERO
            return
        (x, y, z), share = relative(rates, self._mean_radps), dt_s / (_ANGULAR_S + dt_s)
        p, q, r = self._mean_radps
        self._mean_radps = p + share * x, q + share * y, r + share * z
        time_s = _ANGULAR_S + dt_s
        self._angular_radps2 = x / time_s, y / time_s, z / time_s

    def _runs(self, t_s: float) -> bool:
        """Whether the filter gets samples that a unit can be compared with."""
        return self._given is not None and t_s - self._given[0] <= _GAP_S

    def _vote(self, used: _Unit) -> Six:
        voters = [unit for unit in self._units.values() if unit.bound and abs(used.t_s - unit.t_s) <= _FRESH_S]
        if len(voters) < 3 or not used.bound:
            return used.aligned
        self._voted_s = used.t_s
        return tuple([median(axis) for axis in zip(*(unit.aligned for unit in voters), strict=True)])

    def _align(self, unit: _Unit, dt_s: float) -> None:
        """Average the difference from what the filter got."""
        if self._given is None or abs(unit.t_s - self._given[0]) > _FRESH_S or dt_s <= 0.0:
            return
        known_s = unit.t_s - unit.since_s
        share = dt_s / (_MEAN_S if unit.bound else min(_MEAN_S, max(known_s, dt_s)))
        unit.offset = tuple(
            [
                off + share * (value - given - off)
                for off, value, given in zip(unit.offset, unit.values, self._given[1], strict=True)
            ]
        )
        unit.bound = unit.bound or known_s >= _KNOWN_S


def inertial_units(sensors: Iterable[SensorConfig]) -> InertialUnits | None:
    """None for a boat with one inertial sensor or none: it has nothing to bring together."""
    levers_m = lever_arms([row for row in sensors if is_inertial(row)])
    if len(levers_m) < 2:
        return None
    return InertialUnits(levers_m if len(set(levers_m.values())) > 1 else None)


def silences_s(sensors: Iterable[SensorConfig]) -> dict[str, float]:
    """How long each inertial sensor may be silent before another takes over: where there is another, some samples."""
    rows = tuple(sensors)
    several = sum(is_inertial(row) for row in rows) > 1
    return {
        row.name: min(row.timeout_s, max(_LEAST_SILENCE_S, _SILENT_SAMPLES / row.rate_hz))
        if several and is_inertial(row)
        else row.timeout_s
        for row in rows
    }


def _rates(values: Six) -> Vector:
    return values[3], values[4], values[5]


def _moved(values: Six, rates: Vector, angular_radps2: Vector, lever_m: Vector, sign: float) -> Six:
    """The sample by a sensor `lever_m` further away (sign 1), or nearer (-1): f ± (ω × (ω × l) + α × l)."""
    if lever_m == ZERO:
        return values
    (x, y, z), (ax, ay, az) = centripetal_mps2(rates, lever_m), cross(angular_radps2, lever_m)
    return values[0] + sign * (x + ax), values[1] + sign * (y + ay), values[2] + sign * (z + az), *values[3:]


def _values(imu: Imu) -> Six:
    return imu.x_mps2, imu.y_mps2, imu.z_mps2, imu.roll_rate_radps, imu.pitch_rate_radps, imu.yaw_rate_radps
