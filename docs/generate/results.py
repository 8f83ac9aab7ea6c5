"""results.md: the measured tables, from the files that `make results` writes."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from docs.generate.ardurover import beside_ardurover
from docs.generate.consistency import consistency
from docs.generate.markdown import code, number, page, section, table
from docs.generate.source import ROOT

FOLDER = ROOT / "docs" / "results"
_OWN_PAGE = ("theses",)

_INTRODUCTION = """Figures measured in simulation with this program. Each table names its date, its commit
and the command that makes it.
Errors come from the plant's own record, not from the estimate. A simulation is not the sea: expect more there.

[What the theses found](theses.md) has a page of its own.

`make results` measures all tables again. It takes hours; after an interruption it continues where it was."""


def results(folder: Path = FOLDER) -> str:
    """The page."""
    files = sorted(file for file in folder.glob("*.json") if file.stem not in _OWN_PAGE)
    parts = [_SECTIONS.get(file.stem, _table)(json.loads(file.read_text(encoding="utf-8"))) for file in files]
    return page("Measured results", _INTRODUCTION, beside_ardurover(folder), *(parts or ["No table is measured yet."]))


def _table(measured: Mapping[str, Any]) -> str:
    columns = measured["columns"]
    rows = [_row(row, columns) for row in measured["rows"]]
    laws = any(row["law"] for row in measured["rows"])
    headers = ("conditions", *(("law",) if laws else ()), "runs", *(column["title"] for column in columns))
    if not laws:
        rows = [(row[0], *row[2:]) for row in rows]
    origin = f"Measured on {measured['date']} at commit {code(measured['commit'])} by {code(measured['command'])}."
    example = f"One run: {code(measured['rows'][0]['command'])}."
    return section(2, measured["title"], measured["text"], table(headers, rows), f"{origin} {example}")


def _row(row: Mapping[str, Any], columns: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    runs = row["runs"]
    kept = sum(run["ok"] for run in runs)
    checks = str(len(runs)) if kept == len(runs) else f"{len(runs)}, all checks held in {kept}"
    return row["label"], row["law"] or "companion", checks, *(figure(column, runs) for column in columns)


def figure(column: Mapping[str, Any], runs: Sequence[Mapping[str, Any]]) -> str:
    """One figure of all runs, to three digits; empty where no run has the metric."""
    values = [run["metrics"][column["metric"]] for run in runs if column["metric"] in run["metrics"]]
    values = [value for value in values if math.isfinite(value)]
    if not values:
        return ""
    if column["of"] == "count":
        return f"{sum(value > 0.0 for value in values)} of {len(runs)}"
    value = _FIGURES[column["of"]](values)
    return number(float(f"{value:.3g}"))


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values)


_FIGURES: Mapping[str, Callable[[Sequence[float]], float]] = {"max": max, "min": min, "mean": _mean}
_SECTIONS: Mapping[str, Callable[[Mapping[str, Any]], str]] = {"consistency": consistency}
