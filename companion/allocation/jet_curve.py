"""Thrust of a water jet against throttle and speed, and back: T = ρA V_j (V_j − w U), V_j = V₀ + V₁ u^p (momentum theory)."""

from __future__ import annotations

import math

from companion.config import ThrusterConfig


class JetCurve:
    """Curve of one jet. Throttle 0…1, thrust in newtons along the nozzle, speed ahead through the water in m/s. Remembers nothing.

    Below the dead band the impeller stands and nothing is given; above it the thrust begins at that of the dead band, which is negative where the
    boat is faster than the jet.
    """

    __slots__ = ("_density_area", "_exponent", "_idle_mps", "_intake", "_span_mps", "least", "most")

    def __init__(self, thruster: ThrusterConfig) -> None:
        """Raises ValueError for a thruster that is no jet."""
        jet = thruster.jet
        if jet is None:
            raise ValueError(f"thruster {thruster.name} has no jet")
        self._density_area, self._exponent, self._intake = jet.density_area_kgpm, jet.exponent, jet.intake_share
        self._idle_mps, self._span_mps = jet.idle_mps, jet.span_mps
        self.least = thruster.dead_band  # throttle at which the impeller begins to turn
        self.most = self._throttle_at(math.sqrt(thruster.max_n / self._density_area))

    def thrust_n(self, throttle: float, surge_mps: float) -> float:
        """What the jet gives; 0 while the impeller stands."""
        if throttle < self.least:
            return 0.0
        exit_mps = self._idle_mps + self._span_mps * math.pow(throttle, self._exponent)
        return self._density_area * exit_mps * (exit_mps - self._intake * max(0.0, surge_mps))

    def throttle(self, thrust_n: float, surge_mps: float) -> float:
        """The throttle that gives `thrust_n`, held to where the impeller turns and the most that is allowed: the positive root of V_j."""
        half = 0.5 * self._intake * max(0.0, surge_mps)
        under_root = half * half + thrust_n / self._density_area
        if under_root <= 0.0:
            return self.least
        return self._throttle_at(half + math.sqrt(under_root), self.most)

    def _throttle_at(self, exit_mps: float, most: float = 1.0) -> float:
        share = (exit_mps - self._idle_mps) / self._span_mps
        return min(most, max(self.least, math.pow(share, 1.0 / self._exponent))) if share > 0.0 else self.least
