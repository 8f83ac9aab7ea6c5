"""The search on the log of `test_identify`."""

from __future__ import annotations

import numpy as np
import pytest

from companion.analysis.hull_model import HullModel
from companion.analysis.hull_search import Search
from companion.analysis.manoeuvre import read_manoeuvre
from companion.core.progress import Work, tell_nobody
from tests.unit.analysis.test_identify import TRUE, lively, sailed

FREE = ("m11_kg", "x_u", "x_uu")


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> HullModel:
    log = sailed(tmp_path_factory.mktemp("search"), lively(60))
    return HullModel(log, read_manoeuvre(log, []))


def truth(model: HullModel) -> dict[str, float]:
    true = {name: getattr(TRUE, name, getattr(TRUE.damping, name, value)) for name, value in model.model.items()}
    return true | {"lag_s": 0.4, f"x_m {model.groups[0].name}": -1.4, f"x_m {model.groups[1].name}": 1.25}


def work() -> Work:
    return Work(tell_nobody, "", 100.0)


def test_it_goes_down_to_what_was_true(model: HullModel) -> None:
    start = {**truth(model), "m11_kg": 150.0, "x_u": 100.0, "x_uu": 0.0}
    held = {name: "" for name in start if name not in FREE}
    search = Search(model, start, held)
    before = search.surprise
    search.settle(work())
    assert search.surprise < before
    assert {name: value for name, value in search.values.items() if name in held} == {
        name: start[name] for name in held
    }
    assert search.values["m11_kg"] == pytest.approx(TRUE.m11_kg, rel=0.05)
    drag = [0.3 * (values["x_u"] + 0.3 * values["x_uu"]) for values in (search.values, truth(model))]
    assert drag[0] == pytest.approx(drag[1], rel=0.1)
    innovations, slopes = search.innovations()
    assert innovations.shape[1:] == (3,) and slopes.shape == (*innovations.shape, len(FREE))
    assert (innovations**2).mean() == pytest.approx(1.0, abs=0.1)


def test_it_stays_within_the_bounds(model: HullModel) -> None:
    """A boat that is said to be thrice as heavy as it can be."""
    low, high = model.bounds("m11_kg")
    start = {**truth(model), "m11_kg": 5.0 * high}
    search = Search(model, start, {name: "" for name in start if name != "m11_kg"})
    assert search.values["m11_kg"] == pytest.approx(high)
    search.descend(work())
    assert low <= search.values["m11_kg"] <= high


def test_slopes_are_those_of_where_it_is(model: HullModel) -> None:
    start = truth(model)
    search = Search(model, start, {name: "" for name in start if name not in FREE})
    search.descend(work())
    search.renew()
    step = 0.01 * model.doubt("x_u")
    moved = Search(
        model, {**search.values, "x_u": search.values["x_u"] + step}, {n: "" for n in start if n not in FREE}
    )
    change = (moved.left - search.left)[:, 0]
    assert change == pytest.approx(0.01 * search.slopes[:, 0, search.names.index("x_u")], abs=1e-4)
    assert np.abs(change).max() > 1e-4
