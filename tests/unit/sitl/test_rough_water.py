"""Rough water: what it switches on, and how wind and waves go together."""

from __future__ import annotations

import math
import statistics
from dataclasses import replace

import pytest

from companion.config.rough_water import RoughWaterConfig
from companion.config.vessel import ConfigError, bundled, find, load, parse
from sitl.environment import Waves
from sitl.rough_water import is_rough, plant_name, rough_plant, usual_losses, wind_sea
from sitl.sea import Sea
from sitl.world import World, WorldConditions, chosen_plant

REVOLT = load(find("revolt"))
ROUGH = WorldConditions(water="rough", wind="4@90")


def test_the_sea_of_a_wind_over_a_fetch() -> None:
    """The formulae written out, at 8 m/s over 5 km; the fully developed sea of any longer fetch."""
    state = wind_sea(8.0, 5000.0)
    assert state is not None
    fetch = 9.81 * 5000.0 / 64.0
    assert state.height_m == pytest.approx(0.0016 * fetch**0.5 * 64.0 / 9.81)
    assert state.peak_s == pytest.approx(0.286 * fetch ** (1.0 / 3.0) * 8.0 / 9.81)
    grown = wind_sea(8.0, 1.0e7)
    assert grown is not None and grown == wind_sea(8.0, 2.0e7)
    assert grown.height_m == pytest.approx(0.243 * 64.0 / 9.81)


def test_such_a_sea_does_not_break_and_a_breath_of_wind_raises_none() -> None:
    for wind_mps in (0.5, 2.0, 8.0, 20.0):
        for fetch_m in (100.0, 1000.0, 20_000.0):
            state = wind_sea(wind_mps, fetch_m)
            if state is not None:
                assert state.height_m < 9.81 * state.peak_s**2 / math.tau / 7.0
    assert wind_sea(0.0, 1000.0) is None and wind_sea(0.2, 1000.0) is None


@pytest.mark.parametrize("name", bundled())
def test_every_bundled_boat_has_rough_water(name: str) -> None:
    vessel = load(find(name))
    assert vessel.sitl is not None
    plant = rough_plant(vessel, chosen_plant(vessel, None, True), vessel.sitl.rough)
    assert plant.losses is not None and plant.sensor_errors is not None and plant.wind_centre_m is not None
    world = World(vessel, ROUGH)
    world.advance(0.5)
    assert isinstance(world.waves, Sea)


def test_rough_water_takes_the_files_plant_for_it_unless_another_is_asked_for() -> None:
    sitl = REVOLT.sitl
    assert sitl is not None
    assert plant_name(sitl, None, False) == "as_sailed" and plant_name(sitl, None, True) == "slender"
    assert plant_name(sitl, "thesis", True) == "thesis"
    assert plant_name(replace(sitl, plants={"as_sailed": sitl.plants["as_sailed"]}), None, True) == "as_sailed"


def test_what_a_plant_has_of_its_own_stays() -> None:
    plant = chosen_plant(REVOLT, None)
    losses = replace(usual_losses(REVOLT, plant), deduction=0.2)
    made = rough_plant(REVOLT, replace(plant, losses=losses, wind_centre_m=(0.3, 0.4)), RoughWaterConfig())
    assert made.losses == losses and made.wind_centre_m == (0.3, 0.4)
    assert rough_plant(REVOLT, plant, RoughWaterConfig(losses=losses)).losses == losses


@pytest.mark.parametrize("name", ["heron", "wamv16"])
def test_what_propellers_lose_ahead_counts_once(name: str) -> None:
    """A model made by dimensions has it in its damping. Counted by the losses again, boats that plane reached a quarter
    of their speed in rough water, and others 0.8 of it."""
    vessel = load(find(name))
    assert vessel.sitl is not None
    speeds = []
    for water in ("usual", "rough"):
        world = World(vessel, WorldConditions(water=water, waves="0" if water == "rough" else None))
        for k in range(1, 401):
            for thruster in world.thrusters:
                thruster.dead = False
                thruster.demand(0.7, 0.0)
            world.advance(0.1 * k)
        speeds.append(math.hypot(world.truth.surge_mps, world.truth.sway_mps))
    assert 0.9 * speeds[0] < speeds[1] < 1.02 * speeds[0]


