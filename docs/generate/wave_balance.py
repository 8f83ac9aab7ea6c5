"""The sea in which a boat's thrusters just balance the mean drift: the static limit that measured Hold is held
against."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from companion.allocation.geometry import thrusters_of
from companion.config.vessel import VesselConfig, find, load
from companion.core.actuation import Wrench
from companion.positioning.consequence import is_met
from sitl.sea_state import components, parse_sea
from sitl.wave_hull import DriftTable, Met, wave_hull

_MOST_M, _STEPS, _SEEDS = 2.0, 8, 4
FROM_BEAM, FROM_BOW = 0.5 * math.pi, 0.0


def mean_drift(vessel: VesselConfig, waves: str, from_rad: float, seed: int = 0) -> tuple[float, float, float]:
    """(surge_n, sway_n, yaw_nm) of a sea from a direction clockwise from the bow, on the boat at rest."""
    state, sitl = parse_sea(waves), vessel.sitl
    if state is None or sitl is None:
        return 0.0, 0.0, 0.0
    boat = wave_hull(sitl.plants[sitl.plant].hull, vessel)
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


def _height_m(vessel: VesselConfig, from_rad: float, seed: int) -> float:
    limits, thrusters = vessel.limits, thrusters_of(vessel)
    scales = (limits.surge_n, limits.sway_n, limits.yaw_nm)
    low, high = 0.0, _MOST_M
    for _ in range(_STEPS):
        middle = 0.5 * (low + high)
        drift = mean_drift(vessel, f"{middle:.4f}", from_rad, seed)
        within = all(abs(force) <= limit for force, limit in zip(drift, scales, strict=True))
        held = within and is_met(thrusters, scales, Wrench(*(-force for force in drift)), frozenset())
        low, high = (middle, high) if held else (low, middle)
    return low
