"""How fast a vessel can go, by its own file."""

from __future__ import annotations

from companion.config.dimensions import derivation, steady_course
from companion.config.vessel import VesselConfig


def top_speed_mps(config: VesselConfig) -> float:
    """Top speed through calm water at full surge thrust, by the hull model; infinite for a model without damping. For a
    hull with a hump of resistance, the speed beyond the hump."""
    return derivation.top_speed_mps(config.hull, config.limits.surge_n)


def steady_speed_mps(config: VesselConfig) -> float:
    """The speed beyond which the hull leaves its course faster than the thrusters can turn it back; infinite where it
    never does."""
    return steady_course.steady_mps(config.hull, config.thrusters, config.limits.yaw_nm, top_speed_mps(config))
