"""Velocities of an estimate whose heading and antenna are not where the file has them; terms that the file lacks."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from companion.analysis.hull_model import ANTENNA, CANDIDATES, COUPLING, HEADING, HullModel
from companion.analysis.log_reader import Log
from companion.analysis.manoeuvre import Manoeuvre
from companion.config.vessel import find, load

AHEAD_M, STARBOARD_M, ERROR_RAD = 0.4, -0.2, 0.1
LOG = Log(Path(), load(find("revolt")), {})


def turning() -> Manoeuvre:
    """A minute of turns to and fro with way on, by the thrusters' forces of no special meaning."""
    t_s = np.arange(0.0, 60.0, 0.1)
    velocity = np.stack([0.6 + 0.2 * np.sin(0.2 * t_s), 0.1 * np.cos(0.5 * t_s), 0.3 * np.sin(0.3 * t_s)], axis=1)
    force_n = np.stack([10.0 * np.sin(0.1 * t_s)] * 3, axis=1)
    return Manoeuvre(t_s, 0.1 * t_s, velocity, force_n, np.zeros_like(force_n), ((0, len(t_s)),), 0.1)


def mounted() -> tuple[HullModel, dict[str, float]]:
    """A model of the same turns as an estimate sees them that is wrong in heading and lever arm."""
    true = turning()
    values = {**HullModel(LOG, true, mounting=True).model, HEADING: ERROR_RAD}
    values |= dict(zip(ANTENNA, (AHEAD_M, STARBOARD_M), strict=True))
    seen = HullModel(LOG, true, mounting=True).turned(true.velocity, values, back=True)
    yaw_rad = true.yaw_rad + ERROR_RAD
    return HullModel(LOG, replace(true, velocity=seen, yaw_rad=yaw_rad), mounting=True), values


def test_an_antenna_that_is_elsewhere_adds_its_turning_round_the_middle() -> None:
    model = HullModel(LOG, turning(), mounting=True)
    still = {**model.model, ANTENNA[0]: AHEAD_M, ANTENNA[1]: STARBOARD_M}
    seen = model.turned(np.array([[0.0, 0.0, 0.5]]), still, back=True)
    assert seen.tolist()[0] == pytest.approx([-0.5 * STARBOARD_M, 0.5 * AHEAD_M, 0.5])


def test_knowing_heading_and_antenna_gives_the_true_motion_and_balance() -> None:
    model, values = mounted()
    assert model.turned(model.manoeuvre.velocity, values) == pytest.approx(turning().velocity)
    ideal = HullModel(LOG, turning(), mounting=True)
    assert model.imbalance(values) == pytest.approx(ideal.imbalance(ideal.model), abs=1e-4)
    assert model.turned(model.simulate(values), values) == pytest.approx(ideal.simulate(ideal.model), abs=1e-5)


def test_terms_that_the_file_lacks_are_offered_and_have_their_place_in_the_equations() -> None:
    model = HullModel(LOG, turning())
    offered = [name for group in model.candidates for name in group]
    assert COUPLING not in offered  # ReVolt's file has it
    assert set(offered) <= {name for group in CANDIDATES for name in group} and {"n_v", "y_r", "y_uv"} <= set(offered)
    for name in offered:
        values = {**model.model, name: model.doubt(name)}
        assert model.doubt(name) > 0.0 and model.bounds(name)[0] < 0.0 < model.bounds(name)[1]
        assert getattr(model.hull(values).damping, name) == pytest.approx(model.doubt(name))
        assert np.abs(model.imbalance(values) - model.imbalance(model.model)).max() > 1e-3
        # both ways to write the equations
        ideal = HullModel(LOG, replace(turning(), velocity=model.simulate(values)))
        assert np.abs(ideal.imbalance(values)).max() < 0.05


def test_waves_carry_the_hull_without_a_force_and_bring_drift_forces() -> None:
    calm, rough = HullModel(LOG, turning()), HullModel(LOG, replace(turning(), wave_s=2.0))
    assert set(rough.weather) - set(calm.weather) == {
        "aside_north_n",
        "aside_east_n",
        "twist_sine_nm",
        "twist_cosine_nm",
    }
    waves = 0.05 * np.sin(np.pi * turning().t_s)[:, None] * np.array([1.0, 1.0, 0.0])
    carried = HullModel(LOG, replace(turning(), velocity=turning().velocity + waves, wave_s=2.0))
    values = carried.model
    change = carried.imbalance(values) - rough.imbalance(values)
    assert np.abs(change - (waves - waves[0]))[50:-50].max() < 0.02
    pushed = rough.weather_force({**values, "aside_east_n": 3.0, "twist_sine_nm": 2.0}) - rough.weather_force(values)
    yaw = turning().yaw_rad
    assert pushed[:, 1] == pytest.approx(3.0 * np.cos(yaw)) and pushed[:, 0] == pytest.approx(0.0 * yaw)
    assert pushed[:, 2] == pytest.approx(2.0 * np.sin(2.0 * yaw))


@pytest.mark.parametrize("vessel", ["heron", "blueboat"])
def test_a_boat_that_was_weighed_is_no_lighter_in_the_water(vessel: str) -> None:
    """Added mass is never negative. In a dull log mass and thrust can shrink together, and half a boat fits as well."""
    model = HullModel(Log(Path(), load(find(vessel)), {}), turning())
    weighed = model.log.config.hull.mass_kg
    assert model.bounds("m11_kg")[0] == weighed == model.bounds("m22_kg")[0] and weighed < model.model["m11_kg"]
    ours = HullModel(LOG, turning())
    assert ours.bounds("m11_kg")[0] == pytest.approx(0.3 * LOG.config.hull.m11_kg)  # its thrust sets the scale
