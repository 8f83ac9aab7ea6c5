"""Readings that do not affect the motion: absolute time and wind."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from companion.core.readings import Reading, TimeOfDay, Wind
from companion.nav.solution import Motion
from companion.nav.sources import SourceSelector
from companion.nav.witness import Witness

_WIND_TIMEOUT_S = 2.0


class AbsoluteTime:
    """`TimeOfDay` of a receiver → absolute time of any moment.

    Remembers the offset between both clocks, in whole nanoseconds. It follows each new offset by a tenth of the
    difference. A jump of one second or more it follows as a whole, once it has lasted: by then its first reading has
    been judged, and a receiver found to lie is not asked again.
    """

    _JUMP_NS = 1_000_000_000
    _LASTS_S = 0.5  # several control steps

    def __init__(self) -> None:
        self._offset_ns: int | None = None
        self._jump: tuple[int, float] | None = None  # the offset of the last readings, and the first one's time

    def update(self, t_s: float, time_unix_ns: int) -> None:
        """Take the absolute time at vessel time `t_s`."""
        offset = time_unix_ns - round(t_s * 1e9)
        if self._offset_ns is None:
            self._offset_ns = offset
        elif abs(offset - self._offset_ns) < self._JUMP_NS:
            self._offset_ns += (offset - self._offset_ns) // 10
            self._jump = None
        elif self._jump is None or abs(offset - self._jump[0]) >= self._JUMP_NS:
            self._jump = offset, t_s
        elif t_s - self._jump[1] >= self._LASTS_S:
            self._offset_ns, self._jump = offset, None

    def at_ns(self, now_s: float) -> int | None:
        """Absolute time at `now_s` in ns since 1970; None until a receiver gives one."""
        return None if self._offset_ns is None else self._offset_ns + round(now_s * 1e9)


class TrueWind:
    """Apparent wind and the boat's motion → true wind, low-pass filtered over 1 s. Remembers the filtered vector
    (NED, the direction that it blows to)."""

    _TIME_S = 1.0

    def __init__(self, timeout_s: float) -> None:
        self._timeout_s = timeout_s
        self._last_s = -math.inf
        self._north = self._east = 0.0

    def update(
        self, t_s: float, speed_mps: float, from_rad: float, yaw_rad: float, north_mps: float, east_mps: float
    ) -> None:
        """Take an apparent wind (`core.readings.Wind`), with the boat's heading and velocity over ground."""
        towards = yaw_rad + from_rad + math.pi
        north = speed_mps * math.cos(towards) + north_mps
        east = speed_mps * math.sin(towards) + east_mps
        stale = t_s - self._last_s > self._timeout_s
        share = 1.0 if stale else 1.0 - math.exp(-max(t_s - self._last_s, 0.0) / self._TIME_S)
        self._north += share * (north - self._north)
        self._east += share * (east - self._east)
        self._last_s = t_s

    def at(self, now_s: float) -> tuple[float | None, float | None]:
        """(speed_mps, from_rad) of the true wind; (None, None) if the sensor has timed out."""
        if now_s - self._last_s > self._timeout_s:
            return None, None
        return math.hypot(self._north, self._east), math.atan2(-self._east, -self._north)


class SideReadings:
    """`take` the readings of a tick, in any order → absolute time and true wind. `timeouts_s`: of the sensors.
    Remembers both, and the wind sensor in use."""

    def __init__(self, timeouts_s: Mapping[str, float], witness: Witness) -> None:
        self._witness = witness
        self._winds = SourceSelector(timeouts_s)
        self._wind, self._time = TrueWind(_WIND_TIMEOUT_S), AbsoluteTime()

    @property
    def wind_source(self) -> str | None:
        """The wind sensor in use; None before the first reading."""
        return self._winds.current

    def take(self, readings: Sequence[Reading], motion: Motion, oriented: bool) -> None:
        """Take those of `readings` that count here. `oriented`: the heading in `motion` is one; without it an apparent
        wind says nothing."""
        for reading in readings:
            if type(reading) is TimeOfDay:
                if self._witness.time(reading):
                    self._time.update(reading.t_s, reading.time_unix_ns)
            elif type(reading) is Wind and oriented:
                self._take_wind(reading, motion)

    def _take_wind(self, wind: Wind, motion: Motion) -> None:
        if self._winds.offer(wind.source, wind.t_s, self._witness.wind(wind)):
            yaw, (north, east, _) = motion.attitude[2], motion.velocity
            self._wind.update(wind.t_s, wind.speed_mps, wind.from_rad, yaw, north, east)

    def wind(self, now_s: float) -> tuple[float | None, float | None]:
        """As `TrueWind.at`."""
        return self._wind.at(now_s)

    def time_ns(self, t_s: float) -> int | None:
        """As `AbsoluteTime.at_ns`."""
        return self._time.at_ns(t_s)
