"""Standard manoeuvres of a bare plant, and its stability on a straight course: what hulls are compared by.

ITTC 7.5-02-06-03 (turning circle, zig-zag, stopping). No controller, no wind, flat water.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from companion.config.vessel import PlantConfig, VesselConfig
from sitl.hull import dynamics, with_flows
from sitl.hull_flow import flows, hull_of
from sitl.thrusters import ThrusterModel, build

STEP_S = 0.005
_RUN_UP_S, _CIRCLE_S, _LONGEST_S = 20.0, 60.0, 120.0
_SMALL = 1e-5


@dataclass(frozen=True, slots=True)
class Thrust:
    """Of the port and the starboard thruster in N: `mean_n` each on a straight course, `difference_n` between both in a
    turn."""

    mean_n: float
    difference_n: float


class Bare:
    """A boat of two fixed thrusters, port before starboard, on flat water without devices. `helped_n`: a constant force
    ahead beside theirs."""

    def __init__(self, vessel: VesselConfig, plant: PlantConfig, helped_n: float = 0.0) -> None:
        self.hull = hull_of(vessel, plant)
        self.thrusters = build(vessel.thrusters, plant.thruster_lag_s, plant.thruster_x_m)
        for thruster in self.thrusters:
            thruster.lag_on_revolutions = plant.lag_on == "revolutions"
        self.turned_rad, self.t_s = 0.0, 0.0
        self._helped_n = helped_n

    def step(self, port_n: float, starboard_n: float) -> None:
        """Advance with these forces demanded."""
        surge, yaw = self._helped_n, 0.0
        for thruster, force_n in zip(self.thrusters, (port_n, starboard_n), strict=True):
            thruster.drive(_throttle(thruster, force_n))
            thruster.step(STEP_S)
            x_n, _, n_nm = thruster.wrench()
            surge, yaw = surge + x_n, yaw + n_nm
        self.hull.step(surge, 0.0, yaw, STEP_S)
        self.turned_rad += STEP_S * self.hull.turn_radps
        self.t_s += STEP_S

    def turn(self, thrust: Thrust, side: float) -> None:
        """Advance with the moment of the turn to starboard (1), to port (−1), or straight on (0)."""
        half_n = 0.5 * side * thrust.difference_n
        self.step(thrust.mean_n + half_n, thrust.mean_n - half_n)

    def run_up(self, thrust: Thrust) -> None:
        """Straight on until the speed is steady."""
        while self.t_s < _RUN_UP_S:
            self.turn(thrust, 0.0)


def turning_circle(boat: Bare, thrust: Thrust) -> Mapping[str, float]:
    """Advance and transfer at 90°, tactical diameter at 180°, and the steady turn to starboard."""
    boat.run_up(thrust)
    hull, start_m, start_s = boat.hull, boat.hull.north_m, boat.t_s
    found: dict[str, float] = {"speed_before_mps": hull.water_surge_mps}
    while boat.t_s < start_s + _CIRCLE_S:
        boat.turn(thrust, 1.0)
        if "advance_m" not in found and boat.turned_rad >= 0.5 * math.pi:
            found["advance_m"], found["transfer_m"] = hull.north_m - start_m, hull.east_m
        if "tactical_diameter_m" not in found and boat.turned_rad >= math.pi:
            found["tactical_diameter_m"] = hull.east_m
    speed = math.hypot(hull.water_surge_mps, hull.water_sway_mps)
    rate = hull.yaw_rate_radps
    drift = -math.atan2(hull.water_sway_mps, hull.water_surge_mps)
    found |= {"steady_diameter_m": 2.0 * speed / rate, "yaw_rate_dps": math.degrees(rate), "speed_mps": speed}
    return found | {"drift_deg": math.degrees(drift)}


def zigzag(boat: Bare, thrust: Thrust, angle_deg: float = 10.0) -> Mapping[str, float]:
    """How far the heading goes on after the first three changes of side, the time to the first, and the period. Raises
    ValueError for a boat that does not turn."""
    boat.run_up(thrust)
    side, start_s, asked = 1.0, boat.t_s, math.radians(angle_deg)
    times: list[float] = []
    overshoots: list[float] = []
    peak = changed = 0.0  # in the direction that the boat came from
    while len(times) < 5 and boat.t_s < start_s + _LONGEST_S:
        boat.turn(thrust, side)
        if side * boat.turned_rad >= asked:
            times.append(boat.t_s - start_s)
            overshoots.append(math.degrees(peak - changed))
            side = -side
            peak = changed = -side * boat.turned_rad
        peak = max(peak, -side * boat.turned_rad)
    if len(times) < 5:
        raise ValueError(f"{len(times)} changes of side in {_LONGEST_S:g} s")
    return {
        "overshoot_1_deg": overshoots[1],
        "overshoot_2_deg": overshoots[2],
        "overshoot_3_deg": overshoots[3],
        "first_turn_s": times[0],
        "period_s": times[4] - times[2],
    }


def stopping(boat: Bare, thrust: Thrust) -> Mapping[str, float]:
    """Time and way from the steady speed to half of it, without thrust."""
    boat.run_up(thrust)
    hull, start_m, start_s = boat.hull, boat.hull.north_m, boat.t_s
    speed = hull.water_surge_mps
    while hull.water_surge_mps > 0.5 * speed and boat.t_s < start_s + _LONGEST_S:
        boat.step(0.0, 0.0)
    return {"half_speed_s": boat.t_s - start_s, "half_speed_m": hull.north_m - start_m}


def course_roots(vessel: VesselConfig, plant: PlantConfig, speed_mps: float) -> tuple[complex, complex]:
    """Eigenvalues of sway and yaw on a straight course at that speed, the less stable first, in 1/s. A positive real
    part: the hull by itself leaves the course. Of the companion's own equations."""
    rate = with_flows(dynamics(plant.hull), flows(plant, vessel))
    columns = []
    for v, r in ((_SMALL, 0.0), (0.0, _SMALL)):
        plus, minus = rate(speed_mps, v, r, 0.0, 0.0, 0.0), rate(speed_mps, -v, -r, 0.0, 0.0, 0.0)
        columns.append([(plus[i] - minus[i]) / (2.0 * _SMALL) for i in (1, 2)])
    roots = sorted((complex(root) for root in np.linalg.eigvals(np.array(columns).T)), key=lambda root: -root.real)
    return roots[0], roots[1]


def _throttle(thruster: ThrusterModel, force_n: float) -> float:
    curve_n = thruster.config.ahead_n if force_n >= 0.0 else thruster.config.astern_n
    return math.copysign(math.sqrt(abs(force_n) / curve_n), force_n)
