"""Random boats: what their owner types is a vessel, and the boat is another one."""

from __future__ import annotations

import pytest

from companion.config.vessel import parse
from sitl.hidden_hull import PROPULSIONS, RUDDERS, hidden_hull


@pytest.mark.parametrize("seed", range(3))
def test_what_is_typed_is_a_vessel(seed: int) -> None:
    boat = hidden_hull(seed)
    assert parse(boat.text, "typed") == boat.known
    hull = boat.known.hull
    assert 1.0 <= boat.known.length_m <= 8.0 and hull.mass_kg is not None and 15.0 <= hull.mass_kg <= 2000.0
    assert "m11_kg" not in boat.text and "damping" not in boat.text


def test_the_boat_is_another_one_and_the_same_for_its_seed() -> None:
    boat = hidden_hull(7)
    assert boat == hidden_hull(7) and boat.text != hidden_hull(8).text
    known, real = boat.known, boat.real
    assert known.sitl is not None and real.sitl is not None
    plant = real.sitl.plants[real.sitl.plant]
    assert plant.hull == real.hull and plant.hull != known.hull
    for name in ("x_u", "y_vv", "n_r"):
        off = getattr(real.hull.damping, name) / getattr(known.hull.damping, name)
        assert 0.4 < off < 1.7 and off != 1.0
    assert 0.4 < real.thrusters[0].ahead_n / known.thrusters[0].ahead_n < 1.7


def test_all_propulsions_occur() -> None:
    assert {hidden_hull(seed).propulsion for seed in (0, 1, 2, 4, 105, 8, 11, 20)} == {*PROPULSIONS, *RUDDERS}
