"""The table of routes: worst of all runs, both laws, every condition."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from sitl.scenarios import SCENARIOS, route_table
from sitl.scenarios.scenario import ScenarioResult

FIGURES = {
    "completed": 1.0,
    "cross_track_rms_m": 0.2,
    "cross_track_95_m": 0.4,
    "cross_track_max_m": 0.8,
    "time_s": 100.0,
}


def test_a_row_has_the_worst_of_all_runs() -> None:
    worse = {**FIGURES, "completed": 0.0, "cross_track_rms_m": 2.0, "time_s": 300.0}
    assert (
        route_table.row("1", "calm", "thesis", [FIGURES, worse])
        == "| 1 | calm | thesis | 1 of 2 | 2.00 | 0.40 | 0.80 | 200 |"
    )


def test_every_route_is_sailed_in_every_condition_by_both_laws(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[tuple[int, dict[str, str]]] = []

    def run(scenario: Any, compose: Any, folder: Path, seed: int, changes: dict[str, str]) -> ScenarioResult:
        asked.append((seed, changes))
        return ScenarioResult(scenario.name, True, FIGURES, (), None)

    monkeypatch.setattr(route_table, "run", run)
    lines = list(route_table.lines(SCENARIOS["route"], None, 2))  # type: ignore[arg-type]
    assert len(lines) == 2 + 4 * 3 * 2 and len(asked) == 2 * 24
    assert all(set(changes) <= set(SCENARIOS["route"].defaults) for _, changes in asked)
    assert {line.count("|") for line in lines} == {9}
