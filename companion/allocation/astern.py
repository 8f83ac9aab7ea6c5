"""With which thrust and speed a boat sails stern first."""

from __future__ import annotations

import math

from companion.config.dimensions.derivation import top_speed_mps
from companion.config.dimensions.limits import support_n
from companion.config.reversing import stern_first_refusal
from companion.config.vessel import VesselConfig

_BRAKING_SHARE = 0.4
STERN_FIRST_SHARE = 0.8
"""Of the top speed astern: the rest of the thrust is for wind and steering."""


def astern_n(config: VesselConfig) -> float:
    """The thrust astern, within the limit of surge. An azimuth thruster turns round as far as it can, others
    reverse."""
    return min(config.limits.surge_n, sum(support_n(thruster, -1.0, 0.0, 0.0) for thruster in config.thrusters))


def braking_mps2(config: VesselConfig) -> float:
    """The deceleration by which a stop is sure: a share of the thrust astern over the mass. The rest is for wind,
    current and what propellers lose. 0 without way astern."""
    return _BRAKING_SHARE * astern_n(config) / config.hull.m11_kg


def stern_first_mps(config: VesselConfig) -> float:
    """The highest speed through the water to sail stern first at: a share of that at full thrust astern, with the drag
    of the hull ahead. Infinite for a boat that cannot: it sails ahead."""
    if stern_first_refusal(config.thrusters) is not None:
        return math.inf
    return STERN_FIRST_SHARE * top_speed_mps(config.hull, astern_n(config))
