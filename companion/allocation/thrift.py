"""When turning a thruster round saves power: judged by what has long been demanded. With ALLOC_ECON a little is
enough, otherwise only so much that every boat should have it.

At a tenth of the thrust the solver has little to gain in one cycle by turning a thruster, and stays in the nearest
optimum: two pods may push against each other for minutes. The mean demand says where they belong.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.allocation.geometry import Thruster

_MEAN_S = 20.0
_NOTHING_SHARE = 0.003  # of full force: less is nothing to turn for
# Wasted power, as a share of that needed, for which a thruster turns round without thrust: with ALLOC_ECON, and
# without it, where it must be as much as this in full thrusters, too.
_WORTH_SHARE, _WORTH_ALWAYS_SHARE, _WORTH_ALWAYS = 0.08, 0.4, 0.01
_OFF_COS = math.cos(math.radians(40.0))  # of its direction from where its share of the mean demand points
_LULL = 1.5  # times the mean share: no more may be asked of a thruster as it begins to turn
_REST_S = 30.0  # the least time between two such turns of one thruster

Vector = tuple[float, float]


class Thrift:
    """`see` every cycle. Remembers each thruster's share of the last demand, the mean of that, of its force and of the
    power used and needed, and since when each thruster has not been turned round."""

    def __init__(self, thrusters: Sequence[Thruster]) -> None:
        self._thrusters = tuple(thrusters)
        self.reset()

    def reset(self) -> None:
        """Forget the means."""
        self.shares: list[Vector] = [(0.0, 0.0)] * len(self._thrusters)
        """(x, y) in N of each thruster in the unconstrained solution of the mean demand."""
        self._given: list[Vector] = [(0.0, 0.0)] * len(self._thrusters)
        self._asked: list[Vector] = [(0.0, 0.0)] * len(self._thrusters)
        self._used = self._needed = 0.0
        self._rested_s = [0.0] * len(self._thrusters)
        self._taken_s = 0.0

    def see(
        self, ideal: Sequence[Vector], forces_n: Sequence[float], azimuths_rad: Sequence[float], dt_s: float
    ) -> None:
        """One cycle: the unconstrained solution of its demand, and the forces and azimuths of the last."""
        self._taken_s += dt_s
        part = dt_s / min(_MEAN_S, self._taken_s) if dt_s > 0.0 else 0.0
        given = [(f * math.cos(a), f * math.sin(a)) for f, a in zip(forces_n, azimuths_rad, strict=True)]
        self.shares = [_nearer(mean, new, part) for mean, new in zip(self.shares, ideal, strict=True)]
        self._given = [_nearer(mean, new, part) for mean, new in zip(self._given, given, strict=True)]
        self._asked = list(ideal)
        self._used += part * (self._power(given) - self._used)
        self._needed += part * (self._power(ideal) - self._needed)
        self._rested_s = [s + dt_s for s in self._rested_s]

    def is_asked(self, i: int) -> bool:
        """Whether the mean demand has a share for thruster `i`."""
        return math.hypot(*self.shares[i]) > _NOTHING_SHARE * self._thrusters[i].max_n

    def pays(self, i: int, little: bool) -> bool:
        """Whether thruster `i` has long pushed so far off its share of the mean demand that a turn without thrust
        pays. `little`: a little saved power is enough. It waits for a lull: turned in a gust, a ship of 2.2 m lost its
        heading by 6°."""
        if self._rested_s[i] < _REST_S or self._taken_s < _MEAN_S or not self.is_asked(i):
            return False
        share, least = (_WORTH_SHARE, 0.0) if little else (_WORTH_ALWAYS_SHARE, _WORTH_ALWAYS)
        if self._used - self._needed < max(share * self._needed, least):
            return False
        (x, y), (gx, gy) = self.shares[i], self._given[i]
        if math.hypot(*self._asked[i]) > _LULL * math.hypot(x, y):
            return False
        return x * gx + y * gy < _OFF_COS * math.hypot(x, y) * math.hypot(gx, gy)

    def turned_round(self, i: int) -> None:
        """Thruster `i` begins to turn without thrust."""
        self._rested_s[i] = 0.0

    def _power(self, forces: Sequence[Vector]) -> float:
        """In full thrusters."""
        return sum(math.pow(math.hypot(x, y) / t.max_n, 1.5) for t, (x, y) in zip(self._thrusters, forces, strict=True))


def _nearer(mean: Vector, new: Vector, part: float) -> Vector:
    return mean[0] + part * (new[0] - mean[0]), mean[1] + part * (new[1] - mean[1])
