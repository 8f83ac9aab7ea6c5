"""A water jet: an impeller that takes time to change speed, and a nozzle that turns at its rate."""

from __future__ import annotations

import math

from companion.config.devices import JetConfig, NozzleConfig, ThrusterConfig
from sitl.thrusters import ThrusterModel

_RUNAWAY_THROTTLE = 0.5


class Jet(ThrusterModel):
    """As `ThrusterModel`, for a jet, with the speed ahead through the water as further input. `force_n` is along the
    nozzle.

    The exit speed V_j follows the throttle with a first-order lag, down to 0 while the impeller stands (in the dead
    band, or without a command). Force = mass flow times change of speed: ρA V_j (V_j − w U). It brakes where the boat
    is faster than the jet. The nozzle turns this net force: at speed too little aside (docs/inside/results-notes.md).
    """

    __slots__ = ("_exit_mps", "_jet", "_most_mps", "_nozzle", "_target_mps")

    def __init__(
        self,
        config: ThrusterConfig,
        lag_s: float,
        jet: JetConfig,
        x_m: float | None = None,
        nozzle: NozzleConfig | None = None,
    ) -> None:
        """`jet`, `nozzle`: what they really do, whatever the vessel's file says. Without `nozzle` it turns at the
        file's rate, without lag."""
        super().__init__(config, lag_s, x_m)
        self._jet = jet
        self._nozzle = nozzle or NozzleConfig(config.azimuth_rate_radps)
        self._exit_mps = self._target_mps = 0.0
        self._most_mps = math.sqrt(config.max_n / jet.density_area_kgpm)

    def drive(self, throttle: float) -> None:
        """Set the throttle, 0 to 1."""
        self.asked = throttle
        self._target_mps = self._exit_for(throttle)

    def step(self, dt_s: float, surge_mps: float = 0.0, sway_mps: float = 0.0, yaw_rate_radps: float = 0.0) -> None:
        """Advance by `dt_s` at the speed `surge_mps` ahead through the water."""
        target_mps = self._target_mps if not self.runaway else self._exit_for(_RUNAWAY_THROTTLE)
        if self.dead or self.stalled:
            target_mps = 0.0
        self._exit_mps += (target_mps - self._exit_mps) * (
            -math.expm1(-dt_s / self._lag_s) if self._lag_s > 0.0 else 1.0
        )
        jet = self._jet
        self.force_n = (
            jet.density_area_kgpm * self._exit_mps * (self._exit_mps - jet.intake_share * max(0.0, surge_mps))
        )
        if not (self.dead or self.stuck):
            self._turn(dt_s)

    def throttle(self) -> float:
        """The throttle that gives the impeller's present speed; 0 below idling."""
        share = (self._exit_mps - self._jet.idle_mps) / self._jet.span_mps
        return min(1.0, math.pow(share, 1.0 / self._jet.exponent)) if share > 0.0 else 0.0

    def _turn(self, dt_s: float) -> None:
        self._turn_with_lag(self._nozzle, dt_s)

    def _exit_for(self, throttle: float) -> float:
        if throttle < self._config.dead_band:
            return 0.0
        return min(
            self._most_mps, self._jet.idle_mps + self._jet.span_mps * math.pow(min(1.0, throttle), self._jet.exponent)
        )
