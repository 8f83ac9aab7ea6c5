"""How hard a boat can speed up, brake and turn along a path, by its hull model and its thrusters' limits.

A share of the thrust (PATH_EFFORT) is planned with, less what drag and wind take already; the rest is for gusts and
corrections. Source: force over inertia, and the yaw rate at which damping takes that share of the moment.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from companion.config.blades import without_blades
from companion.config.dimensions.limits import sides_nm
from companion.config.hull import AIR_KGPM3, HullConfig, WindageConfig
from companion.config.vessel import VesselConfig
from companion.guidance.bend_speed import steady_turn_radps

_KEPT_SHARE = 0.1  # of the surge limit, never planned with
_LEAST_MPS2 = 0.02
_LEAST_TURN_RADPS, _MOST_TURN_RADPS = math.radians(2.0), math.pi / 2.0
_SPEEDS = 16  # of the table of yaw rates

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Weather:
    """Velocity of water and air over ground, north and east, in m/s; zeros where they are not known."""

    water_north_mps: float = 0.0
    water_east_mps: float = 0.0
    air_north_mps: float = 0.0
    air_east_mps: float = 0.0


@dataclass(frozen=True, slots=True)
class Agility:
    """A boat that can push itself sideways. `agility_of` makes it."""

    hull: HullConfig
    windage: WindageConfig
    surge_n: float
    sway_n: float
    yaw_nm: float
    aims: bool = False  # its thrusters turn: where the plan will need them counts before it does
    # Of `yaw_nm`, what the thrusters give to each side without a force aside: with one a turn runs wide.
    port_share: float = 1.0
    starboard_share: float = 1.0

    @property
    def most_n(self) -> float:
        """The thrust along the path that a plan may count on."""
        return (1.0 - _KEPT_SHARE) * self.surge_n

    @property
    def least_mps2(self) -> float:
        """Acceleration and braking that a plan counts on where no thrust is left."""
        return _LEAST_MPS2

    def gain_mps2(self, force_n: float) -> float:
        """Acceleration by a surplus of thrust along the path."""
        return max(_LEAST_MPS2, force_n / self.hull.m11_kg)

    def laterals_mps2(self, share: Floats) -> Floats:
        """Sideways acceleration of the boat's path, by shares of the sway limit."""
        accelerations: Floats = np.maximum(_LEAST_MPS2, share * self.sway_n / self.hull.m22_kg)
        return accelerations

    def sway_mps(self, share: float) -> float:
        """Sideways speed through the water at which damping takes that share of the sway limit."""
        d = self.hull.damping
        return _speed_at(share * self.sway_n, d.y_v, d.y_vv)

    def turn_radps(self, share: float, surge_mps: float) -> float:
        """Yaw rate at which damping takes that share of the yaw limit, at that speed ahead."""
        rate = steady_turn_radps(self.hull, surge_mps, share * self.yaw_nm)
        return max(_LEAST_TURN_RADPS, min(_MOST_TURN_RADPS, rate))

    def turns_radps(self, share: float, surge_mps: Floats) -> Floats:
        """As `turn_radps`, at several speeds."""
        if self.hull.damping.n_ur == 0.0:
            return np.full(len(surge_mps), self.turn_radps(share, 0.0))
        table = np.linspace(0.0, float(np.max(surge_mps)), _SPEEDS)
        rates: Floats = np.interp(surge_mps, table, [self.turn_radps(share, float(u)) for u in table])
        return rates

    def resisting_n(self, speed_mps: float, course_rad: float, weather: Weather) -> float:
        """What water and wind take of the thrust at that speed over ground, bow along the course."""
        c, s = math.cos(course_rad), math.sin(course_rad)
        drag = self.hull.drag_n(speed_mps - weather.water_north_mps * c - weather.water_east_mps * s)
        air = weather.air_north_mps * c + weather.air_east_mps * s - speed_mps
        if weather.air_north_mps == 0.0 and weather.air_east_mps == 0.0:
            return drag
        return drag - 0.5 * AIR_KGPM3 * self.windage.cx * self.windage.frontal_m2 * abs(air) * air


def agility_of(config: VesselConfig) -> Agility | None:
    """The agility of a boat that can push itself sideways; None for others, whose slip in a bend the model does not
    tell: PATH_ACC, PATH_ACC_LAT and PATH_YAW_RATE bound those."""
    limits = config.limits
    if limits.sway_n <= 0.0:
        return None
    aims = any(thruster.turns for thruster in without_blades(config.thrusters))
    port, starboard = (min(1.0, most_nm / limits.yaw_nm) for most_nm in sides_nm(tuple(config.thrusters)))
    return Agility(config.hull, config.windage, limits.surge_n, limits.sway_n, limits.yaw_nm, aims, port, starboard)


def _speed_at(force: float, linear: float, square: float) -> float:
    """The speed v with linear·v + square·v² = force; infinite without damping."""
    if square > 0.0:
        return (math.sqrt(linear * linear + 4.0 * square * force) - linear) / (2.0 * square)
    return force / linear if linear > 0.0 else math.inf
