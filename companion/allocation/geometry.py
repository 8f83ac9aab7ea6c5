"""Places and directions of the thrusters: τ = T(α) F with columns [cos α, sin α, x sin α − y cos α]."""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.allocation.sectors import Sectors
from companion.allocation.thrust_curve import ThrustCurve
from companion.config.blades import without_blades
from companion.config.devices import ThrusterConfig
from companion.config.vessel import VesselConfig
from companion.core.actuation import Wrench

_TOE_RAD = math.radians(35.0)
_FAR_OFF_RAD = 0.3  # further from the direction wanted, reversing is better
_SIDEWAYS = 0.7  # share across the hull from which a thruster at rest needs no toe


class Thruster:
    """The data of one thruster that allocation uses. `toe_rad`: the azimuth at which it idles."""

    __slots__ = (
        "azimuth_rate_radps",
        "curve",
        "force_rate_nps",
        "max_n",
        "min_n",
        "name",
        "rest_rad",
        "sectors",
        "toe_rad",
        "turns",
        "x_m",
        "y_m",
    )

    def __init__(self, config: ThrusterConfig) -> None:
        self.name = config.name
        self.x_m = config.x_m
        self.y_m = config.y_m
        self.curve = ThrustCurve(config)
        self.max_n = self.curve.max_n
        self.min_n = self.curve.min_n
        self.force_rate_nps = config.force_rate_nps
        self.turns = config.turns
        self.azimuth_rate_radps = config.azimuth_rate_radps
        self.rest_rad = config.azimuth_rad
        self.toe_rad = config.azimuth_rad
        self.sectors = (
            Sectors(config.azimuth_min_rad, config.azimuth_max_rad, config.forbidden_rad)
            if self.turns
            else Sectors(None, None, ())
        )

    @property
    def reversible(self) -> bool:
        """Whether it pushes astern well enough to reverse instead of turning round."""
        return self.min_n <= -0.5 * self.max_n

    def aim_rad(self, direction_rad: float, present_rad: float) -> float:
        """The azimuth to push in that direction: ahead, or in reverse where the stops allow nothing near."""
        ahead_rad = self.sectors.nearest(direction_rad, present_rad)
        if self.reversible and abs(math.remainder(ahead_rad - direction_rad, math.tau)) > _FAR_OFF_RAD:
            return self.sectors.nearest(direction_rad + math.pi, present_rad)
        return ahead_rad


def column(thruster: Thruster, azimuth_rad: float) -> tuple[float, float, float]:
    """(surge, sway, yaw) of one newton of the thruster at that azimuth: N, N, Nm."""
    c, s = math.cos(azimuth_rad), math.sin(azimuth_rad)
    return c, s, thruster.x_m * s - thruster.y_m * c


def wrench_of(thrusters: Sequence[Thruster], forces_n: Sequence[float], azimuths_rad: Sequence[float]) -> Wrench:
    """The wrench of all thrusters: T(α) F."""
    x = y = n = 0.0
    for thruster, force, azimuth in zip(thrusters, forces_n, azimuths_rad, strict=True):
        c, s = math.cos(azimuth), math.sin(azimuth)
        x += c * force
        y += s * force
        n += (thruster.x_m * s - thruster.y_m * c) * force
    return Wrench(x, y, n)


def thrusters_of(config: VesselConfig) -> tuple[Thruster, ...]:
    """All thrusters of a vessel, in the order of its file. Two or more azimuths of a boat with sideways thrust idle
    toed in or out, so that they can answer a sideways demand at once; others idle at rest. Beside others, propellers
    with rudders count as fixed."""
    thrusters = tuple(Thruster(t) for t in without_blades(config.thrusters))
    turning = [t for t in thrusters if t.turns and abs(math.sin(t.rest_rad)) < _SIDEWAYS]
    if config.limits.sway_n > 0.0 and len(turning) >= 2:
        for i, thruster in enumerate(turning):
            side = math.copysign(1.0, -thruster.y_m) if thruster.y_m != 0.0 else (1.0 if i % 2 else -1.0)
            thruster.toe_rad = thruster.sectors.nearest(thruster.rest_rad + side * _TOE_RAD, thruster.rest_rad)
    return thrusters
