"""Wave motion of the hull, separated from its slow motion: what dynamic positioning should leave alone.

Waves move a boat to and fro faster than its thrusters can follow; a positioning law that answers them wears the drives
and gains nothing. The passive observer of Fossen & Strand (1999), *Passive nonlinear observer design for ships using
Lyapunov methods* (Automatica 35), splits the measured motion in two: a slow part that follows the known thrust and an
unknown force, and an oscillator at the frequency of the waves. The slow part has a notch at that frequency, and follows
the boat's own thrust without lag, as a filter of the measured motion alone would not.

The observer here differs in what it measures. The error-state filter gives velocities that are good to millimetres a
second, so that each axis needs one measurement, and positions pass unfiltered but for the oscillation: what is taken
off has no mean, so that wave drift and slow motion stay. Of the forces on the hull it is told that of the measured
wind, too, for positioning counters gusts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from companion.config.hull import HullConfig
from companion.core.actuation import Wrench
from companion.core.estimate import WaveMotion
from companion.core.frames import body_to_ned, ned_to_body
from companion.nav.solution import Motion

_HIGH_PASS_RADPS = 1.0  # of the velocities that tell the waves' frequency: above the motion of positioning
_MEMORY_S = 20.0  # of the spectrum: a score of waves
_MOST_RADPS = 8.0  # a hull follows no faster waves
_CALM_MPS, _WAVES_MPS = 0.015, 0.03  # RMS velocity on an axis: up to the first calm, from the second on waves
_RATIO_OFF, _RATIO_ON = 2.5, 3.5  # frequency of the waves over the bandwidth of the law: nothing is separated below
# Share of the fast motion that the known forces explain: none of it is taken for waves from the second on. A law that
# answers waves explains half of what it sees of them, once none are taken off: below the first, so that it ends.
_OWN_LEAST, _OWN_MOST = 0.6, 0.9
_FULL_MPS, _UNDER_WAY_MPS = 0.6, 1.0  # up to the first speed the frequency met is steady enough, from the second on not
_RETUNE_SHARE, _RETUNE_S = 0.02, 1.0
_OSCILLATION_DAMPING = 0.02  # of the oscillator: depth of the notch
_NOTCH_DAMPING = 1.0  # width of the notch
_SLOW_SHARE = 0.3  # bandwidth of the slow part, over the waves' frequency
_LONGEST_STEP_S = 0.5
_LARGEST_STEP = 1.0  # m/s, rad/s: the velocity has been set anew, no wave does that

Four = tuple[float, float, float, float]
Array = np.ndarray[Any, np.dtype[np.float64]]


class WaveSpectrum:
    """Velocities of a boat → mean frequency and strength of its wave motion. `update` every tick.

    The mean frequency is √(m₂/m₀) of the high-passed velocity, by moments of the samples and of their differences:
    Σ(Δx)²/Σx² = 4 sin²(ω Δt/2), exact for one wave at any step. That is the least-squares form, over a fading memory,
    of the estimator of Belleter, Galeazzi & Fossen (2015), *Experimental verification of a global exponential stable
    nonlinear wave encounter frequency estimator* (Ocean Engineering 97); being no adaptation, it cannot diverge.
    Remembers the high-pass filters and the moments, also of what known forces do to the velocities.
    """

    def __init__(self, size: int) -> None:
        self._low = [[0.0] * size, [0.0] * size]
        self._last = [0.0] * size
        self._known, self._known_low, self._known_last = [0.0] * size, [0.0] * size, [0.0] * size
        self._moment = self._difference = self._weight = self._explained = 0.0
        self._squares = [0.0] * size
        self._fresh = True
        self._dt_s = self._share = self._fade = 0.0

    def update(
        self, velocities: Sequence[float], weights: Sequence[float], dt_s: float, known: Sequence[float] = ()
    ) -> None:
        """Take the velocities of a tick; `weights` bring them to one unit. `known`: accelerations by known forces since
        the last tick."""
        if dt_s != self._dt_s:
            self._dt_s, self._share = dt_s, _HIGH_PASS_RADPS * dt_s / (1.0 + _HIGH_PASS_RADPS * dt_s)
            self._fade = math.exp(-dt_s / _MEMORY_S)
        share, fade, (first, second), last, squares = self._share, self._fade, self._low, self._last, self._squares
        if self._fresh:
            first[:], self._fresh = velocities, False
        moment = difference = explained = 0.0
        for i, value in enumerate(velocities):
            first[i] += share * (value - first[i])
            high = value - first[i]
            second[i] += share * (high - second[i])
            high -= second[i]
            change, last[i] = weights[i] * (high - last[i]), high
            squares[i] = fade * squares[i] + high * high
            high *= weights[i]
            moment += high * high
            difference += change * change
            if known:
                explained += change * weights[i] * self._known_change(i, known[i] * dt_s)
        self._explained = fade * self._explained + explained
        self._weight = fade * self._weight + 1.0
        self._moment, self._difference = fade * self._moment + moment, fade * self._difference + difference

    def _known_change(self, axis: int, change: float) -> float:
        """A velocity's change by known forces, high-passed as the velocities are."""
        self._known[axis] = (1.0 - self._share) * (self._known[axis] + change)
        self._known_low[axis] += self._share * (self._known[axis] - self._known_low[axis])
        high, before = self._known[axis] - self._known_low[axis], self._known_last[axis]
        self._known_last[axis] = high
        return high - before

    @property
    def own_share(self) -> float:
        """Share of the fast motion that the known forces explain, by regression of its changes on theirs."""
        return self._explained / self._difference if self._difference > 0.0 else 0.0

    @property
    def radps(self) -> float:
        """Mean frequency; 0 before there is any motion."""
        if self._moment <= 0.0:
            return 0.0
        return 2.0 / self._dt_s * math.asin(min(1.0, 0.5 * math.sqrt(self._difference / self._moment)))

    def mean(self, axis: int) -> float:
        """Low-passed velocity of an axis, as it came."""
        return self._low[0][axis]

    def rms(self, axis: int) -> float:
        """RMS of the high-passed velocity of an axis, as it came."""
        return math.sqrt(self._squares[axis] / self._weight) if self._weight else 0.0


