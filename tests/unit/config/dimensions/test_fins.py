"""What the blade of a rudder adds to the damping of the hull, and who has it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from companion.config.dimensions.fins import with_fins, without_fins
from companion.config.overlay import overlay_name
from companion.config.vessel import VesselConfig, load
from sitl.hidden_hull import hidden_hull
from tests.unit.rudder_boat import SKIFF, TEXT


def hidden() -> VesselConfig:
    return hidden_hull(8).real  # has a propeller and a rudder


def test_a_blade_that_drifts_is_a_fin_of_the_hull() -> None:
    config = hidden()
    surge_n = config.limits.surge_n
    bare, finned = config.hull.damping, with_fins(config.hull, config.thrusters, surge_n).damping
    x_m = config.thrusters[0].rudder.x_m  # type: ignore[union-attr]
    fin = finned.y_uv - bare.y_uv
    assert fin > 0.0
    assert finned.n_uv - bare.n_uv == pytest.approx(fin * x_m)
    assert finned.n_ur - bare.n_ur == pytest.approx(fin * x_m**2)
    without = tuple(replace(one, rudder=None) for one in config.thrusters)
    assert with_fins(config.hull, without, surge_n) == config.hull


def test_what_the_fins_add_is_taken_off_again() -> None:
    config = hidden()
    damping = without_fins(
        with_fins(config.hull, config.thrusters, config.limits.surge_n), config.thrusters, config.limits.surge_n
    ).damping
    assert (damping.y_uv, damping.n_uv, damping.n_ur) == pytest.approx(
        (config.hull.damping.y_uv, config.hull.damping.n_uv, config.hull.damping.n_ur)
    )


def test_the_companion_counts_on_the_fins_and_the_simulated_boat_has_its_blade_apart(tmp_path: Path) -> None:
    file = tmp_path / "skiff.toml"
    file.write_text(TEXT, encoding="utf-8")
    typed, sailed = SKIFF, load(file)
    assert sailed.hull.damping.n_ur > 1.3 * typed.hull.damping.n_ur
    assert sailed.sitl == typed.sitl and sailed.sitl is not None
    assert sailed.sitl.plants["as_modelled"].hull.damping == typed.hull.damping


def test_a_hull_that_a_trial_found_has_its_fins_already(tmp_path: Path) -> None:
    file = tmp_path / "skiff.toml"
    file.write_text(TEXT, encoding="utf-8")
    trial = "[trial]\naccepted = true\n[hull.damping]\nn_ur = 77.0\n"
    (tmp_path / overlay_name("skiff", "2026-11-26")).write_text(trial, encoding="utf-8")
    assert load(file).hull.damping.n_ur == 77.0
