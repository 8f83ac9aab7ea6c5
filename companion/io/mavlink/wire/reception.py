"""Counts of packets received and lost on one endpoint, for each source, by their sequence numbers."""

from __future__ import annotations

_WINDOW = (1 << 129) - 1
MOST_SOURCES = 32  # remembered for each endpoint


class Reception:
    """`take(sequence)` each packet of one system and component. A packet that arrives out of order is not lost; one
    that arrives twice counts once.

    Remembers the newest number, and which of the 128 before it have arrived.
    """

    __slots__ = ("_came", "_last", "lost", "received")

    def __init__(self) -> None:
        self._last: int | None = None
        self._came = 0  # bit k: whether the packet k before the newest has arrived
        self.received = 0
        self.lost = 0

    def take(self, sequence: int) -> None:
        """Count one packet. `sequence`: 0…255."""
        ahead = 1 if self._last is None else sequence - self._last & 0xFF
        if 0 < ahead < 128:
            self._last = sequence
            self._came = (self._came << ahead | 1) & _WINDOW
            self.lost += ahead - 1
            self.received += 1
            return
        behind = 1 << (-ahead & 0xFF)
        if not self._came & behind:
            self._came |= behind
            self.lost = max(0, self.lost - 1)
            self.received += 1


class Receptions:
    """The receptions of all sources on one endpoint. When there are too many, the one heard first is forgotten."""

    def __init__(self) -> None:
        self._by_source: dict[tuple[int, int], Reception] = {}

    def take(self, system: int, component: int, sequence: int) -> None:
        """Count one packet of a source."""
        reception = self._by_source.get((system, component))
        if reception is None:
            if len(self._by_source) >= MOST_SOURCES:
                del self._by_source[next(iter(self._by_source))]
            reception = self._by_source[system, component] = Reception()
        reception.take(sequence)

    def of(self, system: int, component: int) -> Reception | None:
        """The reception of a source; None where it was not heard."""
        return self._by_source.get((system, component))
