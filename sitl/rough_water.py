"""Rough water: the hull, the wind and the waves of `water=rough`, made of what a vessel's file says."""

from __future__ import annotations

import math
from dataclasses import replace

from companion.config.dimensions.form import GRAVITY_MPS2
from companion.config.losses import LossConfig
from companion.config.rough_water import ROUGH, USUAL, RoughWaterConfig
from companion.config.sea import SeaState
from companion.config.vessel import ConfigError, PlantConfig, SitlConfig, VesselConfig
from companion.core.nearest import did_you_mean
from sitl.wave_hull import air_height_m, wave_hull

_DISC_PA = 6000.0  # thrust over disc area at full thrust: 4 kPa of a trolling motor, 11 kPa of Blue Robotics' T200
_GEAR_LAG_S, _GEAR_PLAY_RAD = 0.2, math.radians(2.0)  # of geared stepper motors and servos (assumed)
_DEDUCTION = 0.05  # at rest, of open propellers below a hull: 0.03 to 0.07 (Carlton 2012, 12)
_CENTRE_AHEAD = 0.05  # of the length: hull and gear are rarely as large ahead of the middle as behind it
_LEAST_M = 0.005  # a lower sea is flat water


def is_rough(name: str | None, simulation: SitlConfig) -> bool:
    """Whether that water is rough; None: as the vessel's file says. Raises ConfigError for an unknown one."""
    water = simulation.water if name is None else name
    kinds = (USUAL, ROUGH)
    if water not in kinds:
        raise ConfigError([f"water '{water}': {USUAL} or {ROUGH}{did_you_mean(water, kinds)}"])
    return water == ROUGH


def plant_name(simulation: SitlConfig, name: str | None, rough: bool) -> str:
    """The plant that is sailed: the one that is asked for, else the file's choice for that water."""
    chosen = simulation.rough.plant if rough and simulation.rough.plant in simulation.plants else simulation.plant
    return chosen if name is None else name


def rough_plant(vessel: VesselConfig, plant: PlantConfig, rough: RoughWaterConfig) -> PlantConfig:
    """The plant with losses, sensor errors and a centre of the wind's force, where it has none of its own."""
    centre_m = _CENTRE_AHEAD * vessel.length_m, air_height_m(plant.hull, vessel)
    return replace(
        plant,
        losses=plant.losses or rough.losses or usual_losses(vessel, plant),
        sensor_errors=plant.sensor_errors or rough.sensor_errors,
        wind_centre_m=plant.wind_centre_m or centre_m,
    )


def usual_losses(vessel: VesselConfig, plant: PlantConfig) -> LossConfig:
    """All losses, of propellers whose diameter follows from their thrust where the file gives none, with shafts as deep
    as the hull or as the diameter."""
    most_n = max(max(row.max_n, -row.min_n) for row in vessel.thrusters)
    propeller_m = math.sqrt(4.0 * most_n / (math.pi * _DISC_PA))
    return LossConfig(
        propeller_m=None if all(row.propeller_m is not None for row in vessel.thrusters) else propeller_m,
        depth_m=max(wave_hull(plant.hull, vessel).draft_m, propeller_m),
        deduction=_DEDUCTION,
        azimuth_lag_s=_GEAR_LAG_S,
        backlash_rad=_GEAR_PLAY_RAD,
    )


def wind_sea(wind_mps: float, fetch_m: float) -> SeaState | None:
    """The waves that a wind at 10 m raises in deep water over that fetch, from where it comes; None where they are next
    to nothing.

    JONSWAP (Hasselmann et al. 1973; Shore Protection Manual 1984, 3-39): g H/U² = 0.0016 X^½ and g T/U = 0.286 X^⅓ with
    X = g F/U², up to those of a fully developed sea, 0.243 and 8.13.
    """
    if wind_mps <= 0.0:
        return None
    fetch = GRAVITY_MPS2 * fetch_m / wind_mps**2
    height_m = min(0.0016 * math.sqrt(fetch), 0.243) * wind_mps**2 / GRAVITY_MPS2
    peak_s = min(0.286 * math.cbrt(fetch), 8.13) * wind_mps / GRAVITY_MPS2
    return SeaState(height_m, None, peak_s) if height_m >= _LEAST_M else None
