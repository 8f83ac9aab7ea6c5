"""A plant that is wrong on purpose: what is changed, by the seed, and what is not."""

from __future__ import annotations

import pytest

from companion.app import load_vessel
from companion.config.vessel import ConfigError
from sitl.plant_error import with_plant_error
from sitl.world import World, WorldConditions


def test_sixteen_seeds_are_all_combinations() -> None:
    vessel = load_vessel("rescuerunner")
    right = vessel.sitl.plants["as_estimated"]  # type: ignore[union-attr]
    found = set()
    for seed in range(16):
        wrong = with_plant_error(vessel, None, 0.3, seed).sitl.plants["as_estimated"]  # type: ignore[union-attr]
        assert wrong.jet is not None and wrong.thruster_x_m is not None
        ratios = (
            wrong.hull.m33_kgm2 / right.hull.m33_kgm2,
            wrong.jet.density_area_kgpm / vessel.thrusters[0].jet.density_area_kgpm,  # type: ignore[union-attr]
            wrong.thruster_x_m[0] / vessel.thrusters[0].x_m,
            wrong.hull.drag_n(8.0) / right.hull.drag_n(8.0),
        )
        assert all(ratio == pytest.approx(0.7) or ratio == pytest.approx(1.3) for ratio in ratios)
        munk = wrong.hull.m22_kg - wrong.hull.m11_kg + wrong.hull.damping.n_uv
        assert munk == pytest.approx(0.0, abs=1e-9), "as directionally stable as before"
        found.add(tuple(round(ratio, 1) for ratio in ratios))
    assert len(found) == 16


def test_the_other_plants_and_the_controller_s_own_model_stay() -> None:
    vessel = load_vessel("rescuerunner")
    wrong = with_plant_error(vessel, "worn", 0.3, 5)
    assert wrong.hull == vessel.hull and wrong.thrusters == vessel.thrusters
    assert wrong.sitl is not None and vessel.sitl is not None
    assert (
        wrong.sitl.plants["as_estimated"] == vessel.sitl.plants["as_estimated"]
        and wrong.sitl.plants["worn"] != vessel.sitl.plants["worn"]
    )
    World(wrong, WorldConditions(plant="worn")).advance(0.1)


def test_what_cannot_be_is_said() -> None:
    with pytest.raises(ConfigError, match="with a jet"):
        with_plant_error(load_vessel("revolt"), None, 0.3, 0)
    with pytest.raises(ConfigError, match="below 1"):
        with_plant_error(load_vessel("rescuerunner"), None, 1.2, 0)
    with pytest.raises(ConfigError, match="no plant named 'new'"):
        with_plant_error(load_vessel("rescuerunner"), "new", 0.2, 0)
