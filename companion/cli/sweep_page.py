"""The report of a sweep: a table on the terminal, and one HTML file that needs no other."""

from __future__ import annotations

import base64
import io
import math
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from rich.console import Console
from rich.markup import escape as plain_markup
from rich.table import Table

from companion.analysis.figure import MATPLOTLIB_MISSING, new_figure
from companion.analysis.report_facts import plain
from companion.analysis.report_page import document, figure
from companion.core.progress import Told
from sitl.sweep.statistics import CONFIDENCE, Estimated
from sitl.sweep.summary import Comparison, PointSummary, compared_by

if TYPE_CHECKING:
    from sitl.sweep.rows import Row

Comparisons = Mapping[str, Sequence[Comparison]]
"""By what is compared with what, in words."""

_CLEAR = 0.05  # of an adjusted p
_MOST_CURVES = 8
_BINS = 30
_ROUNDING = 1e-12
_HINT = (
    f"Intervals hold {100.0 * CONFIDENCE:.0f} %: of failures Wilson's, of percentiles by order statistics, with ? for "
    "an end that so few runs do not tell. The margin is how far the check nearest to failing was from its limit, as a "
    "share of the limit; below 0 it failed."
)
_PAIRED = (
    "Pairs have the same scenario, vessel, settings, faults and seed. Medians: Wilcoxon's signed-rank test, p adjusted "
    "for all metrics of the page after Benjamini and Hochberg. Failures: McNemar's exact test."
)


def compare_by(rows: Sequence[Row], key: str) -> dict[str, Sequence[Comparison]]:
    """Each value of a setting against the first one, by what is compared. Raises SweepError where there are not two."""
    return {
        f"{key}={value or 'default'} against {key}={first or 'default'}": found
        for (value, first), found in compared_by(rows, key).items()
    }


# --- terminal ------------------------------------------------------------------------------------------------------


def print_summaries(found: Sequence[PointSummary], console: Console | None = None) -> None:
    """A line for each design point, and under it the command of the worst run where one failed."""
    table = Table(box=None, pad_edge=False)
    for name in ("point", "runs", "failed", "rate", "least margin"):
        table.add_column(name, justify="left" if name == "point" else "right", overflow="fold")
    for one in found:
        worst = one.worst[0]
        style = "red" if one.failures else ""
        table.add_row(
            plain_markup(one.point), str(one.count), str(one.failures), _percent(one.rate), _margin(worst), style=style
        )
    console = console or Console(highlight=False)
    console.print(table)
    for one in found:
        if one.failures:
            console.print(f"worst of {one.point}: {one.worst[0].run.command}", markup=False, soft_wrap=True)


def print_comparisons(comparisons: Comparisons, console: Console | None = None) -> None:
    """What differs clearly."""
    console = console or Console(highlight=False)
    for title, found in comparisons.items():
        console.print(title, markup=False, style="bold")
        for one in found:
            failures = one.failures
            console.print(
                f"  {one.point}: {failures.count} pairs, failures {_failures(one)}, p {failures.p:.3g}",
                markup=False,
                soft_wrap=True,
            )
            for metric in one.metrics:
                if metric.adjusted < _CLEAR:
                    said = f"median {figure(metric.first)} → {figure(metric.second)}, p {metric.adjusted:.2g}"
                    console.print(f"    {metric.name}: {said}", markup=False, soft_wrap=True)
        if not found:
            console.print("  no pairs: no run of both has the same scenario, vessel, settings and seed")


# --- page ----------------------------------------------------------------------------------------------------------


def write_page(
    out: Path,
    folder: Path,
    rows: Sequence[Row],
    found: Sequence[PointSummary],
    comparisons: Comparisons,
    told: Told,
) -> str:
    """Write the page. Returns a hint where matplotlib is not installed, so that it has no pictures; else empty text.
    Raises OSError."""
    failed = sum(one.failures for one in found)
    name, text = _design(folder)
    title = f"{name}: {len(rows)} runs, {failed} failed"
    parts = [
        f"<h1>{escape(title)}</h1>",
        f"<p>{escape(text)}</p>" if text else "",
        _about(rows),
        f"<p class='hint'>{_HINT}</p>",
        _overview(found),
    ]
    for name, of_points in comparisons.items():
        parts.append(_comparison(name, of_points))
    hint = ""
    scenarios = list(dict.fromkeys(one.scenario for one in found))
    for number, scenario in enumerate(scenarios):
        told(scenario, number / len(scenarios))
        of_scenario = [one for one in found if one.scenario == scenario]
        parts.append(f"<h2>{escape(scenario)}</h2>")
        parts += [_point(one) for one in of_scenario]
        try:
            parts += _pictures(of_scenario)
        except ImportError:
            hint = f"no pictures: {MATPLOTLIB_MISSING}"
    out.write_text(document(title, "\n".join(parts)), encoding="utf-8")
    return hint


