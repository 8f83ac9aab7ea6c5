"""The position drifts away from the way that the velocity makes.

Page's test on the difference of both, towards ±north and ±east: its slack is what an honest receiver wanders and an
honest velocity errs, its threshold what noise and wander can add up to at once. A drift slower than the slack cannot be
told from those. While the receiver's velocity is suspected or not trusted, the way is that of the inertial sensor, for
as long as that is better than nothing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from companion.nav.integrity.along import Along
from companion.nav.integrity.evidence import (
    Channel,
    Evidence,
    Hypothesis,
    InertialStep,
    LieFound,
    PositionSeen,
    Sense,
    VelocitySeen,
)
from companion.nav.integrity.statistics import StepNoise, VectorCusum

_VELOCITY_MPS = 0.05  # lasting error of a measured velocity
_INERTIAL_MPS = 0.1  # of one that the inertial sensor carries on,
_INERTIAL_S = 12.0  # for that long
_WANDER_S = 30.0  # an honest position wanders by its accuracy in that time, at the fastest
_LEAST_M = 0.2
_CLAIMS = 3.0  # of the accuracy that the receiver claims
_NOISES = 8.0  # of its usual step beside the boat's
_GAP_S = 1.5
_PAUSE = 2.5  # times the usual time between velocities: in waves, nobody knows what the boat has done meanwhile
_USUAL_PART = 0.1
_LEAST_S = 0.35  # a single step is noise, or a jump, which `position_jump.py` judges
_AGREES = 0.5  # share of the threshold below which a position agrees with the estimate again
_STEADY_S, _LONGEST_STEADY_S = 3.0, 30.0  # without a further drift, before it can agree
_AS_LONG = 1.5  # times what it took to find the drift, that is: one that goes on shows again by then
_OUTLIER = 1.5  # a step of that many thresholds is a jump

Way = tuple[float, float]


@dataclass(slots=True)
class _Receiver:
    """`way`: what its velocity has added up to, by `velocity`; `antenna_way`: that of the antenna. `usual_s`: between
    two velocities. `carried`: the velocity of the estimate less that of the inertial sums when the velocity was found
    to lie, and when that was. `last`: the last fix, and the way by then. `drifted_s`: when it last drifted by the
    threshold; `steady_s`: for how long it must not, before it can agree."""

    velocity: VelocitySeen | None = None
    usual_s: float = 0.0
    way: Way = (0.0, 0.0)
    antenna_way: Way = (0.0, 0.0)
    carried: tuple[float, float, float] | None = None
    last: tuple[PositionSeen, Way] | None = None
    noise: StepNoise = field(default_factory=StepNoise)
    cusum: VectorCusum = field(default_factory=VectorCusum)
    along: Along = field(default_factory=Along)
    since_s: float | None = None
    drifted_s: float = 0.0
    steady_s: float = _STEADY_S

    def goes_on(self, passed_s: float) -> bool:
        """Whether so long between two velocities is no pause. Learns what is usual."""
        if not 0.0 < passed_s <= _GAP_S:
            return False
        usual_s = self.usual_s or passed_s
        self.usual_s = usual_s + _USUAL_PART * (passed_s - usual_s)
        return passed_s <= _PAUSE * usual_s

    def drifts(self, t_s: float) -> None:
        """It has drifted by the threshold, once more or for the first time."""
        took_s = t_s - self.cusum.onset_s
        self.steady_s = min(max(_STEADY_S, _AS_LONG * took_s), _LONGEST_STEADY_S)
        self.since_s = self.cusum.onset_s if self.since_s is None else self.since_s
        self.drifted_s = t_s
        self.cusum.clear(t_s)


class PositionDrift(Hypothesis):
    """Remembers the way, the noise and the sums of each receiver."""

    def __init__(self) -> None:
        self._receivers: dict[str, _Receiver] = {}

    def clear(self) -> None:
        """Begin the sums anew."""
        for receiver in self._receivers.values():
            receiver.since_s = receiver.last = receiver.carried = None
            receiver.along.clear()

    def accept(self, channel: Channel) -> None:
        """The boat is where that receiver says."""
        if channel.sense is Sense.POSITION and channel.source in self._receivers:
            receiver = self._receivers[channel.source]
            receiver.since_s = receiver.last = None
            receiver.along.clear()

    def update(self, evidence: Evidence, now_s: float) -> Sequence[LieFound]:
        """Receivers whose position has drifted off, until it agrees with the estimate again."""
        self.doubt = 0.0
        by_time: list[PositionSeen | VelocitySeen] = [*evidence.velocities, *evidence.positions]
        by_time.sort(key=lambda seen: seen.t_s)
        for seen in by_time:
            receiver = self._receivers.get(seen.source)
            if receiver is None:
                receiver = self._receivers[seen.source] = _Receiver()
            if isinstance(seen, VelocitySeen):
                lies = Channel(Sense.VELOCITY, seen.source) in evidence.distrusted | evidence.suspected
                self._advance(receiver, seen, lies, evidence)
                receiver.along.velocity(seen)
            elif evidence.driven:
                self._compare(receiver, seen, Channel(Sense.POSITION, seen.source) in evidence.distrusted)
                self._follow(receiver, seen, evidence)
            else:
                receiver.last = None
                receiver.along.clear()
        return [
            LieFound(Channel(Sense.POSITION, source), "drifts", receiver.since_s, asks=True)
            for source, receiver in self._receivers.items()
            if receiver.since_s is not None
        ]

    def _advance(self, receiver: _Receiver, seen: VelocitySeen, lies: bool, evidence: Evidence) -> None:
        if lies:
            if receiver.carried is None and evidence.inertial is not None:
                receiver.carried = _carried(evidence, evidence.inertial, seen.t_s)
                receiver.velocity = receiver.last = None
            return
        if receiver.carried is not None:
            receiver.carried = receiver.last = None
        last, receiver.velocity = receiver.velocity, seen
        passed_s = math.inf if last is None else seen.t_s - last.t_s
        if last is None or not receiver.goes_on(passed_s):
            receiver.last = None
            return
        half_s = 0.5 * passed_s
        (north, east), (antenna_north, antenna_east) = receiver.way, receiver.antenna_way
        receiver.way = (
            north + half_s * (last.north_mps + seen.north_mps),
            east + half_s * (last.east_mps + seen.east_mps),
        )
        receiver.antenna_way = (
            antenna_north + half_s * (last.raw[0] + seen.raw[0]),
            antenna_east + half_s * (last.raw[1] + seen.raw[1]),
        )

    @staticmethod
    def _way(receiver: _Receiver, seen: PositionSeen) -> Way | None:
        """The way that the boat, or the antenna, has made by the time of a fix; None: unknown."""
        carried, velocity = receiver.carried, receiver.velocity
        if carried is not None:
            gone_s = seen.t_s - carried[2]
            if gone_s > _INERTIAL_S or seen.way is None:
                return None
            return seen.way.north_m + gone_s * carried[0], seen.way.east_m + gone_s * carried[1]
        if velocity is None or seen.t_s - velocity.t_s > _GAP_S:
            return None
        beyond_s = seen.t_s - velocity.t_s
        if seen.antenna is not None:
            north, east = receiver.antenna_way
            return north + beyond_s * velocity.raw[0], east + beyond_s * velocity.raw[1]
        return (
            receiver.way[0] + beyond_s * velocity.north_mps,
            receiver.way[1] + beyond_s * velocity.east_mps,
        )

    def _compare(self, receiver: _Receiver, seen: PositionSeen, distrusted: bool) -> None:
        threshold_m = max(_LEAST_M, _CLAIMS * seen.sigma_m, _NOISES * receiver.noise.size)
        known = receiver.since_s is not None
        doubt = _drift(receiver, seen, self._way(receiver, seen), threshold_m, distrusted and not known)
        self.doubt = max(self.doubt, min(doubt, 1.0))
        if doubt >= 1.0 and (known or seen.t_s - receiver.cusum.onset_s >= _LEAST_S):
            receiver.drifts(seen.t_s)
        elif known and seen.t_s - receiver.drifted_s >= receiver.steady_s:
            off_m = math.hypot(seen.off_north_m, seen.off_east_m)
            if off_m <= _AGREES * threshold_m + min(3.0 * seen.estimate_sigma_m, threshold_m):
                receiver.since_s = None

    @staticmethod
    def _follow(receiver: _Receiver, seen: PositionSeen, evidence: Evidence) -> None:
        """Whether a position goes along with a velocity that lies."""
        lies = Channel(Sense.VELOCITY, seen.source) in evidence.distrusted
        since_s = receiver.along.position(seen, lies, receiver.noise.size)
        if since_s is not None and receiver.since_s is None:
            receiver.since_s, receiver.drifted_s, receiver.steady_s = since_s, seen.t_s, _STEADY_S


def _drift(receiver: _Receiver, seen: PositionSeen, way: Way | None, threshold_m: float, distrusted: bool) -> float:
    """The drift from fix to fix, summed up, over the threshold; 0 where it cannot be told."""
    last = receiver.last
    receiver.last = None if way is None or distrusted else (seen, way)
    if way is None or last is None or distrusted or not _follows(last[0], seen):
        receiver.cusum.clear(seen.t_s)
        return 0.0
    (north_m, east_m), (last_north_m, last_east_m) = _place(seen), _place(last[0])
    north = north_m - last_north_m - (way[0] - last[1][0])
    east = east_m - last_east_m - (way[1] - last[1][1])
    if math.hypot(north, east) > _OUTLIER * threshold_m:
        receiver.last = last
        return 0.0
    if receiver.since_s is None:
        receiver.noise.update(north, east)
    slack_mps = (_VELOCITY_MPS if receiver.carried is None else _INERTIAL_MPS) + seen.sigma_m / _WANDER_S
    receiver.cusum.update(seen.t_s, north, east, (seen.t_s - last[0].t_s) * slack_mps)
    return receiver.cusum.largest / threshold_m


def _carried(evidence: Evidence, inertial: InertialStep, t_s: float) -> tuple[float, float, float]:
    return evidence.north_mps - inertial.north_mps, evidence.east_mps - inertial.east_mps, t_s


def _place(seen: PositionSeen) -> Way:
    return (seen.north_m, seen.east_m) if seen.antenna is None else seen.antenna


def _follows(last: PositionSeen, seen: PositionSeen) -> bool:
    """Whether two fixes can be compared: close in time, of one kind, and both of the boat or both of the antenna."""
    alike = last.fix is seen.fix and (last.antenna is None) == (seen.antenna is None)
    return 0.0 < seen.t_s - last.t_s <= _GAP_S and alike
