"""The comparison with ArduRover: its rows name measured figures, and the ratio tells which side is better."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from docs.generate.ardurover import beside_ardurover, rows
from docs.results.measure import tables

TABLES = {table["name"]: table for table in tables()}


@pytest.mark.parametrize("row", rows(), ids=lambda row: f"{row['task']}, {row['figure']}")
def test_a_row_names_a_figure_that_is_measured(row: dict[str, Any]) -> None:
    table = TABLES[row["table"]]
    assert row["row"] in [one["label"] for one in table["rows"]]
    assert row["metric"] in [column["metric"] for column in table["columns"]]


def written(folder: Path, label: str, runs: list[Mapping[str, float]]) -> None:
    found = [{"seed": i, "ok": True, "metrics": metrics} for i, metrics in enumerate(runs)]
    (folder / "beside_ardurover.json").write_text(json.dumps({"rows": [{"label": label, "runs": found}]}))


def test_the_ratio_is_above_one_where_the_boat_is_better(tmp_path: Path) -> None:
    written(
        tmp_path, "Follow, RescueRunner", [{"in_wake_share": 1.0, "gap_straight_rms_m": 3.0}, {"in_wake_share": 0.8}]
    )
    section = beside_ardurover(tmp_path)
    assert "| in the wake ±4 m, share | 0.7 | 0.98 | 0.9 (0.8) | 2 | 1.29 |" in section
    assert "| gap RMS, m, by the truth | 1.99 | 2.28 | 3 (3) | 1 | **0.66** |" in section
    assert "| Hold" not in section


def test_nothing_measured_is_no_section(tmp_path: Path) -> None:
    assert beside_ardurover(tmp_path) == ""
