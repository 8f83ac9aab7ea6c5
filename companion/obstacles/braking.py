"""How fast the boat may go and still stop within a given way, by its hull model and the current."""

from __future__ import annotations

import math

import numpy as np

from companion.config.vessel import VesselConfig
from companion.core.estimate import NavState
from companion.obstacles.occupancy import Floats
from companion.params.store import Parameters

_STEP_MPS = 0.05
_FASTEST_MPS = 25.0
_THRUST_SHARE = 0.6  # of the thrust astern; the rest is for steering and for wind
_TURNED_SHARE = 0.5  # of a thruster's thrust ahead, once it has turned round
_LEAST_MPS2 = 0.02
_DRIFT_MPS = 1.0  # below it, a boat that cannot reverse comes to rest somehow
_MOST = 1.5  # times PATH_ACC
_LAG = 1.5  # times 1/PATH_BW_SURGE: delay of the boat's speed behind its demand
_STREAM_STEP_MPS = 0.1


class Braking:
    """`speed_mps(way_m, stream_mps)` → the highest speed over ground. Remembers the stopping distances for each stream,
    until the parameters change."""

    def __init__(self, config: VesselConfig, parameters: Parameters) -> None:
        self._hull = config.hull
        self._parameters = parameters
        astern_n = sum(
            max(-thruster.min_n, _TURNED_SHARE * thruster.max_n if thruster.kind == "azimuth" else 0.0)
            for thruster in config.thrusters
            if thruster.pushes_astern
        )
        self._thrust_n = _THRUST_SHARE * min(config.limits.surge_n, astern_n)
        self._tables: dict[tuple[int, float], tuple[Floats, Floats]] = {}

    @property
    def lag_s(self) -> float:
        """Time before the boat brakes: delay of its speed loop and CP_DELAY."""
        return _LAG / self._parameters["PATH_BW_SURGE"] + self._parameters["CP_DELAY"]

    def speed_mps(self, way_m: float, stream_mps: float) -> float:
        """The highest speed over ground from which the boat stops within `way_m`: v t + D(v) = way, with the lag t and
        D from m11 v' = −(thrust astern + drag(v − stream)), at most 1.5 PATH_ACC. `stream_mps`: current along its
        course."""
        if math.isinf(way_m):
            return math.inf
        speeds, ways = self._table(stream_mps)
        return float(np.interp(max(0.0, way_m), ways + self.lag_s * speeds, speeds))

    def way_m(self, speed_mps: float, stream_mps: float) -> float:
        """Distance in which the boat stops from that speed over ground; infinite where it cannot."""
        speeds, ways = self._table(stream_mps)
        if speed_mps > speeds[-1]:
            return math.inf
        return float(np.interp(speed_mps, speeds, ways)) + self.lag_s * speed_mps

    def _table(self, stream_mps: float) -> tuple[Floats, Floats]:
        most_mps2 = _MOST * self._parameters["PATH_ACC"]
        key = round(stream_mps / _STREAM_STEP_MPS), most_mps2
        if key not in self._tables:
            if len(self._tables) > 100:
                self._tables.clear()
            self._tables[key] = self._stopping_ways(key[0] * _STREAM_STEP_MPS, most_mps2)
        return self._tables[key]

    def _stopping_ways(self, stream_mps: float, most_mps2: float) -> tuple[Floats, Floats]:
        """Speeds, and the way to rest from each; they end where the boat cannot stop any more."""
        speeds, ways, way_m = [0.0], [0.0], 0.0
        while speeds[-1] < _FASTEST_MPS:
            speed = speeds[-1] + 0.5 * _STEP_MPS
            water = speed - stream_mps
            force_n = self._thrust_n + self._hull.drag_n(water)
            braking = min(most_mps2, force_n / self._hull.m11_kg)
            if braking < _LEAST_MPS2:
                if speed > _DRIFT_MPS:
                    break
                braking = _LEAST_MPS2  # it drifts; nobody can do better
            way_m += speed * _STEP_MPS / braking
            speeds.append(speeds[-1] + _STEP_MPS)
            ways.append(way_m)
        return np.asarray(speeds), np.asarray(ways)


def stream_along_mps(nav: NavState, north: float, east: float) -> float:
    """The current along the unit vector (north, east); 0 where none is known."""
    if nav.current_north_mps is None or nav.current_east_mps is None:
        return 0.0
    return nav.current_north_mps * north + nav.current_east_mps * east
