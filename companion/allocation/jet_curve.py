"""Thrust of a water jet as a function of throttle and speed, and its inverse: T = ρA V_j (V_j − w U), V_j = V₀ + V₁ u^p
(momentum theory)."""

from __future__ import annotations

import math

from companion.config.devices import ThrusterConfig


class JetCurve:
    """Curve of one jet. Throttle 0…1, thrust in newtons along the nozzle, speed ahead through the water in m/s.
    Remembers nothing.

    Inside the dead band the impeller stands and the thrust is 0. At its edge (`least`) the thrust begins with a step;
    it is negative if the boat is faster than the jet.
    """

    __slots__ = ("_density_area", "_exponent", "_idle_mps", "_intake", "_span_mps", "least", "most")

    def __init__(self, thruster: ThrusterConfig) -> None:
        """Raises ValueError for a thruster that is not a jet."""
        jet = thruster.jet
        if jet is None:
            raise ValueError(f"thruster {thruster.name} is not a jet")
        self._density_area, self._exponent, self._intake = jet.density_area_kgpm, jet.exponent, jet.intake_share
        self._idle_mps, self._span_mps = jet.idle_mps, jet.span_mps
        self.least = thruster.dead_band  # throttle at which the impeller begins to turn
        self.most = self._throttle_at(math.sqrt(thruster.max_n / self._density_area))

    def thrust_n(self, throttle: float, surge_mps: float) -> float:
        """The thrust of the jet in N; 0 while the impeller stands."""
        if throttle < self.least:
            return 0.0
        exit_mps = self._idle_mps + self._span_mps * math.pow(throttle, self._exponent)
        return self._density_area * exit_mps * (exit_mps - self._intake * max(0.0, surge_mps))

    def throttle(self, thrust_n: float, surge_mps: float) -> float:
        """The throttle that gives `thrust_n`, held within `least` and `most`: from the positive root for V_j."""
        half = 0.5 * self._intake * max(0.0, surge_mps)
        under_root = half * half + thrust_n / self._density_area
        if under_root <= 0.0:
            return self.least
        return self._throttle_at(half + math.sqrt(under_root), self.most)

    def _throttle_at(self, exit_mps: float, most: float = 1.0) -> float:
        share = (exit_mps - self._idle_mps) / self._span_mps
        return min(most, max(self.least, math.pow(share, 1.0 / self._exponent))) if share > 0.0 else self.least
