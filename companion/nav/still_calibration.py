"""Level and gyro bias of an inertial sensor, from a few seconds in which the boat lies still."""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.core.events import SHORT_NAME
from companion.core.readings import Heading, Imu, MagneticField, Reading
from companion.nav.lever_arms import Vector

_SILENT_S = 3.0
_FEWEST = 50
_MOST_TILT_RAD = math.radians(20.0)
_MOST_BIAS_RADPS = math.radians(5.0)  # what no gyro has: the boat turns
_AT_ENDS = 0.2  # share of the time, at its begin and at its end, over which directions are averaged
_LEVEL_PART = 0.3  # of the Earth's field, at least, which alone turns with the boat; to 70 degrees of latitude


class StillMean:
    """Means of one inertial sensor over `duration_s`: call `update` with the readings of each tick until `failure` or
    `complete`.

    `swing_radps`: largest standard deviation of a rate at which the boat counts as still; `turn_rad`: how far headings
    and magnetic fields may turn meanwhile. A steady turn looks like a bias to the gyro alone. `progress`: 0…1;
    `silent`: whether the failure is that the sensor sends too little. Remembers sums.
    """

    def __init__(
        self, name: str, duration_s: float, swing_radps: float, now_s: float, turn_rad: float = math.inf
    ) -> None:
        self.name = name
        self.progress = 0.0
        self.failure: str | None = None
        self.silent = False
        self._duration_s, self._swing_radps = duration_s, swing_radps
        self._begin_s = self._heard_s = now_s
        self._count = 0
        self._force = [0.0, 0.0, 0.0]
        self._rates = [0.0, 0.0, 0.0]
        self._squares = [0.0, 0.0, 0.0]
        self._turn_rad = turn_rad
        self._directions = _Directions()

    @property
    def complete(self) -> bool:
        """Whether the means are there."""
        return self.progress >= 1.0 and self.failure is None

    @property
    def force(self) -> Vector:
        """Mean specific force, m/s²."""
        x, y, z = (part / self._count for part in self._force)
        return x, y, z

    @property
    def rates(self) -> Vector:
        """Mean rates, rad/s."""
        x, y, z = (part / self._count for part in self._rates)
        return x, y, z

    def update(self, readings: Sequence[Reading], now_s: float) -> None:
        """Take the readings of a tick. Does nothing after the end."""
        if self.failure is not None or self.complete:
            return
        self.progress = min(1.0, (now_s - self._begin_s) / self._duration_s)
        for reading in readings:
            if isinstance(reading, Imu) and reading.source == self.name:
                self._heard_s = now_s
                self._add(reading)
            elif isinstance(reading, Heading | MagneticField):
                self._directions.add(reading, self.progress)
        if now_s - self._heard_s > _SILENT_S or (self.progress >= 1.0 and self._count < _FEWEST):
            self.silent = True
            self.failure = f"{self.name[:SHORT_NAME]} is silent"
        elif self._moves():
            self.failure = "the boat moves"

    def _add(self, imu: Imu) -> None:
        self._count += 1
        rates = (imu.roll_rate_radps, imu.pitch_rate_radps, imu.yaw_rate_radps)
        for i, (force, rate) in enumerate(zip((imu.x_mps2, imu.y_mps2, imu.z_mps2), rates, strict=True)):
            self._force[i] += force
            self._rates[i] += rate
            self._squares[i] += rate * rate

    def _moves(self) -> bool:
        rates = self._count >= _FEWEST and (self._swing() > self._swing_radps or self._turn() > _MOST_BIAS_RADPS)
        return rates or (self.progress >= 1.0 and self._directions.turned_rad() > self._turn_rad)

    def _swing(self) -> float:
        """Largest standard deviation of the rates."""
        means = self.rates
        variances = (square / self._count - mean * mean for square, mean in zip(self._squares, means, strict=True))
        return math.sqrt(max(0.0, *variances))

    def _turn(self) -> float:
        """Largest mean rate."""
        return max(map(abs, self.rates))


class _Directions:
    """How far the boat turns by each heading and magnetic field: `add` all, then `turned_rad`. Remembers sums."""

    def __init__(self) -> None:
        self._ends: dict[tuple[type, str], tuple[list[Vector], list[Vector]]] = {}

    def add(self, reading: Heading | MagneticField, progress: float) -> None:
        """Take one reading, at that share of the time."""
        if _AT_ENDS < progress < 1.0 - _AT_ENDS:
            return
        if isinstance(reading, Heading):
            unit = math.cos(reading.yaw_rad), math.sin(reading.yaw_rad), 0.0
        else:
            length = math.hypot(reading.x, reading.y, reading.z) or 1.0
            unit = reading.x / length, reading.y / length, reading.z / length
        ends = self._ends.setdefault((type(reading), reading.source), ([], []))
        ends[progress > 0.5].append(unit)

    def turned_rad(self) -> float:
        """The largest turn."""
        turns = (
            math.dist(_mean(first), _mean(last)) / (_LEVEL_PART if kind is MagneticField else 1.0)
            for (kind, _), (first, last) in self._ends.items()
            if first and last
        )
        return max(turns, default=0.0)


def _mean(units: Sequence[Vector]) -> Vector:
    x, y, z = (math.fsum(axis) / len(units) for axis in zip(*units, strict=True))
    return x, y, z


def level_of(force: Vector) -> tuple[float, float]:
    """(roll_rad, pitch_rad) of a sensor whose mean specific force at rest is `force`. Raises ValueError for a sensor
    that is not mounted level."""
    x, y, z = force
    roll, pitch = math.atan2(-y, -z), math.atan2(x, math.hypot(y, z))
    if max(abs(roll), abs(pitch)) > _MOST_TILT_RAD:
        tilt = math.degrees(max(abs(roll), abs(pitch)))
        raise ValueError(f"mounted {tilt:.0f} deg off level")
    return roll, pitch


def between_rad(one: Vector, other: Vector) -> float:
    """Angle between two vectors, 0…π; 0 where either has no length."""
    x, y, z = one
    u, v, w = other
    across = math.hypot(y * w - z * v, z * u - x * w, x * v - y * u)
    return math.atan2(across, x * u + y * v + z * w)
