"""theses.md: what the three theses found, what stands here beside it, and whether it is the same."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from docs.generate.least_errors import inertia_for, least_error
from docs.generate.markdown import code, number, page, section, table
from docs.generate.source import ROOT
from docs.results.measure import run_name, theses

MEASURED = ROOT / "docs" / "results" / "theses.json"
_INTRODUCTION = """The program is based on three theses. This page compares each of their findings with the simulated
boats, with the thesis's law and with the companion's own. Figures are means of six seeds, in brackets the smallest and
the largest.

A figure of a thesis counts as reproduced on a seed if it is between half and one and a half times as large, unless
narrower limits are stated; findings without a figure also have limits in `docs/results/theses.toml`. The limits were
written before these seeds were sailed. The verdict says on how many seeds all limits of a finding are kept."""
_CALIBRATED = """What the plants stand on:

* ReVolt, `as_sailed`: sway and yaw damping by the times of the legs; inertia and surge damping as the thesis prints
  them. It is the usual plant.
* ReVolt, `sea_trial`: surge by 2 knots at 50 N, quadratic; sway as before, with the centre of the drag 0.25 m ahead by
  the levers that were tuned at sea; inertia in yaw by a radius of gyration of a quarter of the length. Nothing of the
  box is in it, so that all of the box's figures are predictions.
