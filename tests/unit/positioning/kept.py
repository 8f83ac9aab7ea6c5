"""A boat that its keeper holds, with its real controller, allocation and thrusters, and a perfect estimate."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from companion.allocation.allocator import Allocator
from companion.config.vessel import VesselConfig
from companion.control.controller import Controller
from companion.core.actuation import ZERO_WRENCH
from companion.core.estimate import NavState
from companion.params.store import Parameters
from companion.params.table import table_of
from companion.positioning.bow_keeper import BowKeeper
from sitl.hull import Hull
from sitl.thrusters import build


def moving(nav: NavState, hull: Hull) -> NavState:
    """The state with place and motion of the hull."""
    return replace(
        nav,
        north_m=hull.north_m,
        east_m=hull.east_m,
        yaw_rad=hull.yaw_rad,
        surge_mps=hull.surge_mps,
        sway_mps=hull.sway_mps,
        north_mps=hull.north_mps,
        east_mps=hull.east_mps,
        yaw_rate_radps=hull.yaw_rate_radps,
    )


def kept(
    config: VesselConfig,
    keeper: BowKeeper,
    nav_at: Callable[[float], NavState],
    hull: Hull,
    step: Callable[[float, float, float, float], None],
    lag_s: float,
    duration_s: float,
) -> list[tuple[float, float]]:
    """(distance from the point, heading) each tenth of a second. `nav_at(t_s)`: the estimate; `step(surge_n, sway_n,
    yaw_nm, dt_s)`: moves the hull; `lag_s`: of the thrusters."""
    values = Parameters(config.parameters, table_of(config))
    control, allocator, thrusters = (
        Controller(config, values),
        Allocator(config, values),
        build(config.thrusters, lag_s, None),
    )
    achieved, track = ZERO_WRENCH, []
    for i in range(round(duration_s * 10.0)):
        nav = nav_at(0.1 * i)
        allocation = allocator.update(control.update(keeper.update(nav, None, 1.0, 0.1), nav, achieved, 0.1), 0.1)
        achieved = allocation.achieved
        for thruster, command in zip(thrusters, allocation.thrusters, strict=True):
            thruster.demand(command.throttle, command.azimuth_rad)
        for _ in range(5):
            for thruster in thrusters:
                thruster.step(0.02)
            surge_n, sway_n, yaw_nm = (sum(axis) for axis in zip(*[t.wrench() for t in thrusters], strict=True))
            step(surge_n, sway_n, yaw_nm, 0.02)
        track.append((math.hypot(hull.north_m, hull.east_m), hull.yaw_rad))
    return track
