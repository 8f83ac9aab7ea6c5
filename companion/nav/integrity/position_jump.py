"""The position jumps: by more than the boat can have moved since the last fix.

Whether the receiver jumped or the estimate drifted is told by the receiver's own track: a fix is compared with the fix
before, moved on by the velocity or by the forces felt; only after a gap with the dead-reckoned estimate. A jump is
followed when independent evidence agrees with it, and when the operator accepts it.
"""

from __future__ import annotations

import math

from companion.core.readings import FixType
from companion.nav.integrity.continuity import Continuity
from companion.nav.integrity.evidence import Channel, PositionSeen, Sense
from companion.nav.integrity.jump import JumpHypothesis, Tracked
from companion.nav.integrity.statistics import StepNoise
from companion.nav.outliers import Verdict

_LEAST_M = 0.3
_CLAIMS = 3.0  # of the accuracy that the receiver claims, the worse one of the two fixes
_GRADE_CLAIMS = 5.3  # the same from one grade of fix to another, whose errors have nothing in common: one in 10⁶
_NOISES = 8.0  # of its usual step beside the boat's
_GAP_S = 1.3  # after a longer one, a fix is compared with the estimate: dead reckoning in waves is no step
_GAP_MPS = 0.1  # error of dead reckoning beyond its sigma
_ESTIMATES = 4.0  # of the estimate's sigma
_AGREES = 0.4  # of the jump, by which dead reckoning that has got worse may excuse it
_BACK = 0.5  # of the jump: nearer to the estimate than to where it has jumped to, or it is not back
_FRESH_S = 2.0  # of another receiver's fix
_LATEST_S = 1.0  # between two latencies: a boat under way is that much off its fixes when one becomes the other


_Receiver = Tracked[PositionSeen, StepNoise]


