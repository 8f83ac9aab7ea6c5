"""Missions with legs sailed stern first, in lockstep, judged by the truth."""

from __future__ import annotations

from pathlib import Path

import pytest

from companion.cli.rig import LockstepRig
from sitl.scenarios import SCENARIOS
from sitl.scenarios.scenario import run
from tests.scenarios.seeds import seeds

VESSELS = ["revolt", "aboat", "cybership2", "otter", "heron", "blueboat", "wamv16"]


def sail(folder: Path, vessel: str, seed: int, **changes: str) -> dict[str, float]:
    outcome = run(SCENARIOS["stern_first"], LockstepRig, folder, seed=seed, vessel=vessel, changes=changes)
    assert outcome.ok, f"{outcome.error or [check.row() for check in outcome.checks if not check.ok]}"
    return dict(outcome.metrics)


def test_two_propellers_in_a_current(tmp_path: Path) -> None:
    metrics = sail(tmp_path, "otter", 1, current="0.15", side="15")
    assert metrics["speed_astern_mps"] > 0.8 and metrics["cross_track_rms_m"] < 0.3


@pytest.mark.sweep
def test_azimuths_keep_the_legs_as_well_as_bow_first(tmp_path: Path) -> None:
    assert sail(tmp_path, "aboat", 2, current="0.2", wind="3")["cross_track_rms_m"] < 0.1


@pytest.mark.sweep
@pytest.mark.parametrize("seed", seeds(4, 10))
@pytest.mark.parametrize("vessel", VESSELS)
def test_every_vessel_sweep(tmp_path: Path, vessel: str, seed: int) -> None:
    small = vessel == "cybership2"
    sail(tmp_path, vessel, seed, wind="0.5" if small else "2", current="0.03" if small else "0.15")