class _Split:
    """One axis: slow velocity, acceleration by unknown forces, displacement and velocity of the waves."""

    __slots__ = ("acceleration", "displacement", "slow", "wave")

    def __init__(self, velocity: float, acceleration: float) -> None:
        """The boat moves steadily: unknown forces balance what gives it the known `acceleration`."""
        self.slow, self.acceleration = velocity, -acceleration
        self.displacement = self.wave = 0.0

    def is_off(self, velocity: float) -> bool:
        """Whether the velocity has been set anew."""
        return abs(velocity - self.slow - self.wave) > _LARGEST_STEP

    def step(self, measured: float, acceleration: float, dt_s: float, tuning: _Tuning) -> None:
        """Take a velocity, and the known acceleration since the last one."""
        a, b, c, d = tuning.oscillator
        displacement, wave = self.displacement, self.wave
        slow = self.slow + dt_s * (acceleration + self.acceleration)
        displacement, wave = a * displacement + b * wave, c * displacement + d * wave
        off = measured - slow - wave
        k1, k2, k3, k4 = tuning.gains
        self.slow, self.acceleration = slow + k1 * off, self.acceleration + k2 * off
        self.displacement, self.wave = displacement + k3 * off, wave + k4 * off


class _Tuning:
    """Matrices of the observer for one frequency and step: the four poles are two of the notch and two of the slow
    part."""

    __slots__ = ("dt_s", "gains", "oscillator", "radps")

    def __init__(self, radps: float, dt_s: float) -> None:
        self.radps, self.dt_s = radps, dt_s
        self.oscillator = _oscillator(radps, dt_s)
        a, b, c, d = self.oscillator
        step = np.array([[1.0, dt_s, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, a, b], [0.0, 0.0, c, d]])
        seen = np.array([1.0, 0.0, 0.0, 1.0]) @ step
        wanted = np.convolve(_pair(_SLOW_SHARE * radps, 1.0, dt_s), _pair(radps, _NOTCH_DAMPING, dt_s))
        self.gains = _placed(step, seen, wanted)

    def differs(self, radps: float, dt_s: float) -> bool:
        """Whether it is worth while to tune anew."""
        return abs(radps / self.radps - 1.0) > _RETUNE_SHARE or abs(dt_s / self.dt_s - 1.0) > _RETUNE_SHARE


