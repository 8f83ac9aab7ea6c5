"""A jet boat that differs from its file: mass, thrust, nozzle and drag wrong, each up or down by the seed."""

from __future__ import annotations

from dataclasses import replace

from companion.config.vessel import ConfigError, PlantConfig, VesselConfig
from sitl.noise import stream

_MASS, _THRUST, _NOZZLE, _DRAG = range(4)


def with_plant_error(vessel: VesselConfig, plant: str | None, fraction: float, seed: int) -> VesselConfig:
    """The same vessel, whose plant of that name (None: the file's choice) is wrong by `fraction`.

    The lowest four bits of the seed say which of mass, thrust, nozzle and drag are up (0) or down (1): 16 seeds in a
    row are all combinations. Mass: inertia with added mass, and what cancels the Munk moment. Thrust: of the jet at any
    throttle. Nozzle: the moment at a given angle. Drag: resistance and damping.

    Raises ConfigError for a vessel without a jet or plant, or a fraction outside 0 to 1.
    """
    simulation, jet = vessel.sitl, vessel.thrusters[0].jet
    if simulation is None or jet is None:
        raise ConfigError([f"{vessel.name}: plant_error is for a simulated vessel with a jet"])
    if not 0.0 <= fraction < 1.0:
        raise ConfigError([f"plant_error {fraction:g}: must be a share from 0 to below 1"])
    name = simulation.plant if plant is None else plant
    if name not in simulation.plants:
        raise ConfigError([f"{vessel.name}: no plant named '{name}'; there is {', '.join(simulation.plants)}"])
    factor = [1.0 - fraction if seed >> bit & 1 else 1.0 + fraction for bit in range(4)]
    right = simulation.plants[name]
    real = right.jet or jet
    lever_m = vessel.thrusters[0].x_m if right.thruster_x_m is None else right.thruster_x_m[0]
    wrong = replace(
        _hull(right, factor[_MASS], factor[_DRAG]),
        jet=replace(real, density_area_kgpm=real.density_area_kgpm * factor[_THRUST]),
        thruster_x_m=(lever_m * factor[_NOZZLE],),
    )
    return replace(vessel, sitl=replace(simulation, plants={**simulation.plants, name: wrong}))


def with_wrong_windage(plant: PlantConfig, fraction: float, seed: int) -> PlantConfig:
    """The same plant with wind areas wrong by `fraction`, frontal and lateral each up or down by the seed. Raises
    ConfigError for a fraction outside 0 to 1."""
    if not 0.0 <= fraction < 1.0:
        raise ConfigError([f"windage_error {fraction:g}: must be a share from 0 to below 1"])
    right, signs = plant.windage, stream(seed, "windage").choices((-1.0, 1.0), k=2)
    windage = replace(
        right,
        frontal_m2=right.frontal_m2 * (1.0 + signs[0] * fraction),
        lateral_m2=right.lateral_m2 * (1.0 + signs[1] * fraction),
    )
    return replace(plant, windage=windage)


def _hull(plant: PlantConfig, mass: float, drag: float) -> PlantConfig:
    hull, damping = plant.hull, plant.hull.damping
    damped = replace(damping, **{name: getattr(damping, name) * drag for name in damping.__slots__})
    return replace(
        plant,
        hull=replace(
            hull,
            m11_kg=hull.m11_kg * mass,
            m22_kg=hull.m22_kg * mass,
            m33_kgm2=hull.m33_kgm2 * mass,
            damping=replace(damped, n_uv=damping.n_uv * mass),
            resistance=tuple((speed_mps, force_n * drag) for speed_mps, force_n in hull.resistance),
        ),
    )
