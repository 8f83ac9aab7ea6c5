"""What a boat does until its jet's nozzle has come back: one that turns slowly goes on turning the boat meanwhile."""

from __future__ import annotations

from dataclasses import dataclass

from companion.config.vessel import VesselConfig
from companion.core.actuation import ZERO_WRENCH

_LAG_S = 0.3  # from a command to the nozzle's motion
_LEAST_SHARE = 0.05  # of the surge limit: with less thrust than that no nozzle steers


@dataclass(frozen=True, slots=True)
class Foreseen:
    """After `time_s`: by how much the bow will have turned beyond its present rate, and the rate grown."""

    time_s: float
    turned_rad: float
    grown_radps: float


class SlowNozzle:
    """`pushed`: what the thrusters gave in the last cycle; set it each cycle. `rate_radps`: how fast the nozzle turns.
    Remembers both."""

    def __init__(self, config: VesselConfig, stop_rad: float) -> None:
        self._lever_m, self._stop_rad = abs(config.thrusters[0].x_m), stop_rad
        self._least_n = _LEAST_SHARE * config.limits.surge_n
        self._inertia_kgm2 = config.hull.m33_kgm2
        self.rate_radps = config.thrusters[0].azimuth_rate_radps
        self.pushed = ZERO_WRENCH

    def foreseen(self, held_nm: float, resisting_nms: float) -> Foreseen:
        """Until the nozzle gives `held_nm`, the moment of the turn that is asked for. The surplus falls evenly, since
        the nozzle turns at its rate: ∫ is half of it, ∫∫ a third. `resisting_nms`: the hull's damping in yaw."""
        surplus_nm = self.pushed.yaw_nm - held_nm
        slew_nmps = self._lever_m * max(self._least_n, self.pushed.surge_n) * self.rate_radps
        time_s = min(2.0 * self._stop_rad / self.rate_radps, abs(surplus_nm) / slew_nmps) + _LAG_S
        gain_1ps2 = surplus_nm / (self._inertia_kgm2 + 0.5 * resisting_nms * time_s)
        return Foreseen(time_s, gain_1ps2 * time_s * time_s / 3.0, 0.5 * gain_1ps2 * time_s)
