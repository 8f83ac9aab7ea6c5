"""What a model predicts of a part of a log that it was not fitted to."""

from __future__ import annotations

from pathlib import Path

import pytest

from companion.analysis.held_out import prediction, split
from companion.analysis.hull_model import HullModel
from companion.analysis.manoeuvre import read_manoeuvre
from tests.unit.analysis.test_identify import lively, sailed


def test_the_lag_of_the_thrusters_speaks_for_no_hull(tmp_path: Path) -> None:
    """No overlay has it. With slow thrusters a hull that was worse than the file's was proposed as far better."""
    log = sailed(tmp_path, lively(60))
    _, held_out = split(read_manoeuvre(log, []), ())
    model = HullModel(log, held_out, mounting=True).model
    found = prediction(log, held_out, model, {**model, "lag_s": 0.4})
    assert found is not None and found.ratio == pytest.approx(1.0)
    worse = prediction(log, held_out, model, {**model, "lag_s": 0.4, "m33_kgm2": 2.0 * model["m33_kgm2"]})
    assert worse is not None and worse.ratio > 1.0
