"""The page of what the theses found: its findings can be sailed, its figures are measured, its verdicts follow from
them."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

from docs.generate.least_errors import inertia_for, least_error
from docs.generate.theses import MEASURED, findings_page, holds, kept_on, spread, verdict
from docs.results.measure import ROOT, run_name, runs_of, tables, theses

SAID = theses()
FINDINGS = SAID["finding"]
SERVED = {*range(16), *range(100, 106)}


def rows() -> dict[str, dict[str, Any]]:
    return {row["label"]: row for row in json.loads(MEASURED.read_text(encoding="utf-8"))["rows"]}


def finding(**keys: Any) -> dict[str, Any]:
    run = {"label": "", "law": "thesis", "scenario": "hold", "show": [["a", "m"]]}
    return {"name": "one", "run": [run, run], "expect": [{"run": 0, "metric": "a", "low": 1.0, "high": 2.0}], **keys}


def measured(*values: tuple[float, float]) -> dict[str, dict[str, Any]]:
    """Two runs on a seed for each pair."""
    return {
        f"one {i}": {"runs": [{"seed": seed, "metrics": {"a": pair[i]}} for seed, pair in enumerate(values)]}
        for i in range(2)
    }


@pytest.mark.parametrize("one", FINDINGS, ids=[one["name"] for one in FINDINGS])
def test_a_finding_says_where_it_stands_and_what_must_hold(one: dict[str, Any]) -> None:
    assert one["thesis"].endswith(".") and one["source"][0].isdigit()
    ways = [key for key in ("expect", "cannot", "by") if key in one]
    assert len(ways) == 1
    for expected in one.get("expect", ()):
        assert expected["low"] <= expected["high"] and 0 <= expected["run"] < len(one["run"])
    if "by" in one:
        path, _, name = one["by"].partition("::")
        assert f"def {name}(" in (ROOT / path).read_text(encoding="utf-8") if name else (ROOT / path).is_file()


def test_names_are_distinct() -> None:
    names = [one["name"] for one in FINDINGS]
    assert len(set(names)) == len(names)


def test_every_run_is_measured_on_six_seeds_that_served_nothing() -> None:
    found = rows()
    (table,) = (table for table in tables() if table["name"] == "theses")
    assert set(found) == {row["label"] for row in table["rows"]}
    for row in table["rows"]:
        runs = runs_of(table, row)
        assert [run["seed"] for run in found[row["label"]]["runs"]] == [run.seed for run in runs]
        assert len(runs) == 6 and not SERVED & {run.seed for run in runs}
        assert found[row["label"]]["command"].split()[1:] == runs[0].words or "'" in found[row["label"]]["command"]


@pytest.mark.parametrize("one", [one for one in FINDINGS if "expect" in one], ids=lambda one: one["name"])
def test_the_page_has_the_verdict_that_follows_from_the_figures(one: dict[str, Any]) -> None:
    runs = rows()
    kept = kept_on(one, runs)
    assert len(kept) == 6
    line = next(line for line in findings_page().splitlines() if line.startswith(f"| {one['thesis']}"))
    assert f"**{verdict(one, runs)}**" in line and "not measured" not in line
    for i, run in enumerate(one["run"]):
        for metric, text in run["show"]:
            assert spread(runs[run_name(one, i)]["runs"], metric, text) in line


def test_a_page_without_measurements_says_so(tmp_path: Path) -> None:
    text = findings_page(tmp_path / "none.json")
    assert "Nothing is measured yet." in text and text.count("**not measured yet**") > 10


def test_a_finding_is_reproduced_where_all_that_is_expected_holds() -> None:
    assert verdict(finding(), measured((1.5, 0.0), (1.0, 0.0))) == "reproduced"
    assert verdict(finding(), measured((1.5, 0.0), (3.0, 0.0))) == "on 1 of 2 seeds"
    assert verdict(finding(), measured((0.5, 0.0))) == "not reproduced"
    assert verdict(finding(used="the plant"), measured((1.5, 0.0))) == "reproduced; calibrated on it"
    assert verdict(finding(), measured((math.nan, 0.0))) == "not reproduced"
    assert verdict(finding(), {}) == "not measured yet"
    assert verdict(finding(cannot="no sea here"), {}) == "cannot be repeated"


def test_a_ratio_is_to_another_run_or_to_another_metric() -> None:
    by_run = finding(expect=[{"run": 0, "metric": "a", "than": 1, "low": 1.9, "high": 2.1}])
    assert holds(by_run, [{"a": 4.0}, {"a": 2.0}]) and not holds(by_run, [{"a": 4.0}, {"a": 0.0}])
    by_metric = finding(expect=[{"run": 0, "metric": "a", "than": 0, "of": "b", "low": 1.9, "high": 2.1}])
    assert holds(by_metric, [{"a": 4.0, "b": 2.0}, {}]) and not holds(by_metric, [{"a": 4.0}, {}])


def test_the_printed_law_cannot_follow_its_reference_ahead_within_the_printed_error() -> None:
    assert least_error("SURGE", 263.93, 5.0) > 0.5
    assert least_error("YAW", 322.15, math.radians(45.0)) > math.radians(2.0 * 6.5)
    assert 90.0 < inertia_for("YAW", math.radians(6.5), math.radians(45.0), 10.0, 322.15) < 120.0
