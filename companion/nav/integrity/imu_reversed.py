"""An axis of an inertial sensor has the wrong sign: the hypotheses run side by side, each with one axis turned round.

What the accelerometers have added up to, less what a receiver's velocity has gained, is noise where all axes are right.
With one axis reversed it is twice that axis's part, with the other sign. The log-likelihood of "this axis is reversed"
against "all is right" is summed up by Page's test. Where roll or pitch rate is reversed, the force of gravity is taken
out of the wrong direction: its part is that of twice the tilt. An attitude that is wrong for other reasons tells
nothing: of a filter that has just begun, or whose heading lies.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

from companion.core.frames import ned_to_body
from companion.core.readings import Imu
from companion.nav.integrity.evidence import Channel, Evidence, Hypothesis, LieFound, Sense, VelocitySeen, sense_of_axis
from companion.nav.integrity.felt import AXES, Felt, Parts
from companion.nav.integrity.heading_turned import HeadingTurned
from companion.nav.integrity.statistics import FALSE_ALARM, NoiseSize

_WINDOW_S = 0.45
_LONGEST_S = 1.5
_LEAST_SIGMA_MPS = 0.03  # of a difference over a window, on one axis
_KNOWN_WINDOWS = 30  # after which the noise that was measured counts, before the accuracy of the vessel's file
_MEAN_LENGTH = math.sqrt(0.5 * math.pi)  # of a vector, in sigmas of one axis
_MOST_OF_A_WINDOW = 0.2  # of the threshold; the less likely axes count as much less
_AS_WELL = 0.9
_THRESHOLD = -2.0 * math.log(FALSE_ALARM)  # log-likelihoods of windows are not quite independent


class _Sensor(NamedTuple):
    """What it feels, and the sums of each hypothesis."""

    felt: Felt
    sums: list[float]


class ImuReversed(Hypothesis):
    """Remembers the sums of the sensor in use, the last velocity of a receiver, and its noise."""

    def __init__(self, heading: HeadingTurned | None = None) -> None:
        """`heading`: what may explain the same, and has seen the tick before."""
        self._heading = heading
        self._sensor: _Sensor | None = None
        self._source = ""
        self._before: VelocitySeen | None = None
        self._noise, self._windows = NoiseSize(), 0
        self._sigma_mps = 0.0
        self._found: LieFound | None = None

    def clear(self) -> None:
        """Begin the sums anew."""
        self._sensor = self._before = self._found = None

    def update(self, evidence: Evidence, now_s: float) -> Sequence[LieFound]:
        """The sensor in use, if one of its axes is reversed."""
        known = self._findings()
        self.doubt = 1.0 if known else 0.0
        if known:
            return known
        if not _knows_attitude(evidence) or not evidence.driven or not evidence.imu:
            self.clear()
            return ()
        source = evidence.carrying
        if source != self._source:
            self.clear()
            self._source = source
        samples = [imu for imu in evidence.imu if imu.source == source]
        at = 0
        for seen in evidence.velocities:
            while at < len(samples) and samples[at].t_s <= seen.t_s + 1e-6:
                self._sample(samples[at])
                at += 1
            if Channel(Sense.VELOCITY, seen.source) not in evidence.distrusted:
                self._compare(seen)
        for imu in samples[at:]:
            self._sample(imu)
        return self._findings()

    def _findings(self) -> Sequence[LieFound]:
        return () if self._found is None else (self._found,)

    def _sample(self, imu: Imu) -> None:
        if self._sensor is None:
            self._sensor = _Sensor(Felt(imu), [0.0] * len(AXES))
        elif not self._sensor.felt.sample(imu):
            self._sensor = None

    def _compare(self, seen: VelocitySeen) -> None:
        before, sensor = self._before, self._sensor
        if sensor is None or seen.inertial_north_mps is None or seen.inertial_east_mps is None:
            return
        if before is not None and before.source != seen.source:
            return
        if before is not None and seen.t_s - before.t_s < _WINDOW_S:
            return
        self._before = seen
        parts, sensor.felt.parts = sensor.felt.parts, Parts()
        known = before is not None and before.inertial_north_mps is not None and seen.t_s - before.t_s <= _LONGEST_S
        if not known:
            return
        assert before is not None and before.inertial_north_mps is not None and before.inertial_east_mps is not None
        if not parts.tells(before.yaw_rad, seen.yaw_rad):
            return
        north = seen.north_mps - before.north_mps - (seen.inertial_north_mps - before.inertial_north_mps)
        east = seen.east_mps - before.east_mps - (seen.inertial_east_mps - before.inertial_east_mps)
        self._weigh(sensor, parts, ned_to_body(north, east, before.yaw_rad), seen)

    def _sigma(self, seen: VelocitySeen) -> float:
        """One sigma of a difference over a window, on one axis. Another kind of fix has another noise."""
        if seen.sigma_mps != self._sigma_mps:
            self._noise, self._windows, self._sigma_mps = NoiseSize(), 0, seen.sigma_mps
        if self._windows < _KNOWN_WINDOWS:
            return max(_LEAST_SIGMA_MPS, math.sqrt(2.0) * seen.sigma_mps)
        return max(_LEAST_SIGMA_MPS, self._noise.size / _MEAN_LENGTH)

    def _weigh(self, sensor: _Sensor, parts: Parts, rest: tuple[float, float], seen: VelocitySeen) -> None:
        """Add the log-likelihood of each hypothesis. `rest`: the receiver's gain less the accelerometers'."""
        sigma = self._sigma(seen)
        as_is = rest[0] * rest[0] + rest[1] * rest[1]
        gains = []
        for forward, starboard in zip(parts.forward, parts.starboard, strict=True):
            x, y = rest[0] + 2.0 * forward, rest[1] + 2.0 * starboard
            gains.append((as_is - x * x - y * y) / (2.0 * sigma * sigma))
        share = min(1.0, _MOST_OF_A_WINDOW * _THRESHOLD / max(*gains, 1e-9))
        for i, gain in enumerate(gains):
            sensor.sums[i] = max(0.0, sensor.sums[i] + (share * gain if gain > 0.0 else gain))
        worst = max(range(len(AXES)), key=lambda i: sensor.sums[i])
        self.doubt = max(self.doubt, sensor.sums[worst] / _THRESHOLD)
        if self.doubt < 0.2:
            self._noise.update(math.sqrt(as_is))
            self._windows += 1
        if self.doubt >= 1.0 and not self._is_the_heading(self.doubt):
            channel = Channel(sense_of_axis(AXES[worst]), self._source)
            self._found = LieFound(channel, f"{AXES[worst]} axis reversed", seen.t_s - _LONGEST_S, lasting=True)

    def _is_the_heading(self, doubt: float) -> bool:
        """Whether a turned heading explains it about as well, and thrust does not speak for that of the sensor."""
        return self._heading is not None and self._heading.explains >= _AS_WELL * min(doubt, 1.0)


def _knows_attitude(evidence: Evidence) -> bool:
    """Whether the filter has settled, with a heading that is believed."""
    settled = evidence.inertial is not None and evidence.inertial.settled
    return settled and all(channel.sense is not Sense.HEADING for channel in evidence.distrusted)
