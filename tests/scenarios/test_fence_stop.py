"""Stops in front of a fence over seeds, judged by raw truth."""

from __future__ import annotations

from pathlib import Path

import pytest

from companion.cli.rig import LockstepRig
from companion.config.vessel import bundled, find
from sitl.scenarios import SCENARIOS
from sitl.scenarios.scenario import run

WAYS = ("heading", "manual", "forces", "mission", "late")


def stop(folder: Path, seed: int, vessel: str | None = None, **changes: str) -> dict[str, float]:
    outcome = run(SCENARIOS["fence_stop"], LockstepRig, folder, seed=seed, vessel=vessel, changes=changes)
    assert outcome.ok, f"{outcome.error or [check.row() for check in outcome.checks if not check.ok]}"
    return dict(outcome.metrics)


@pytest.mark.parametrize(
    ("by", "seed"), [("heading", 5000), ("late", 2), pytest.param("mission", 5005, marks=pytest.mark.sweep)]
)
def test_stops_inside(tmp_path: Path, by: str, seed: int) -> None:
    metrics = stop(tmp_path, seed, by=by, stay="30")
    if by != "late":  # Hold, which a fence across the mission asks for, brakes at once
        assert metrics["middle_short_of_line_m"] < 6.0, "it is slowed down no earlier than it must"


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(16))
@pytest.mark.parametrize("by", WAYS)
def test_stops_inside_sweep(tmp_path: Path, by: str, seed: int) -> None:
    stop(tmp_path, seed, by=by)


@pytest.mark.sweep
@pytest.mark.parametrize("by", ["heading", "forces", "mission"])
@pytest.mark.parametrize("vessel", [name for name in bundled() if name != "sailbot"])  # test_sailing has its fence
def test_every_boat_stops_inside(tmp_path: Path, vessel: str, by: str) -> None:
    stop(tmp_path, 5003, vessel=vessel, by=by)


@pytest.mark.sweep
@pytest.mark.parametrize("by", WAYS)
@pytest.mark.parametrize(
    "change", [{"model_error": "-0.4"}, {"model_error": "0.4"}, {"gnss": "sbas"}, {"current": "0.2@0"}]
)
def test_stops_inside_in_other_conditions(tmp_path: Path, by: str, change: dict[str, str]) -> None:
    stop(tmp_path, 3, by=by, **change)


def test_a_fence_too_small_for_its_margin_is_kept(tmp_path: Path) -> None:
    """A boat without reverse held where it had coasted to, and drifted over the line within its watch circle."""
    text = find("rescuerunner").read_text(encoding="utf-8")
    for line, other in (("DP_WATCH_R = 25.0", "DP_WATCH_R = 44.0"), ("FENCE_MARGIN = 25.0", "FENCE_MARGIN = 50.0")):
        assert text.count(line) == 1
        text = text.replace(line, other)
    path = tmp_path / "wide.toml"
    path.write_text(text, encoding="utf-8")
    stop(tmp_path / "log", 0, vessel=str(path), stay="90")


def test_a_check_can_fail(tmp_path: Path) -> None:
    """No boat stops in so short a way in such a wind: the scenario must say so."""
    changes = {"by": "late", "late": "1", "line": "25", "stay": "20", "wind": "18@180"}
    outcome = run(SCENARIOS["fence_stop"], LockstepRig, tmp_path, seed=0, changes=changes)
    assert not outcome.ok and any(not check.ok and check.name.startswith("the hull") for check in outcome.checks)
