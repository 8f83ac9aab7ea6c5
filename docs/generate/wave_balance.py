"""The sea in which a boat's thrusters just balance the mean drift, and the wind in which they balance wind and waves of
rough water: the static limits that measured Hold is held against."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache

import numpy as np

from companion.allocation.geometry import thrusters_of
from companion.analysis.polar import wrench_against
from companion.config.losses import LossConfig
from companion.config.sea import SeaState
from companion.config.vessel import PlantConfig, VesselConfig, find, load
from companion.core.actuation import Wrench
from companion.positioning.consequence import is_met
from sitl.battery import FULL_V, BatteryModel
from sitl.gusts import at_ten_metres
from sitl.rough_water import rough_plant, wind_sea
from sitl.sea_state import components, parse_sea
from sitl.wave_hull import DriftTable, Met, wave_hull
from sitl.world import chosen_plant

_MOST_M, _MOST_MPS, _STEPS, _SEEDS = 2.0, 20.0, 8, 4
FROM_BEAM, FROM_BOW = 0.5 * math.pi, 0.0


def mean_drift(vessel: VesselConfig, waves: str, from_rad: float, seed: int = 0) -> tuple[float, float, float]:
    """(surge_n, sway_n, yaw_nm) of a sea from a direction clockwise from the bow, on the boat at rest."""
    state = parse_sea(waves)
    return (0.0, 0.0, 0.0) if state is None else _drift_of(vessel, chosen_plant(vessel, None), state, from_rad, seed)


def _drift_of(
    vessel: VesselConfig, plant: PlantConfig, state: SeaState, from_rad: float, seed: int
) -> tuple[float, float, float]:
    boat = wave_hull(plant.hull, vessel)
    sea = components(state, from_rad, seed)
    ahead, across = np.cos(sea.towards_rad), np.sin(sea.towards_rad)
    met = Met(sea.number_radpm, sea.omega_radps, sea.omega_radps, ahead, across)
    forces = DriftTable(boat).coefficients(boat, met, 0.0, 0.0) @ sea.amplitude_m**2
    return float(forces[0]), float(forces[1]), float(forces[2])


@cache
def static_height_m(name: str, from_rad: float) -> float:
    """The significant height, with its usual period, whose mean drift the boat's allocation just balances; the mean of
    a few seeds. 2 m at most."""
    vessel = load(find(name))
    return sum(_height_m(vessel, from_rad, seed) for seed in range(_SEEDS)) / _SEEDS


@cache
def static_wind_mps(name: str, from_rad: float) -> float:
    """The mean wind at the boat in rough water whose force, with the drift of its waves, the boat's allocation just
    balances with what the hull, the wind's centre and the battery's sag take; the mean of a few seeds. 20 m/s at most.
    """
    return sum(_wind_mps(load(find(name)), from_rad, seed, 1.0) for seed in range(_SEEDS)) / _SEEDS


@cache
def least_static_wind_mps(name: str, from_rad: float) -> float:
    """As `static_wind_mps`, of a boat whose wind areas are as much larger than believed as rough water may make
    them."""
    vessel = load(find(name))
    assert vessel.sitl is not None
    area = 1.0 + vessel.sitl.rough.windage_error
    return sum(_wind_mps(vessel, from_rad, seed, area) for seed in range(_SEEDS)) / _SEEDS


def _height_m(vessel: VesselConfig, from_rad: float, seed: int) -> float:
    def demand(height_m: float) -> Wrench:
        return Wrench(*(-force for force in mean_drift(vessel, f"{height_m:.4f}", from_rad, seed)))

    return _most(vessel, demand, _MOST_M)


def _wind_mps(vessel: VesselConfig, from_rad: float, seed: int, area: float) -> float:
    """`area`: the wind areas over those that the vessel's file gives."""
    assert vessel.sitl is not None
    rough = vessel.sitl.rough
    plant = rough_plant(vessel, chosen_plant(vessel, None, True), rough)
    losses, (ahead_m, above_m) = plant.losses, plant.wind_centre_m or (0.0, 1.0)

    def demand(wind_mps: float) -> Wrench:
        against = wrench_against(vessel, math.sqrt(area) * wind_mps, from_rad)
        state = wind_sea(at_ten_metres(rough.gusts, wind_mps, above_m), rough.fetch_m)
        x, y, n = (0.0, 0.0, 0.0) if state is None else _drift_of(vessel, plant, state, from_rad, seed)
        turning_nm = against.yaw_nm + ahead_m * against.sway_n - n
        needed = Wrench(against.surge_n - x, against.sway_n - y, turning_nm)
        left = _left(vessel, losses, needed)
        return Wrench(needed.surge_n / left, needed.sway_n / left, needed.yaw_nm / left)

    return _most(vessel, demand, _MOST_MPS)


def _left(vessel: VesselConfig, losses: LossConfig | None, needed: Wrench) -> float:
    """Share of the thrust that the hull and the battery's sag leave while the thrusters give `needed`, of a full
    battery. All thrusters are taken to share alike."""
    if losses is None:
        return 1.0
    assert vessel.sitl is not None
    left = deducted = 1.0 - losses.deduction
    full_n = sum(thruster.max_n for thruster in vessel.thrusters)
    for _ in range(_STEPS if losses.sag else 0):
        throttle = min(1.0, math.hypot(needed.surge_n, needed.sway_n) / left / full_n)
        battery = BatteryModel(vessel.sitl.battery_wh)
        battery.step(vessel.sitl.hotel_power_w + vessel.sitl.full_power_w * throttle**1.5, 0.0)
        left = deducted * (battery.voltage_v / FULL_V) ** 2
    return left


def _most(vessel: VesselConfig, demand: Callable[[float], Wrench], most: float) -> float:
    """The largest value up to `most` whose demand the vessel's allocation meets within the limits of the wrench."""
    limits, thrusters = vessel.limits, thrusters_of(vessel)
    scales = (limits.surge_n, limits.sway_n, limits.yaw_nm)
    low, high = 0.0, most
    for _ in range(_STEPS):
        middle = 0.5 * (low + high)
        wrench = demand(middle)
        asked = (wrench.surge_n, wrench.sway_n, wrench.yaw_nm)
        within = all(abs(force) <= limit for force, limit in zip(asked, scales, strict=True))
        low, high = (middle, high) if within and is_met(thrusters, scales, wrench, frozenset()) else (low, middle)
    return low