def _design(folder: Path) -> tuple[str, str]:
    """Name and text of the design that was sailed last into a folder; the folder's name where there is none."""
    try:
        design = tomllib.loads((folder / "design.toml").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return folder.resolve().name, ""
    return str(design["name"]), str(design.get("text", ""))


def _about(rows: Sequence[Row]) -> str:
    commits = ", ".join(dict.fromkeys(row.commit for row in rows))
    versions = ", ".join(f"{name} {version}" for name, version in rows[0].versions.items())
    hours = sum(row.duration_s for row in rows) / 3600.0
    return f"<p>Commit {escape(commits)}; {escape(versions)}; {hours:.2f} hours of one core.</p>"


def _overview(found: Sequence[PointSummary]) -> str:
    rows = [
        (
            escape(one.point),
            str(one.count),
            f"<span class='{'bad' if one.failures else 'good'}'>{one.failures}</span>",
            _percent(one.rate),
            _margin(one.worst[0]),
        )
        for one in found
    ]
    return _table(("design point", "runs", "failed", "failure rate", "least margin"), rows)


def _point(one: PointSummary) -> str:
    figures = [
        (
            escape(plain(metric.name)),
            str(len(metric.values)),
            *(_estimated(value) for value in (metric.low, metric.median, metric.high)),
            f"{figure(metric.least)} to {figure(metric.most)}",
            _which(metric.largest),
            escape(", ".join(f"{name} {value:+.2f}" for name, value in metric.influences.items())),
        )
        for metric in one.distributions
    ]
    head = ("metric", "runs", "5 %", "median", "95 %", "range", "largest in", "rank correlation")
    worst = [
        (
            _margin(row),
            escape(row.error or ", ".join(row.failed_checks) or f"nearest: {row.tightest or 'none'}"),
            f"<code>{escape(row.run.command)}</code>",
            f"<code>{escape(row.log)}</code>" if row.log else "",
        )
        for row in one.worst
    ]
    return (
        f"<h3>{escape(one.point)}</h3><p>{one.failures} of {one.count} failed: {_percent(one.rate)}</p>"
        f"{_table(head, figures)}<p class='hint'>Worst runs</p>{_table(('margin', 'what', 'again by', 'log'), worst)}"
    )


def _comparison(title: str, found: Sequence[Comparison]) -> str:
    if not found:
        return f"<h2>{escape(title)}</h2><p>No pairs.</p>"
    rows = []
    for one in found:
        unpaired = f"; {one.unpaired} without a partner" if one.unpaired else ""
        rows.append(
            (
                escape(one.point),
                "failures",
                f"{one.failures.count}{unpaired}",
                _failures(one),
                "",
                "",
                _p(one.failures.p),
            )
        )
        for metric in one.metrics:
            figures = (figure(metric.first), figure(metric.second))
            rows.append(
                (
                    "",
                    escape(plain(metric.name)),
                    str(metric.count),
                    *figures,
                    _estimated(metric.median),
                    _p(metric.adjusted),
                )
            )
    head = ("design point", "", "pairs", "median before", "after", "median difference", "p")
    return f"<h2>{escape(title)}</h2><p class='hint'>{_PAIRED}</p>{_table(head, rows)}"


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    top = "".join(f"<th>{escape(name)}</th>" for name in head)
    body = "".join(f"<tr>{''.join(f'<td>{cell}</td>' for cell in row)}</tr>" for row in rows)
    return f"<div class='wide'><table><tr>{top}</tr>{body}</table></div>"


# --- pictures ------------------------------------------------------------------------------------------------------


def _pictures(found: Sequence[PointSummary]) -> Iterator[str]:
    """A picture of each metric: how often which value came, and which share of the runs stays below it."""
    shown = found[:_MOST_CURVES]
    for name in dict.fromkeys(metric.name for one in shown for metric in one.distributions):
        values = {
            one.point: np.sort(metric.values) for one in shown for metric in one.distributions if metric.name == name
        }
        yield f"<div class='wide'><img class='picture' alt='{escape(name)}' src='{_drawn(name, values)}'></div>"
    if len(found) > _MOST_CURVES:
        yield f"<p class='hint'>Pictures show the first {_MOST_CURVES} of {len(found)} design points.</p>"


def _drawn(name: str, values: Mapping[str, np.ndarray[tuple[int], np.dtype[np.float64]]]) -> str:
    """Histogram and empirical distribution function, as a data URL. Raises ImportError without matplotlib."""
    drawn = new_figure(11.0, 3.0)
    counts, shares = drawn.subplots(1, 2)
    every = np.concatenate(list(values.values()))
    if np.ptp(every) <= _ROUNDING * np.max(np.abs(every)):
        every = every[:1]  # numpy makes no bins between values that differ by rounding alone
    bins = np.histogram_bin_edges(every, bins=min(_BINS, max(5, math.isqrt(len(every)))))
    for point, found in values.items():
        counts.hist(found, bins=bins, histtype="step", label=point)
        shares.ecdf(found, label=point)
    counts.set(xlabel=plain(name), ylabel="runs")
    shares.set(xlabel=plain(name), ylabel="share of runs", ylim=(0.0, 1.0))
    shares.grid(alpha=0.3)
    shares.legend(fontsize="x-small", loc="lower right")
    buffer = io.BytesIO()
    drawn.savefig(buffer, format="png", dpi=80)
    return f"data:image/png;base64,{base64.b64encode(buffer.getvalue()).decode()}"


# --- words ---------------------------------------------------------------------------------------------------------


def _percent(rate: Estimated) -> str:
    return f"{100.0 * rate.value:.3g} % ({100.0 * rate.low:.3g} to {100.0 * rate.high:.3g})"


def _estimated(value: Estimated) -> str:
    low, high = (figure(end) if math.isfinite(end) else "?" for end in (value.low, value.high))
    return f"{figure(value.value)} ({low} to {high})"


def _which(row: Row) -> str:
    """A run of a design point: its seed, and what was sampled."""
    return escape(", ".join((f"seed {row.seed}", *(f"{name} {value:g}" for name, value in row.factors.items()))))


def _margin(row: Row) -> str:
    none = "no result" if row.error else "–"
    return none if row.margin is None else f"{row.margin:+.2f}"


def _failures(one: Comparison) -> str:
    failures = one.failures
    return f"{failures.only_first + failures.both} → {failures.only_second + failures.both}"


def _p(value: float) -> str:
    return f"<b>{value:.2g}</b>" if value < _CLEAR else f"{value:.2g}"
