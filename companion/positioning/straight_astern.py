"""Going astern without steering: a rudder or a nozzle steers by thrust ahead, which drives the boat the other way."""

from __future__ import annotations

from companion.config.hull import HullConfig
from companion.core.actuation import Wrench
from companion.core.estimate import NavState
from companion.core.setpoint import Progress, WrenchSetpoint
from companion.params.store import Parameters


def straight_astern(
    hull: HullConfig, parameters: Parameters, nav: NavState, astern_mps: float, progress: Progress
) -> WrenchSetpoint:
    """The force along the hull that brings the boat to `astern_mps` astern, by the law of speed under way, and no
    moment."""
    gain = hull.m11_kg * parameters["PATH_BW_SURGE"]
    astern_n = -gain * (astern_mps + nav.surge_mps) - hull.drag_n(astern_mps)
    return WrenchSetpoint(Wrench(astern_n, 0.0, 0.0), progress)
