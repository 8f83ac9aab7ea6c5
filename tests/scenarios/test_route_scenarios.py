"""ÅBOAT's routes and survey over seeds, judged by raw truth."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from companion.cli.rig import LockstepRig
from sitl.scenarios import SCENARIOS
from sitl.scenarios.scenario import ScenarioResult, run

WINDY = {"wind": "6", "current": "0.3"}
CALM = {"wind": "", "current": ""}
ROUTES = ("1", "2", "3", "4")


def sail(folder: Path, seed: int, name: str = "route", draw: bool = False, **changes: str) -> ScenarioResult:
    outcome = run(SCENARIOS[name], LockstepRig, folder, seed=seed, changes=changes, draw=draw)
    assert outcome.ok, f"{outcome.error or [check.row() for check in outcome.checks if not check.ok]}"
    return outcome


def test_a_route_in_wind_and_current_and_its_picture(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    assert sail(tmp_path, 3, draw=True, route="1", **WINDY).hint == ""
    assert (tmp_path / "route.png").stat().st_size > 20_000


@pytest.mark.sweep
def test_the_thesis_law_is_much_further_off(tmp_path: Path) -> None:
    """What it sailed with stands in the manifest: both laws of that name are the thesis's."""
    metrics = sail(tmp_path, 1, route="2", law="thesis", **WINDY).metrics
    assert metrics["cross_track_rms_m"] > 1.0 and metrics["cross_track_95_m"] > 2.0
    parameters = json.loads((tmp_path / "manifest.json").read_text(encoding="utf-8"))["parameters"]
    assert parameters["WP_LAW"] == 1 and parameters["DP_LAW"] == 1 and parameters["PATH_KIND"] == 0


def test_survey_lines_in_a_current(tmp_path: Path) -> None:
    sail(tmp_path, 0, name="survey", transects="2", gnss="sbas", **WINDY)


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(16))
@pytest.mark.parametrize("gnss", ["rtk", "sbas"])
@pytest.mark.parametrize("weather", [CALM, WINDY], ids=["calm", "windy"])
@pytest.mark.parametrize("route", ROUTES)
def test_sweep_routes(tmp_path: Path, route: str, weather: dict[str, str], gnss: str, seed: int) -> None:
    sail(tmp_path, seed, route=route, gnss=gnss, **weather)


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(16))
def test_sweep_survey(tmp_path: Path, seed: int) -> None:
    sail(tmp_path, seed, name="survey", **WINDY)


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("plant", ["light", "laden"])
@pytest.mark.parametrize("route", ROUTES)
def test_sweep_with_another_load(tmp_path: Path, route: str, plant: str, seed: int) -> None:
    sail(tmp_path, seed, route=route, plant=plant, **WINDY)


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(16))
def test_sweep_hold_by_sbas(tmp_path: Path, seed: int) -> None:
    outcome = run(
        SCENARIOS["hold"],
        LockstepRig,
        tmp_path,
        seed=seed,
        vessel="aboat",
        changes={"gnss": "sbas", "wind": "6", "current": "0.3"},
    )
    assert (
        outcome.error is None and outcome.metrics["position_rms_m"] < 0.9 and outcome.metrics["heading_rms_deg"] < 4.0
    )
