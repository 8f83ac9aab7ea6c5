"""When a thruster that has long pushed astern turns round, to push ahead where it is stronger.

The solver chooses the direction of a thruster while little is demanded, and then astern is as good as ahead. In a
rising wind the thruster would stay there: the way round leads through azimuths that give less of what is demanded.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.allocation.geometry import Thruster

_MEAN_S, _LONG_S = 5.0, 20.0
_WORTH = 1.15  # force ahead over force astern
_HARD_SHARE = 0.4  # of full force astern, in the mean
_LULL_SHARE = 1.05  # of the mean force: up to it the thruster turns
_AT_END_SHARE = 0.9  # likewise: such a thruster has nothing left, and waits for no lull
_OFF_RAD = math.radians(20.0)  # from the opposite azimuth: further off, nothing is gained


class StrongSide:
    """`see` every cycle. Remembers each thruster's mean force, over a short time and over a long one: a way back to the
    point, which asks for much, is over before a turn would pay."""

    def __init__(self, thrusters: Sequence[Thruster]) -> None:
        self._stronger = [t.turns and t.max_n > _WORTH * -t.min_n > 0.0 for t in thrusters]
        self._mean_n = [0.0] * len(self._stronger)
        self._long_n = [0.0] * len(self._stronger)

    def see(self, forces_n: Sequence[float], dt_s: float) -> None:
        """The forces of the last cycle."""
        if dt_s <= 0.0:
            return
        short, long = dt_s / (dt_s + _MEAN_S), dt_s / (dt_s + _LONG_S)
        self._mean_n = [mean + short * (force - mean) for mean, force in zip(self._mean_n, forces_n, strict=True)]
        self._long_n = [mean + long * (force - mean) for mean, force in zip(self._long_n, forces_n, strict=True)]

    def way_round_rad(self, i: int, t: Thruster, force_n: float, azimuth_rad: float) -> float | None:
        """The azimuth at which thruster `i` pushes ahead in the direction of its force; None where it should not turn
        now. It waits until no more is asked than usual, unless it has nothing left."""
        mean_n = self._mean_n[i]
        if not self._stronger[i]:
            return None
        has_left = mean_n > _AT_END_SHARE * t.min_n
        if has_left and (self._long_n[i] > _HARD_SHARE * t.min_n or force_n < _LULL_SHARE * mean_n):
            return None
        low_rad, high_rad = t.sectors.span(azimuth_rad)
        opposite = (
            azimuth_rad - math.copysign(math.pi, azimuth_rad),
            azimuth_rad + math.copysign(math.pi, azimuth_rad),
        )
        for wanted_rad in opposite:
            target_rad = min(high_rad, max(low_rad, wanted_rad))
            if abs(target_rad - wanted_rad) < _OFF_RAD:
                return target_rad
        return None

    def turned(self, i: int) -> None:
        """Thruster `i` begins to turn round."""
        self._mean_n[i] = self._long_n[i] = 0.0
