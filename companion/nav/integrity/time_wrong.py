"""The absolute time of a receiver jumps, or runs at another rate than the boat's clock."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from companion.core.readings import TimeOfDay
from companion.nav.integrity.evidence import Channel, Evidence, Hypothesis, LieFound, Sense

_JUMP_NS = 400_000_000  # less is the delay of a line or of the host; a leap second is more
_RATE = 1e-3  # that of any crystal oscillator is far smaller
_WINDOW_S = 60.0
_MOST_LEAP_S, _WHOLE_S = 20, 0.2


@dataclass(slots=True)
class _Receiver:
    """Absolute time less the boat's, in ns: when the window began, and now. `leapt`: leap seconds have set it back."""

    from_s: float
    from_ns: int
    now_ns: int
    since_s: float | None = None
    fault: str = ""
    leapt: bool = False


class TimeWrong(Hypothesis):
    """Remembers the offset of each receiver's time, as it was.

    A receiver that has no almanac yet tells GPS time, or UTC by the leap seconds of its firmware, and sets itself back
    by whole seconds minutes later; so does one at a leap second. Once that is no lie.
    """

    def __init__(self) -> None:
        self._receivers: dict[str, _Receiver] = {}

    def clear(self) -> None:
        """The present times are believed."""
        self._receivers.clear()

    def update(self, evidence: Evidence, now_s: float) -> Sequence[LieFound]:
        """Receivers whose time is not what it was, until it is again."""
        self.doubt = 0.0
        for time in evidence.times:
            self._take(time, evidence.driven)
        return [
            LieFound(Channel(Sense.TIME, source), receiver.fault, receiver.since_s)
            for source, receiver in self._receivers.items()
            if receiver.since_s is not None
        ]

    def _take(self, time: TimeOfDay, driven: bool) -> None:
        offset_ns = time.time_unix_ns - round(time.t_s * 1e9)
        receiver = self._receivers.get(time.source)
        if receiver is None or not driven:
            self._receivers[time.source] = _Receiver(time.t_s, offset_ns, offset_ns)
            return
        receiver.now_ns = offset_ns
        off_ns = offset_ns - receiver.from_ns
        passed_s = time.t_s - receiver.from_s
        allowed_ns = _JUMP_NS + _RATE * passed_s * 1e9
        if not receiver.leapt and receiver.since_s is None and _is_leap(off_ns):
            self._receivers[time.source] = _Receiver(time.t_s, offset_ns, offset_ns, leapt=True)
            return
        doubt = abs(off_ns) / allowed_ns
        self.doubt = max(self.doubt, min(doubt, 1.0))
        if doubt < 1.0:
            receiver.since_s = None
            if passed_s >= _WINDOW_S:
                receiver.from_s, receiver.from_ns = time.t_s, offset_ns
        elif receiver.since_s is None:
            receiver.since_s = time.t_s
            receiver.fault = f"is off by {off_ns * 1e-9:.1f} s"


def _is_leap(off_ns: int) -> bool:
    """Whether the time was set back by one leap second or by all of them."""
    back_s = -off_ns * 1e-9
    return 0.5 < back_s < _MOST_LEAP_S + 0.5 and abs(back_s - round(back_s)) <= _WHOLE_S
