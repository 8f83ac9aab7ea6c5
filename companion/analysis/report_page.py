"""The page of a report: one HTML file that needs no other. Its first screen says what was sailed and how well."""

from __future__ import annotations

import base64
import math
from collections.abc import Iterator, Mapping, Sequence
from html import escape
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np

from companion.analysis import report_facts as facts
from companion.analysis.report_data import Recorded
from companion.analysis.report_sections import SECTIONS, Page, table
from companion.analysis.svg_map import Chart, track_map

_MOST_PICTURE = 3_000_000
_HINT = "Wheel and drag move the track; a drag across a chart zooms them all; a double click shows all."


def html(page: Page, chart: Chart) -> str:
    """The HTML text."""
    recorded = page.recorded
    title = f"{recorded.log.config.title}: {recorded.log.folder.resolve().name}"
    lines = facts.verdicts(recorded, [tuple(row) for row in page.links])
    verdicts = "".join(
        f"<li class='{line.level.value}'><b>{escape(line.subject)}</b>{escape(line.text)}</li>" for line in lines
    )
    about = f"{_scenario(recorded)}<ul class='verdicts'>{verdicts}</ul>{table(None, _facts(recorded))}"
    first = f"<div class='first'><div>{about}</div><div>{track_map(recorded, chart)}</div></div>"
    parts = [
        f"<h1>{escape(title)}</h1>",
        first,
        f"<p class='hint'>{_HINT}</p>",
    ]
    parts += [_checks(recorded), _pictures(recorded)]
    parts += [f"<h2>{escape(heading)}</h2>{section(page)}" for heading, section in SECTIONS.items()]
    return document(title, "\n".join(parts), "report.js")


def document(title: str, body: str, script: str | None = None) -> str:
    """A page that needs no other file."""
    code = "" if script is None else f"<script>{_resource(script)}</script>"
    head = f"<meta charset='utf-8'><meta name='viewport' content='width=device-width'><title>{escape(title)}</title>"
    style = f"<style>{_resource('report.css')}</style>"
    return f"<!DOCTYPE html>\n<html lang='en'><head>{head}{style}</head><body>\n{body}\n{code}</body></html>\n"


def _resource(name: str) -> str:
    return resources.files("companion.analysis").joinpath(name).read_text(encoding="utf-8")


def _facts(recorded: Recorded) -> list[tuple[str, str]]:
    ticks, t = recorded.ticks, recorded.t_s
    period = np.diff(t, prepend=t[0])
    speed = np.hypot(ticks["surge_mps"], ticks["sway_mps"])
    top = f", at most {float(np.nanmax(speed)):.2f} m/s" if np.any(np.isfinite(speed)) else ""
    modes = facts.mode_times(recorded)
    armed_s = float(np.sum(period[ticks["armed"] > 0.0]))
    rows = [
        ("vessel", recorded.log.config.name),
        ("begun", _date(ticks["time_unix_ns"][-1] - 1e9 * (t[-1] - t[0]))),  # a clock may have learnt the time since
        (
            "duration",
            f"{facts.duration(float(t[-1] - t[0]))}, armed {facts.duration(armed_s)}",
        ),
        ("sailed over ground", f"{facts.distance_m(recorded):.0f} m{top}"),
        ("modes", ", ".join(f"{name} {facts.duration(seconds)}" for name, seconds in modes.items())),
        ("program", f"USV companion {recorded.manifest.get('version', '?')}"),
    ]
    rows += _truth_facts(recorded)
    if recorded.manifest.get("seed") is not None:
        rows.append(("seed", str(recorded.manifest["seed"])))
    return rows


def _truth_facts(recorded: Recorded) -> Iterator[tuple[str, str]]:
    for quantity, rms, largest, *_ in facts.consistency_rows(recorded):
        yield f"estimate of {quantity}", f"RMS {rms}, largest {largest}, against the truth (simulation)"


def _date(unix_ns: float) -> str:
    if not math.isfinite(unix_ns):
        return "?"
    return str(np.datetime64(round(unix_ns * 1e-9), "s")).replace("T", " ") + " UTC"


# --- scenarios -----------------------------------------------------------------------------------------------------


def _scenario(recorded: Recorded) -> str:
    result = recorded.result
    if result is None:
        return ""
    words = ", ".join(f"{key} {value}" for key, value in dict(result.get("settings", {})).items() if value)
    return f"<p><b>Scenario {escape(str(result.get('scenario', '?')))}</b>{': ' if words else ''}{escape(words)}</p>"


def _checks(recorded: Recorded) -> str:
    """Checks and figures of a scenario."""
    result = recorded.result
    if result is None:
        return ""
    rows = "".join(_check_row(check) for check in result.get("checks") or ())
    head = "<tr><th>check</th><th>measured</th><th>limit</th><th></th></tr>"
    checks = f"<table>{head}{rows}</table>" if rows else ""
    error = f"<p class='bad'>{escape(str(result['error']))}</p>" if result.get("error") else ""
    metrics = [_metric(name, value) for name, value in dict(result.get("metrics") or {}).items()]
    figures = f"<details><summary>all figures</summary>{table(None, metrics)}</details>" if metrics else ""
    return f"<h2>Checks</h2>{error}{checks}{figures}"


def _metric(name: str, value: object) -> tuple[str, str]:
    stem, _, unit = name.rpartition("_")
    if unit in ("rad", "radps") and isinstance(value, int | float):
        return facts.plain(f"{stem}_{'deg' if unit == 'rad' else 'degps'}"), figure(math.degrees(value))
    return facts.plain(name), figure(value)


def _check_row(check: Mapping[str, Any]) -> str:
    relation = "at least" if check["at_least"] else "at most"
    verdict = ("good", "holds") if check["ok"] else ("bad", "FAILS")
    value, unit = in_degrees(float(check["value"]), str(check["unit"]))
    limit, _ = in_degrees(float(check["limit"]), str(check["unit"]))
    return (
        f"<tr><td>{escape(str(check['name']))}</td><td>{figure(value)} {escape(unit)}</td>"
        f"<td>{relation} {limit:.4g} {escape(unit)}</td><td class='{verdict[0]}'>{verdict[1]}</td></tr>"
    )


def in_degrees(value: float, unit: str) -> tuple[float, str]:
    """A value and its unit for people, who read degrees."""
    if unit.startswith("rad"):
        return math.degrees(value), unit.replace("rad", "°", 1)
    return value, unit.replace("deg", "°", 1)


def figure(value: object) -> str:
    """A number for people; anything else as it is."""
    if not isinstance(value, int | float):
        return str(value)
    return f"{value:.4g}" if abs(value) >= 1e-3 or value == 0 else f"{value:.5f}"


def _pictures(recorded: Recorded) -> str:
    """The scenario's own pictures."""
    if recorded.result is None:
        return ""
    parts = []
    for path in _png_files(recorded.log.folder):
        data = base64.b64encode(path.read_bytes()).decode()
        image = f"<img class='picture' alt='{escape(path.stem)}' src='data:image/png;base64,{data}'>"
        parts.append(f"<div class='wide'>{image}</div>")
    return f"<h2>Picture</h2>{''.join(parts)}" if parts else ""


def _png_files(folder: Path) -> Sequence[Path]:
    return [path for path in sorted(folder.glob("*.png")) if path.stat().st_size < _MOST_PICTURE]
