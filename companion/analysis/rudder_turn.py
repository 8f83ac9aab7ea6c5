"""How far weather carries a boat with a rudder while it brings its bow up.

A rudder turns the boat only in flow, and the flow takes the boat along: there is no moment at rest to set against that
of the weather. So the turn is sailed, from rest beam on, by the controller's model of the hull, the boat's own
allocation, and the mean forces of the weather.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from companion.allocation.rudder import RudderAllocator
from companion.analysis.polar import strongest
from companion.config.vessel import VesselConfig
from companion.control.model import coriolis, damping
from companion.core.actuation import Wrench
from companion.core.angles import wrap_pi
from companion.params.store import Parameters
from companion.params.table import table_of

_DT_S, _MOST_S = 0.1, 60.0
_UP_RAD = math.radians(20.0)  # of the bow off the weather: it has come up
_MOST_LEEWAY_MPS, _HALVINGS = 5.0, 20

Weather = Callable[[float], Wrench]
"""The wrench that balances the weather from a direction clockwise from the bow."""


def room_m(config: VesselConfig, weather: Weather) -> float:
    """How far the boat gets from where it begins until its bow points up; infinite where it does not within a
    minute. For a boat whose thruster is a propeller with a rudder."""
    allocator = RudderAllocator(config, Parameters(config.parameters, table_of(config)))
    hull, turn = config.hull, Wrench(0.0, 0.0, -config.limits.yaw_nm)
    yaw_rad, u, v, r = 0.5 * math.pi, 0.0, _leeway_mps(config, weather), 0.0  # the weather comes from north
    north_m = east_m = farthest_m = 0.0
    for _ in range(round(_MOST_S / _DT_S)):
        push, against = allocator.update(turn, _DT_S, u).achieved, weather(wrap_pi(-yaw_rad))
        drag, turning = damping(hull, u, v, r), coriolis(hull, u, v, r)
        u += _DT_S * (push.surge_n - against.surge_n - drag[0] - turning[0]) / hull.m11_kg
        v += _DT_S * (push.sway_n - against.sway_n - drag[1] - turning[1]) / hull.m22_kg
        r += _DT_S * (push.yaw_nm - against.yaw_nm - drag[2] - turning[2]) / hull.m33_kgm2
        yaw_rad = wrap_pi(yaw_rad + _DT_S * r)
        north_m += _DT_S * (u * math.cos(yaw_rad) - v * math.sin(yaw_rad))
        east_m += _DT_S * (u * math.sin(yaw_rad) + v * math.cos(yaw_rad))
        farthest_m = max(farthest_m, math.hypot(north_m, east_m))
        if abs(yaw_rad) < _UP_RAD:
            return farthest_m
    return math.inf


def _leeway_mps(config: VesselConfig, weather: Weather) -> float:
    """The speed aside at which the water's drag meets the weather from abeam."""
    push_n = -weather(-0.5 * math.pi).sway_n
    return strongest(lambda mps: damping(config.hull, 0.0, mps, 0.0)[1] <= push_n, _MOST_LEEWAY_MPS, _HALVINGS)
