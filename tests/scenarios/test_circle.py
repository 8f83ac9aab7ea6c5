"""Orbits in lockstep, as ground stations command them, judged by the plant's record."""

from __future__ import annotations

from pathlib import Path

import pytest

from companion.cli.rig import LockstepRig
from sitl.scenarios import SCENARIOS
from sitl.scenarios.scenario import run
from tests.scenarios.seeds import seeds

VESSELS = ["revolt", "aboat", "cybership2", "rescuerunner"]


def sail(folder: Path, vessel: str, seed: int, **changes: str) -> dict[str, float]:
    outcome = run(SCENARIOS["circle"], LockstepRig, folder, seed=seed, vessel=vessel, changes=changes)
    assert outcome.ok, f"{outcome.error or [check.row() for check in outcome.checks if not check.ok]}"
    return dict(outcome.metrics)


def test_aboat_in_a_current(tmp_path: Path) -> None:
    metrics = sail(tmp_path, "aboat", 1, current="0.3", gnss="rtk", turns="0.75")
    assert metrics["radius_rms_m"] < 0.06 and metrics["radius_max_m"] < 0.15


@pytest.mark.sweep
def test_revolt_counter_clockwise(tmp_path: Path) -> None:
    assert sail(tmp_path, "revolt", 2, current="0.1", direction="ccw", turns="2")["radius_rms_m"] < 0.05


@pytest.mark.sweep
def test_a_jet(tmp_path: Path) -> None:
    assert sail(tmp_path, "rescuerunner", 3, turns="2", gnss="rtk")["radius_rms_m"] < 0.3


@pytest.mark.sweep
@pytest.mark.parametrize("seed", seeds(4, 10))
@pytest.mark.parametrize("direction", ["cw", "ccw"])
@pytest.mark.parametrize("vessel", VESSELS)
def test_every_vessel_sweep(tmp_path: Path, vessel: str, direction: str, seed: int) -> None:
    sail(tmp_path, vessel, seed, direction=direction)


@pytest.mark.sweep
@pytest.mark.parametrize("seed", seeds(4, 10))
@pytest.mark.parametrize(("vessel", "current"), [("revolt", "0.1"), ("aboat", "0.3"), ("rescuerunner", "0.5")])
def test_in_a_current_sweep(tmp_path: Path, vessel: str, current: str, seed: int) -> None:
    sail(tmp_path, vessel, seed, current=current)
