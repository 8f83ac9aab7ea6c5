"""Rough water: the hull, the wind and the waves of `water=rough`, made of what a vessel's file says."""

from __future__ import annotations

import math
from dataclasses import replace

from companion.config.dimensions.form import GRAVITY_MPS2
from companion.config.dimensions.surge_damping import linear
from companion.config.losses import LossConfig
from companion.config.rough_water import ROUGH, USUAL, RoughWaterConfig
from companion.config.sea import SeaState
from companion.config.vessel import ConfigError, PlantConfig, SitlConfig, VesselConfig
from companion.core.nearest import did_you_mean
from sitl.wave_hull import air_height_m, wave_hull

_DISC_PA = 6000.0  # thrust over disc area at full thrust: 4 kPa of a trolling motor, 11 kPa of Blue Robotics' T200
_GEAR_LAG_S, _GEAR_PLAY_RAD = 0.2, math.radians(2.0)  # of geared stepper motors and servos (assumed)
_ADVANCE = LossConfig().advance_ratio  # of a propeller of usual pitch
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
    """The plant with losses, sensor errors and a centre of the wind's force, where it has none of its own. A hull of
    the controller's model leaves to the losses what its damping has of them."""
    losses = plant.losses or rough.losses
    if losses is None:
        losses, plant = usual_losses(vessel, plant), _without(vessel, plant)
    centre_m = _CENTRE_AHEAD * vessel.length_m, air_height_m(plant.hull, vessel)
    return replace(
        plant,
        losses=losses,
        sensor_errors=plant.sensor_errors or rough.sensor_errors,
        wind_centre_m=plant.wind_centre_m or centre_m,
    )


def usual_losses(vessel: VesselConfig, plant: PlantConfig) -> LossConfig:
    """All losses, of propellers whose diameter follows from their thrust where the file gives none, with shafts as deep
    as the hull or as the diameter. Where the hull is that of the controller's model, their pitch is such that they lose
    ahead what its damping says, if that is less than usual: propellers of fast boats have more."""
    propeller_m = _usual_m(vessel)
    lost, told = _lost_ahead(vessel), _told(vessel, plant)
    return LossConfig(
        propeller_m=None if all(row.propeller_m is not None for row in vessel.thrusters) else propeller_m,
        advance_ratio=_ADVANCE * max(1.0, lost / told) if told > 0.0 else _ADVANCE,
        depth_m=max(wave_hull(plant.hull, vessel).draft_m, propeller_m),
        deduction=_DEDUCTION,
        azimuth_lag_s=_GEAR_LAG_S,
        backlash_rad=_GEAR_PLAY_RAD,
    )


def _without(vessel: VesselConfig, plant: PlantConfig) -> PlantConfig:
    """The plant whose damping ahead is without what `usual_losses` take: the controller's model has it there."""
    told, damping = _told(vessel, plant), plant.hull.damping
    left = max(0.0, told - _lost_ahead(vessel))
    return replace(plant, hull=replace(plant.hull, damping=replace(damping, x_u=left))) if told > 0.0 else plant


def _told(vessel: VesselConfig, plant: PlantConfig) -> float:
    """Linear damping ahead of a model by dimensions, N per m/s, which is thrust that propellers lose. 0 for a hull that
    was measured, or another than the controller's."""
    told = vessel.hull.damping.x_u
    return told if vessel.hull.form is not None and plant.hull.damping.x_u == told else 0.0


def _lost_ahead(vessel: VesselConfig) -> float:
    """What propellers of usual pitch lose ahead, N per m/s, at half thrust."""
    usual_m = _usual_m(vessel)
    return linear([replace(row, propeller_m=row.propeller_m or usual_m) for row in vessel.thrusters])


def _usual_m(vessel: VesselConfig) -> float:
    most_n = max(max(row.max_n, -row.min_n) for row in vessel.thrusters)
    return math.sqrt(4.0 * most_n / (math.pi * _DISC_PA))


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
