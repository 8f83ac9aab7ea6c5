"""When the values of an NMEA 0183 sentence were valid: by the UTC that it bears, else by that of its neighbours, else
by its arrival."""

from __future__ import annotations

from companion.io.sensors.message_timing import MessageTiming
from companion.io.sensors.nmea0183_fields import DAY_S, Sentence, seconds_of_day
from companion.io.sensors.sample_clock import SampleClock

_OWN_CLOCKS = ("ZDA", "TTM", "TLL")  # each kind: not that of the fixes
_JUMP_S = 0.3
_NEAR_S = 5.0  # from the last stamped sentence, for another message of the same clock
_NO_DELAY_S = 1e-3  # less tells nothing: most receivers print hundredths
_BURST_S = 0.03  # how long after a stamped sentence one without may still be of the same epoch,
_BURST_SHARE = 0.4  # and that as a share of the time between epochs


class SentenceTimes:
    """(kind, sentence, arrival of its first byte) → vessel time of validity.

    GGA, GNS, RMC, GLL, GST and ZDA carry UTC, and so do TTM and TLL of a radar. The smallest difference of arrival and
    stamp counts as the configured latency, so that sentences delayed by the line or the operating system keep their own
    time. ZDA has a clock of its own: some receivers send it with the pulse of the second, well before the measurements
    of that moment. TTM and TLL have theirs: the radar's may be wrong. HDT, VTG and others without a stamp belong to the
    epoch of the stamped one just before them, each kind once. Those that come alone are valid on arrival, less the
    latency. Remembers the relation of the clocks and the last epoch.
    """

    def __init__(self, latency_s: float, pace: MessageTiming) -> None:
        self._latency_s = latency_s
        self._pace = pace
        self._clock, *others = (SampleClock(latency_s, _JUMP_S, tick_s=1.0, wrap=DAY_S) for _ in ("", *_OWN_CLOCKS))
        self._own_clocks = dict(zip(_OWN_CLOCKS, others, strict=True))
        self._stamp_s: float | None = None
        self._interval_s = 0.0
        self._epoch_s = self._epoch_arrival_s = 0.0
        self._seen: set[str] = set()

    def of(self, kind: str, sentence: Sentence, arrival_s: float) -> float:
        """Vessel time at which the sentence was valid. Raises ValueError for a time field that is no time."""
        direct_s = arrival_s - self._latency_s
        if stamp := sentence.get("timestamp"):
            if own := self._own_clocks.get(kind):
                return self._aligned(own, seconds_of_day(stamp), arrival_s)[0]
            return self._stamped(seconds_of_day(stamp), arrival_s)
        since_s = arrival_s - self._epoch_arrival_s
        if (
            self._stamp_s is None
            or kind in self._seen
            or not 0.0 <= since_s <= min(_BURST_S, _BURST_SHARE * self._interval_s)
        ):
            return direct_s
        self._seen.add(kind)
        return min(self._epoch_s, direct_s)

    def at(self, of_day_s: float, arrival_s: float) -> float:
        """Vessel time of a moment of UTC, by the clock of the stamped sentences; valid on arrival, less the latency,
        where none came lately or the moment lies ahead or too far back."""
        direct_s = arrival_s - self._latency_s
        if self._stamp_s is None:
            return direct_s
        since_s = (of_day_s - self._stamp_s + 0.5 * DAY_S) % DAY_S - 0.5 * DAY_S
        t_s = self._epoch_s + since_s
        return t_s if abs(since_s) <= _NEAR_S and t_s <= arrival_s else direct_s

    def _aligned(self, clock: SampleClock, stamp_s: float, arrival_s: float) -> tuple[float, float]:
        """(time of validity, by how much it was late)."""
        direct_s = arrival_s - self._latency_s
        t_s = clock.time_s(stamp_s, arrival_s)
        late_s = direct_s - t_s
        return (direct_s if late_s < _NO_DELAY_S else t_s), late_s

    def _stamped(self, stamp_s: float, arrival_s: float) -> float:
        t_s, late_s = self._aligned(self._clock, stamp_s, arrival_s)
        self._pace.late(late_s)
        if stamp_s != self._stamp_s:
            if self._stamp_s is not None:
                self._interval_s = (stamp_s - self._stamp_s) % DAY_S
            self._stamp_s = stamp_s
            self._seen.clear()
        self._epoch_s, self._epoch_arrival_s = t_s, arrival_s
        return t_s
