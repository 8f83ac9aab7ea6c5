"""The largest yaw moment beside the force ahead that is asked for.

`limits.yaw_nm` is that at rest. Between two fixed thrusters it is bounded by the one that pushes astern, where most
propellers are weaker; under way the other pushes harder, and the difference of both grows. So does the push of rudders
beside other thrusters, with the race of their propellers.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.config.blades import without_blades
from companion.config.devices import ThrusterConfig
from companion.config.dimensions.limits import figures, rudder_share, turning_nm
from companion.config.vessel import VesselConfig

_STEPS = 16  # of the table, up to the largest force ahead
_LESS = 0.5  # of a step, by which the force ahead is lowered
_BY_HAND = 0.01  # a limit of the file that differs so much from that of the thrusters is somebody's choice, and stays


class YawLimit:
    """`nm(surge_n)` → Nm. `most_nm`: the largest beside any force ahead. It never changes.

    It is `limits.yaw_nm` beside any force, except for a boat that only fixed thrusters turn, with rudders or without.
    """

    def __init__(self, config: VesselConfig) -> None:
        limits, thrusters = config.limits, config.thrusters
        self._least_nm, self._most_n = limits.yaw_nm, limits.surge_n
        self._table: list[float] = []
        self._strongest = 0  # place in the table of the largest moment
        if limits.sway_n > 0.0 or any(thruster.kind != "fixed" for thruster in without_blades(thrusters)):
            return
        at_rest_nm = figures(thrusters)[2].value
        if math.isclose(at_rest_nm, limits.yaw_nm, rel_tol=_BY_HAND):
            self._table = [_turning_nm(thrusters, self._most_n * i / _STEPS) for i in range(_STEPS + 1)]
            self._strongest = self._table.index(max(self._table))

    @property
    def most_nm(self) -> float:
        """The largest moment to either side."""
        return max(self._least_nm, self._table[self._strongest]) if self._table else self._least_nm

    def within(self, surge_n: float, yaw_nm: float) -> tuple[float, float]:
        """The force ahead and the moment that the boat can have at once: the moment within its limit, and the force
        less where that gives more of the moment. Without its heading the boat would lose its way too."""
        wanted_nm = abs(yaw_nm)
        if self._table and wanted_nm > self.nm(surge_n):
            i, step_n = self._strongest, self._most_n / _STEPS
            while surge_n > step_n * i:
                surge_n = max(step_n * i, surge_n - _LESS * step_n)
                if self.nm(surge_n) >= wanted_nm:
                    break
        most_nm = self.nm(surge_n)
        return surge_n, min(most_nm, max(-most_nm, yaw_nm))

    def nm(self, surge_n: float) -> float:
        """The largest moment to either side beside that force ahead."""
        if not self._table or surge_n <= 0.0:
            return self._least_nm
        place = min(float(_STEPS), _STEPS * surge_n / self._most_n)
        i = min(_STEPS - 1, int(place))
        low, high = self._table[i], self._table[i + 1]
        return max(self._least_nm, low + (place - i) * (high - low))


def _turning_nm(thrusters: Sequence[ThrusterConfig], surge_n: float) -> float:
    """Largest moment beside that force ahead, as the share of it that limits keep. Of two screws one can push ahead,
    for its rudder, while the other pushes astern."""
    rudders = [thruster for thruster in thrusters if thruster.kind == "rudder"]
    if len(rudders) != 1:
        return turning_nm(thrusters, surge_n)
    lever_m = 0.0 if (rudder := rudders[0].rudder) is None else abs(rudder.x_m)
    return turning_nm(without_blades(thrusters), surge_n) + lever_m * rudder_share(rudders[0]) * surge_n
