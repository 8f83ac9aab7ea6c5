"""A heading is a quarter or half of a turn off: two antennas are swapped or sit athwart, a compass is mounted the other
way round. It has been so from the start, and the gyro agrees with it.

A receiver's velocity, turned into the boat's axes by that heading, changes by the same angle beside what the
accelerometers feel, whatever the current. The log-likelihood of "turned by that angle" against "as it is" is summed up
by Page's test for each of three angles. An inertial sensor that is turned or has a reversed axis looks alike; but it is
against the thrust of the boat, too, and a heading is not: thrust and forces are both felt along the hull. So the
changes of the modelled velocity tell which of both it is, where they tell enough. Few boats are pushed sideways or
pitch by their thrust: that one of these axes is reversed is summed up beside the angles, which must be clearly
likelier. The forces are those of the sensor alone: in those of a filter a tilt has long hidden what is wrong.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from companion.core.frames import ned_to_body
from companion.core.readings import Imu
from companion.nav.integrity.evidence import (
    INERTIAL,
    Channel,
    Evidence,
    Hypothesis,
    LieFound,
    ModelStep,
    Sense,
    VelocitySeen,
)
from companion.nav.integrity.felt import AXES, LEVEL_TIME_S, Felt, Parts
from companion.nav.integrity.statistics import FALSE_ALARM

_TURNS_RAD = (0.5 * math.pi, math.pi, -0.5 * math.pi)
_WINDOW_S, _LONGEST_S = 0.45, 1.5
_LEAST_SIGMA_MPS = 0.04  # of a difference over a window, on one axis: of velocity and tilt
_MOST_OF_A_WINDOW = 0.2  # of the threshold
_THRESHOLD = -2.0 * math.log(FALSE_ALARM)  # log-likelihoods of windows are not quite independent
_JUMP_SHARE, _JUMP_SIGMAS = 2.0, 10.0
_CLEARLY = 5.0  # by which one angle must be likelier than the others, and than a reversed axis
_WITNESS_SIGMAS = 3.0, 2.0  # by which thrust must agree with the forces: at the threshold, and at twice that
_LEANS_SIGMAS, _LEANS_SHARE = 2.0, 4.0  # by which it leans to one side, and how much more the heading is suspected then
_FORGOTTEN_S = 60.0  # time constant of that
_FRESH_S, _IN_USE_RAD = 2.0, math.radians(45.0)  # a heading of that age, as near to the estimate, has made it so

Pair = tuple[float, float]


class _Point(NamedTuple):
    """A velocity, and what the model has added up to by then, in that run."""

    seen: VelocitySeen
    model: ModelStep


class HeadingTurned(Hypothesis):
    """Remembers what the inertial sensor in use feels, the last velocity of a receiver, the slow parts of the gains,
    the sums of each angle and axis, how thrust and forces go together, the last heading of each source, and what is
    found."""

    def __init__(self) -> None:
        self._begin()
        self._source = ""
        self._headings: dict[str, tuple[float, float]] = {}  # when, and how far off the estimate
        self._found: dict[str, LieFound] = {}

    def _begin(self) -> None:
        self._felt: Felt | None = None
        self._before: _Point | None = None
        self._slow = self._slow_model = (0.0, 0.0)  # m/s²
        self._sums = [0.0] * len(_TURNS_RAD)
        self._reversed = [0.0] * len(AXES)
        self._both = self._squares = 0.0  # of forces times thrust, and of that squared

    def clear(self) -> None:
        """Begin anew."""
        self._begin()
        self._found.clear()

    def accept(self, channel: Channel) -> None:
        """The boat points where that source says."""
        if channel.sense is Sense.HEADING:
            self._begin()
            self._found.pop(channel.source, None)

    @property
    def _witness(self) -> float:
        """By how many sigmas thrust goes with the forces; below 0, against them."""
        return self._both / math.sqrt(self._squares) if self._squares > 0.0 else 0.0

    @property
    def explains(self) -> float:
        """By how much a turned heading explains what speaks against the inertial sensor, over the threshold. It counts
        the more where thrust goes with that sensor, and not at all where thrust is against it, too, or a reversed axis
        is clearly likelier."""
        likely, witness = max(self._sums) / _THRESHOLD, self._witness
        if max(self._reversed[1:]) > max(self._sums) + _CLEARLY:
            return 0.0
        return 0.0 if witness < -_LEANS_SIGMAS else _LEANS_SHARE * likely if witness > _LEANS_SIGMAS else likely

    def update(self, evidence: Evidence, now_s: float) -> Sequence[LieFound]:
        """Headings that are turned."""
        for heading in evidence.headings:
            self._headings[heading.source] = heading.t_s, heading.off_rad
        lies = any(self._rests_on(channel) for channel in evidence.distrusted)
        if not evidence.driven or lies or evidence.model is None or evidence.carrying != self._source:
            self._begin()
            self._source = evidence.carrying
        else:
            self._take(evidence)
        *_, second, largest = sorted(self._sums)
        second = max(second, *self._reversed[1:])  # the first one is against the thrust
        self.doubt = 1.0 if self._found else min(largest / _THRESHOLD, 0.99)
        at_once, least = _WITNESS_SIGMAS
        asked = max(at_once + 1.0 - largest / _THRESHOLD, least)
        if largest >= max(_THRESHOLD, second + _CLEARLY) and self._witness >= asked:
            self._blame(_TURNS_RAD[self._sums.index(largest)], now_s)
        return list(self._found.values())

    def _rests_on(self, channel: Channel) -> bool:
        """Whether it tells nothing where that channel lies."""
        return channel.sense is Sense.HEADING or (channel.sense in INERTIAL and channel.source == self._source)

    def _take(self, evidence: Evidence) -> None:
        """The samples and velocities of a tick, in order of time."""
        assert evidence.model is not None
        samples, at = [imu for imu in evidence.imu if imu.source == self._source], 0
        for seen in evidence.velocities:
            while at < len(samples) and samples[at].t_s <= seen.t_s + 1e-6:
                self._sample(samples[at])
                at += 1
            if Channel(Sense.VELOCITY, seen.source) not in evidence.distrusted:
                self._compare(_Point(seen, evidence.model))
        for imu in samples[at:]:
            self._sample(imu)

    def _sample(self, imu: Imu) -> None:
        if self._felt is None or not self._felt.sample(imu):
            self._felt, self._before = Felt(imu), None

    def _compare(self, point: _Point) -> None:
        """The gains of a window, at its end."""
        before, (seen, model) = self._before, point
        if self._felt is None or (before is not None and before.seen.source != seen.source):
            return
        passed_s = math.inf if before is None else seen.t_s - before.seen.t_s
        if passed_s < _WINDOW_S:
            return
        self._before, parts = point, self._felt.parts
        self._felt.parts = Parts()
        if before is None or passed_s > _LONGEST_S or before.model.run != model.run:
            return
        if not parts.tells(before.seen.yaw_rad, seen.yaw_rad):
            return
        half_rad = 0.5 * parts.turned_rad
        felt = parts.gained(half_rad)
        gained = seen.north_mps - before.seen.north_mps, seen.east_mps - before.seen.east_mps
        last = before.model
        thrust = model.pushed_ahead_mps - last.pushed_ahead_mps, model.pushed_starboard_mps - last.pushed_starboard_mps
        sigma_mps = max(_LEAST_SIGMA_MPS, math.sqrt(2.0) * seen.sigma_mps)
        if math.hypot(*gained) > _JUMP_SHARE * math.hypot(*felt) + _JUMP_SIGMAS * sigma_mps:
            return  # no turn makes more of what was felt: it has jumped, or the boat gathers way steadily
        middle = ned_to_body(*gained, before.seen.yaw_rad + half_rad)
        lasts_s = passed_s * (math.sin(half_rad) / half_rad if half_rad else 1.0)
        gained, self._slow = _quick(middle, self._slow, passed_s, lasts_s)
        thrust, self._slow_model = _quick(thrust, self._slow_model, passed_s, passed_s)
        self._weigh(gained, felt, parts.reversed(half_rad), sigma_mps)
        product, kept = felt[0] * thrust[0] + felt[1] * thrust[1], math.exp(-passed_s / _FORGOTTEN_S)
        self._both = kept * self._both + product
        self._squares = kept * self._squares + product * product

    def _weigh(self, gained: Pair, felt: Pair, had_axes: Sequence[Pair], sigma_mps: float) -> None:
        """Add the log-likelihood of each angle, and of each reversed axis. The less likely ones count as much less as
        the likeliest does where it would count for too much."""
        angles = [ned_to_body(*felt, turn_rad) for turn_rad in _TURNS_RAD]
        as_is = _apart(gained, felt)
        gains = [(as_is - _apart(gained, other)) / (2.0 * sigma_mps * sigma_mps) for other in (*angles, *had_axes)]
        share = min(1.0, _MOST_OF_A_WINDOW * _THRESHOLD / max(*gains, 1e-9))
        sums = [
            max(0.0, before + (share * gain if gain > 0.0 else gain))
            for before, gain in zip((*self._sums, *self._reversed), gains, strict=True)
        ]
        self._sums, self._reversed = sums[: len(_TURNS_RAD)], sums[len(_TURNS_RAD) :]

    def _blame(self, turn_rad: float, now_s: float) -> None:
        """All headings by which the estimate is where it is."""
        fault = f"is off by {abs(math.degrees(turn_rad)):.0f} deg"
        for source, (t_s, off_rad) in self._headings.items():
            if now_s - t_s <= _FRESH_S and abs(off_rad) <= _IN_USE_RAD:
                channel = Channel(Sense.HEADING, source)
                self._found[source] = LieFound(channel, fault, now_s - _LONGEST_S, asks=True, lasting=True, loses=True)


def _apart(one: Pair, other: Pair) -> float:
    """The square of what two velocities differ by."""
    x, y = one[0] - other[0], one[1] - other[1]
    return x * x + y * y


def _quick(gained: Pair, slow_mps2: Pair, passed_s: float, lasts_s: float) -> tuple[Pair, Pair]:
    """A gain of velocity without its slow part, and that slow part with it, as `Felt` has it of forces. `lasts_s`: the
    time that the slow part adds up over, along the axes of the middle: less than has passed where the boat turns."""
    share = passed_s / LEVEL_TIME_S
    x = slow_mps2[0] + share * (gained[0] / lasts_s - slow_mps2[0])
    y = slow_mps2[1] + share * (gained[1] / lasts_s - slow_mps2[1])
    return (gained[0] - lasts_s * x, gained[1] - lasts_s * y), (x, y)
