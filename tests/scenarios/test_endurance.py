"""Hold for endurance, by raw truth: less thrust inside the circle, and the bow in the weather where it is free."""

from __future__ import annotations

from pathlib import Path

import pytest

from companion.cli.rig import LockstepRig
from sitl.scenarios import SCENARIOS
from sitl.scenarios.measure import receiver_error_m
from sitl.scenarios.scenario import run


def sail(folder: Path, seed: int, vessel: str, **changes: str) -> dict[str, float]:
    outcome = run(SCENARIOS["endurance"], LockstepRig, folder, seed=seed, vessel=vessel, changes=changes)
    assert outcome.ok, f"{outcome.error or [check.row() for check in outcome.checks if not check.ok]}"
    return dict(outcome.metrics)


def test_a_circle_is_kept(tmp_path: Path) -> None:
    metrics = sail(tmp_path, 3, "aboat", econ="1", time="60")
    assert metrics["variation_percent_ps"] < 0.6


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize(("vessel", "share"), [("aboat", 0.9), ("revolt", 0.4)])
def test_the_circle_quiets_the_thrusters_and_costs_no_energy(
    tmp_path: Path, vessel: str, share: float, seed: int
) -> None:
    """ÅBOAT's thrusters vary little without it."""
    whole = sail(tmp_path / "whole", seed, vessel, econ="0")
    soft = sail(tmp_path / "soft", seed, vessel, econ="1")
    assert soft["variation_percent_ps"] < share * whole["variation_percent_ps"]
    assert soft["power_percent"] < 1.03 * whole["power_percent"]


@pytest.mark.sweep
@pytest.mark.parametrize("vessel", ["aboat", "revolt"])
def test_a_free_heading_saves_energy(tmp_path: Path, vessel: str) -> None:
    held = sail(tmp_path / "held", 4, vessel, econ="0", time="300", wind="4@90", current="")
    free = sail(tmp_path / "free", 4, vessel, econ="0", time="300", wind="4@90", current="", heading="free")
    assert free["power_percent"] < 0.4 * held["power_percent"]


def test_the_circle_allows_for_the_slow_error_of_a_receiver_without_corrections(tmp_path: Path) -> None:
    limits = {}
    for gnss in ("rtk", "sbas"):
        outcome = run(
            SCENARIOS["endurance"], LockstepRig, tmp_path / gnss, seed=1, vessel="revolt",
            changes={"time": "1", "wind": "1", "gnss": gnss},
        )  # fmt: skip
        limits[gnss] = outcome.checks[0].limit
    assert limits["sbas"] == limits["rtk"] + receiver_error_m("sbas")
