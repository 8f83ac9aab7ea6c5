"""A source repeats itself: the same bits again and again, while the boat moves.

Noise alone changes the last digits of an honest source. How often they repeat is learnt for each source; a run counts
only where the boat has moved by more than the source's resolution meanwhile.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from companion.nav.integrity.evidence import Channel, Evidence, Hypothesis, LieFound, Sense
from companion.nav.integrity.statistics import RepeatRun, Resolution

FAULT = "repeats"
_STEPS = 3.0  # of the resolution, by which the boat must have moved for a repeat to be wrong
_METRES_PER_DEGREE = 111_000.0
_LEAST_WIND_S = 10.0  # a steady wind repeats in the coarse figures of a vane


Axes = tuple[float, float]


@dataclass(slots=True)
class _Watch:
    """A channel's run of repeats, the resolution of its axes, what turns that into units of the motion, and the motion
    when the run began."""

    run: RepeatRun = field(default_factory=RepeatRun)
    axes: tuple[Resolution, Resolution] = field(default_factory=lambda: (Resolution(), Resolution()))
    scale: Axes = (1.0, 1.0)
    from_north: float = 0.0
    from_east: float = 0.0
    has_moved: bool = False

    def take(self, t_s: float, value: tuple[float, ...], steps: Axes, motion: Axes | None) -> None:
        """`steps`: the value on two axes. `motion`: a sum, on the same axes; None: unknown."""
        self.run.update(value, t_s)
        if self.run.run == 0:
            self.has_moved = False
            if motion is not None:
                self.from_north, self.from_east = motion
        self.axes[0].update(steps[0])
        self.axes[1].update(steps[1])

    def moved(self, motion: Axes | None) -> bool:
        """Whether the boat has moved by more than the resolution since the run began, be it there and back. None:
        nobody knows, so nothing excuses repeats."""
        if motion is None:
            return True
        if not self.has_moved:
            resolution = min(axis.step * unit for axis, unit in zip(self.axes, self.scale, strict=True))
            way = math.hypot(motion[0] - self.from_north, motion[1] - self.from_east)
            self.has_moved = way >= _STEPS * resolution
        return self.has_moved


class Repeated(Hypothesis):
    """Remembers a run for each channel, and the way that the boat has made by the estimate."""

    def __init__(self) -> None:
        self._watches: dict[Channel, _Watch] = {}
        self._imus: dict[str, _Watch] = {}  # of the inertial sensors, whose samples are many
        self._way_north = self._way_east = 0.0
        self._last_s = math.inf

    def update(self, evidence: Evidence, now_s: float) -> Sequence[LieFound]:
        """Channels that repeat though the boat moves."""
        dt_s, self._last_s = min(max(now_s - self._last_s, 0.0), 1.0), now_s
        self._way_north += evidence.north_mps * dt_s
        self._way_east += evidence.east_mps * dt_s
        way = (self._way_north, self._way_east)
        inertial = evidence.inertial
        swing = None if inertial is None else (inertial.north_mps, inertial.east_mps)
        turn = None if inertial is None else (inertial.turned_rad, 0.0)
        for seen in evidence.positions:
            degrees, watch = (seen.lat_deg, seen.lon_deg), self._watch(Sense.POSITION, seen.source)
            watch.scale = _METRES_PER_DEGREE, _METRES_PER_DEGREE * math.cos(math.radians(seen.lat_deg))
            watch.take(seen.t_s, degrees, degrees, way)
        for velocity in evidence.velocities:
            self._watch(Sense.VELOCITY, velocity.source).take(velocity.t_s, velocity.raw, velocity.raw, swing)
        for heading in evidence.headings:
            steps = heading.raw, heading.raw
            self._watch(Sense.HEADING, heading.source).take(heading.t_s, (heading.raw,), steps, turn)
        self._take_others(evidence)
        return self._judged(evidence, {Sense.POSITION: way, Sense.VELOCITY: swing, Sense.HEADING: turn}, now_s)

    def _take_others(self, evidence: Evidence) -> None:
        """Sources that are noisy enough to be judged without the boat's motion."""
        none = (0.0, 0.0)
        for imu in evidence.raw_imu:
            sample = (
                imu.x_mps2, imu.y_mps2, imu.z_mps2, imu.roll_rate_radps, imu.pitch_rate_radps, imu.yaw_rate_radps,
            )  # fmt: skip
            watch = self._imus.get(imu.source)
            if watch is None:
                watch = self._imus[imu.source] = self._watch(Sense.IMU, imu.source)
            watch.take(imu.t_s, sample, none, none)
        for seen in evidence.fields:
            self._watch(Sense.FIELD, seen.source).take(seen.t_s, (seen.x, seen.y, seen.z), none, none)
        for wind in evidence.winds:
            if wind.speed_mps > 0.0:
                value = wind.speed_mps, wind.from_rad
                self._watch(Sense.WIND, wind.source).take(wind.t_s, value, none, none)

    def _watch(self, sense: Sense, source: str) -> _Watch:
        channel = Channel(sense, source)
        found = self._watches.get(channel)
        if found is None:
            found = self._watches[channel] = _Watch()
        return found

    def _judged(self, evidence: Evidence, motions: dict[Sense, Axes | None], now_s: float) -> Sequence[LieFound]:
        self.doubt = 0.0
        if not evidence.driven:
            return ()
        found = []
        for channel, watch in self._watches.items():
            if not watch.run.run:
                continue
            doubt = watch.run.doubt if watch.moved(motions.get(channel.sense)) else 0.0
            if channel.sense is Sense.WIND:
                doubt = min(doubt, (now_s - watch.run.since_s) / _LEAST_WIND_S)
            self.doubt = max(self.doubt, doubt)
            if doubt >= 1.0:
                found.append(LieFound(channel, FAULT, watch.run.since_s))
        return found
