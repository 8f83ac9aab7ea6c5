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

    def gauss(self, mean: float, sigma: float) -> float:
        """The next number, of that mean and standard deviation."""
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
