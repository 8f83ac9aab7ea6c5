"""No honest sensor is found to lie, whatever the weather, the receiver and the hull model are."""

from __future__ import annotations

import csv
from pathlib import Path

import pytest

from companion.cli.rig import LockstepRig
from sitl.scenarios import SCENARIOS
from sitl.scenarios.scenario import run

VESSELS = ("aboat", "cybership2", "rescuerunner", "revolt")


@pytest.mark.parametrize(("vessel", "duration"), [("revolt", "100"), ("rescuerunner", "60")])
def test_no_honest_sensor_is_doubted(tmp_path: Path, vessel: str, duration: str) -> None:
    sail(tmp_path, vessel, 0, duration)


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(1, 50))
@pytest.mark.parametrize("vessel", VESSELS)
def test_nor_on_any_other_day(tmp_path: Path, vessel: str, seed: int) -> None:
    sail(tmp_path, vessel, seed)


@pytest.mark.sweep
@pytest.mark.parametrize(("vessel", "seed"), [("aboat", 6018), ("blueboat", 6018), ("otter", 6018), ("otter", 6024)])
def test_a_velocity_that_gets_noisier_is_no_jump(tmp_path: Path, vessel: str, seed: int) -> None:
    sail(tmp_path, vessel, seed - 1000, "600")


def test_a_go_to_that_is_refused_while_the_heading_is_lost_is_asked_for_again(tmp_path: Path) -> None:
    scenario, changes, faults = SCENARIOS["honest_senses"], {"duration": "80"}, ("imu_lost@15+60",)
    outcome = run(scenario, LockstepRig, tmp_path, seed=1002, vessel="blueboat", changes=changes, faults=faults)
    with (tmp_path / "events.csv").open(encoding="utf-8") as file:
        texts = [row["text"] for row in csv.DictReader(file)]
    refused = texts.index("Go-to refused: heading not valid")
    assert outcome.error is None and any(text.startswith("Going to a point") for text in texts[refused:])


def sail(tmp_path: Path, vessel: str, seed: int, duration: str = "150") -> None:
    scenario, changes = SCENARIOS["honest_senses"], {"duration": duration}
    outcome = run(scenario, LockstepRig, tmp_path, seed=1000 + seed, vessel=vessel, changes=changes)
    assert outcome.ok, outcome.error or [check.row() for check in outcome.checks]
