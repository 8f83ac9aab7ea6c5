"""The heading drifts away from what the gyro has turned; or the gyro away from the heading.

Page's test on the difference of both. Which of them lies is told by how it began: a gyro whose bias changes does so
from one sample to the next, without the moment that a real turn needs; a gyro with the wrong sign turns as far as the
heading does, the other way; a heading that creeps leaves the gyro as it was. A gyro that drifts off slowly cannot be
told from a heading that does: the heading is blamed. While it is not used, nobody steers by it: if it goes on to turn
as far as the gyro, the other way, it was the gyro after all. What one latency explains is blamed on neither
(`late_heading.py`): what that makes of a turn ends with it.
"""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import accumulate

from companion.core.angles import wrap_pi
from companion.core.readings import Imu
from companion.nav.integrity.evidence import Channel, Evidence, HeadingSeen, Hypothesis, LieFound, ModelStep, Sense
from companion.nav.integrity.late_heading import explained_by_latency
from companion.nav.integrity.statistics import Median3, NoiseSize, ScalarCusum

_SLACK_RADPS = math.radians(0.15)
_TURN_SHARE = 0.04  # of a turn: the gyro's scale, the compass's deviation, its tilt in a tight turn
_BIAS_SIGMAS = 3.0  # of the gyro's bias, as the filter knows it
_LEAST_RAD = math.radians(1.5)
_NOISES = 8.0
_WANDERS = 1.0  # of the slow error by the vessel's file, while the heading stays
_TURNED_WANDERS = 3.0  # more of it after a turn, since a compass deviates with the heading
_ALL_TURNED_RAD = math.radians(60.0)  # by so far; in proportion before
_GAP_S = 1.5
_SKIPPED = 5
_AGREES_RAD = math.radians(3.0)
_STEADY_S = 5.0  # without a further drift, before a source can be believed again
_MEMORY_S = 15.0
_STEP_SAMPLES = 5  # whose mean is compared with that of as many more: a bias changes in between, no boat turns so soon
_ROUND_ONSET_S = 1.0  # how far the onset may be off
_STEP_SHARE = 0.6  # of the rate of the drift, by which the gyro's step must explain it
_LEAST_STEP_RADPS = math.radians(0.6)  # smaller steps are noise
_OPPOSITE = 0.6  # share of the drift by which heading and turn may differ in size
_OPPOSITE_UNUSED = 0.25  # the same, of a heading that is not used
_LEAST_TURN_RAD = math.radians(5.0)  # of that, and how often in a row
_OPPOSITE_TIMES = 2
_MODEL_TICKS = 5  # between two rates that are compared with the model
_MODEL_SLOPE = 0.3
_MODEL_MOST = 3.0  # times the changes of the model, up to which thrust made those of the gyro


class _Track:
    """Heading and turn of the last seconds, each unwrapped, in the order of time."""

    def __init__(self) -> None:
        self.times_s: list[float] = []
        self.headings_rad: list[float] = []
        self.turns_rad: list[float] = []

    def add(self, t_s: float, turn_rad: float, step_rad: float) -> None:
        """The next moment; `step_rad`: what the heading gained on the turn since the one before."""
        gained_rad = self.headings_rad[-1] - self.turns_rad[-1] + step_rad if self.times_s else 0.0
        self.times_s.append(t_s)
        self.headings_rad.append(turn_rad + gained_rad)
        self.turns_rad.append(turn_rad)
        old = 0
        while self.times_s[old] < t_s - _MEMORY_S:
            old += 1
        if old:
            del self.times_s[:old], self.headings_rad[:old], self.turns_rad[:old]

    def spread_rad(self, from_s: float) -> float:
        """By how much the turns since a time differ at most."""
        first = bisect_left(self.times_s, from_s)
        since = self.turns_rad[first:]
        return max(since) - min(since) if since else 0.0

    def is_late(self, from_s: float, slack_radps: float, threshold_rad: float) -> bool:
        """Whether the headings since a time are late by so much that no drift is left."""
        first = max(bisect_left(self.times_s, from_s) - 1, 0)
        slack = slack_radps, _TURN_SHARE
        return explained_by_latency(self.times_s, self.headings_rad, self.turns_rad, first, slack, threshold_rad)

    def is_opposite(self, from_s: float, share: float = _OPPOSITE, least_rad: float = 0.0) -> bool:
        """Whether the heading has turned about as far as the gyro since a time, but the other way. `least_rad`: of the
        turn."""
        first = bisect_left(self.times_s, from_s)
        if len(self.times_s) - first < 2:
            return False
        heading_rad = self.headings_rad[-1] - self.headings_rad[first]
        turn_rad = self.turns_rad[-1] - self.turns_rad[first]
        return abs(heading_rad + turn_rad) <= share * abs(heading_rad - turn_rad) and abs(turn_rad) >= least_rad


