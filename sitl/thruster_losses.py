"""Losses of propellers: inflow, cross flow, ventilation, the races of others, the hull, the battery."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from companion.config.devices import ThrusterConfig
from companion.config.dimensions.form import WATER_KGPM3
from companion.config.losses import LossConfig
from sitl.battery import FULL_V
from sitl.thrusters import ThrusterModel

_KT = 0.35  # bollard thrust coefficient: Wageningen B4-70, P/D 0.8, whose advance ratio without thrust is 0.88
_MOST_GAIN = 1.3  # of a propeller in water from behind
_PUSHES = 0.05  # of full force: less makes no race
_CALM = (0.0, 0.0, math.inf)

Water = tuple[float, float, float]  # velocity ahead and to starboard beside the hull's water, depth of the shaft


@dataclass(frozen=True, slots=True)
class _Propeller:
    """With √T₀ of the thrust at rest: the speed ahead without thrust is `free_mps` √T₀, and the mass flow ρ A √(T₀/2ρA)
    is `taken_along` √T₀."""

    diameter_m: float
    free_mps: float
    taken_along: float


def _propeller(diameter_m: float | None, advance_ratio: float) -> _Propeller | None:
    """None without a diameter."""
    if diameter_m is None:
        return None
    free_mps = advance_ratio / (diameter_m * math.sqrt(_KT * WATER_KGPM3))
    return _Propeller(diameter_m, free_mps, math.sqrt(0.125 * math.pi * WATER_KGPM3) * diameter_m)


@dataclass(frozen=True, slots=True)
class _Race:
    """The race of thruster `of` as another one meets it: the direction to there, and the share of its thrust that is
    left right behind."""

    of: int
    x: float
    y: float
    straight: float


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

    Jets and rudders have laws of their own for the inflow; of them only hull and battery take something. Of a sail,
    with its keel and rudder, nothing does: it has neither race nor battery.
    """

    def __init__(
        self, config: LossConfig, thrusters: Sequence[ThrusterConfig], places: Sequence[tuple[float, float]]
    ) -> None:
        """`places`: ahead and to starboard, where they really are."""
        self._config, self._places = config, tuple(places)
        self._propellers = [
            None
            if thruster.kind in ("jet", "rudder", "sail")
            else _propeller(config.propeller_m or thruster.propeller_m, config.advance_ratio)
            for thruster in thrusters
        ]
        self._sails = [thruster.kind == "sail" for thruster in thrusters]
        self._races = [self._races_at(i) for i in range(len(thrusters))]
        self._pushes_n = [_PUSHES * max(thruster.max_n, -thruster.min_n) for thruster in thrusters]

    def _races_at(self, i: int) -> tuple[_Race, ...]:
        """The races that thruster `i` may lie in."""
        here, propeller = self._places[i], self._propellers[i]
        if propeller is None or not self._config.interaction:
            return ()
        found = []
        for j, there in enumerate(self._places):
            if j != i and self._propellers[j] is not None:
                away_x, away_y = here[0] - there[0], here[1] - there[1]
                distance = max(math.hypot(away_x, away_y), 1e-9)
                straight = behind(distance / propeller.diameter_m)
                found.append(_Race(j, away_x / distance, away_y / distance, straight))
        return tuple(found)

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
        pushes = [
            (thruster.given_n, math.cos(thruster.azimuth_rad), math.sin(thruster.azimuth_rad)) for thruster in thrusters
        ]
        surge = sway = yaw = 0.0
        for i, propeller in enumerate(self._propellers):
            x_m, y_m = self._places[i]
            if propeller is None:
                x_n, y_n, n_nm = thrusters[i].wrench()
                share = 1.0 if self._sails[i] else common
                surge, sway, yaw = surge + share * x_n, sway + share * y_n, yaw + share * n_nm
            elif pushes[i][0] != 0.0:
                flow = self._flow_at(i, velocity, _CALM if water is None else water[i])
                share, across_n = self._in_water(propeller, pushes[i], flow)
                force_n, c, s = pushes[i]
                force_n *= common * share * self._in_races(i, pushes)
                x_n, y_n = c * force_n - s * across_n, s * force_n + c * across_n
                surge, sway, yaw = surge + x_n, sway + y_n, yaw + x_m * y_n - y_m * x_n
        return surge, sway, yaw

    def _flow_at(self, i: int, velocity: tuple[float, float, float], water: Water) -> Water:
        """The thruster's velocity through the water there, ahead and to starboard, and the depth of its shaft."""
        x_m, y_m = self._places[i]
        return velocity[0] - velocity[2] * y_m - water[0], velocity[1] + velocity[2] * x_m - water[1], water[2]

    def _in_water(self, propeller: _Propeller, push: tuple[float, float, float], flow: Water) -> tuple[float, float]:
        """Share of the thrust that the flow leaves, and the force of the flow across, to the right of the shaft."""
        config, (given_n, c, s), (ahead, starboard, depth_m) = self._config, push, flow
        root, share, across_n = math.sqrt(abs(given_n)), 1.0, 0.0
        if config.inflow:
            along = c * ahead + s * starboard
            share = 1.0 - (along if given_n > 0.0 else -along) / (propeller.free_mps * root)
            share = 0.0 if share < 0.0 else _MOST_GAIN if share > _MOST_GAIN else share
        if config.cross_flow:
            across_n = -(c * starboard - s * ahead) * propeller.taken_along * root
        if config.ventilation:
            share *= ventilated(2.0 * depth_m / propeller.diameter_m)
        return share, across_n

    def _in_races(self, i: int, pushes: Sequence[tuple[float, float, float]]) -> float:
        """Share of the thrust that the races of the other thrusters leave."""
        share = 1.0
        for race in self._races[i]:
            force_n, c, s = pushes[race.of]
            if abs(force_n) >= self._pushes_n[race.of]:
                along = race.x * c + race.y * s  # a race goes against the force on the boat
                share *= off_race(race.straight, -along if force_n > 0.0 else along)
        return share


def ventilated(submergence: float) -> float:
    """Share of the thrust at a shaft depth in propeller radii."""
    if submergence >= 1.3:
        return 1.0
    return max(0.0, 1.0 - 0.675 * math.pow(1.0 - 0.769 * submergence, 1.258))


def raced(diameters: float, off_deg: float) -> float:
    """Share of the thrust at so many diameters from another thruster, so far off its race."""
    return off_race(behind(diameters), math.cos(math.radians(off_deg)))


def behind(diameters: float) -> float:
    """Share of the thrust right behind another thruster."""
    return 1.0 - math.pow(0.8, math.pow(diameters, 2.0 / 3.0))


def off_race(straight: float, cosine: float) -> float:
    """Share of the thrust at an angle of that cosine off the race, from the share right behind."""
    turned = math.degrees(math.acos(1.0 if cosine > 1.0 else -1.0 if cosine < -1.0 else cosine)) ** 3
    return straight + (1.0 - straight) * turned / (130.0 / max(straight, 1e-3) ** 3 + turned)
