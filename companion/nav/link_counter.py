"""How well a link carries: the counter of the RescueRunner thesis (6.3.6), up with each message lost, down with each received, 0…40. About 0 is good:
at least half of the messages arrive."""

from __future__ import annotations

import math

MOST = 40
_USUAL_SHARE = 0.1  # of the newest interval in the usual one
_SHORTEST_S, _LONGEST_S = 0.01, 5.0
_WRAPS = 100  # messages of silence above which sequence numbers may have come round


class LinkCounter:
    """Of the receiving end. `heard(now_s, lost)` each message, `value(now_s)` → 0…40.

    `lost`: how many went missing before it, by their sequence numbers. While nothing comes, messages count as lost at the usual interval; the next one puts its
    own count in place of that. Remembers counter, time of the last message and the usual interval.
    """

    def __init__(self) -> None:
        self._counter = 0
        self._heard_s: float | None = None
        self.interval_s: float | None = None
        """Between two messages as sent, the lost ones among them; None before the second."""

    def heard(self, now_s: float, lost: int) -> None:
        silent = self._silent(now_s)
        lost = max(0, lost if silent < _WRAPS else max(lost, silent))
        if self._heard_s is not None:
            interval_s = min(_LONGEST_S, max(_SHORTEST_S, (now_s - self._heard_s) / (1 + lost)))
            usual_s = interval_s if self.interval_s is None else self.interval_s
            self.interval_s = usual_s + _USUAL_SHARE * (interval_s - usual_s)
        self._heard_s = now_s
        self._counter = max(0, min(MOST, self._counter + lost) - 1)

    def value(self, now_s: float) -> int:
        return min(MOST, self._counter + self._silent(now_s))

    def _silent(self, now_s: float) -> int:
        """Messages that should have come since the last one; half an interval late is not lost."""
        if self._heard_s is None or self.interval_s is None or not math.isfinite(now_s):
            return 0
        return max(0, math.floor((now_s - self._heard_s) / self.interval_s - 0.5))


class AcknowledgedCounter:
    """Of the sending end, by what the other reports to have received. `sent()` each message, `reported(received)` each report, `value` → 0…40.

    Both count modulo 65536. While no report comes, what is sent counts as lost once two reports are overdue: one alone may have been lost itself.
    """

    def __init__(self, usual: int) -> None:
        """`usual`: messages sent between two reports."""
        self._patience = math.ceil(2.5 * usual)
        self._counter = 0
        self._sent = self._sent_then = 0
        self._received: int | None = None

    def sent(self) -> None:
        self._sent += 1

    def reported(self, received: int) -> None:
        sent, arrived = self._sent - self._sent_then, 0 if self._received is None else (received - self._received) & 0xFFFF
        if self._received is not None and arrived <= 2 * sent + MOST:  # else the other end began anew
            self._counter = min(MOST, max(0, self._counter + max(0, sent - arrived) - min(sent, arrived)))
        self._received, self._sent_then = received & 0xFFFF, self._sent

    @property
    def value(self) -> int:
        overdue = self._sent - self._sent_then - self._patience
        return min(MOST, self._counter + max(0, overdue))
