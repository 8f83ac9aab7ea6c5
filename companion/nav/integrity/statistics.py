"""Statistics that the hypotheses share: repeats, cumulative sums, the size of noise.

Sources: Page (1954) and Basseville & Nikiforov (1993), *Detection of abrupt changes*, chapters 2 and 5: the cumulative
sum (CUSUM).
"""

from __future__ import annotations

import math

FALSE_ALARM = 1e-9
"""Probability at which a run of repeats counts as impossible: at 100 Hz once in months, were that all there is."""

_LN_FALSE_ALARM = math.log(FALSE_ALARM)
_PRIOR_REPEATS, _PRIOR_SAMPLES = 1.2, 4.0  # as if 4 samples had been seen, of which 1.2 repeated
_SQRT_3 = math.sqrt(3.0)  # by which steps between independent positions differ more than they measure


class RepeatRun:
    """Values of one source → how improbable the present run of repeated values is, as the natural logarithm.

    A first-order Markov chain: after a new value the next repeats with one probability, after a repeat with another.
    Both are learnt from the runs that have ended, so a coarse or slow source is given its repeats. Remembers the last
    value, the counts, and since when the value is the same.
    """

    def __init__(self) -> None:
        self._value: object = None
        self._news = self._news_repeated = 0  # samples after a new value, and how many of them repeated
        self._repeats = self._repeats_repeated = 0
        self.run = 0
        self.since_s = math.inf

    def update(self, value: object, t_s: float) -> None:
        """Take one value."""
        if value == self._value:
            self.run += 1
            return
        if self.run:
            self._learn()
        elif self._value is not None:
            self._news += 1
        self._value, self.run, self.since_s = value, 0, t_s

    @staticmethod
    def update_each(runs: tuple[RepeatRun, ...], values: tuple[float, ...], t_s: float) -> None:
        """Take one value for each of several sources. Most are new after a new one, which needs no more than this."""
        for run, value in zip(runs, values, strict=True):
            if run.run or run._value is None or value == run._value:
                run.update(value, t_s)
            else:
                run._news += 1
                run._value, run.since_s = value, t_s

    def _learn(self) -> None:
        """From a run of repeats that has ended."""
        if self.doubt >= 1.0:
            return  # it was a fault: it teaches nothing about the source
        self._news += 1
        self._news_repeated += 1
        self._repeats += self.run
        self._repeats_repeated += self.run - 1

    @property
    def doubt(self) -> float:
        """The logarithm of the run's probability over that of a false alarm: from 1 on it is impossible."""
        if not self.run:
            return 0.0
        first = (self._news_repeated + _PRIOR_REPEATS) / (self._news + _PRIOR_SAMPLES)
        further = (self._repeats_repeated + _PRIOR_REPEATS) / (self._repeats + _PRIOR_SAMPLES)
        return (math.log(first) + (self.run - 1) * math.log(further)) / _LN_FALSE_ALARM


class Resolution:
    """Values of one axis → the smallest step between two that differ. Remembers it."""

    def __init__(self) -> None:
        self._last = math.nan
        self.step = math.inf

    def update(self, value: float) -> None:
        """Take one value."""
        last, self._last = self._last, value
        if not math.isnan(last) and value != last:
            self.step = min(self.step, abs(value - last))


class NoiseSize:
    """Magnitudes of differences → their usual size, an average in which one outlier counts little. Remembers it."""

    def __init__(self, samples: int = 200, most: float = 4.0) -> None:
        """`samples` of the average; `most`: a difference counts with at most this many times the present size."""
        self._share = 1.0 / samples
        self._most = most
        self._count = 0
        self.size = 0.0

    def update(self, magnitude: float) -> None:
        """Take one magnitude."""
        self._count += 1
        share = max(self._share, 1.0 / self._count)
        bounded = magnitude if self._count < 10 else min(magnitude, self._most * self.size + 1e-12)
        self.size += share * (bounded - self.size)


class Median3:
    """Steps of a value → steps of the median of its last three: an outlier alone does not show, a slope comes one
    sample late. Remembers the three."""

    def __init__(self) -> None:
        self._oldest = self._middle = self._newest = 0.0

    @property
    def newest_off(self) -> float:
        """The newest of the three less their median."""
        return self._newest - sorted((self._oldest, self._middle, self._newest))[1]

    def step(self, step: float) -> float:
        """Take one step."""
        before = sorted((self._oldest, self._middle, self._newest))[1]
        self._oldest, self._middle, self._newest = self._middle, self._newest, self._newest + step
        return sorted((self._oldest, self._middle, self._newest))[1] - before


class StepNoise:
    """Steps on two axes → the usual size of their noise, whatever they have in common. The noise of the last moments
    counts where it is larger: a source that has just become noisy does not yet lie. Remembers both sizes, and the last
    step."""

    def __init__(self) -> None:
        self._usual = NoiseSize()
        self._now = NoiseSize(8, 100.0)
        self._last: tuple[float, float] | None = None

    @property
    def size(self) -> float:
        """Mean length of the noise of a step."""
        return max(self._usual.size, self._now.size)

    def update(self, north: float, east: float) -> None:
        """Take one step."""
        last, self._last = self._last, (north, east)
        self._usual.update(math.hypot(north, east))
        if last is not None:
            self._now.update(math.hypot(north - last[0], east - last[1]) / _SQRT_3)


class VectorCusum:
    """Increments on two axes → four one-sided cumulative sums, ±north and ±east. Remembers them and when each was last
    0."""

    def __init__(self) -> None:
        self._sums = [0.0, 0.0, 0.0, 0.0]
        self._zero_s = [0.0, 0.0, 0.0, 0.0]

    def clear(self, t_s: float) -> None:
        """Start again."""
        self._sums = [0.0, 0.0, 0.0, 0.0]
        self._zero_s = [t_s, t_s, t_s, t_s]

    def update(self, t_s: float, north: float, east: float, slack: float) -> None:
        """Take one increment. `slack`: what each sum falls by."""
        sums, zero_s = self._sums, self._zero_s
        for i, step in enumerate((north, -north, east, -east)):
            value = sums[i] + step - slack
            if value <= 0.0:
                value, zero_s[i] = 0.0, t_s
            sums[i] = value

    @property
    def largest(self) -> float:
        """The largest of the sums."""
        return max(self._sums)

    @property
    def onset_s(self) -> float:
        """When the largest sum was last 0: an estimate of when the change began."""
        return self._zero_s[self._sums.index(max(self._sums))]


class ScalarCusum:
    """Increments → two one-sided cumulative sums. Remembers them and when each was last 0."""

    def __init__(self) -> None:
        self._up = self._down = 0.0
        self._up_s = self._down_s = 0.0

    def clear(self, t_s: float) -> None:
        """Start again."""
        self._up = self._down = 0.0
        self._up_s = self._down_s = t_s

    def update(self, t_s: float, step: float, slack: float) -> None:
        """Take one increment. `slack`: what both sums fall by."""
        self._up += step - slack
        self._down += -step - slack
        if self._up <= 0.0:
            self._up, self._up_s = 0.0, t_s
        if self._down <= 0.0:
            self._down, self._down_s = 0.0, t_s

    @property
    def largest(self) -> float:
        """The larger of the sums."""
        return max(self._up, self._down)

    @property
    def onset_s(self) -> float:
        """When the larger sum was last 0."""
        return self._up_s if self._up >= self._down else self._down_s
