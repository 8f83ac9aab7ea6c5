"""What measures the tables of results: its rows exist, its runs are kept, its files are what the page reads."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from companion.cli.main import argument_parser
from docs.generate.results import results
from docs.results import measure
from docs.results.consistency import consistency_rows, words_of
from docs.results.measure import Failed, Run, runs_of, sailed, tables
from sitl.scenarios import SCENARIOS

PARSER = argument_parser()
ROWS = [(table, row) for table in tables() for row in table["rows"]]


@pytest.mark.parametrize(("table", "row"), ROWS, ids=[f"{table['name']}-{row['label']}" for table, row in ROWS])
def test_a_row_can_be_sailed(table: dict[str, Any], row: dict[str, Any]) -> None:
    for run in runs_of(table, row):
        PARSER.parse_args(run.words)
        assert {key for key, _ in run.settings} <= SCENARIOS[run.scenario].defaults.keys()


def test_seeds_alternate_the_sign_of_a_spread() -> None:
    table = {"scenario": "four_corner", "seeds": 4, "columns": []}
    runs = runs_of(table, {"label": "", "spread": 0.2, "set": {"wind": "2"}}, most_seeds=2)
    assert [dict(run.settings)["model_error"] for run in runs] == ["-0.2", "0.2"]


def test_a_finished_run_is_not_sailed_again(tmp_path: Path) -> None:
    run = Run("hold", "revolt", 1, (("wind", "2"),))
    finished = tmp_path / run.folder / "finished.json"
    finished.parent.mkdir(parents=True)
    kept = {"commit": "abc", "seed": 1, "ok": True, "error": None, "metrics": {"position_rms_m": 0.1}}
    finished.write_text(json.dumps(kept))
    assert sailed(run, tmp_path, "abc") == kept


def test_a_run_without_a_result_is_named(tmp_path: Path) -> None:
    with pytest.raises(Failed, match="scenario run no_such"):
        sailed(Run("no_such", "", 0, ()), tmp_path, "abc")


def test_a_measured_table_becomes_a_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def sail(run: Run, kept: Path, commit: str) -> dict[str, Any]:
        return {
            "commit": commit,
            "seed": run.seed,
            "ok": True,
            "error": None,
            "metrics": {"position_rms_m": 0.1 + run.seed},
        }

    monkeypatch.setattr(measure, "sailed", sail)
    assert measure.main(["--table", "holding", "--seeds", "2", "--out", str(tmp_path), "--kept", str(tmp_path)]) == 0
    page = results(tmp_path)
    assert "| Hold, ReVolt, wind 2 m/s | 2 | 1.1 |" in page
    assert "make results ARGS='--table holding'" in page


@pytest.mark.parametrize("row", consistency_rows()["rows"], ids=lambda row: row["label"])
def test_a_row_of_consistency_can_be_sailed(row: dict[str, Any]) -> None:
    arguments = argument_parser().parse_args(words_of(row, consistency_rows()["seeds"]))
    assert len(arguments.seeds) == 20


def test_measured_consistency_becomes_a_section(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    verdict = {"mean": 1.02, "half": 0.1, "means": [1.0, 1.04], "band": [0.74, 1.3], "outside": 0, "word": "inside"}
    wrong = {**verdict, "mean": 2.0, "outside": 2, "word": "over-confident"}
    kinds = {"NEES": {"all five": verdict}, "NIS": {"heading": wrong}, "NVS": {"north": verdict}, "bias": {}}
    row = {"label": "A boat", "command": "companion evaluate", "seeds": [1, 2], "date": "2026-01-01", "commit": "abc"}
    content = {"command": "", "rows": [{**row, "cases": {"hold": {"kinds": kinds}}}]}
    monkeypatch.setattr(measure, "measured_consistency", lambda kept, jobs, seeds: content)
    assert measure.main(["--table", "consistency", "--out", str(tmp_path), "--kept", str(tmp_path)]) == 0
    page = results(tmp_path)
    assert "| Hold | 1.02, 2 of 2 | **2.00, 0 of 2: over-confident** |" in page
    assert "NEES all five (0.74 to 1.30)" in page and "seeds 1–2" in page
