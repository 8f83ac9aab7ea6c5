"""Losses of propellers: inflow, cross flow, ventilation, the races of others, the hull, the battery."""

from __future__ import annotations

import math
from collections.abc import Sequence

from companion.config.devices import ThrusterConfig
from companion.config.dimensions.form import WATER_KGPM3
from companion.config.losses import LossConfig
from sitl.battery import FULL_V
from sitl.thrusters import ThrusterModel

_KT, _J = 0.35, 0.88  # bollard thrust coefficient and advance ratio without thrust: Wageningen B4-70, P/D 0.8
_MOST_GAIN = 1.3  # of a propeller in water from behind
_PUSHES = 0.05  # of full force: less makes no race
_CALM = (0.0, 0.0, math.inf)

Water = tuple[float, float, float]  # velocity ahead and to starboard beside the hull's water, depth of the shaft


class ThrusterLosses:
    """Thrusters, the boat's velocity through the water and the water at each → the wrench that is left.

    * Inflow: T = T₀ (1 − V/V₀) at constant revolutions, V₀ = J₀ n D with T₀ = K_T ρ n² D⁴ (Oosterveld and van Oossanen
      1975: the open-water curve is nearly straight).
    * Cross flow: the mass flow ρ A √(T₀/2ρA) of momentum theory leaves along the shaft, and its momentum across it is
      lost (Faltinsen 1990, 9).
    * Ventilation: 1 − 0.675 (1 − 0.769 h/R)^1.258 at a shaft depth h below 1.3 R (Minsaas et al. 1983).
    * In the race of another: 1 − 0.8^((x/D)^⅔) right behind it, with the angle φ in degrees off it towards 1 by
      φ³/(130/t³ + φ³) (Dang and Laheij 2004).
    * Battery: revolutions go with the voltage, thrust with its square.

    Jets and rudders have laws of their own for the inflow; of them only hull and battery take something.
    """

    def __init__(
        self, config: LossConfig, thrusters: Sequence[ThrusterConfig], places: Sequence[tuple[float, float]]
    ) -> None:
        """`places`: ahead and to starboard, where they really are."""
        self._config, self._places = config, tuple(places)
        self._diameters = [
            None if thruster.kind in ("jet", "rudder") else config.propeller_m or thruster.propeller_m
            for thruster in thrusters
        ]

    def wrench(
        self,
        thrusters: Sequence[ThrusterModel],
        velocity: tuple[float, float, float],
        water: Sequence[Water] | None,
        battery_v: float,
    ) -> tuple[float, float, float]:
        """(surge_n, sway_n, yaw_nm) of all thrusters. `velocity`: surge and sway through the water, rate of yaw;
        `water`: at each thruster, None in flat water."""
        common = 1.0 - self._config.deduction
        if self._config.sag:
            common *= (battery_v / FULL_V) ** 2
        surge = sway = yaw = 0.0
        for i, thruster in enumerate(thrusters):
            share, drag = common, (0.0, 0.0)
            diameter = self._diameters[i]
            if diameter is not None and thruster.given_n != 0.0:
                factor, drag = self._in_water(i, thruster, diameter, velocity, _CALM if water is None else water[i])
                share *= factor * self._in_races(i, thrusters, diameter)
            x_n, y_n, n_nm = thruster.wrench()
            x_m, y_m = self._places[i]
            surge, sway = surge + share * x_n + drag[0], sway + share * y_n + drag[1]
            yaw += share * n_nm + x_m * drag[1] - y_m * drag[0]
        return surge, sway, yaw

    def _in_water(
        self, i: int, thruster: ThrusterModel, diameter: float, velocity: tuple[float, float, float], water: Water
    ) -> tuple[float, tuple[float, float]]:
        """Share of the thrust that the flow leaves, and the force of the flow across."""
        x_m, y_m = self._places[i]
        ahead = velocity[0] - velocity[2] * y_m - water[0]
        starboard = velocity[1] + velocity[2] * x_m - water[1]
        c, s = math.cos(thruster.azimuth_rad), math.sin(thruster.azimuth_rad)
        force_n = abs(thruster.given_n)
        along, across = c * ahead + s * starboard, c * starboard - s * ahead
        along = math.copysign(along, along * thruster.given_n)
        share, drag = 1.0, (0.0, 0.0)
        if self._config.inflow:
            free_mps = _J * math.sqrt(force_n / (_KT * WATER_KGPM3)) / diameter
            share = min(max(1.0 - along / free_mps, 0.0), _MOST_GAIN)
        if self._config.cross_flow:
            drag_n = -across * math.sqrt(0.5 * WATER_KGPM3 * 0.25 * math.pi * diameter * diameter * force_n)
            drag = -s * drag_n, c * drag_n
        if self._config.ventilation:
            share *= ventilated(water[2] / (0.5 * diameter))
        return share, drag

    def _in_races(self, i: int, thrusters: Sequence[ThrusterModel], diameter: float) -> float:
        """Share of the thrust that the races of the other thrusters leave."""
        share = 1.0
        if not self._config.interaction:
            return share
        x_m, y_m = self._places[i]
        for j, other in enumerate(thrusters):
            if j == i or self._diameters[j] is None or abs(other.given_n) < _PUSHES * other.max_n:
                continue
            away_x, away_y = x_m - self._places[j][0], y_m - self._places[j][1]
            distance = math.hypot(away_x, away_y)
            race = other.azimuth_rad + (math.pi if other.given_n > 0.0 else 0.0)
            off = (away_x * math.cos(race) + away_y * math.sin(race)) / max(distance, 1e-9)
            share *= raced(distance / diameter, math.degrees(math.acos(min(max(off, -1.0), 1.0))))
        return share


def ventilated(submergence: float) -> float:
    """Share of the thrust at a shaft depth in propeller radii."""
    if submergence >= 1.3:
        return 1.0
    return max(0.0, 1.0 - 0.675 * math.pow(1.0 - 0.769 * submergence, 1.258))


def raced(diameters: float, off_deg: float) -> float:
    """Share of the thrust at so many diameters from another thruster, so far off its race."""
    straight = 1.0 - math.pow(0.8, math.pow(diameters, 2.0 / 3.0))
    turned = off_deg**3
    return straight + (1.0 - straight) * turned / (130.0 / max(straight, 1e-3) ** 3 + turned)
