"""Many runs of scenarios on one page: how each figure is distributed, which checks fail, a link to each run."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np

from companion.analysis.log_reader import LogError
from companion.analysis.report_data import is_result
from companion.analysis.report_facts import plain
from companion.analysis.report_page import document, figure
from companion.analysis.svg_chart import COLOURS, nice_steps

_WIDTH, _LEFT, _RIGHT, _ROW = 1000, 330, 30, 26
_MOST_NAME = 52


@dataclass(frozen=True, slots=True)
class Run:
    """One run. `group`: the folder above it, or its scenario."""

    folder: Path
    group: str
    result: Mapping[str, Any]

    @property
    def metrics(self) -> Mapping[str, float]:
        """Its figures."""
        found = self.result.get("metrics") or {}
        return {name: float(value) for name, value in found.items() if isinstance(value, int | float)}


def runs_in(folder: Path) -> list[Run]:
    """The runs whose result.json is one or two folders below, in order of their names."""
    runs = []
    for path in sorted((*folder.glob("*/result.json"), *folder.glob("*/*/result.json"))):
        try:
            result = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError):
            continue
        if not is_result(result):
            continue
        group = path.parent.parent.name if path.parent.parent != folder else str(result.get("scenario", "?"))
        runs.append(Run(path.parent, group, result))
    return runs


def write_table(folder: Path, out: Path) -> int:
    """Write the page of all runs below `folder`. Returns how many there are. Raises LogError for none, OSError."""
    runs = runs_in(folder)
    if not runs:
        raise LogError(f"{folder}: neither a log nor a folder of scenarios' runs: no manifest.json, no */result.json")
    groups: dict[str, list[Run]] = {}
    for run in runs:
        groups.setdefault(run.group, []).append(run)
    title = f"{folder.resolve().name}: {len(runs)} runs"
    parts = [f"<h1>{escape(title)}</h1>", _summary(groups), "<h2>Figures</h2>"]
    parts.append("<p class='hint'>A dot is a run and leads to its report; the bar is the median.</p>")
    for name in dict.fromkeys(name for run in runs for name in run.metrics):
        parts.append(_strip(name, groups, out))
    parts += ["<h2>Runs</h2>", _runs(runs, out)]
    out.write_text(document(title, "\n".join(parts)), encoding="utf-8")
    return len(runs)


def _summary(groups: Mapping[str, Sequence[Run]]) -> str:
    rows = []
    for name, runs in groups.items():
        good = sum(bool(run.result.get("ok")) for run in runs)
        failing: dict[str, int] = {}
        for run in runs:
            for check in run.result.get("checks") or ():
                failing[check["name"]] = failing.get(check["name"], 0) + (not check["ok"])
        said = "; ".join(f"{check} fails in {count}" for check, count in failing.items() if count)
        klass = "good" if good == len(runs) else "bad"
        rows.append(
            f"<tr><td>{escape(name)}</td><td class='{klass}'>{good} of {len(runs)}</td><td>{escape(said)}</td></tr>"
        )
    return f"<table><tr><th>runs</th><th>all checks hold</th><th></th></tr>{''.join(rows)}</table>"


def _strip(name: str, groups: Mapping[str, Sequence[Run]], out: Path) -> str:
    """One figure: a row for each group, a dot for each run."""
    rows = {
        group: [(run, run.metrics[name]) for run in runs if math.isfinite(run.metrics.get(name, math.nan))]
        for group, runs in groups.items()
    }
    rows = {group: found for group, found in rows.items() if found}
    values = [value for found in rows.values() for _, value in found]
    if not values:
        return ""
    low, high = min(0.0, *values), max(0.0, *values)
    high = high if high > low else low + 1.0
    height = _ROW * len(rows) + 28

    def x_of(value: float) -> float:
        return _LEFT + (value - low) / (high - low) * (_WIDTH - _LEFT - _RIGHT)

    parts = [
        f"<line class='grid' x1='{x_of(tick):.1f}' x2='{x_of(tick):.1f}' y1='4' y2='{height - 20}'/>"
        f"<text class='tick' x='{x_of(tick):.1f}' y='{height - 6}' text-anchor='middle'>{tick:.4g}</text>"
        for tick in nice_steps(low, high, 6)
    ]
    for at, (group, found) in enumerate(rows.items()):
        y = 4 + _ROW * (at + 0.5)
        shown = group if len(group) <= _MOST_NAME else group[: _MOST_NAME - 1] + "…"
        parts.append(f"<text class='tick' x='{_LEFT - 12}' y='{y + 4:.1f}' text-anchor='end'>{escape(shown)}</text>")
        middle = x_of(float(np.median([value for _, value in found])))
        parts.append(f"<rect x='{middle - 1.5:.1f}' width='3' y='{y - 10:.1f}' height='20' fill='#999'/>")
        parts += [_dot(run, value, x_of(value), y, out) for run, value in found]
    return (
        f"<figure><figcaption><b>{escape(plain(name))}</b></figcaption>"
        f"<svg class='chart' viewBox='0 0 {_WIDTH} {height}' role='img' aria-label='{escape(name)}'>"
        f"{''.join(parts)}</svg></figure>"
    )


def _dot(run: Run, value: float, x: float, y: float, out: Path) -> str:
    colour = COLOURS[0] if run.result.get("ok") else COLOURS[1]
    said = f"{run.group}, seed {run.result.get('seed', '?')}: {figure(value)}"
    dot = f"<circle cx='{x:.1f}' cy='{y:.1f}' r='4.5' fill='{colour}' fill-opacity='.65'>"
    return f"<a href='{_link(run, out)}'>{dot}<title>{escape(said)}</title></circle></a>"


def _runs(runs: Sequence[Run], out: Path) -> str:
    rows = []
    for run in runs:
        good = bool(run.result.get("ok"))
        verdict = f"<td class='{'good' if good else 'bad'}'>{'all hold' if good else 'FAILS'}</td>"
        name = f"{run.group}, seed {run.result.get('seed', '?')}"
        error = escape(str(run.result.get("error") or ""))
        rows.append(f"<tr><td><a href='{_link(run, out)}'>{escape(name)}</a></td>{verdict}<td>{error}</td></tr>")
    return f"<div class='long'><table><tr><th>run</th><th>checks</th><th></th></tr>{''.join(rows)}</table></div>"


def _link(run: Run, out: Path) -> str:
    """To the run's report, relative to this page."""
    place = os.path.relpath(run.folder / "report.html", out.parent)
    return quote(Path(place).as_posix())
