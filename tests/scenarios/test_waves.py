"""Hold in waves, by raw truth: the thrusters leave the to and fro alone, and the place is kept as well or better."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from companion.cli.rig import LockstepRig
from sitl.scenarios import SCENARIOS
from sitl.scenarios.rig import Conditions
from sitl.scenarios.scenario import Settings, run


def hold(folder: Path, seed: int, vessel: str, waves: str, left_alone: bool) -> dict[str, float]:
    def prepare(conditions: Conditions, settings: Settings) -> Conditions:
        changed = endurance.prepare(conditions, settings) if endurance.prepare is not None else conditions
        return replace(changed, parameters={**changed.parameters, "DP_WAVES": float(left_alone)})

    endurance = SCENARIOS["endurance"]
    changes = {"econ": "0", "time": "120", "waves": waves, "gnss": "rtk", "wind": "3", "current": "0.1"}
    outcome = run(replace(endurance, prepare=prepare), LockstepRig, folder, seed=seed, vessel=vessel, changes=changes)
    assert outcome.error is None
    return dict(outcome.metrics)


@pytest.mark.sweep
@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize(
    ("vessel", "waves"), [("aboat", "0.2"), ("revolt", "0.1")]
)  # in which the boat keeps its place
def test_waves_are_left_alone(tmp_path: Path, vessel: str, waves: str, seed: int) -> None:
    answered = hold(tmp_path / "answered", seed, vessel, waves, left_alone=False)
    alone = hold(tmp_path / "alone", seed, vessel, waves, left_alone=True)
    assert alone["variation_percent_ps"] < 0.7 * answered["variation_percent_ps"]
    assert alone["position_rms_m"] < 1.15 * answered["position_rms_m"]
