"""Boats without a compass: the heading is found by their motion, and Hold goes by it; judged by the plant's record."""

from __future__ import annotations

from pathlib import Path

import pytest

from companion.cli.rig import LockstepRig
from sitl.scenarios import SCENARIOS
from sitl.scenarios.scenario import run
from tests.scenarios.seeds import seeds

VESSELS = ["revolt", "otter", "rescuerunner", "blueboat", "aboat", "wamv16", "heron"]


def sail(folder: Path, vessel: str, seed: int, **changes: str) -> dict[str, float]:
    outcome = run(SCENARIOS["no_compass"], LockstepRig, folder, seed=seed, vessel=vessel, changes=changes)
    assert outcome.ok, f"{outcome.error or [check.row() for check in outcome.checks if not check.ok]}"
    return dict(outcome.metrics)


def test_a_push_in_calm_water(tmp_path: Path) -> None:
    assert sail(tmp_path, "revolt", 2, rest="5", hold="30")["pushed_s"] < 20.0


def test_waves_are_enough(tmp_path: Path) -> None:
    assert sail(tmp_path, "otter", 3, rest="40", hold="20", waves="0.2@90", wind="4")["pushed_s"] < 0.5


@pytest.mark.sweep
@pytest.mark.parametrize("seed", seeds(4, 10))
@pytest.mark.parametrize("gnss", ["rtk", "standalone"])
@pytest.mark.parametrize("vessel", VESSELS)
def test_every_vessel_sweep(tmp_path: Path, vessel: str, gnss: str, seed: int) -> None:
    assert sail(tmp_path, vessel, seed, gnss=gnss, wind="4")["first_error_deg"] < 15.0
