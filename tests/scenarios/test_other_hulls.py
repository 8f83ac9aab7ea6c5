"""The controller with its own model on hulls that move by other equations, by raw truth."""

from __future__ import annotations

from pathlib import Path

import pytest

from companion.cli.rig import LockstepRig
from sitl.scenarios import SCENARIOS
from sitl.scenarios.scenario import run

SQUARE = {"side": "60", "limit": "2", "wind": "4", "current": "0.2"}


def sail(name: str, vessel: str, folder: Path, seed: int, **changes: str) -> dict[str, float]:
    outcome = run(SCENARIOS[name], LockstepRig, folder, seed=seed, vessel=vessel, changes=changes)
    assert outcome.ok, (outcome.error, [check.row() for check in outcome.checks if not check.ok])
    events = next(folder.rglob("events.csv")).read_text(encoding="utf-8")
    assert "sense_distrusted" not in events, "honest sensors are doubted"
    return dict(outcome.metrics)


def test_aboat_sails_its_square_on_a_hull_with_lift(tmp_path: Path) -> None:
    metrics = sail("mission_square", "aboat", tmp_path, 0, plant="slender", side="16")
    assert metrics["cross_track_rms_m"] < 0.4


def test_the_published_otter_sails_a_square(tmp_path: Path) -> None:
    metrics = sail("mission_square", "otter", tmp_path, 0, plant="published", side="20", limit="2")
    assert metrics["cross_track_rms_m"] < 0.6


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("plant", ["strips", "published", "mended", "published_2023"])
def test_another_otter_lies_bow_to_the_weather(tmp_path: Path, plant: str, seed: int) -> None:
    sail("bow_hold", "otter", tmp_path, seed, plant=plant)


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("plant", ["strips", "published", "mended", "published_2023"])
def test_another_otter_sails_a_square_in_wind_and_current(tmp_path: Path, plant: str, seed: int) -> None:
    sail("mission_square", "otter", tmp_path, seed, plant=plant, **SQUARE)


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("vessel", ["revolt", "aboat"])
def test_hold_and_square_on_hulls_with_lift(tmp_path: Path, vessel: str, seed: int) -> None:
    sail("hold", vessel, tmp_path / "hold", seed, plant="slender", gnss="rtk")
    sail("mission_square", vessel, tmp_path / "square", seed, plant="slender")


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(4))
def test_a_route_on_a_hull_with_lift(tmp_path: Path, seed: int) -> None:
    sail("route", "aboat", tmp_path, seed, plant="slender", route="1")