def _oscillator(radps: float, dt_s: float) -> Four:
    """Transition of (displacement, velocity) over a step, row by row."""
    damping = _OSCILLATION_DAMPING
    damped = radps * math.sqrt(1.0 - damping * damping)
    kept, c, s = math.exp(-damping * radps * dt_s), math.cos(damped * dt_s), math.sin(damped * dt_s)
    return (
        kept * (c + damping * radps / damped * s),
        kept * s / damped,
        -kept * radps * radps / damped * s,
        kept * (c - damping * radps / damped * s),
    )


def _pair(radps: float, damping: float, dt_s: float) -> Array:
    """Polynomial in z with the two poles of s² + 2 ζ ω s + ω²."""
    kept = math.exp(-2.0 * damping * radps * dt_s)
    middle = math.exp(-damping * radps * dt_s) * math.cos(radps * math.sqrt(1.0 - damping * damping) * dt_s)
    return np.array([1.0, -2.0 * middle, kept])


def _placed(step: Array, seen: Array, wanted: Array) -> Four:
    """Gains with which the error of the observer has that polynomial (Ackermann)."""
    observed, rows = np.zeros((4, 4)), seen
    for i in range(4):
        observed[i], rows = rows, rows @ step
    polynomial = np.zeros((4, 4))
    for coefficient in wanted:
        polynomial = polynomial @ step + coefficient * np.eye(4)
    gains = polynomial @ np.linalg.solve(observed, np.array([0.0, 0.0, 0.0, 1.0]))
    k1, k2, k3, k4 = (float(gain) for gain in gains)
    return k1, k2, k3, k4