* ÅBOAT: an estimate by its length, mass and motors. The thesis prints no gains; `WPT_*` are ours.
* RescueRunner, `as_sailed`: mass, size and speed as printed. The nozzle's rate of 14°/s and lag of 0.3 s are not
  printed; they are what makes it swing at 20 m, and nothing else was chosen for it."""
_BOUND = """With the printed gains and reference the printed figures cannot be those of the whole box. A body without
any lag in its thrusters, with the linear damping that suits it best, has at least these errors:"""


def findings_page(measured: Path = MEASURED) -> str:
    """The page."""
    said = theses()
    runs = _rows(measured)
    boats = list(dict.fromkeys(finding["boat"] for finding in said["finding"]))
    return page(
        "What the theses found",
        _INTRODUCTION,
        f"{said['served']} {_origin(measured)}",
        _CALIBRATED,
        _summary(said["finding"], runs, boats),
        *(_boat(boat, [one for one in said["finding"] if one["boat"] == boat], runs) for boat in boats),
    )


Runs = Mapping[str, Mapping[str, Any]]


def _rows(measured: Path) -> Runs:
    if not measured.is_file():
        return {}
    return {row["label"]: row for row in json.loads(measured.read_text(encoding="utf-8"))["rows"]}


def _origin(measured: Path) -> str:
    if not measured.is_file():
        return "Nothing is measured yet."
    found = json.loads(measured.read_text(encoding="utf-8"))
    return f"Measured on {found['date']} at commit {code(found['commit'])} by {code(found['command'])}."


# --- verdicts ------------------------------------------------------------------------------------------------------


def kept_on(finding: Mapping[str, Any], runs: Runs) -> dict[int, bool]:
    """Whether all that a finding expects holds, by seed; empty where it is not measured or expects nothing."""
    measured = [runs.get(run_name(finding, i)) for i in range(len(finding.get("run", ())))]
    if not finding.get("expect") or not measured or None in measured:
        return {}
    by_run = [{run["seed"]: run["metrics"] for run in row["runs"]} for row in measured if row is not None]
    return {seed: holds(finding, [metrics[seed] for metrics in by_run]) for seed in by_run[0]}


def holds(finding: Mapping[str, Any], metrics: Sequence[Mapping[str, float]]) -> bool:
    """Whether all that a finding expects holds of one seed; `metrics`: those of its runs, in their order."""
    return all(_within(expected, metrics) for expected in finding["expect"])


def _within(expected: Mapping[str, Any], metrics: Sequence[Mapping[str, float]]) -> bool:
    value = metrics[expected["run"]].get(expected["metric"], math.nan)
    if "than" in expected:
        value /= metrics[expected["than"]].get(expected.get("of", expected["metric"]), math.nan) or math.nan
    return bool(expected["low"] <= value <= expected["high"])


def verdict(finding: Mapping[str, Any], runs: Runs) -> str:
    """In a few words, whether the finding is reproduced."""
    if "cannot" in finding:
        return "cannot be repeated"
    if "by" in finding:
        return str(finding["verdict"])
    kept = kept_on(finding, runs)
    if not kept:
        return "not measured yet"
    count = sum(kept.values())
    if count in (0, len(kept)):
        said = "reproduced" if count else "not reproduced"
    else:
        said = f"on {count} of {len(kept)} seeds"
    return f"{said}; calibrated on it" if "used" in finding else said


# --- the tables ----------------------------------------------------------------------------------------------------


def _summary(findings: Sequence[Mapping[str, Any]], runs: Runs, boats: Sequence[str]) -> str:
    kinds = ("reproduced", "on some of the seeds", "not reproduced", "cannot be repeated")
    rows = []
    for boat in boats:
        said = [verdict(finding, runs).partition(";")[0] for finding in findings if finding["boat"] == boat]
        counts = [
            sum(one == kind or (one.startswith("on ") and kind.startswith("on ")) for one in said) for kind in kinds
        ]
        rows.append((boat, *map(str, counts)))
    return table(("findings of", *kinds), rows)


def _boat(boat: str, findings: Sequence[Mapping[str, Any]], runs: Runs) -> str:
    rows = [
        (
            f"{finding['thesis']} ({finding['source']})",
            _cell(finding, runs, "thesis"),
            _cell(finding, runs, "ours"),
            f"**{verdict(finding, runs)}**",
        )
        for finding in findings
    ]
    notes = [line for finding in findings for line in _notes(finding)]
    commands = [
        (_name(finding), code(runs[run_name(finding, 0)]["command"]))
        for finding in findings
        if run_name(finding, 0) in runs
    ]
    commands += [(_name(finding), code(f"python -m pytest {finding['by']}")) for finding in findings if "by" in finding]
    return section(
        2,
        boat,
        table(("the thesis found", "here, its law", "here, our law", "verdict"), rows),
        "\n".join(notes),
        _bound() if boat == "ReVolt" else "",
        table(("finding", "one run of it"), commands),
    )


def _name(finding: Mapping[str, Any]) -> str:
    return str(finding["name"]).replace("_", " ")


def _notes(finding: Mapping[str, Any]) -> Iterator[str]:
    said = [finding[key] for key in ("note", "cannot") if key in finding]
    if "used" in finding:
        said.append(f"Calibrated on it: {finding['used']}.")
    if said:
        yield f"* *{_name(finding)}*: {' '.join(said)}"


def _cell(finding: Mapping[str, Any], runs: Runs, law: str) -> str:
    cells = []
    for i, run in enumerate(finding.get("run", ())):
        row = runs.get(run_name(finding, i))
        if run["law"] == law and row is not None:
            shown = "; ".join(spread(row["runs"], metric, text) for metric, text in run["show"])
            cells.append(f"{run['label']}: {shown}")
    return ".<br>".join(cells)


def spread(runs: Sequence[Mapping[str, Any]], metric: str, text: str) -> str:
    """Mean, least and largest of a metric, with what stands after it; how many of all for `completed`."""
    values = [run["metrics"][metric] for run in runs if math.isfinite(run["metrics"].get(metric, math.nan))]
    if metric == "completed":
        return f"{sum(value > 0.0 for value in values)} of {len(runs)} {text}"
    if not values:
        return f"no {text}"
    if metric.endswith("_worst_leg"):
        return f"{text}: {', '.join(number(value) for value in sorted(set(values)))}"
    mean, least, most = (
        number(float(f"{value:.2g}")) for value in (sum(values) / len(values), min(values), max(values))
    )
    return f"{mean} ({least} … {most}){'' if text.startswith('°') else ' '}{text}"


def _bound() -> str:
    turn = math.radians(45.0)
    rows = [
        ("5 m ahead, 263.93 kg as printed", f"{least_error('SURGE', 263.93, 5.0):.2f} m", "0.3 m"),
        *(
            (f"turn of 45°, {inertia:g} kg m²{text}", f"{math.degrees(least_error('YAW', inertia, turn)):.1f}°", "6.5°")
            for inertia, text in (
                (322.15, " as printed"),
                (169.0, ", a radius of gyration of 0.25 lengths"),
                (117.0, ", 0.2 lengths"),
            )
        ),
    ]
    needed = inertia_for("YAW", math.radians(6.5), turn, 10.0, 322.15)
    after = f"""The leg ahead rules it out. A turn of 45° within 6.5° needs {needed:.0f} kg m² or less, of thrusters
that obey at once and push as they are told; the printed inertia is three times that, and 0.2 lengths is little for a
boat with its batteries and pods at the ends. So the figures are those of the coupled leg, in which the heading stays,
as the thesis says in 11.3, or of another law than it prints."""
    return "\n\n".join((_BOUND, table(("step", "least error", "the thesis's figure"), rows).rstrip(), after))
