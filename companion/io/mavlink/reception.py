"""How many packets of one source have come in on one endpoint, and how many were lost on the way, by their sequence numbers."""

from __future__ import annotations

MOST_SOURCES = 32  # remembered on an endpoint


class Reception:
    """`take(sequence)` each packet of a system and component. A packet that was overtaken is not lost after all; one that comes twice counts once."""

    __slots__ = ("_last", "lost", "received")

    def __init__(self) -> None:
        self._last: int | None = None
        self.received = 0
        self.lost = 0

    def take(self, sequence: int) -> None:
        ahead = 1 if self._last is None else sequence - self._last & 0xFF
        if ahead == 0:
            return
        self.received += 1
        if ahead < 128:
            self.lost += ahead - 1
            self._last = sequence
        else:
            self.lost = max(0, self.lost - 1)


class Receptions:
    """Of all sources on one endpoint; the one heard first gives way when there are too many."""

    def __init__(self) -> None:
        self._by_source: dict[tuple[int, int], Reception] = {}

    def take(self, system: int, component: int, sequence: int) -> None:
        reception = self._by_source.get((system, component))
        if reception is None:
            if len(self._by_source) >= MOST_SOURCES:
                del self._by_source[next(iter(self._by_source))]
            reception = self._by_source[system, component] = Reception()
        reception.take(sequence)

    def of(self, system: int, component: int) -> Reception | None:
        """None for who has not been heard."""
        return self._by_source.get((system, component))