class PositionJump(JumpHypothesis[PositionSeen, StepNoise]):
    """`screen` is asked for each fix before it is used. Remembers the last fix, the noise, the track and the velocity
    by the last honest step of each receiver."""

    def __init__(self) -> None:
        super().__init__(Sense.POSITION, StepNoise)
        self._by_step: dict[str, tuple[float, float]] = {}

    def clear_late(self) -> None:
        """Receivers are believed, but for those that are further off than one whose latency changes."""
        for receiver in self._sources.values():
            if not _is_far(receiver):
                receiver.track.clear()

    def suspects(self, source: str) -> bool:
        """Whether that receiver is off its own track."""
        receiver = self._sources.get(source)
        return receiver is not None and receiver.track.suspect

    def screen(self, seen: PositionSeen, driven: bool, maybe_late: bool = False) -> Verdict | None:
        """What is to become of a fix: REJECT one beside its own track; None: the usual rule. `maybe_late`: it is not
        judged, since its time is in doubt."""
        receiver = self._known(seen)
        if receiver is None:
            return None
        last = receiver.last
        if (seen.lat_deg, seen.lon_deg) == (last.lat_deg, last.lon_deg):
            return receiver.verdict  # it repeats: no step of the receiver
        receiver.last = seen
        if not driven and not (maybe_late and _is_far(receiver)):
            receiver.track.clear()
            self._learn(receiver, last, seen)
            return None
        gap_s = seen.t_s - last.t_s
        bound_m = self._bound_m(receiver, last, seen)
        if gap_s > _GAP_S:
            reach_m = bound_m + _ESTIMATES * seen.estimate_sigma_m + _GAP_MPS * gap_s
            receiver.track.place(seen.t_s, seen.off_north_m, seen.off_east_m, reach_m)
        elif gap_s > 0.0:
            north, east = self._unexplained(last, seen, bound_m)
            receiver.track.take(seen.t_s, north, east, bound_m)
            if not receiver.track.suspect:
                receiver.noise.update(north, east)
        off_m = math.hypot(seen.off_north_m, seen.off_east_m)
        unsure_m = min(3.0 * seen.estimate_sigma_m, _AGREES * receiver.track.size)  # else all agrees in the end
        receiver.track.compare(seen.t_s, off_m, min(bound_m + unsure_m, _BACK * receiver.track.size))
        return receiver.verdict

    def _unexplained(self, last: PositionSeen, seen: PositionSeen, bound_m: float) -> tuple[float, float]:
        """The receiver's step less the boat's. Without measured forces the estimate's velocity lags behind in turns;
        then a step like the one before is the boat's, too."""
        north, east = _step(last, seen)
        gap_s, before = seen.t_s - last.t_s, self._by_step.get(seen.source)
        if seen.way is None and before is not None:
            n, e = seen.north_m - last.north_m - gap_s * before[0], seen.east_m - last.east_m - gap_s * before[1]
            if math.hypot(n, e) < math.hypot(north, east):
                north, east = n, e
        if math.hypot(north, east) <= bound_m:
            self._by_step[seen.source] = (seen.north_m - last.north_m) / gap_s, (seen.east_m - last.east_m) / gap_s
        return north, east

    @staticmethod
    def _bound_m(receiver: _Receiver, last: PositionSeen, seen: PositionSeen) -> float:
        claim_m = max(last.sigma_m, seen.sigma_m)
        claims = _CLAIMS if last.fix == seen.fix else _GRADE_CLAIMS
        return max(_LEAST_M, claims * claim_m + _NOISES * receiver.noise.size)

    @staticmethod
    def _learn(receiver: _Receiver, last: PositionSeen, seen: PositionSeen) -> None:
        if 0.0 < seen.t_s - last.t_s <= _GAP_S:
            receiver.noise.update(*_step(last, seen))

    @staticmethod
    def _size(track: Continuity) -> str:
        return f"{track.size:.{1 if track.size < 10.0 else 0}f} m"

    def confirmed(self, source: str, distrusted: frozenset[Channel], now_s: float) -> bool:
        """Whether another receiver that is trusted and has not jumped itself is where this one has jumped to, closer
        than to the estimate."""
        jumped = self._sources[source].last
        for name, other in self._sources.items():
            fresh = now_s - other.last.t_s <= _FRESH_S and other.last.fix >= FixType.FIX_2D
            trusted = not other.track.suspect and Channel(Sense.POSITION, name) not in distrusted
            if name == source or not fresh or not trusted:
                continue
            apart_m = math.hypot(jumped.north_m - other.last.north_m, jumped.east_m - other.last.east_m)
            off_m = math.hypot(other.last.off_north_m, other.last.off_east_m)
            if apart_m <= _LEAST_M + 3.0 * math.hypot(jumped.sigma_m, other.last.sigma_m) and apart_m < off_m:
                return True
        return False


def _is_far(receiver: _Receiver) -> bool:
    """Whether a receiver is further off than a change of its latency explains."""
    last = receiver.last
    reach_m = _LATEST_S * math.hypot(last.estimate_north_mps, last.estimate_east_mps)
    return receiver.track.size > max(_LEAST_M, _CLAIMS * last.sigma_m) + reach_m


def _step(last: PositionSeen, seen: PositionSeen) -> tuple[float, float]:
    """The receiver's step less the boat's: by the velocity that it had and the forces since, as in waves a second is
    long for a mean of two velocities; without forces by that."""
    dt_s, began, ended = seen.t_s - last.t_s, last.way, seen.way
    if began is not None and ended is not None:
        north = ended.north_m - began.north_m + dt_s * began.carried_north_mps
        east = ended.east_m - began.east_m + dt_s * began.carried_east_mps
    else:
        north = 0.5 * dt_s * (last.estimate_north_mps + seen.estimate_north_mps)
        east = 0.5 * dt_s * (last.estimate_east_mps + seen.estimate_east_mps)
    return seen.north_m - last.north_m - north, seen.east_m - last.east_m - east
