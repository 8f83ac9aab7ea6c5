"""Hidden hulls that have, or lack, terms beside those of their file."""

from __future__ import annotations

import pytest

from companion.config.vessel import AS_MODELLED
from sitl.hidden_hull import HiddenHull, hidden_hull
from sitl.hidden_structure import structure_of, structured_hull, water_of

SEEDS = range(100, 140)
CROSS = ("y_vv", "n_rr", "n_vv", "y_rr")
LIFT = ("y_uv", "n_uv", "n_ur")


def first(has: str, value: bool) -> HiddenHull:
    return structured_hull(next(seed for seed in SEEDS if getattr(structure_of(seed), has) is value))


def test_the_same_seed_is_the_same_boat_and_its_file_stays() -> None:
    assert structured_hull(107) == structured_hull(107) and water_of(hidden_hull(107)) == water_of(hidden_hull(107))
    assert structured_hull(107).known.hull == hidden_hull(107).known.hull


@pytest.mark.parametrize("has", ["coupled", "lift", "strips", "wind_sensor"])
def test_some_boats_have_each_and_some_have_not(has: str) -> None:
    share = sum(getattr(structure_of(seed), has) for seed in SEEDS) / len(SEEDS)
    assert 0.1 < share < 0.9


def test_strips_stand_in_place_of_the_quadratic_terms() -> None:
    boat = first("strips", True)
    assert boat.real.sitl is not None
    plant = boat.real.sitl.plants[AS_MODELLED]
    assert plant.cross_flow is not None and plant.hull == boat.real.hull
    assert all(getattr(boat.real.hull.damping, name) == 0.0 for name in CROSS)


def test_lift_and_coupling() -> None:
    without, coupled = first("lift", False).real.hull, first("coupled", True).real.hull
    assert all(getattr(without.damping, name) == 0.0 for name in LIFT)
    assert coupled.m23_kgm != 0.0 and coupled.damping.n_v != 0.0
    assert coupled.m22_kg * coupled.m33_kgm2 > coupled.m23_kgm**2


def test_the_water_is_that_of_a_small_boat() -> None:
    waters = [(hidden_hull(seed), water_of(hidden_hull(seed))) for seed in SEEDS]
    assert 0.3 < sum(bool(water.waves) for _, water in waters) / len(waters) < 0.7
    for boat, water in waters:
        assert 0.0 <= water.current_share <= 0.3
        assert not water.waves or 0.01 <= float(water.waves) / boat.known.length_m <= 0.051
