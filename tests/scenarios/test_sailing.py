"""A boat under sail: a triangle with a leg dead against the wind and Hold, by raw truth; the vane lost, a fence."""

from __future__ import annotations

from pathlib import Path

import pytest

from companion.cli.rig import LockstepRig
from sitl.scenarios import SCENARIOS
from sitl.scenarios.scenario import ScenarioError, ScenarioResult, run
from tests.unit.config.test_sail import wing, with_motor


def sailed(folder: Path, seed: int, *faults: str, vessel: str = "sailbot", **changes: str) -> ScenarioResult:
    return run(SCENARIOS["sail_triangle"], LockstepRig, folder, seed, vessel, changes, faults=faults)


def bad(outcome: ScenarioResult) -> object:
    return outcome.error or [check.row() for check in outcome.checks if not check.ok] or outcome.margins


def test_it_beats_and_holds_with_a_wrong_model_of_its_sail(tmp_path: Path) -> None:
    outcome = sailed(tmp_path, 200, leg="45", hold="45", model_error="0.2")
    assert outcome.ok, bad(outcome)
    assert outcome.metrics["made_good_mps"] > 0.4


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(201, 205))
def test_it_stays_inside_the_fence_beside_a_beat_and_in_hold(tmp_path: Path, seed: int) -> None:
    outcome = sailed(tmp_path, seed, fence="25", model_error="-0.2")
    assert outcome.ok, bad(outcome)
    assert min(margin.value for margin in outcome.margins if margin.name == "fence") > 0.0


@pytest.mark.sweep
def test_a_wing_sail_beats_and_holds(tmp_path: Path) -> None:
    boat = tmp_path / "wingbot.toml"
    boat.write_text(wing(), encoding="utf-8")
    outcome = sailed(tmp_path / "log", 210, vessel=str(boat), leg="45", hold="45", model_error="-0.2")
    assert outcome.ok, bad(outcome)
    assert outcome.metrics["made_good_mps"] > 0.4


@pytest.mark.sweep
@pytest.mark.parametrize("wind", ["3", "8"])
def test_it_sails_in_light_and_in_strong_wind(tmp_path: Path, wind: str) -> None:
    outcome = sailed(tmp_path, 205, wind=wind)
    assert outcome.ok, bad(outcome)


@pytest.mark.sweep
def test_it_sails_on_by_the_last_wind_while_the_vane_is_lost(tmp_path: Path) -> None:
    outcome = sailed(tmp_path, 206, "wind_unplugged@60+60", hold="31")
    assert outcome.error is None, bad(outcome)
    texts = (tmp_path / "events.csv").read_text(encoding="utf-8")
    assert "Wind vane lost: sails by the last wind" in texts
    assert "Wind vane: back" in texts


def test_a_boat_without_a_sail_is_told_so(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="it needs a sail"):
        sailed(tmp_path, 1, vessel="revolt")


def test_without_wind_a_boat_with_a_motor_goes_round_and_holds_by_it(tmp_path: Path) -> None:
    boat = tmp_path / "motorsailer.toml"
    boat.write_text(with_motor(), encoding="utf-8")
    outcome = sailed(tmp_path / "log", 211, vessel=str(boat), leg="30", hold="50", wind="0.3", current="0.1")
    assert outcome.error is None, bad(outcome)
    assert outcome.metrics["worst_miss_m"] < 6.0, "as near as under sail"
    assert outcome.metrics["hold_off_max_m"] < 15.0, "its watch circle"
    assert all(margin.value >= 0.0 for margin in outcome.margins), bad(outcome)
    assert "By motor: no wind" in (tmp_path / "log" / "events.csv").read_text(encoding="utf-8")
