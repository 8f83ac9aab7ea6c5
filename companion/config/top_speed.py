"""Top speed of a vessel, by its own file."""

from __future__ import annotations

from companion.config.dimensions import derivation
from companion.config.vessel import VesselConfig


def top_speed_mps(config: VesselConfig) -> float:
    """Top speed through calm water at full surge thrust, by the hull model; infinite for a model without damping. For a
    hull with a hump of resistance, the speed beyond the hump."""
    return derivation.top_speed_mps(config.hull, config.limits.surge_n)
