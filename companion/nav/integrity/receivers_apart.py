"""Two receivers are apart by more than their accuracies explain.

Where one of them jumps, creeps or contradicts the forces, other hypotheses name it. A slow lie that is consistent in
itself leaves only this: one of the two is wrong. Both are used on, with the distance between them as their accuracy.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from companion.core.readings import FixType
from companion.nav.integrity.evidence import Channel, Evidence, Hypothesis, LieFound, PositionSeen, Sense

_LEAST_M = 0.5
_CLAIMS = 4.0  # of both accuracies together
_LASTS_S = 3.0
_FRESH_S = 1.5
_AGREES = 0.7


Pair = tuple[str, str]


@dataclass(slots=True)
class _Apart:
    """The receiver that is named, as it claimed less when that began; the other one; how far apart they are now."""

    lesser: str
    other: str
    distance_m: float


class ReceiversApart(Hypothesis):
    """`sigma_m` is what to believe of their accuracy. Remembers the last fix of each receiver, and since when each pair
    is apart."""

    def __init__(self) -> None:
        self._last: dict[str, PositionSeen] = {}
        self._since_s: dict[Pair, float] = {}
        self._found: dict[Pair, _Apart] = {}

    def clear(self) -> None:
        """Begin anew."""
        self._since_s.clear()
        self._found.clear()

    def sigma_m(self, source: str, claimed_m: float) -> float:
        """One sigma on each axis: as claimed, or the distance to the receiver that says otherwise."""
        return max([claimed_m, *(apart.distance_m for pair, apart in self._found.items() if source in pair)])

    def update(self, evidence: Evidence, now_s: float) -> Sequence[LieFound]:
        """Of each pair that is apart: the receiver that claims less."""
        self.doubt = 0.0
        for seen in evidence.positions:
            self._last[seen.source] = seen
        names = [
            name
            for name, seen in self._last.items()
            if now_s - seen.t_s <= _FRESH_S
            and seen.fix >= FixType.FIX_2D
            and Channel(Sense.POSITION, name) not in evidence.distrusted
        ]
        pairs = [(first, second) for i, first in enumerate(names) for second in names[i + 1 :]]
        for pair in [pair for pair in self._since_s if pair not in pairs]:
            self._forget(pair)
        for pair in pairs if evidence.driven else ():
            self._compare(pair, now_s)
        return [
            LieFound(
                Channel(Sense.POSITION, apart.lesser), f"is {apart.distance_m:.0f} m from {apart.other}",
                self._since_s[pair], used=True,
            )
            for pair, apart in self._found.items()
        ]  # fmt: skip

    def _compare(self, pair: Pair, now_s: float) -> None:
        first, second = self._last[pair[0]], self._last[pair[1]]
        ahead_s = second.t_s - first.t_s
        north = second.north_m - first.north_m - ahead_s * second.estimate_north_mps
        east = second.east_m - first.east_m - ahead_s * second.estimate_east_mps
        apart_m, known = math.hypot(north, east), self._found.get(pair)
        threshold_m = _LEAST_M + _CLAIMS * math.hypot(first.sigma_m, second.sigma_m)
        if apart_m <= (1.0 if known is None else _AGREES) * threshold_m:
            self._forget(pair)
            return
        since_s = self._since_s.setdefault(pair, now_s)
        doubt = (now_s - since_s) / _LASTS_S
        self.doubt = max(self.doubt, min(doubt, 1.0))
        if known is not None:
            known.distance_m = apart_m
        elif doubt >= 1.0:
            lesser, other = pair if first.sigma_m > second.sigma_m else (pair[1], pair[0])
            self._found[pair] = _Apart(lesser, other, apart_m)

    def _forget(self, pair: Pair) -> None:
        self._since_s.pop(pair, None)
        self._found.pop(pair, None)
