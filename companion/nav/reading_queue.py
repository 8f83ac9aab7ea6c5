"""Readings wait until the filter comes to their time: it runs behind the present by the longest latency of the sensors
that give them, so that a delayed measurement meets the state of its own time."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from operator import attrgetter

from companion.core.readings import GnssFix, GroundVelocity, Heading, HeadingBy, Imu, MagneticField, Reading
from companion.nav.slow_samples import SlowSamples

_MEASURED = frozenset({GnssFix, GroundVelocity, Heading, MagneticField})
_MOST_HALF_S = 0.005  # a sensor may send faster than its row says
_LONGEST_S = 0.5  # no sensor, however slow, holds up the filter by more: what comes later is fused by its lag


class ReadingQueue:
    """`add` the readings of a tick, in any order, then take those that are `due`.

    Only sensors whose readings have come count, so that a slow wind sensor holds up nothing. A receiver whose values
    are later than its row says (`late_s`) gets its readings dated back by that. The samples of a slow inertial sensor
    come in parts (`SlowSamples`), for which measurements of its step wait. Remembers the readings that are not due yet,
    and the longest latency.
    """

    def __init__(
        self,
        latencies_s: Mapping[str, float],
        late_s: Callable[[str], float],
        periods_s: Mapping[str, float] | None = None,
        averaging: Collection[str] = (),
    ) -> None:
        """`latencies_s`: by the vessel's file; `late_s(source)`: of a receiver, beyond that. `periods_s`: between two
        samples of an inertial sensor. `averaging`: the inertial sensors whose samples are means since the one
        before."""
        self._latencies_s, self._late_s = latencies_s, late_s
        self._half_s = {source: min(0.5 * period_s, _MOST_HALF_S) for source, period_s in (periods_s or {}).items()}
        self._slow = SlowSamples(averaging)
        self._lags_s: dict[tuple[str, bool], float] = {}
        self._settled: set[str] = set()  # sources that are no receivers: their latency never changes
        self.lag_s = 0.0
        self.pending: list[Reading] = []

    def add(self, readings: Sequence[Reading]) -> None:
        """Take the readings of navigation among these."""
        arrived = [self._dated(reading) for reading in readings if type(reading) in _MEASURED]
        arrived += self._in_parts([reading for reading in readings if type(reading) is Imu])
        if arrived:
            self.pending.extend(arrived)
            self.pending.sort(key=self._turn_s)

    def due(self, now_s: float) -> list[Reading]:
        """Take out the readings up to `now_s` less the longest latency, in order of time. Each meets the inertial
        sample nearest to it: the turns and accelerations of waves change in a few milliseconds."""
        horizon_s = now_s - self.lag_s
        count = 0
        for reading in self.pending:
            if self._turn_s(reading) > horizon_s:
                break
            count += 1
        due = self.pending[:count]
        del self.pending[:count]
        return due

    def _turn_s(self, reading: Reading) -> float:
        """The time by which readings are in order: an inertial sample holds from half a period before it on."""
        return reading.t_s - self._half_s.get(reading.source, 0.0) if type(reading) is Imu else reading.t_s

    def _in_parts(self, samples: list[Imu]) -> list[Imu]:
        """Inertial samples in order of time, those of a slow sensor in parts."""
        samples.sort(key=attrgetter("t_s"))
        parts = [part for imu in samples for part in self._slow.parts(imu)]
        for source in {imu.source for imu in samples}:
            latency_s = self._latencies_s.get(source, 0.0)
            self._take_lag((source, False), latency_s + self._slow.period_s(source))
        return parts

    def _dated(self, reading: Reading) -> Reading:
        if not _of_receiver(reading):
            if reading.source not in self._settled:
                self._settled.add(reading.source)
                self._take_lag((reading.source, False), self._latencies_s.get(reading.source, 0.0))
            return reading
        late_s = self._late_s(reading.source)
        key = reading.source, late_s != 0.0
        self._take_lag(key, self._latencies_s.get(reading.source, 0.0) + late_s)
        if late_s and isinstance(reading, GnssFix | GroundVelocity | Heading):
            return replace(reading, t_s=reading.t_s - late_s)
        return reading

    def _take_lag(self, key: tuple[str, bool], lag_s: float) -> None:
        lag_s = min(max(lag_s, 0.0), _LONGEST_S)
        if lag_s != self._lags_s.get(key):
            self._lags_s[key] = lag_s
            self.lag_s = max(self._lags_s.values())


def _of_receiver(reading: Reading) -> bool:
    return isinstance(reading, GnssFix | GroundVelocity) or (
        isinstance(reading, Heading) and reading.by is HeadingBy.BASELINE
    )
