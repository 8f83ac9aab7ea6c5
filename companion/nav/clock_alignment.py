"""Another system's clock → vessel time: when was it so, what a message with a time stamp says?

Arrival − stamp is the difference of the two clocks plus what the way took. The way takes longer at times, never shorter, so the least difference
of the last while is that of the fastest message; drift moves it by 2 ms in the 20 s that are remembered, at 100 ppm. What that fastest message
took itself is known from questions and answers (MAVLink TIMESYNC), else it is taken to be a configured latency.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

_BUCKET_S, _BUCKETS = 2.0, 10  # the least delay is remembered for 20 s
_EXCHANGES_S = 60.0
_LATE_S = 1.0  # over the least delay: this message was held up, or the sender's clock has been set
_LATE_LASTS_S = 5.0  # after which it is the clock
_REORDER_S = 2.0  # by which stamps may go back
_AGREE_S = 1.0
_TRIAL_S, _TRIAL_COUNT = 1.0, 3
_SLOWEST, _FASTEST = 0.7, 1.4  # of a clock, against ours, seen over the trial


@dataclass(slots=True)
class _Trial:
    """A clock that is not trusted yet: its first stamp and arrival, and what came since."""

    stamp_s: float
    arrived_s: float
    least_s: float
    count: int = 1


@dataclass(slots=True)
class _Exchanges:
    """(arrived_s, round trip, latency of the fastest message) of the last minute."""

    kept: deque[tuple[float, float, float]] = field(default_factory=deque)

    def add(self, now_s: float, trip_s: float, latency_s: float) -> None:
        while self.kept and now_s - self.kept[0][0] > _EXCHANGES_S:
            self.kept.popleft()
        self.kept.append((now_s, trip_s, latency_s))

    @property
    def latency_s(self) -> float | None:
        """By the quickest round trip."""
        return min(self.kept, key=lambda kept: kept[1])[2] if self.kept else None


class ClockAlignment:
    """`arrived(stamp_s, now_s, latency_s)` → vessel time of what the message says, never later than `now_s`.

    A clock counts once three messages over a second agree on it and it runs about as fast as ours; until then, and for senders whose stamps do
    not run (MAVSDK's stay at 0), it is the arrival less `latency_s`. Stamps that go back or jump ahead are put to the same trial: a clock
    that started anew takes over a second later, a single wrong stamp changes nothing. Messages may come in any order, late or not at all.
    Remembers the least delay of the last 20 s by pieces of 2 s, the newest stamp, the trial, and the exchanges of the last minute.
    """

    def __init__(self) -> None:
        self._buckets: deque[tuple[float, float]] = deque()  # (begin, least arrival − stamp)
        self._newest_s = -math.inf
        self._good_s = -math.inf  # when a message came last that was not late
        self._trial: _Trial | None = None
        self._exchanges = _Exchanges()

    @property
    def aligned(self) -> bool:
        """Whether the sender's clock counts."""
        return bool(self._buckets)

    @property
    def latency_s(self) -> float | None:
        """What the fastest message takes, by exchanges; None where the sender answers none."""
        return self._exchanges.latency_s

    def arrived(self, stamp_s: float | None, now_s: float, latency_s: float) -> float:
        """`stamp_s`: by the sender's clock, None or not a number for none; `now_s`: of arrival, must not go back; `latency_s`: of the way, where exchanges tell none."""
        measured = self._exchanges.latency_s
        latency_s = latency_s if measured is None else measured
        if stamp_s is None or not math.isfinite(stamp_s):
            return now_s - latency_s
        delay_s = now_s - stamp_s
        if self.aligned:
            least_s = self._least_s()
            strange = stamp_s < self._newest_s - _REORDER_S or delay_s < least_s - _AGREE_S
            late = delay_s > least_s + _LATE_S
            tried = late and self._trial is not None and abs(delay_s - self._trial.least_s) <= _AGREE_S  # stamps that went back have caught up
            if not strange and not tried and not (late and now_s - self._good_s > _LATE_LASTS_S):
                if not late:
                    self._good_s = now_s
                    self._trial = None
                self._newest_s = max(self._newest_s, stamp_s)
                self._remember(delay_s, now_s)
                return min(now_s, stamp_s + self._least_s() - latency_s)
        self._try(stamp_s, now_s)
        return min(now_s, stamp_s + self._least_s() - latency_s) if self._newest_s == stamp_s and self.aligned else now_s - latency_s

    def exchanged(self, sent_s: float, theirs_s: float, now_s: float) -> None:
        """An answer to a question that was sent at `sent_s`: by the sender's clock it was `theirs_s` in between."""
        trip_s = now_s - sent_s
        if not 0.0 <= trip_s < _EXCHANGES_S or not math.isfinite(theirs_s):
            return
        latency_s = 0.5 * trip_s
        if self.aligned:
            by_clock_s = self._least_s() - (0.5 * (sent_s + now_s) - theirs_s)
            if abs(by_clock_s) <= trip_s + _LATE_S:  # else the answer is by another clock than the stamps
                latency_s = by_clock_s
        self._exchanges.add(now_s, trip_s, min(max(0.0, latency_s), trip_s + _LATE_S))

    def _least_s(self) -> float:
        return min(least_s for _, least_s in self._buckets)

    def _remember(self, delay_s: float, now_s: float) -> None:
        buckets = self._buckets
        if buckets and now_s - buckets[-1][0] < _BUCKET_S:
            buckets[-1] = (buckets[-1][0], min(buckets[-1][1], delay_s))
        else:
            buckets.append((now_s, delay_s))
        while now_s - buckets[0][0] > _BUCKET_S * _BUCKETS:
            buckets.popleft()

    def _try(self, stamp_s: float, now_s: float) -> None:
        """Put a clock to trial; it takes over when it has passed."""
        trial, delay_s = self._trial, now_s - stamp_s
        if trial is None or abs(delay_s - trial.least_s) > _AGREE_S:
            self._trial = _Trial(stamp_s, now_s, delay_s)
            return
        trial.count += 1
        trial.least_s = min(trial.least_s, delay_s)
        span_s = now_s - trial.arrived_s
        if span_s < _TRIAL_S or trial.count < _TRIAL_COUNT:
            return
        if not _SLOWEST <= (stamp_s - trial.stamp_s) / span_s <= _FASTEST:
            self._trial = _Trial(stamp_s, now_s, delay_s)
            return
        self._buckets.clear()
        self._exchanges = _Exchanges()
        self._buckets.append((now_s, trial.least_s))
        self._newest_s, self._good_s, self._trial = stamp_s, now_s, None