@dataclass(slots=True)
class _Source:
    last: HeadingSeen | None = None
    apart_rad: Median3 = field(default_factory=Median3)  # heading less turn, a sample late: an outlier is no drift
    noise: NoiseSize = field(default_factory=NoiseSize)
    cusum: ScalarCusum = field(default_factory=ScalarCusum)
    since_s: float | None = None
    drifted_s: float = 0.0  # when it last drifted by the threshold
    opposite: int = 0  # stretches in a row in which it turned against the gyro while it was not used
    unused_s: float = 0.0  # when the present one began
    track: _Track = field(default_factory=_Track)
    skipped: int = 0  # headings in a row that were off the others

    def skip(self, last: HeadingSeen, seen: HeadingSeen) -> None:
        """A heading is off the median: it jumps, which `heading_jump.py` judges, or the one before was an outlier, as
        the first of all may be. Several of them count from now on."""
        self.last = last
        self.skipped += 1
        if self.skipped >= _SKIPPED:
            self.last, self.apart_rad, self.skipped = seen, Median3(), 0
            self.cusum.clear(seen.t_s)


class HeadingDrift(Hypothesis):
    """Remembers the sums of each source, and the gyro's samples of the last seconds."""

    def __init__(self) -> None:
        self._sources: dict[str, _Source] = {}
        self._sensor = ""  # the inertial sensor that carries the estimate
        self._rates: deque[tuple[float, float]] = deque()  # (time, yaw rate) of its samples
        self._imu: tuple[str, str, float] | None = None  # the sensor whose gyro lies, how, and since when
        self._turning: deque[tuple[float, float, float]] = deque()  # time, yaw rate, and what the model adds up to
        self._run: int | None = None

    def clear(self) -> None:
        """Begin the sums anew."""
        self._imu = None
        for source in self._sources.values():
            source.since_s, source.last = None, None

    def accept(self, channel: Channel) -> None:
        """The boat points where that source says."""
        if channel.sense is Sense.HEADING and channel.source in self._sources:
            self._sources[channel.source] = _Source()

    def update(self, evidence: Evidence, now_s: float) -> Sequence[LieFound]:
        """Sources whose heading has drifted off, until it agrees with the estimate again; or the sensor whose gyro
        has."""
        self.doubt = 0.0
        self._remember(evidence, now_s)
        for seen in evidence.headings:
            source = self._sources.get(seen.source)
            if source is None:
                source = self._sources[seen.source] = _Source()
            settled = evidence.inertial is not None and evidence.inertial.settled
            judged = evidence.driven or evidence.maybe_late  # `is_late` allows for that
            if judged and settled and seen.turned_rad is not None:
                self._compare(source, seen, evidence, Channel(Sense.HEADING, seen.source) in evidence.distrusted)
            else:
                source.last = None
        found = [
            LieFound(Channel(Sense.HEADING, name), "drifts", source.since_s, asks=True)
            for name, source in self._sources.items()
            if source.since_s is not None
        ]
        if self._imu is None:
            return found
        sensor, fault, since_s = self._imu
        lies = LieFound(Channel(Sense.GYRO, sensor), fault, since_s, lasting=True)
        return (lies,) if sensor == self._sensor else (lies, *found)

    def _remember(self, evidence: Evidence, now_s: float) -> None:
        step, rates, sensor = evidence.inertial, self._rates, evidence.carrying
        if sensor != self._sensor:
            self._change(sensor)
        if step is None or step.run != self._run:
            rates.clear()
            for source in self._sources.values():
                source.last = None
        self._run = None if step is None else step.run
        samples = [imu for imu in evidence.imu if imu.source == sensor]
        self._remember_model(samples, evidence.model, now_s)
        rates.extend((imu.t_s, imu.yaw_rate_radps) for imu in samples)
        while rates and rates[0][0] < now_s - _MEMORY_S:
            rates.popleft()

    def _change(self, sensor: str) -> None:
        """Another gyro has another bias; and what headings seemed to do beside one that lies is void."""
        if self._imu is not None and self._imu[0] == self._sensor:
            for source in self._sources.values():
                source.since_s = None
        self._sensor = sensor
        self._rates.clear()
        self._turning.clear()

    def _remember_model(self, samples: Sequence[Imu], model: ModelStep | None, now_s: float) -> None:
        """The gyro's rate beside that of the hull model, for each tick."""
        turning = self._turning
        if model is None or not samples:
            turning.clear()
            return
        mean_radps = sum(sample.yaw_rate_radps for sample in samples) / len(samples)
        turning.append((now_s, mean_radps, model.turn_radps))
        while turning[0][0] < now_s - _MEMORY_S:
            turning.popleft()

    def _compare(self, source: _Source, seen: HeadingSeen, evidence: Evidence, distrusted: bool) -> None:
        assert evidence.inertial is not None and seen.turned_rad is not None
        last, source.last = source.last, seen
        if last is None or last.turned_rad is None or not 0.0 < seen.t_s - last.t_s <= _GAP_S:
            source.cusum.clear(seen.t_s)
            source.apart_rad = Median3()
            return
        step_rad = wrap_pi(seen.yaw_rad - last.yaw_rad - (seen.turned_rad - last.turned_rad))
        threshold_rad = _threshold_rad(source, seen)
        if abs(source.apart_rad.newest_off + step_rad) > threshold_rad:
            source.skip(last, seen)
            return
        source.skipped = 0
        source.noise.update(abs(step_rad))
        source.track.add(seen.t_s, seen.turned_rad, step_rad)
        slack_radps = _SLACK_RADPS + _BIAS_SIGMAS * evidence.inertial.turn_sigma_radps
        turn_rad = abs(seen.turned_rad - last.turned_rad)
        source.cusum.update(
            last.t_s, source.apart_rad.step(step_rad), (seen.t_s - last.t_s) * slack_radps + _TURN_SHARE * turn_rad
        )
        doubt = source.cusum.largest / threshold_rad
        self.doubt = max(self.doubt, min(doubt, 1.0))
        if doubt >= 1.0 and source.track.is_late(source.cusum.onset_s, slack_radps, threshold_rad):
            return
        if doubt >= 1.0:
            if source.since_s is None and not distrusted:
                self._blame(source, seen, evidence)
                source.opposite, source.unused_s = 0, seen.t_s
            elif source.since_s is not None and distrusted and evidence.imu:
                self._reconsider(source, source.since_s, seen.t_s, evidence.carrying)
            source.drifted_s = seen.t_s
            source.cusum.clear(seen.t_s)
        elif seen.t_s - source.drifted_s >= _STEADY_S and abs(seen.off_rad) <= _AGREES_RAD + 3.0 * seen.sigma_rad:
            source.since_s = None

    def _blame(self, source: _Source, seen: HeadingSeen, evidence: Evidence) -> None:
        onset_s = source.cusum.onset_s
        rate_radps = source.cusum.largest / max(seen.t_s - onset_s, 0.05) + _SLACK_RADPS
        step_radps = self._gyro_step_radps(onset_s)
        mirrored = step_radps <= 2.0 * self._rate_before_radps(onset_s) + _LEAST_STEP_RADPS
        if not evidence.imu:
            source.since_s = onset_s
        elif mirrored and source.track.is_opposite(onset_s) and _against_model(self._turning, onset_s):
            self._imu = evidence.carrying, "yaw axis reversed", onset_s
        elif step_radps >= max(_STEP_SHARE * rate_radps, _LEAST_STEP_RADPS):
            self._imu = evidence.carrying, "yaw rate is off", onset_s
        else:
            source.since_s = onset_s

    def _reconsider(self, source: _Source, since_s: float, t_s: float, imu: str) -> None:
        """Blame the gyro in place of a heading that is not used, where both still turn opposite ways."""
        turn_rad = source.track.spread_rad(source.unused_s)
        if turn_rad < _LEAST_TURN_RAD:
            return
        opposite = source.track.is_opposite(source.unused_s, _OPPOSITE_UNUSED, _LEAST_TURN_RAD)
        source.opposite, source.unused_s = (source.opposite + 1 if opposite else 0), t_s
        if source.opposite >= _OPPOSITE_TIMES:
            self._imu, source.since_s = (imu, "yaw axis reversed", since_s), None

    def _rate_before_radps(self, onset_s: float) -> float:
        """Mean size of the yaw rate just before a time: a gyro that changes its sign then steps by twice as much."""
        before = [abs(rate) for t_s, rate in self._rates if _ROUND_ONSET_S < onset_s - t_s <= 2.0 * _ROUND_ONSET_S]
        return sum(before) / len(before) if before else 0.0

    def _gyro_step_radps(self, onset_s: float) -> float:
        """The largest change of the yaw rate from a few samples to the next few, around a time."""
        near = [rate for t_s, rate in self._rates if abs(t_s - onset_s) <= _ROUND_ONSET_S]
        sums = list(accumulate(near, initial=0.0))
        count = _STEP_SAMPLES
        return max(
            (abs(sums[i + 2 * count] - 2.0 * sums[i + count] + sums[i]) / count for i in range(len(sums) - 2 * count)),
            default=0.0,
        )


def _threshold_rad(source: _Source, seen: HeadingSeen) -> float:
    """How far heading and turn of good sensors may differ, after the turns since they began to."""
    wanders = _WANDERS
    if seen.wander_rad > 0.0:
        spread_rad = source.track.spread_rad(source.cusum.onset_s)
        wanders += _TURNED_WANDERS * min(spread_rad / _ALL_TURNED_RAD, 1.0)
    return max(_LEAST_RAD, _NOISES * source.noise.size) + wanders * seen.wander_rad


def _against_model(turning: Sequence[tuple[float, float, float]], from_s: float) -> bool:
    """Whether the gyro's rate falls where thrust should raise it: the slope between their changes is negative. Changes
    far beyond those of thrust are waves and gusts, whose slope is chance."""
    since = [point for point in turning if point[0] >= from_s]
    products = squares = felt = 0.0
    for before, after in zip(since, since[_MODEL_TICKS:], strict=False):
        model_radps, gyro_radps = after[2] - before[2], after[1] - before[1]
        products += model_radps * gyro_radps
        squares += model_radps * model_radps
        felt += gyro_radps * gyro_radps
    return products < -_MODEL_SLOPE * squares and felt <= _MODEL_MOST**2 * squares
