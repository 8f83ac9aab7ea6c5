"""Hold of boats with two fixed thrusters: 600 s in gusts and a current, by raw truth."""

from __future__ import annotations

from pathlib import Path

import pytest

from companion.cli.rig import LockstepRig
from sitl.scenarios import SCENARIOS
from sitl.scenarios.scenario import run


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("vessel", ["blueboat", "heron", "otter", "wamv16"])
def test_a_catamaran_lies_bow_to_the_weather(tmp_path: Path, vessel: str, seed: int) -> None:
    outcome = run(SCENARIOS["bow_hold"], LockstepRig, tmp_path, seed=seed, vessel=vessel)
    assert outcome.ok, [check.row() for check in outcome.checks if not check.ok]


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("vessel", ["blueboat", "heron", "otter", "wamv16"])
def test_a_catamaran_sails_a_square(tmp_path: Path, vessel: str, seed: int) -> None:
    changes = {"side": "60", "limit": "2", "wind": "4", "current": "0.2"}
    outcome = run(SCENARIOS["mission_square"], LockstepRig, tmp_path, seed=seed, vessel=vessel, changes=changes)
    assert outcome.ok, [check.row() for check in outcome.checks if not check.ok]
