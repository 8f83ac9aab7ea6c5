"""Clock alignment: the vessel time at which another system stamped a message.

Arrival − stamp is the offset of the two clocks plus the delay of the link. The delay varies but has a minimum, so the
least difference over the last 20 s belongs to the fastest message. A clock that drifts by 100 ppm moves it by 2 ms in
that time. The latency of the fastest message comes from round trips (MAVLink TIMESYNC), else it is a configured value.
A round trip tells the offset of the clocks, which stays when the latency grows.
"""

from __future__ import annotations

import math
from collections import deque
from dataclasses import dataclass, field

_BUCKET_S, _BUCKETS = 2.0, 10  # the least delay is remembered for 20 s
_EXCHANGES_S = 60.0
_STEADY_S = 0.05  # by which the least arrival less stamp may change without another latency: jitter
_SET_S = 0.05  # beyond what round trips explain: the sender's clock was set
_LATE_S = 1.0  # over the least delay: the message was held up, or the sender's clock was set
_LATE_LASTS_S = 5.0  # lateness that lasts longer means the clock was set
_REORDER_S = 2.0  # by which stamps may go back
_AGREE_S = 1.0  # delays within it belong to the same clock
_TRIAL_S, _TRIAL_COUNT = 1.0, 3
_SLOWEST, _FASTEST = 0.7, 1.4  # rate of a clock against ours over the trial, to pass it


@dataclass(slots=True)
class _Trial:
    """A clock that is not trusted yet: its first stamp and arrival, its least delay and how many messages came."""

    stamp_s: float
    arrived_s: float
    least_s: float
    count: int = 1


@dataclass(slots=True)
class _Exchanges:
    """Round trips of the last minute: (arrived_s, trip_s, vessel time less the sender's clock; None where that is
    another clock than that of its stamps; the least arrival less stamp then)."""

    kept: deque[tuple[float, float, float | None, float]] = field(default_factory=deque)

    def add(self, now_s: float, trip_s: float, offset_s: float | None, least_s: float) -> None:
        """Add a round trip and drop those older than a minute, and those before the sender's clock was set: no offset
        is wrong by more than half of its trip."""
        while self.kept and (now_s - self.kept[0][0] > _EXCHANGES_S or self._was_set(trip_s, offset_s)):
            self.kept.popleft()
        self.kept.append((now_s, trip_s, offset_s, least_s))

    def _was_set(self, trip_s: float, offset_s: float | None) -> bool:
        _, before_s, known_s, _ = self.kept[0]
        return (
            offset_s is not None
            and known_s is not None
            and abs(offset_s - known_s) > 0.5 * (trip_s + before_s) + _SET_S
        )

    def latency_s(self, least_s: float | None) -> float | None:
        """Latency of the fastest message now, by the shortest round trip; None before the first. `least_s`: its arrival
        less its stamp. That grows with the latency, the offset of the clocks does not."""
        if not self.kept:
            return None
        _, trip_s, offset_s, then_s = min(self.kept, key=lambda kept: kept[1])
        if offset_s is None or least_s is None:
            return 0.5 * trip_s
        if abs(least_s - then_s) <= _STEADY_S:
            least_s = then_s
        return max(0.0, least_s - offset_s)


class ClockAlignment:
    """`arrived(stamp_s, now_s, latency_s)` → vessel time at which the message was stamped, never later than `now_s`.

    A clock is trusted once three messages over a second agree on it and it runs about as fast as ours. Until then the
    result is the arrival less `latency_s`; so it stays for senders whose stamps do not run (MAVSDK's stay at 0). Stamps
    that go back or jump ahead begin a new trial: a restarted clock takes over a second later, and a single wrong stamp
    changes nothing. Messages may come in any order, late or not at all.

    Remembers the least delay of the last 20 s in pieces of 2 s, the newest stamp, the trial, and the round trips of the
    last minute.
    """

    def __init__(self) -> None:
        self._buckets: deque[tuple[float, float]] = deque()  # (begin, least arrival − stamp)
        self._newest_s = -math.inf
        self._good_s = -math.inf  # arrival of the last message that was not late
        self._trial: _Trial | None = None
        self._exchanges = _Exchanges()

    @property
    def aligned(self) -> bool:
        """Whether the sender's clock is trusted."""
        return bool(self._buckets)

    @property
    def latency_s(self) -> float | None:
        """Latency of the fastest message, measured by round trips; None where the sender answers none."""
        return self._exchanges.latency_s(self._least_s() if self.aligned else None)

    def _latency_s(self, otherwise_s: float) -> float:
        measured_s = self.latency_s
        return otherwise_s if measured_s is None else measured_s

    def arrived(self, stamp_s: float | None, now_s: float, latency_s: float) -> float:
        """`stamp_s`: by the sender's clock, None or NaN for none. `now_s`: arrival in vessel time, must not go back.
        `latency_s`: of the link, used where no round trip was measured."""
        if stamp_s is None or not math.isfinite(stamp_s):
            return now_s - self._latency_s(latency_s)
        delay_s = now_s - stamp_s
        if self.aligned:
            least_s = self._least_s()
            strange = stamp_s < self._newest_s - _REORDER_S or delay_s < least_s - _AGREE_S
            late = delay_s > least_s + _LATE_S
            # stamps that went back have caught up
            tried = late and self._trial is not None and abs(delay_s - self._trial.least_s) <= _AGREE_S
            if not strange and not tried and not (late and now_s - self._good_s > _LATE_LASTS_S):
                if not late:
                    self._good_s = now_s
                    self._trial = None
                self._newest_s = max(self._newest_s, stamp_s)
                self._remember(delay_s, now_s)
                return min(now_s, stamp_s + self._least_s() - self._latency_s(latency_s))
        latency_s = self._latency_s(latency_s)
        self._try(stamp_s, now_s)
        return (
            min(now_s, stamp_s + self._least_s() - latency_s)
            if self._newest_s == stamp_s and self.aligned
            else now_s - latency_s
        )

    def exchanged(self, sent_s: float, theirs_s: float, now_s: float) -> None:
        """The far end answered a request of `sent_s` (vessel time); its own clock read `theirs_s` in between."""
        trip_s = now_s - sent_s
        if not 0.0 <= trip_s < _EXCHANGES_S or not math.isfinite(theirs_s):
            return
        offset_s = 0.5 * (sent_s + now_s) - theirs_s
        least_s = self._least_s() if self.aligned else math.inf
        same = abs(least_s - offset_s) <= trip_s + _LATE_S  # else answers and stamps are by different clocks
        self._exchanges.add(now_s, trip_s, offset_s if same else None, least_s)

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
        """Try a clock; it is trusted when it has passed."""
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
