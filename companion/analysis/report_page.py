"""The page of a report: one HTML file that needs no other."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

from companion.analysis.report_data import Recorded
from companion.analysis.report_plots import Pictures
from companion.params.store import Parameters

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 1200px; margin: 2em auto; padding: 0 1em; color: #222; }
h1 { font-size: 1.5em; } h2 { font-size: 1.15em; margin-top: 2em; border-bottom: 1px solid #ccc; }
table { border-collapse: collapse; font-size: 0.9em; }
td, th { padding: 0.15em 0.8em 0.15em 0; text-align: left; vertical-align: top; }
th { border-bottom: 1px solid #ccc; } td.n { text-align: right; font-variant-numeric: tabular-nums; }
tr.WARNING td { background: #fff6d6; }
tr.ERROR td, tr.CRITICAL td, tr.ALERT td, tr.EMERGENCY td { background: #ffe0dc; }
svg { width: 100%; height: auto; } .long { max-height: 32em; overflow: auto; }
"""

Rows = Sequence[Sequence[str]]


def page(recorded: Recorded, pictures: Pictures, mission: Rows, links: Rows) -> str:
    """The HTML text. `mission`: number, command, place, time reached; `links`: sender, packets, missing."""
    title = f"{recorded.log.config.title}: {recorded.log.folder.name}"
    parts = [f"<h1>{escape(title)}</h1>", _table(None, _facts(recorded))]
    if recorded.warnings:
        parts.append(f"<p>{escape('; '.join(recorded.warnings[:5]))}</p>")
    for heading, picture in pictures.by_title.items():
        parts += [f"<h2>{escape(heading)}</h2>", picture]
    if links:
        parts.append(_table(("system", "packets", "missing", "share"), links))
    parts.append(
        "<h2>Mission</h2>"
        + (_table(("item", "what", "where", "reached, s"), mission) if mission else "<p>None was sailed.</p>")
    )
    parts.append(f"<h2>Events</h2><div class='long'>{_events(recorded)}</div>")
    changed = _changed(recorded.log.parameters, recorded)
    parts.append(
        "<h2>Parameters that differ from the table's defaults</h2>"
        + (_table(("name", "value", "default"), changed) if changed else "<p>None.</p>")
    )
    body = "\n".join(parts)
    head = f"<head><meta charset='utf-8'><title>{escape(title)}</title><style>{_STYLE}</style></head>"
    return f"<!DOCTYPE html>\n<html lang='en'>{head}<body>\n{body}\n</body></html>\n"


def _facts(recorded: Recorded) -> Rows:
    ticks, t = recorded.ticks, recorded.t_s
    valid = ticks["position_valid"] > 0.0
    way = np.hypot(np.diff(ticks["north_m"]), np.diff(ticks["east_m"]))
    sailed_m = float(np.sum(way[valid[1:] & valid[:-1]]))
    period = np.diff(t, prepend=t[0])
    rows = [
        ("vessel", recorded.log.config.name),
        ("program", f"USV companion {recorded.manifest.get('version', '?')}"),
        ("begun", _date(ticks["time_unix_ns"][0])),
        ("duration", f"{t[-1] - t[0]:.0f} s"),
        ("armed", f"{float(np.sum(period[ticks['armed'] > 0.0])):.0f} s"),
        (
            "sailed over ground",
            f"{sailed_m:.0f} m, at most {float(np.nanmax(np.hypot(ticks['surge_mps'], ticks['sway_mps']))):.2f} m/s",
        ),
        (
            "modes",
            ", ".join(
                f"{name} {float(np.sum(period[recorded.modes == n])):.0f} s"
                for n, name in enumerate(recorded.mode_names)
            ),
        ),
    ]
    errors = np.abs(ticks["cross_track_error_m"][np.isfinite(ticks["cross_track_error_m"])])
    if len(errors):
        rows.append(
            (
                "cross-track error",
                f"RMS {math.sqrt(float(np.mean(errors**2))):.2f} m, 95 % {float(np.percentile(errors, 95)):.2f} m, "
                f"largest {float(np.max(errors)):.2f} m",
            )
        )
    if recorded.truth is not None:
        rows.append(("estimate against the truth (simulation)", _against_truth(recorded)))
    if recorded.manifest.get("seed") is not None:
        rows.append(("seed", str(recorded.manifest["seed"])))
    return rows


def _against_truth(recorded: Recorded) -> str:
    assert recorded.truth is not None
    ticks, truth, t = recorded.ticks, recorded.truth, recorded.t_s
    valid = ticks["position_valid"] > 0.0
    if not np.any(valid):
        return "no valid position"
    north, east = np.interp(t, truth["t_s"], truth["north_m"]), np.interp(t, truth["t_s"], truth["east_m"])
    off = np.hypot(ticks["north_m"] - north, ticks["east_m"] - east)[valid]
    return f"position RMS {math.sqrt(float(np.mean(off**2))):.2f} m, largest {float(np.max(off)):.2f} m"


def _date(unix_ns: float) -> str:
    return (
        str(np.datetime64(int(unix_ns), "ns").astype("datetime64[s]")).replace("T", " ") + " UTC"
        if math.isfinite(unix_ns)
        else "?"
    )


def _events(recorded: Recorded) -> str:
    rows = "".join(
        f"<tr class='{escape(event.severity)}'><td class='n'>{event.t_s:.1f}</td>"
        f"<td>{escape(event.severity.lower())}</td><td>{escape(event.text)}</td></tr>"
        for event in recorded.events
    )
    return f"<table><tr><th>s</th><th></th><th></th></tr>{rows}</table>"


def _changed(values: Mapping[str, float], recorded: Recorded) -> Rows:
    table = Parameters()
    rows = []
    for name, value in sorted(values.items()):
        spec = table.spec(name)
        if spec is not None and not spec.read_only and abs(value - table.defaults[name]) > 1e-6 * max(1.0, abs(value)):
            rows.append((name, f"{value:g} {spec.unit}", f"{table.defaults[name]:g}"))
    return rows


def _table(header: Sequence[str] | None, rows: Rows) -> str:
    head = "" if header is None else "<tr>" + "".join(f"<th>{escape(cell)}</th>" for cell in header) + "</tr>"
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table>{head}{body}</table>"
