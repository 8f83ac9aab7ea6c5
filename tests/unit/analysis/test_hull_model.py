"""Velocities of an estimate whose heading and antenna are not where the file has them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from companion.analysis.hull_model import ANTENNA, HEADING, HullModel
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
    assert model.imbalance(values) == pytest.approx(ideal.imbalance(ideal.model))
    assert model.turned(model.simulate(values), values) == pytest.approx(ideal.simulate(ideal.model))
