"""Hold in waves, by raw truth: what drift costs, and that waves to and fro cost little."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from companion.cli.rig import LockstepRig
from companion.config.vessel import find, load
from companion.core.angles import wrap_pi
from docs.generate.wave_balance import FROM_BEAM, mean_drift, static_height_m
from sitl.scenarios import SCENARIOS
from sitl.scenarios.rig import Conditions
from sitl.scenarios.scenario import ScenarioError, run


def sail(folder: Path, seed: int, vessel: str = "revolt", **changes: str) -> dict[str, float]:
    outcome = run(SCENARIOS["wave_hold"], LockstepRig, folder, seed=seed, vessel=vessel, changes=changes)
    assert outcome.error is None, outcome.error
    return dict(outcome.metrics)


def test_the_thrusters_carry_the_mean_drift(tmp_path: Path) -> None:
    metrics = sail(tmp_path, 1, waves="0.1@90", time="40")
    drift = mean_drift(load(find("revolt")), "0.1", FROM_BEAM, 1)
    assert metrics["used_n"] == pytest.approx(abs(drift[1]), rel=0.5)  # groups of waves pass in so short a time
    assert metrics["slow_max_m"] < 0.5


def test_a_sea_that_makes_no_sense_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="so steep they break"):
        sail(tmp_path, 1, waves="0.5@90/1")
    with pytest.raises(ScenarioError, match="or bow"):
        sail(tmp_path, 1, heading="abeam")


@pytest.mark.parametrize(("heading", "from_deg"), [("beam", 90.0), ("port", -90.0), ("bow", 0.0)])
def test_the_sea_comes_from_the_side_that_is_asked_for(heading: str, from_deg: float) -> None:
    scenario = SCENARIOS["wave_hold"]
    assert scenario.prepare is not None
    settings = {**scenario.defaults, "waves": "0.1@70", "heading": heading}
    start = scenario.prepare(Conditions("revolt"), settings).start
    assert start is not None and math.degrees(wrap_pi(math.radians(70.0) - start[2])) == pytest.approx(from_deg)


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(4))
def test_without_drift_waves_cost_little(tmp_path: Path, seed: int) -> None:
    metrics = sail(tmp_path, seed, waves="0.1@90", drift="off")
    assert metrics["used_n"] < 0.5 and metrics["slow_rms_m"] < 0.05


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(4))
def test_it_keeps_its_place_below_half_of_the_static_balance(tmp_path: Path, seed: int) -> None:
    height_m = 0.5 * static_height_m("revolt", FROM_BEAM)
    metrics = sail(tmp_path, seed, waves=f"{height_m:.3f}@90")
    assert metrics["kept"] == 1.0 and metrics["slow_rms_m"] < 0.3
