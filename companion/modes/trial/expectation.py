"""What a rough model says of a boat before its sea trial: speeds, forces and distances. Each may be wrong by half."""

from __future__ import annotations

import math
from dataclasses import dataclass

from companion.config.devices import ThrusterConfig
from companion.config.dimensions.limits import largest
from companion.config.top_speed import top_speed_mps
from companion.config.vessel import VesselConfig
from companion.guidance.bend_speed import steady_turn_radps

_HULL_SPEED = 0.4  # Froude number of the top speed of a model without damping
_LEAST_SWAY_SHARE = 0.05  # of the surge force, from which sideways pushes are worth a manoeuvre
_NO_MOMENT_M = 1e-2  # lever of a boat that cannot turn without pushing ahead
_GRAVITY_MPS2 = 9.81
_LEAST_RADIUS_M = 15.0  # of what is proposed: a small boat drifts as far as a large one
_STRONG_CURRENT = 0.4  # of the top speed: in such a current the motor check, which cannot be interrupted, stays inside
_CHECK_S = 25.0  # time of the motor check
STEERAGE_SHARE = 0.5
"""Of the top speed, through the water: speed at which a boat turns that needs way for it."""
_BRAKES, _TURNS = 0.5, 0.5  # share of the model's deceleration, and turning rate, counted on before they were seen


@dataclass(frozen=True, slots=True)
class Expectation:
    """Figures of one boat: largest forces and moment, top speed, turning rate (on the spot, or with way on where
    it needs that), time constant of the speed ahead, deceleration with full thrust astern."""

    length_m: float
    surge_n: float
    astern_n: float
    sway_n: float
    yaw_nm: float
    top_mps: float
    turn_radps: float
    speeding_s: float
    brake_mps2: float
    needs_way: bool = False  # it turns only while its thruster pushes ahead or astern

    @property
    def sways(self) -> bool:
        """Whether the boat can push itself sideways."""
        return self.sway_n > _LEAST_SWAY_SHARE * self.surge_n

    @property
    def turn_s(self) -> float:
        """Time for half a turn."""
        return math.pi / self.turn_radps + self.speeding_s

    @property
    def turning_s(self) -> float:
        """Time for half a turn that is counted on before one was seen, in which a current carries the boat; 0 for one
        that pushes sideways. With way on a boat turns at once, but perhaps at half of the rate."""
        if self.sways:
            return 0.0
        return math.pi / (_TURNS * self.turn_radps) if self.needs_way else self.turn_s

    @property
    def run_m(self) -> float:
        """Way to nearly full speed and back to rest."""
        return 1.5 * self.speeding_s * self.top_mps + 0.5 * self.top_mps**2 / (_BRAKES * self.brake_mps2)

    @property
    def radius_m(self) -> float:
        """Radius of a circle with room for every manoeuvre."""
        room_m = max(_LEAST_RADIUS_M, min(max(0.75 * self.run_m, 10.0 * self.length_m), 30.0 * self.length_m))
        drift_m = _STRONG_CURRENT * self.top_mps * (_CHECK_S + self.turning_s)
        return max(room_m, drift_m + 2.0 * self.length_m)

    @property
    def least_radius_m(self) -> float:
        """Radius below which a trial says nothing."""
        return 4.0 * self.length_m

    @property
    def budget_s(self) -> float:
        """Longest time for the whole trial: 15 minutes for a boat of 2 m, more for a larger one."""
        return 900.0 * max(1.0, math.sqrt(0.5 * self.length_m))


def expected(config: VesselConfig) -> Expectation:
    """What the file's model says."""
    hull, limits = config.hull, config.limits
    top = top_speed_mps(config)
    top = min(top, 3.0 * _HULL_SPEED * math.sqrt(_GRAVITY_MPS2 * config.length_m))
    astern = min(limits.surge_n, sum(_astern_n(thruster) for thruster in config.thrusters))
    needs_way = config.has_rudder or (largest(config.thrusters, 2, free=(1,)) < _NO_MOMENT_M * limits.surge_n)
    return Expectation(
        length_m=config.length_m,
        surge_n=limits.surge_n,
        astern_n=astern,
        sway_n=limits.sway_n,
        yaw_nm=limits.yaw_nm,
        top_mps=top,
        turn_radps=_turn_radps(config, STEERAGE_SHARE * top if needs_way else 0.0),
        speeding_s=max(1.0, hull.m11_kg * top / limits.surge_n),
        brake_mps2=max(1e-3, astern / hull.m11_kg),
        needs_way=needs_way,
    )


def _astern_n(thruster: ThrusterConfig) -> float:
    if thruster.turns_round:
        return max(thruster.max_n, -thruster.min_n)
    along = math.cos(thruster.azimuth_rad)
    return -thruster.min_n * along if along > 0.0 else -thruster.max_n * along


def _turn_radps(config: VesselConfig, ahead_mps: float) -> float:
    """Steady yaw rate at half the largest moment, at that speed ahead."""
    return min(1.5, max(0.02, steady_turn_radps(config.hull, ahead_mps, 0.5 * config.limits.yaw_nm)))
