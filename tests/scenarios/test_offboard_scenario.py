"""Another computer steers the boat, in lockstep, judged by the plant's record; then it is silent."""

from __future__ import annotations

from pathlib import Path

import pytest

from companion.cli.rig import LockstepRig
from sitl.scenarios import SCENARIOS
from sitl.scenarios.scenario import run


def sail(folder: Path, vessel: str, seed: int, **changes: str) -> None:
    outcome = run(SCENARIOS["offboard"], LockstepRig, folder, seed=seed, vessel=vessel, changes=changes)
    assert outcome.ok, f"{outcome.error or [check.row() for check in outcome.checks if not check.ok]}"


def test_revolt_in_weather(tmp_path: Path) -> None:
    """ÅBOAT sails by MAVSDK's own plugin in tests/protocol."""
    sail(tmp_path, "revolt", 1, wind="2", current="0.1", time="35")


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(16))
@pytest.mark.parametrize("vessel", ["revolt", "aboat", "cybership2", "rescuerunner"])
def test_every_vessel_sweep(tmp_path: Path, vessel: str, seed: int) -> None:
    sail(tmp_path, vessel, seed)


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(16))
def test_revolt_in_weather_sweep(tmp_path: Path, seed: int) -> None:
    sail(tmp_path, "revolt", seed, wind="2", current="0.1")