class WaveObserver:
    """Motion and thrust → the boat's wave motion, None where there is none to take off. `update` every tick.

    It is taken off in full from an RMS velocity of 30 mm/s on, and not at all below 15 mm/s, which gusts alone make;
    where the waves' frequency is well above the bandwidth of the law; while the boat is slow, since the frequency that
    it meets changes with speed and course; and where thrust and wind do not explain the motion: a boat that pushes
    itself to and fro is no wave's. Each of these fades, so that no step reaches the thrusters. Remembers
    the spectrum, the observers, whether they know the wind, and the frequency that they are tuned to.
    """

    def __init__(self, hull: HullConfig, length_m: float) -> None:
        self._hull, self._half_m = hull, 0.5 * length_m
        self._begin()

    def _begin(self) -> None:
        self._spectrum = WaveSpectrum(3)
        self._splits: tuple[_Split, _Split, _Split] | None = None
        self._tuning: _Tuning | None = None
        self._tuned_s = self._last_s = -math.inf
        self._windy = False  # whether the known force has the wind in it

    def update(
        self,
        now_s: float,
        thrust: Wrench | None,
        motion: Motion,
        bandwidths_radps: tuple[float, float],
        water: tuple[float, float] = (0.0, 0.0),
        wind: Wrench | None = None,
    ) -> WaveMotion | None:
        """`thrust`: on the hull since the last call, None if unknown: then the observer begins anew.
        `bandwidths_radps`: of the positioning law, for place and yaw. `water`: velocity of the water (NED), 0 while it
        is unknown. `wind`: its force on the hull, None if unknown. What the thrust does against a gust would count for
        slow motion without it, and what the boat still does for waves."""
        dt_s, self._last_s = now_s - self._last_s, now_s
        if thrust is None or not 0.0 < dt_s <= _LONGEST_STEP_S:
            self._begin()
            self._last_s = now_s
            return None
        velocities = motion.velocity[0], motion.velocity[1], motion.rates[2]
        spectrum, force = self._spectrum, self._known(thrust, wind)
        known = self._accelerations(force, velocities[:2], water, motion.attitude[2])
        spectrum.update(velocities, (1.0, 1.0, self._half_m), dt_s, known)
        place, yaw = self._weights(motion, bandwidths_radps)
        if place <= 0.0 and yaw <= 0.0:
            self._splits = None
            return None
        tuning = self._tune(now_s, dt_s)
        splits = self._splits
        if splits is None or any(split.is_off(velocity) for split, velocity in zip(splits, velocities, strict=True)):
            x, y, n = known
            splits = self._splits = _Split(velocities[0], x), _Split(velocities[1], y), _Split(velocities[2], n)
        slow = splits[0].slow, splits[1].slow
        accelerations = self._accelerations(force, slow, water, motion.attitude[2])
        for split, velocity, acceleration in zip(splits, velocities, accelerations, strict=True):
            split.step(velocity, acceleration, dt_s, tuning)
        north, east, turn = splits
        return WaveMotion(
            spectrum.radps,
            place * north.displacement,
            place * east.displacement,
            yaw * turn.displacement,
            place * (velocities[0] - north.slow),
            place * (velocities[1] - east.slow),
            yaw * (velocities[2] - turn.slow),
        )

    def _known(self, thrust: Wrench, wind: Wrench | None) -> Wrench:
        """The known force on the hull. A wind that comes to be known, or is no longer, is a step in it: the observers
        begin anew."""
        if (wind is not None) != self._windy:
            self._splits, self._windy = None, wind is not None
        if wind is None:
            return thrust
        return Wrench(thrust.surge_n + wind.surge_n, thrust.sway_n + wind.sway_n, thrust.yaw_nm + wind.yaw_nm)

    def _weights(self, motion: Motion, bandwidths_radps: tuple[float, float]) -> tuple[float, float]:
        """Shares of the wave motion of place and yaw that are taken off."""
        spectrum = self._spectrum
        place = _between(math.hypot(spectrum.rms(0), spectrum.rms(1)), _CALM_MPS, _WAVES_MPS)
        yaw = _between(self._half_m * spectrum.rms(2), _CALM_MPS, _WAVES_MPS)
        if place <= 0.0 and yaw <= 0.0:
            return 0.0, 0.0
        slow, radps = math.hypot(spectrum.mean(0), spectrum.mean(1)), spectrum.radps
        if not radps < _MOST_RADPS:
            return 0.0, 0.0
        kept = 1.0 - _between(slow, _FULL_MPS, _UNDER_WAY_MPS)
        kept *= 1.0 - _between(spectrum.own_share, _OWN_LEAST, _OWN_MOST)
        first, second = (_between(radps / bandwidth, _RATIO_OFF, _RATIO_ON) for bandwidth in bandwidths_radps)
        return kept * place * first, kept * yaw * second

    def _tune(self, now_s: float, dt_s: float) -> _Tuning:
        radps, tuning = self._spectrum.radps, self._tuning
        if tuning is not None and now_s - self._tuned_s < _RETUNE_S:
            return tuning
        if tuning is None or tuning.differs(radps, dt_s):
            self._tuning, self._tuned_s = _Tuning(radps, dt_s), now_s
        return self._tuning or _Tuning(radps, dt_s)

    def _accelerations(
        self, force: Wrench, slow: tuple[float, float], water: tuple[float, float], yaw_rad: float
    ) -> tuple[float, float, float]:
        """By the known force, and by damping along the hull, which a boat that brakes loses fast, in NED; what else the
        hull meets counts as unknown forces. `slow`: its velocity."""
        hull = self._hull
        u, _ = ned_to_body(slow[0] - water[0], slow[1] - water[1], yaw_rad)
        surge_n = force.surge_n - hull.drag_n(u)
        north, east = body_to_ned(surge_n / hull.m11_kg, force.sway_n / hull.m22_kg, yaw_rad)
        return north, east, force.yaw_nm / hull.m33_kgm2


def _between(value: float, low: float, high: float) -> float:
    """0 up to `low`, 1 from `high` on, straight between."""
    return min(1.0, max(0.0, (value - low) / (high - low)))
