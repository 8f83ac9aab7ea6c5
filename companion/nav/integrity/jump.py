"""What every jump has in common: each source's own track, and what is found of one that has left it."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

from companion.nav.integrity.continuity import Continuity
from companion.nav.integrity.evidence import (
    Channel,
    Evidence,
    HeadingSeen,
    Hypothesis,
    LieFound,
    PositionSeen,
    Sense,
    VelocitySeen,
)
from companion.nav.outliers import Verdict

Seen = TypeVar("Seen", bound=PositionSeen | VelocitySeen | HeadingSeen)
Noise = TypeVar("Noise")


class Tracked(Generic[Seen, Noise]):
    """A source: its last reading, the size of its usual steps, and its track."""

    __slots__ = ("last", "noise", "track")

    def __init__(self, last: Seen, noise: Noise) -> None:
        self.last = last
        self.noise = noise
        self.track = Continuity()

    @property
    def verdict(self) -> Verdict | None:
        """REJECT while the source is off its own track; None: the usual rule."""
        return Verdict.REJECT if self.track.suspect else None


class JumpHypothesis(Hypothesis, Generic[Seen, Noise]):
    """A source makes a step that the boat cannot have made. Remembers each source of one sense."""

    def __init__(self, sense: Sense, new_noise: Callable[[], Noise]) -> None:
        self._sense = sense
        self._new_noise = new_noise
        self._sources: dict[str, Tracked[Seen, Noise]] = {}

    def clear(self) -> None:
        """All sources are believed."""
        for source in self._sources.values():
            source.track.clear()

    def accept(self, channel: Channel) -> None:
        """That source is right as it is."""
        if channel.sense is self._sense and channel.source in self._sources:
            self._sources[channel.source].track.clear()

    def absolve(self, from_s: float) -> None:
        """What the sources seem to have done since then is void."""
        for source in self._sources.values():
            if from_s <= source.track.since_s < math.inf:
                source.track.clear()

    def update(self, evidence: Evidence, now_s: float) -> Sequence[LieFound]:
        """Sources that have jumped; each asks to be accepted."""
        self.doubt = 0.0
        found = []
        for name, source in self._sources.items():
            track = source.track
            self.doubt = max(self.doubt, 0.5 * track.suspect, 1.0 * track.jumped)
            if evidence.driven and track.jumped:
                fault = f"jumped {self._size(track)}"
                found.append(LieFound(Channel(self._sense, name), fault, track.since_s, asks=True, jump=True))
        return found

    @staticmethod
    @abstractmethod
    def _size(track: Continuity) -> str:
        """How far the source has jumped, with the unit, for people."""

    def _known(self, seen: Seen) -> Tracked[Seen, Noise] | None:
        """The source of a reading; None for its first one, which nothing can be compared with."""
        known = self._sources.get(seen.source)
        if known is None:
            self._sources[seen.source] = Tracked(seen, self._new_noise())
        return known
