"""Capability polar: the strongest wind that a boat can hold against from each side, with all thrusters and without the
one that it misses most.

The force of the wind is that of the vessel's windage, in full; the present current pushes too. Whether the thrusters
can give the wrench against both is asked of the boat's own consequence check (`positioning/consequence.py`): steady
thrust, without a reserve for gusts and waves.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection
from dataclasses import dataclass

from companion.allocation.geometry import thrusters_of
from companion.config.hull import AIR_KGPM3
from companion.config.vessel import VesselConfig
from companion.control.model import coriolis, damping
from companion.core.actuation import Wrench
from companion.positioning.consequence import is_met

MOST_MPS = 32.0  # a wind that is not looked beyond
_STEPS = 7  # of halving: to 0.25 m/s


@dataclass(frozen=True, slots=True)
class Polar:
    """The strongest wind in m/s from each of the directions `from_rad`, clockwise from the bow: `holds_mps` with the
    thrusters that work, `worst_mps` with one less, and in `missed` its name. None: it does not even hold against the
    current."""

    from_rad: tuple[float, ...]
    holds_mps: tuple[float | None, ...]
    worst_mps: tuple[float | None, ...]
    missed: tuple[str, ...]


def polar(
    config: VesselConfig,
    current_mps: tuple[float, float] = (0.0, 0.0),
    out: Collection[int] = (),
    directions: int = 36,
) -> Polar | None:
    """The polar of a vessel. `current_mps`: velocity of the water over ground in body axes; `out`: indices of thrusters
    that do not work. None for a boat without sideways thrust or without windage: it has none."""
    if config.limits.sway_n <= 0.0 or config.windage.lateral_m2 <= 0.0:
        return None
    gone = frozenset(out)
    left = [i for i in range(len(config.thrusters)) if i not in gone]
    angles = tuple(math.tau * n / directions for n in range(directions))
    holds = [_strongest(config, angle, current_mps, gone, MOST_MPS) for angle in angles]
    worst: list[float | None] = []
    missed: list[str] = []
    for angle, most in zip(angles, holds, strict=True):
        found = [(_strongest(config, angle, current_mps, gone | {i}, most or 0.0), i) for i in left]
        least, i = min(found, key=lambda pair: -1.0 if pair[0] is None else pair[0], default=(most, -1))
        worst.append(least)
        missed.append(config.thrusters[i].name if i >= 0 else "")
    return Polar(angles, tuple(holds), tuple(worst), tuple(missed))


def wrench_against(
    config: VesselConfig, wind_mps: float, from_rad: float, current_mps: tuple[float, float] = (0.0, 0.0)
) -> Wrench:
    """The wrench that keeps a boat at rest in this wind (from a direction clockwise from the bow) and current."""
    windage = config.windage
    x, y = -wind_mps * math.cos(from_rad), -wind_mps * math.sin(from_rad)
    pressure = 0.5 * AIR_KGPM3
    through = -current_mps[0], -current_mps[1], 0.0
    drag, munk = damping(config.hull, *through), coriolis(config.hull, *through)
    surge_n, sway_n, yaw_nm = (d + c for d, c in zip(drag, munk, strict=True))
    return Wrench(
        surge_n - pressure * windage.cx * windage.frontal_m2 * wind_mps * x,
        sway_n - pressure * windage.cy * windage.lateral_m2 * wind_mps * y,
        yaw_nm + pressure * windage.cn * windage.lateral_m2 * config.length_m * 2.0 * x * y,
    )


def can_hold(config: VesselConfig, wrench: Wrench, out: frozenset[int] = frozenset()) -> bool:
    """Whether the thrusters without those of the indices `out` give a wrench, within its limits. What the boat has no
    limit for, sideways force or moment, is asked of the thrusters alone."""
    scales = (config.limits.surge_n, config.limits.sway_n, config.limits.yaw_nm)
    asked = (wrench.surge_n, wrench.sway_n, wrench.yaw_nm)
    within = all(abs(value) <= limit or limit <= 0.0 for value, limit in zip(asked, scales, strict=True))
    return within and is_met(thrusters_of(config), scales, wrench, out)


def strongest(holds: Callable[[float], bool], most: float, steps: int) -> float:
    """The largest value from 0 to `most` that is held, by so many steps of halving."""
    if holds(most):
        return most
    low, high = 0.0, most
    for _ in range(steps):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low


def _strongest(
    config: VesselConfig, from_rad: float, current_mps: tuple[float, float], out: frozenset[int], most_mps: float
) -> float | None:
    def holds(wind_mps: float) -> bool:
        return can_hold(config, wrench_against(config, wind_mps, from_rad, current_mps), out)

    return strongest(holds, most_mps, _STEPS) if holds(0.0) else None
