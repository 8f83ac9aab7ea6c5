"""Hold from full speed, judged by raw truth: a boat brakes and holds about where it stops."""

from __future__ import annotations

from pathlib import Path

import pytest

from companion.cli.rig import LockstepRig
from companion.config.vessel import bundled
from sitl.scenarios import SCENARIOS
from sitl.scenarios.scenario import run


def stop(folder: Path, seed: int, vessel: str, **changes: str) -> dict[str, float]:
    outcome = run(SCENARIOS["full_stop"], LockstepRig, folder, seed=seed, vessel=vessel, changes=changes)
    assert outcome.ok, f"{outcome.error or [check.row() for check in outcome.checks if not check.ok]}"
    return dict(outcome.metrics)


def test_two_motors_stop_within_lengths(tmp_path: Path) -> None:
    metrics = stop(tmp_path, 1, "otter", run="20", time="20")
    assert metrics["way_m"] < 6.0, "three lengths"


@pytest.mark.parametrize("vessel", ["revolt", "aboat"])
def test_pods_stop_a_boat_as_hard(tmp_path: Path, vessel: str) -> None:
    """The reference of positioning took 12 m from 1 m/s, and 16 m from 1.6 m/s."""
    metrics = stop(tmp_path, 1, vessel, run="25", time="15")
    assert metrics["way_m"] < 4.0


def test_a_jet_holds_where_it_has_coasted_to(tmp_path: Path) -> None:
    """It has no way astern: it coasts, and does not creep on to a point planned ahead."""
    stop(tmp_path, 1, "rescuerunner", by="silence", run="10", time="5")


@pytest.mark.sweep
@pytest.mark.parametrize("by", ["hold", "silence"])
@pytest.mark.parametrize("vessel", [name for name in bundled() if name != "sailbot"])
@pytest.mark.parametrize("seed", range(3))
def test_every_boat_with_motors_stops(tmp_path: Path, vessel: str, by: str, seed: int) -> None:
    stop(tmp_path, seed, vessel, by=by, wind="5")
