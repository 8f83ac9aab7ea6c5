"""Force of a propeller with a rudder behind it as a function of thrust, angle and speed, and its inverse. Formulae and
sources: `companion.config.rudder`."""

from __future__ import annotations

import math

from companion.config.devices import ThrusterConfig
from companion.config.dimensions.form import WATER_KGPM3

_TINY = 1.0e-9


class RudderCurve:
    """Thrust in N along the hull, angle in rad with the sign of the push to starboard, speed ahead through the water in
    m/s. Remembers nothing.

    The blade's own drift is not in it: to the hull it is a fin (`companion.config.dimensions.fins`).
    """

    __slots__ = ("_coefficient", "_disc", "_free", "_gain", "_race", "_rudder", "_stop_rad", "_wake", "lever_m")

    def __init__(self, thruster: ThrusterConfig) -> None:
        """Raises ValueError for a thruster without a rudder, or in the race of a propeller without its diameter."""
        rudder, propeller_m = thruster.rudder, thruster.propeller_m
        if rudder is None or (propeller_m is None and rudder.race_share > 0.0):
            raise ValueError(f"thruster {thruster.name} has no rudder")
        self._rudder = rudder
        # ½ ρ A_P; a blade without a propeller is in no race
        self._disc = math.inf if propeller_m is None else 0.5 * WATER_KGPM3 * 0.25 * math.pi * propeller_m**2
        self._coefficient = 0.5 * WATER_KGPM3 * rudder.area_m2 * rudder.lift_scale
        self._race, self._free = rudder.race_share, 1.0 - rudder.race_share
        self._gain, self._wake = rudder.race_gain, 1.0 - rudder.wake_share
        self._stop_rad = min(abs(thruster.azimuth_min_rad or 0.0), abs(thruster.azimuth_max_rad or 0.0))
        self.lever_m = rudder.x_m

    def inflow(self, thrust_n: float, surge_mps: float) -> float:
        """As `RudderConfig.inflow`."""
        return self._rudder.inflow(thrust_n, surge_mps, self._disc)

    def force_n(self, thrust_n: float, angle_rad: float, surge_mps: float) -> tuple[float, float]:
        """(surge, sway) of propeller and blade together. 0 sideways without flow."""
        pressure = self._coefficient * self.inflow(thrust_n, surge_mps)
        lift = self._rudder.lift(angle_rad)
        return thrust_n - pressure * self._rudder.drag(lift), pressure * lift

    def most_n(self, inflow: float) -> float:
        """The push sideways at the stop, by the flow U² at the blade, m²/s²."""
        return self._coefficient * inflow * self._rudder.lift(self._stop_rad)

    def angle_rad(self, side_n: float, thrust_n: float, surge_mps: float) -> float:
        """The angle that pushes sideways with `side_n`, held within the stops; 0 where there is no flow."""
        return self.angle_in_flow_rad(side_n, self.inflow(thrust_n, surge_mps))

    def angle_in_flow_rad(self, side_n: float, inflow: float) -> float:
        """As `angle_rad`, by the flow U² at the blade, m²/s²."""
        pressure = self._coefficient * inflow
        if pressure < _TINY:
            return 0.0
        lift, slope, cross = abs(side_n) / pressure, self._rudder.slope, self._rudder.cross_flow
        angle = (math.sqrt(slope * slope + 4.0 * cross * lift) - slope) / (2.0 * cross)
        return math.copysign(min(self._stop_rad, angle), side_n)

    def thrust_n(self, side_n: float, surge_mps: float) -> float:
        """The least thrust ahead with which the blade at its stop pushes sideways with `side_n`; infinite for a blade
        beside the race that the flow alone does not serve."""
        ahead = self._wake * max(0.0, surge_mps)
        needed = abs(side_n) / (self._coefficient * self._rudder.lift(self._stop_rad)) - self._free * ahead * ahead
        if needed <= self._race * ahead * ahead:
            return 0.0
        if self._race < _TINY:
            return math.inf
        jet = ahead + (math.sqrt(needed / self._race) - ahead) / self._gain
        return self._disc * (jet * jet - ahead * ahead)
