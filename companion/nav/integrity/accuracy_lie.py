"""A receiver claims to be better than it is: its positions scatter by more than the accuracy that it reports."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from companion.nav.integrity.evidence import Channel, Evidence, Hypothesis, LieFound, PositionSeen, Sense
from companion.nav.integrity.statistics import NoiseSize

_RATIO = 3.0  # of the scatter to the claim, where the claim is a lie
_LEAST_M = 0.03  # scatter of a step, by waves and vibration, that is no lie
_SAMPLES = 30  # of the average
_MOST = 3.0  # a step counts with at most so many times the average: of ten positions one may be an outlier, two steps
_MOST_AT_FIRST = 2.0  # and with at most so many thresholds, until the average is known
_MEAN_OF_STEP = math.sqrt(math.pi)  # mean length of a step between two positions, in sigmas of one axis
_GAP_S = 1.5
_AGREES = 0.5


@dataclass(slots=True)
class _Receiver:
    last: PositionSeen | None = None
    scatter: NoiseSize = field(default_factory=lambda: NoiseSize(_SAMPLES, _MOST))
    count: int = 0
    since_s: float | None = None


class AccuracyLie(Hypothesis):
    """`sigma_m` is what to believe instead. Remembers the scatter of each receiver."""

    def __init__(self) -> None:
        self._receivers: dict[str, _Receiver] = {}

    def clear(self) -> None:
        """Claims are believed."""
        self._receivers.clear()

    def sigma_m(self, source: str, claimed_m: float) -> float:
        """One sigma on each axis: as claimed, or as the positions scatter where that is a lie."""
        receiver = self._receivers.get(source)
        if receiver is None or receiver.since_s is None:
            return claimed_m
        return max(claimed_m, receiver.scatter.size / _MEAN_OF_STEP)

    def update(self, evidence: Evidence, now_s: float) -> Sequence[LieFound]:
        """Receivers whose accuracy is a lie; they are used by their scatter."""
        self.doubt = 0.0
        for seen in evidence.positions:
            receiver = self._receivers.get(seen.source)
            if receiver is None:
                receiver = self._receivers[seen.source] = _Receiver()
            self._take(receiver, seen, evidence.driven)
        return [
            LieFound(Channel(Sense.POSITION, source), "is noisier than it claims", receiver.since_s, used=True)
            for source, receiver in self._receivers.items()
            if receiver.since_s is not None
        ]

    def _take(self, receiver: _Receiver, seen: PositionSeen, driven: bool) -> None:
        if seen.way is None:
            receiver.last = receiver.since_s = None  # the estimate's velocity lags behind: not the positions scatter
            return
        last, receiver.last = receiver.last, seen
        if last is None or not 0.0 < seen.t_s - last.t_s <= _GAP_S or last.fix is not seen.fix:
            receiver.count, receiver.scatter = 0, NoiseSize(_SAMPLES, _MOST)
            return
        dt_s = seen.t_s - last.t_s
        step_m = math.hypot(
            seen.north_m - last.north_m - 0.5 * dt_s * (last.estimate_north_mps + seen.estimate_north_mps),
            seen.east_m - last.east_m - 0.5 * dt_s * (last.estimate_east_mps + seen.estimate_east_mps),
        )
        threshold_m = max(_LEAST_M, _RATIO * _MEAN_OF_STEP * seen.sigma_m)
        known = receiver.count >= _SAMPLES
        receiver.scatter.update(step_m if known else min(step_m, _MOST_AT_FIRST * threshold_m))
        receiver.count += 1
        doubt = receiver.scatter.size / threshold_m if receiver.count >= _SAMPLES else 0.0
        if driven:
            self.doubt = max(self.doubt, min(doubt, 1.0))
        if doubt >= 1.0 and driven and receiver.since_s is None:
            receiver.since_s = seen.t_s
        elif doubt < _AGREES and receiver.count >= _SAMPLES:
            receiver.since_s = None
