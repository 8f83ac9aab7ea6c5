"""Link quality: the counter of the RescueRunner thesis (Hallhagen & Persson 2016, 6.3.6).

It goes up by one with each message lost and down by one with each received, within 0…40. Near 0 the link is good: at
least half of the messages arrive.
"""

from __future__ import annotations

import math

MOST = 40
_USUAL_SHARE = 0.1  # weight of the newest interval in the usual one
_SHORTEST_S, _LONGEST_S = 0.01, 5.0
_WRAPS = 100  # after more missed messages, the 8-bit sequence number may have wrapped


class LinkCounter:
    """At the receiving end: `heard(now_s, lost)` each message, `value(now_s)` → 0…40.

    During silence, messages count as lost at the usual interval; the next message replaces that by its own count.
    Remembers the counter, the time of the last message and the usual interval.
    """

    def __init__(self) -> None:
        self._counter = 0
        self._heard_s: float | None = None
        self.interval_s: float | None = None
        """Interval at which messages are sent, lost ones included; None before the second."""

    def heard(self, now_s: float, lost: int) -> None:
        """A message came. `lost`: how many are missing before it, by their sequence numbers."""
        silent = self._silent(now_s)
        lost = max(0, lost if silent < _WRAPS else max(lost, silent))
        if self._heard_s is not None:
            interval_s = min(_LONGEST_S, max(_SHORTEST_S, (now_s - self._heard_s) / (1 + lost)))
            usual_s = interval_s if self.interval_s is None else self.interval_s
            self.interval_s = usual_s + _USUAL_SHARE * (interval_s - usual_s)
        self._heard_s = now_s
        self._counter = max(0, min(MOST, self._counter + lost) - 1)

    def value(self, now_s: float) -> int:
        """The counter now, 0…40."""
        return min(MOST, self._counter + self._silent(now_s))

    def _silent(self, now_s: float) -> int:
        """Messages overdue since the last one; one that is late by half an interval is not lost yet."""
        if self._heard_s is None or self.interval_s is None or not math.isfinite(now_s):
            return 0
        return max(0, math.floor((now_s - self._heard_s) / self.interval_s - 0.5))


class AcknowledgedCounter:
    """At the sending end: `sent()` each message, `reported(received)` each report of the far end, `value` → 0…40.

    Once two reports are overdue, what is sent counts as lost; a single report may itself have been lost.
    """

    def __init__(self, usual: int) -> None:
        """`usual`: how many messages are sent between two reports."""
        self._patience = math.ceil(2.5 * usual)
        self._counter = 0
        self._sent = self._sent_then = 0
        self._received: int | None = None

    def sent(self) -> None:
        """A message was sent."""
        self._sent += 1

    def reported(self, received: int) -> None:
        """`received`: how many messages the far end has received in all, modulo 65536."""
        sent, arrived = (
            self._sent - self._sent_then,
            0 if self._received is None else (received - self._received) & 0xFFFF,
        )
        if self._received is not None and arrived <= 2 * sent + MOST:  # else the far end has restarted
            self._counter = min(MOST, max(0, self._counter + max(0, sent - arrived) - min(sent, arrived)))
        self._received, self._sent_then = received & 0xFFFF, self._sent

    @property
    def value(self) -> int:
        """The counter now, 0…40."""
        overdue = self._sent - self._sent_then - self._patience
        return min(MOST, self._counter + max(0, overdue))
