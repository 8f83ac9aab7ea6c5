"""Heading by a magnetometer alone through the whole vessel: bytes, drivers, estimator."""

from __future__ import annotations

from pathlib import Path

import pytest

from companion.analysis.log_reader import open_log
from companion.analysis.replay import replay
from companion.cli.rig import LockstepRig
from sitl.scenarios import SCENARIOS
from sitl.scenarios.rig import Conditions
from sitl.scenarios.scenario import ScenarioError, ScenarioResult, run
from sitl.tow import TowLeg
from tests.unit.nav.test_ahrs import follow, sailing_of


def sail(folder: Path, seed: int, vessel: str | None = None, **changes: str) -> ScenarioResult:
    return run(SCENARIOS["ahrs"], LockstepRig, folder, seed=seed, vessel=vessel, changes=changes)


def test_heading_in_turns_and_waves(tmp_path: Path) -> None:
    outcome = sail(tmp_path, 5, "aboat")
    assert outcome.ok, [check.row() for check in outcome.checks if not check.ok]


@pytest.mark.sweep
def test_the_accuracy_stated_is_that_of_the_errors(tmp_path: Path) -> None:
    """Seven independent errors a run: over 16 runs chi-square of 112, 95 % of which is 0.76 to 1.28."""
    outcomes = [sail(tmp_path / str(seed), seed) for seed in range(16)]
    failed = [(seed, check.row()) for seed, outcome in enumerate(outcomes) for check in outcome.checks if not check.ok]
    assert not failed
    nees = [outcome.metrics["heading_nees"] for outcome in outcomes]
    assert 0.76 < sum(nees) / len(nees) < 1.28, nees


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(16))
def test_the_filter_alone(seed: int) -> None:
    """At 200 Hz, in motion that knows no plant: 8 m/s, turns of 0.3 g, waves of 2° and 5°."""
    judged = follow(sailing_of(seed)).judged()
    assert judged.mean() < 1.0 and judged.max() < 3.0


def test_a_replay_says_the_same_to_the_last_bit(tmp_path: Path) -> None:
    rig = LockstepRig(
        Conditions(
            "revolt", seed=3, wind="2", magnetometer="calibrated", tow=(TowLeg(5.0, 0.0), TowLeg(15.0, 6.0, 0.2))
        ),
        tmp_path,
    )
    while rig.now_s < 20.0:
        rig.step()
    rig.close()
    result = replay(open_log(tmp_path), tmp_path / "replay.csv")
    assert not result.warnings and result.largest_in_log() == 0.0


@pytest.mark.sweep
def test_the_thesis_loses_it(tmp_path: Path) -> None:
    thesis, own = (sail(tmp_path / each, 0, ahrs=each).metrics for each in ("thesis", "companion"))
    assert thesis["heading_error_max_deg"] > 8.0 > 4.0 * own["heading_error_max_deg"]
    assert thesis["heading_error_mean_deg"] > 5.0 * own["heading_error_mean_deg"]


@pytest.mark.sweep
def test_uncalibrated_iron_is_no_compass(tmp_path: Path) -> None:
    """Motion holds the heading against it; the errors are about twice those of a calibrated one."""
    raw, calibrated = (sail(tmp_path / each, 1, magnetometer=each).metrics for each in ("raw", "calibrated"))
    assert raw["heading_error_max_deg"] > 1.7 * calibrated["heading_error_max_deg"]
    assert raw["heading_error_mean_deg"] > 1.7 * calibrated["heading_error_mean_deg"]


def test_an_unknown_word_is_said(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="calibrated, raw"):
        sail(tmp_path, 0, magnetometer="golden")
