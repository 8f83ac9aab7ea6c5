"""Which allocation a vessel has."""

from __future__ import annotations

from companion.allocation.allocator import Allocator
from companion.allocation.jet import JetAllocator
from companion.allocation.rudder import RudderAllocator
from companion.allocation.rudders import RuddersAllocator
from companion.allocation.sail import SailAllocator
from companion.config.vessel import VesselConfig
from companion.params.store import Parameters

AnyAllocator = Allocator | JetAllocator | RudderAllocator | RuddersAllocator | SailAllocator


def allocator_of(config: VesselConfig, parameters: Parameters) -> AnyAllocator:
    """The allocation of a vessel, by the kinds of its thrusters."""
    kind = config.thrusters[0].kind
    if config.has_sail:
        return SailAllocator(config, parameters)
    if kind == "jet":
        return JetAllocator(config, parameters)
    if config.has_rudder:
        return RudderAllocator(config, parameters)
    if any(thruster.kind == "rudder" for thruster in config.thrusters):
        return RuddersAllocator(config, parameters)
    return Allocator(config, parameters)
