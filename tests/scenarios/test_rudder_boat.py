"""Boats with rudders: missions and Hold in wind and current, by raw truth."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from companion.cli.new_file import file_text
from companion.cli.rig import LockstepRig
from sitl.scenarios import SCENARIOS
from sitl.scenarios.scenario import ScenarioResult, run
from tests.unit.rudder_boat import ANSWERS, SHIP_TEXT, SKIFF, TEXT

SCREWS = file_text(replace(ANSWERS, layout="two-rudders", spread_m=0.4))


def sailed(name: str, folder: Path, seed: int, text: str = TEXT, **changes: str) -> ScenarioResult:
    file = folder / "skiff.toml"
    file.write_text(text, encoding="utf-8")
    return run(SCENARIOS[name], LockstepRig, folder / "log", seed=seed, vessel=str(file), changes=changes)


def test_it_sails_a_square_in_wind_and_current(tmp_path: Path) -> None:
    outcome = sailed("mission_square", tmp_path, 7, side="20", limit="0.5", wind="4", current="0.15")
    assert outcome.ok, [check.row() for check in outcome.checks if not check.ok]


@pytest.mark.sweep
@pytest.mark.parametrize("seed", range(4))
def test_it_holds_within_its_alarm_circle_without_circling(tmp_path: Path, seed: int) -> None:
    metrics = sailed("bow_hold", tmp_path, seed, wind="4", current="0.2").metrics
    assert metrics["radius_95_m"] < SKIFF.parameters["DP_ALARM_R"]
    assert metrics["radius_max_m"] < 1.5 * SKIFF.parameters["DP_ALARM_R"]
    assert metrics["turns"] < 1.5


@pytest.mark.sweep
@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("follow", {"leader": "straight@0.9", "gnss": "sbas", "wind": "2", "gap": "15"}),
        ("follow", {"leader": "slalom@1.0", "gnss": "rtk"}),
        ("circle", {"wind": "2"}),
        ("gnss_dropout", {}),
        ("offboard", {}),
    ],
)
def test_it_does_what_other_boats_do(tmp_path: Path, name: str, changes: dict[str, str]) -> None:
    outcome = sailed(name, tmp_path, 2, **changes)
    assert outcome.ok, outcome.error or [check.row() for check in outcome.checks if not check.ok]


@pytest.mark.sweep
@pytest.mark.parametrize("by", ["heading", "manual"])
def test_it_stays_inside_the_fence(tmp_path: Path, by: str) -> None:
    """It does not lie still afterwards as the scenario asks of others: it sails about in its watch circle."""
    metrics = sailed("fence_stop", tmp_path, 2, by=by).metrics
    assert metrics["hull_short_of_line_m"] > 0.0 and metrics["breaches"] == 0.0


def test_two_screws_with_rudders_sail_a_square(tmp_path: Path) -> None:
    outcome = sailed("mission_square", tmp_path, 8, SCREWS, side="20", limit="0.5", wind="4", current="0.15")
    assert outcome.ok, [check.row() for check in outcome.checks if not check.ok]


def test_a_ship_with_rudder_and_side_thrusters_holds_point_and_heading(tmp_path: Path) -> None:
    outcome = sailed("hold", tmp_path, 9, SHIP_TEXT, time="60", wind="3")
    assert outcome.ok, [check.row() for check in outcome.checks if not check.ok]
    assert outcome.metrics["position_rms_m"] < 0.1 and outcome.metrics["heading_rms_deg"] < 1.0
