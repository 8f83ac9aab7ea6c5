"""Random streams from the seed: one for each source of noise, so that a further source does not change the others."""

from __future__ import annotations

import math
import random
from collections.abc import Iterator

from companion.core.angles import TWO_PI


def stream(seed: int, name: str) -> random.Random:
    """The random stream `name` of the run with this seed."""
    return random.Random(f"{seed}/{name}")


def normals(rng: random.Random) -> Iterator[float]:
    """Endless standard normal numbers (Box and Muller, 1958): as `rng.gauss`, at half its cost."""
    uniform = rng.random
    while True:
        angle = uniform() * TWO_PI
        radius = math.sqrt(-2.0 * math.log(1.0 - uniform()))
        yield math.cos(angle) * radius
        yield math.sin(angle) * radius


class GaussMarkov:
    """First-order Gauss–Markov (Ornstein–Uhlenbeck) process with zero mean, sampled exactly.

    `sigma`: of the stationary distribution, from which it starts; `tau_s`: time constant; `value`: now.
    """

    __slots__ = ("_decay", "_dt_s", "_kick", "_rng", "_sigma", "_tau_s", "value")

    def __init__(self, rng: random.Random, sigma: float, tau_s: float) -> None:
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
