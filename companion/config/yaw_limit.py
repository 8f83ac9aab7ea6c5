"""The largest yaw moment beside the force ahead that is asked for.

`limits.yaw_nm` is that at rest. Between two fixed thrusters it is bounded by the one that pushes astern, where most
propellers are weaker; under way the other pushes harder, and the difference of both grows. So does the push of rudders
beside other thrusters, with the race of their propellers and with the boat's speed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.config.blades import steered_by_rudder, without_blades
from companion.config.devices import ThrusterConfig
from companion.config.dimensions.form import WATER_KGPM3
from companion.config.dimensions.limits import SHARE, figures, rudder_share, turning_nm
from companion.config.rudder import RudderConfig
from companion.config.vessel import VesselConfig

_STEPS = 16  # of the table, up to the largest force ahead
_LESS = 0.5  # of a step, by which the force ahead is lowered
_BY_HAND = 0.01  # a limit of the file that differs so much from that of the thrusters is somebody's choice, and stays


class _Flow:
    """What a rudder gives more of the moment in the flow of the boat's speed than at rest."""

    def __init__(self, thruster: ThrusterConfig, rudder: RudderConfig, propeller_m: float) -> None:
        stop_rad = min(abs(thruster.azimuth_min_rad or 0.0), abs(thruster.azimuth_max_rad or 0.0))
        self._rudder, self._disc = rudder, 0.5 * WATER_KGPM3 * 0.25 * math.pi * propeller_m * propeller_m
        pressure = 0.5 * WATER_KGPM3 * rudder.area_m2 * rudder.lift_scale
        self._nm = SHARE * abs(rudder.x_m) * pressure * rudder.lift(stop_rad)

    def more_nm(self, thrust_n: float, surge_mps: float) -> float:
        """Beside that thrust, at that speed ahead through the water."""
        rudder, disc = self._rudder, self._disc
        return self._nm * max(0.0, rudder.inflow(thrust_n, surge_mps, disc) - rudder.inflow(thrust_n, 0.0, disc))


class YawLimit:
    """`nm(surge_n, surge_mps)` → Nm. `most_nm`: the largest beside any force ahead, at rest. It never changes.

    It is `limits.yaw_nm` beside any force, except for a boat that only fixed thrusters turn, with rudders or without,
    and except for the speed of a boat with rudders beside other thrusters. `aside_nm`: what thrusters give more of it
    that push the boat aside with it, as one in the bow does; 0 for a boat without sideways thrust.
    """

    def __init__(self, config: VesselConfig) -> None:
        limits, thrusters = config.limits, config.thrusters
        self._least_nm, self._most_n = limits.yaw_nm, limits.surge_n
        self._table: list[float] = []
        self._strongest = 0  # place in the table of the largest moment
        self._flows: list[_Flow] = []
        self.aside_nm = 0.0
        self._by_race = limits.sway_n <= 0.0  # a boat that pushes itself sideways pushes each screw to and fro
        with_rudders = not steered_by_rudder(thrusters) and any(thruster.kind == "rudder" for thruster in thrusters)
        by_force = self._by_race and all(thruster.kind == "fixed" for thruster in without_blades(thrusters))
        if self._by_race and not (with_rudders or by_force):
            return
        if not math.isclose(figures(thrusters)[2].value, limits.yaw_nm, rel_tol=_BY_HAND):
            return
        if not self._by_race:
            self.aside_nm = max(0.0, turning_nm(without_blades(thrusters), 0.0) - limits.yaw_nm)
        if with_rudders:
            self._flows = [
                _Flow(thruster, thruster.rudder, thruster.propeller_m)
                for thruster in thrusters
                if thruster.kind == "rudder" and thruster.rudder is not None and thruster.propeller_m is not None
            ]
        if by_force:
            self._table = [_turning_nm(thrusters, self._most_n * i / _STEPS) for i in range(_STEPS + 1)]
            self._strongest = self._table.index(max(self._table))

    @property
    def most_nm(self) -> float:
        """The largest moment to either side."""
        return max(self._least_nm, self._table[self._strongest]) if self._table else self._least_nm

    @property
    def by_speed(self) -> bool:
        """Whether the boat's speed counts."""
        return bool(self._flows)

    def within(self, surge_n: float, yaw_nm: float, surge_mps: float = 0.0, aside: bool = False) -> tuple[float, float]:
        """The force ahead and the moment that the boat can have at once: the moment within its limit, and the force
        less where that gives more of the moment. Without its heading the boat would lose its way too. `surge_mps`:
        speed ahead through the water; `aside`: the heading counts before the force sideways."""
        wanted_nm = abs(yaw_nm)
        if self._table and wanted_nm > self.nm(surge_n, surge_mps):
            i, step_n = self._strongest, self._most_n / _STEPS
            while surge_n > step_n * i:
                surge_n = max(step_n * i, surge_n - _LESS * step_n)
                if self.nm(surge_n, surge_mps) >= wanted_nm:
                    break
        most_nm = self.nm(surge_n, surge_mps) + (self.aside_nm if aside else 0.0)
        return surge_n, min(most_nm, max(-most_nm, yaw_nm))

    def nm(self, surge_n: float, surge_mps: float = 0.0) -> float:
        """The largest moment to either side beside that force ahead, at that speed ahead through the water."""
        return self._at_rest_nm(surge_n) + (self._by_speed_nm(surge_n, surge_mps) if surge_mps > 0.0 else 0.0)

    def _at_rest_nm(self, surge_n: float) -> float:
        if not self._table or surge_n <= 0.0:
            return self._least_nm
        place = min(float(_STEPS), _STEPS * surge_n / self._most_n)
        i = min(_STEPS - 1, int(place))
        low, high = self._table[i], self._table[i + 1]
        return max(self._least_nm, low + (place - i) * (high - low))

    def _by_speed_nm(self, surge_n: float, surge_mps: float) -> float:
        thrust_n = surge_n / max(1, len(self._flows)) if self._by_race or surge_n < 0.0 else 0.0
        return math.fsum(flow.more_nm(thrust_n, surge_mps) for flow in self._flows)


def _turning_nm(thrusters: Sequence[ThrusterConfig], surge_n: float) -> float:
    """Largest moment beside that force ahead, as the share of it that limits keep. Of two screws one can push ahead,
    for its rudder, while the other pushes astern."""
    rudders = [thruster for thruster in thrusters if thruster.kind == "rudder"]
    if len(rudders) != 1:
        return turning_nm(thrusters, surge_n)
    lever_m = 0.0 if (rudder := rudders[0].rudder) is None else abs(rudder.x_m)
    return turning_nm(without_blades(thrusters), surge_n) + lever_m * rudder_share(rudders[0]) * surge_n