def test_a_measured_hull_keeps_its_damping() -> None:
    for name in ("revolt", "cybership2", "aboat", "otter"):
        vessel = load(find(name))
        assert vessel.sitl is not None
        plant = chosen_plant(vessel, None, True)
        assert rough_plant(vessel, plant, vessel.sitl.rough).hull == plant.hull


def test_usual_water_is_as_before() -> None:
    world = World(REVOLT, WorldConditions(wind="4@90"))
    assert type(world.waves) is Waves and world.wind.mean_mps == 4.0
    assert World(REVOLT, WorldConditions(wind="4@90", water="usual")).truth == world.truth


def test_the_mean_wind_at_the_boat_is_the_same_in_both_waters() -> None:
    assert World(REVOLT, ROUGH).wind.mean_mps == 4.0
    world = World(REVOLT, replace(ROUGH, wind="4@90/npd"))
    assert world.wind.mean_mps < 3.5  # named by its mean at 10 m, as ever with a spectrum


def drift_n(conditions: WorldConditions) -> float:
    """Sway force of the sea on the boat at rest, beam on: none where there is no sea state."""
    waves = World(REVOLT, conditions).waves
    if not isinstance(waves, Sea):
        return 0.0
    total = 0.0
    for k in range(1, 400):
        waves.update(0.05 * k)
        total += waves.force()[1] / 399.0
    return total


def test_waves_come_with_the_wind_unless_they_are_set() -> None:
    beam = replace(ROUGH, wind="4@90", waves=None)
    assert drift_n(beam) < -2.0  # to port, as the wind from starboard
    assert drift_n(replace(beam, wind="1@90")) > 0.5 * drift_n(beam)
    assert drift_n(replace(beam, waves="0")) == 0.0
    assert drift_n(replace(beam, wind=None)) == 0.0
    assert drift_n(replace(beam, waves="0.1@270")) > 2.0


def test_the_current_turns() -> None:
    """In an hour, by about the share that the file says; in usual water it stays as it is."""
    for water, least, most in (("usual", 0.0, 0.0), ("rough", math.radians(5.0), math.radians(20.0))):
        current = World(REVOLT, WorldConditions(water=water, current="0.2@90")).current
        turned = []
        for _ in range(60):
            current.update(60.0)
            turned.append(math.atan2(current.north_mps, current.east_mps))
        assert least <= statistics.pstdev(turned) <= most


def test_wind_areas_differ_from_the_file_by_the_seed() -> None:
    found = {seed: World(REVOLT, replace(ROUGH, seed=seed)) for seed in range(6)}
    ratios = {round(world.plant.windage.lateral_m2 / 1.2, 6) for world in found.values()}
    assert ratios == {0.8, 1.2}


def test_the_file_can_ask_for_it_and_the_run_has_the_last_word() -> None:
    text = (
        find("revolt")
        .read_text(encoding="utf-8")
        .replace('plant = "as_sailed"', 'plant = "as_sailed"\nwater = "rough"')
    )
    vessel = parse(text, "revolt.toml")
    assert isinstance(World(vessel, replace(ROUGH, water=None)).waves, Sea)
    assert not isinstance(World(vessel, replace(ROUGH, water="usual")).waves, Sea)


def test_unknown_water_and_plants_are_refused() -> None:
    assert REVOLT.sitl is not None
    with pytest.raises(ConfigError, match="water 'ruff': usual or rough"):
        is_rough("ruff", REVOLT.sitl)
    text = find("revolt").read_text(encoding="utf-8").replace('plant = "slender"', 'plant = "slim"')
    with pytest.raises(ConfigError, match=r"rough\.plant: no plant named 'slim'"):
        parse(text, "revolt.toml")
