"""Where the thrusters sit and how they push: τ = T(α) F with columns [cos α, sin α, x sin α − y cos α]."""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.allocation.thrust_curve import ThrustCurve
from companion.config import ThrusterConfig, VesselConfig
from companion.core.types import Wrench

_TOE_RAD = math.radians(35.0)


class Thruster:
    """What allocation must know of one thruster, ready for use. `sector` is None where it turns endlessly."""

    __slots__ = ("azimuth_rate_radps", "curve", "force_rate_nps", "max_n", "min_n", "name", "rest_rad", "sector", "toe_rad", "turns", "x_m", "y_m")

    def __init__(self, config: ThrusterConfig) -> None:
        self.name = config.name
        self.x_m = config.x_m
        self.y_m = config.y_m
        self.curve = ThrustCurve(config)
        self.max_n = self.curve.max_n
        self.min_n = self.curve.min_n
        self.force_rate_nps = config.force_rate_nps
        self.turns = config.kind == "azimuth"
        self.azimuth_rate_radps = config.azimuth_rate_radps
        self.rest_rad = config.azimuth_rad
        self.toe_rad = config.azimuth_rad
        self.sector: tuple[float, float] | None = None
        if self.turns and (config.azimuth_min_rad is not None or config.azimuth_max_rad is not None):
            low = -math.inf if config.azimuth_min_rad is None else config.azimuth_min_rad
            high = math.inf if config.azimuth_max_rad is None else config.azimuth_max_rad
            self.sector = (low, high)

    @property
    def reversible(self) -> bool:
        """Whether it pushes astern well enough that reversing does instead of turning round."""
        return self.min_n <= -0.5 * self.max_n

    def in_sector(self, azimuth_rad: float) -> float:
        """The nearest azimuth that the thruster can take; turned by whole turns where that brings it into the sector."""
        if self.sector is None:
            return azimuth_rad
        low, high = self.sector
        for turned in (azimuth_rad, azimuth_rad - 2.0 * math.pi, azimuth_rad + 2.0 * math.pi):
            if low <= turned <= high:
                return turned
        return min(high, max(low, azimuth_rad))


def column(thruster: Thruster, azimuth_rad: float) -> tuple[float, float, float]:
    """Wrench of one newton of the thruster at that azimuth."""
    c, s = math.cos(azimuth_rad), math.sin(azimuth_rad)
    return c, s, thruster.x_m * s - thruster.y_m * c


def wrench_of(thrusters: Sequence[Thruster], forces_n: Sequence[float], azimuths_rad: Sequence[float]) -> Wrench:
    """What all thrusters together do: T(α) F."""
    x = y = n = 0.0
    for thruster, force, azimuth in zip(thrusters, forces_n, azimuths_rad, strict=True):
        c, s = math.cos(azimuth), math.sin(azimuth)
        x += c * force
        y += s * force
        n += (thruster.x_m * s - thruster.y_m * c) * force
    return Wrench(x, y, n)


def thrusters_of(config: VesselConfig) -> tuple[Thruster, ...]:
    """All thrusters of a vessel. Two or more azimuths of a boat that moves sideways idle toed in or out, so that a sideways demand
    finds some leverage at once; a single one, or one that only steers, idles at rest."""
    thrusters = tuple(Thruster(t) for t in config.thrusters)
    turning = [t for t in thrusters if t.turns]
    if config.limits.sway_n > 0.0 and len(turning) >= 2:
        for i, thruster in enumerate(turning):
            side = math.copysign(1.0, -thruster.y_m) if thruster.y_m != 0.0 else (1.0 if i % 2 else -1.0)
            thruster.toe_rad = thruster.in_sector(thruster.rest_rad + side * _TOE_RAD)
    return thrusters
