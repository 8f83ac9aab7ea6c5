"""Random streams from the seed: one for each source of noise, so that a further source does not change the others."""

from __future__ import annotations

import math
import random

from companion.core.angles import TWO_PI


def stream(seed: int, name: str) -> random.Random:
    """The random stream `name` of the run with this seed."""
    return random.Random(f"{seed}/{name}")


class Normals:
    """Normal numbers from a random stream (Box and Muller, 1958): the same as its `gauss` gives, at less cost. Whoever
    shares the stream shares this. Remembers the second number of a pair."""

    __slots__ = ("_second", "_uniform", "_waits")

    def __init__(self, rng: random.Random) -> None:
        self._uniform = rng.random
        self._second = 0.0
        self._waits = False

    def next(self) -> float:
        """The next standard normal number."""
        if self._waits:
            self._waits = False
            return self._second
        angle = self._uniform() * TWO_PI
        radius = math.sqrt(-2.0 * math.log(1.0 - self._uniform()))
        self._second, self._waits = math.sin(angle) * radius, True
        return math.cos(angle) * radius

    def pair(self) -> tuple[float, float]:
        """The next two."""
        angle = self._uniform() * TWO_PI
        radius = math.sqrt(-2.0 * math.log(1.0 - self._uniform()))
        if not self._waits:
            return math.cos(angle) * radius, math.sin(angle) * radius
        first, self._second = self._second, math.sin(angle) * radius
        return first, math.cos(angle) * radius

    def gauss(self, mean: float, sigma: float) -> float:
        """The next number, of that mean and standard deviation."""
        if self._waits:
            self._waits = False
            return mean + self._second * sigma
        return mean + self.next() * sigma


class GaussMarkov:
    """First-order Gauss–Markov (Ornstein–Uhlenbeck) process with zero mean, sampled exactly.

    `sigma`: of the stationary distribution, from which it starts; `tau_s`: time constant; `value`: now.
    """

    __slots__ = ("_decay", "_dt_s", "_kick", "_rng", "_sigma", "_tau_s", "value")

    def __init__(self, rng: Normals, sigma: float, tau_s: float) -> None:
        self._rng, self._sigma, self._tau_s = rng, sigma, tau_s
        self._dt_s = self._decay = self._kick = 0.0
        self.value = rng.gauss(0.0, sigma) if sigma > 0.0 else 0.0

    def update(self, dt_s: float) -> float:
        """Advance by `dt_s`; returns the new value."""
        if dt_s != self._dt_s:
            self._dt_s = dt_s
            self._decay = math.exp(-dt_s / self._tau_s)
            self._kick = self._sigma * math.sqrt(1.0 - self._decay * self._decay)
        if self._sigma > 0.0:
            self.value = self._decay * self.value + self._rng.gauss(0.0, self._kick)
        return self.value


class Bridge:
    """A first-order Gauss–Markov process between values of it that are given, at times much closer to each other than
    its time constant: a Brownian bridge from each to the next.

    `sigma`, `tau_s`: as of the process; `value`: now. Remembers the next given value, and when it is reached.
    """

    __slots__ = ("_density", "_left_s", "_next", "_rng", "value")

    def __init__(self, rng: Normals, sigma: float, tau_s: float, value: float) -> None:
        self._rng, self._density = rng, 2.0 * sigma * sigma / tau_s
        self.value = self._next = value
        self._left_s = 0.0

    def lead_to(self, value: float, in_s: float) -> None:
        """Reach that value in that time."""
        self._next, self._left_s = value, in_s

    def update(self, dt_s: float) -> float:
        """Advance by `dt_s`; returns the new value."""
        share = min(dt_s / self._left_s, 1.0) if self._left_s > 0.0 else 1.0
        mean = self.value + share * (self._next - self.value)
        self.value = self._rng.gauss(mean, math.sqrt(self._density * dt_s * (1.0 - share)))
        self._left_s -= dt_s
        return self.value
