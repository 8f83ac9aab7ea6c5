"""The report of a Trial: one HTML file with what was sailed, what it shows of the boat, and what changes and why."""

from __future__ import annotations

import io
import math
import tomllib
from collections.abc import Sequence
from dataclasses import replace
from html import escape
from pathlib import Path

import numpy as np

from companion.analysis import capability as polar
from companion.analysis.figure import MATPLOTLIB_MISSING, new_figure
from companion.analysis.imo import figures
from companion.analysis.keeping import Keeping
from companion.analysis.trial_identify import TrialIdentification
from companion.config.vessel import ConfigError, LimitsConfig, VesselConfig

_STYLE = """
body { font: 15px/1.5 system-ui, sans-serif; max-width: 1000px; margin: 2em auto; padding: 0 1em; color: #222; }
h1 { font-size: 1.5em; } h2 { font-size: 1.15em; margin-top: 2em; border-bottom: 1px solid #ccc; }
table { border-collapse: collapse; font-size: 0.9em; } th { border-bottom: 1px solid #ccc; }
td, th { padding: 0.15em 0.8em 0.15em 0; text-align: left; vertical-align: top; }
svg { width: 100%; height: auto; } pre { background: #f4f4f4; padding: 0.8em; overflow: auto; }
"""
_AXES = (("surge", "m/s"), ("sway", "m/s"), ("yaw rate", "rad/s"))


def after(found: TrialIdentification) -> VesselConfig:
    """The vessel as it is with the overlay."""
    config, over = found.log.config, tomllib.loads(found.overlay)
    config = replace(config, parameters={**config.parameters, **over.get("parameters", {})})
    if not found.better:
        return config
    limits = LimitsConfig(**over["limits"]) if "limits" in over else config.limits
    windage = replace(config.windage, **over.get("windage", {}))
    return replace(config, hull=found.fit.hull, windage=windage, thrusters=found.fit.thrusters, limits=limits)


def write_report(found: TrialIdentification, out: Path, kept: Sequence[Keeping] = ()) -> tuple[str, ...]:
    """Write the report; returns warnings. `kept`: station keeping before and after.

    Raises OSError, LogError.
    """
    warnings: list[str] = list(found.warnings)
    config = found.log.config
    current = (found.values["current_north_mps"], found.values["current_east_mps"])
    shown = figures(found.log.folder, found.ran, config.length_m, current, warnings)
    parts = [
        f"<h1>{escape(config.title)}: sea trial</h1>",
        f"<p>Log {escape(found.log.folder.name)}. Current {math.hypot(*current):.2f} m/s.</p>",
        "<h2>Manoeuvres</h2>",
        _table(
            ("manoeuvre", "from, s", "for, s", "end"),
            [
                (one.name, f"{one.from_s:.0f}", f"{one.to_s - one.from_s:.0f}", "at the circle" if one.cut else "done")
                for one in found.ran
            ],
        ),
        "<h2>Manoeuvring figures (IMO MSC.137(76))</h2>",
        _table(
            ("figure", "value", "lengths"),
            [(f.name, f"{f.value:.2f} {f.unit}", "" if f.lengths is None else f"{f.lengths:.1f} L") for f in shown],
        ),
        "<h2>What changes, and why</h2>",
        *_changes(found),
        "<h2>Sensors, and what the thrusters do near zero</h2>",
        *_checked(found),
        "<h2>Measured and predicted</h2>",
        _measured(found, warnings),
        "<h2>Wind that the boat holds against</h2>",
        _capability(found, warnings),
        "<h2>Station keeping</h2>",
        _keeping(kept, warnings),
        "<h2>Overlay</h2>",
        f"<pre>{escape(found.overlay)}</pre>",
    ]
    head = f"<head><meta charset='utf-8'><title>{escape(config.title)}: trial</title><style>{_STYLE}</style></head>"
    out.write_text(
        f"<!DOCTYPE html>\n<html lang='en'>{head}<body>\n" + "\n".join(parts) + "\n</body></html>\n", encoding="utf-8"
    )
    return tuple(warnings)


def _changes(found: TrialIdentification) -> list[str]:
    rows = []
    for e in found.fit.estimates:
        if e.name.startswith(("current", "wind_north", "wind_east", "north_n", "east_n", "aside_", "twist_")):
            continue
        doubt = e.held if e.sigma is None else f"± {1.96 * e.sigma:.2g}"
        rows.append((e.name, f"{e.model:.4g}", f"{e.value:.4g}", doubt))
    parts = [_table(("quantity", "before", "now", "95 % interval"), rows)]
    if (p := found.prediction) is not None:
        verdict = "the new model counts" if found.better else "the model of the file stays"
        parts.append(
            f"<p>Prediction over 10 s of manoeuvres that the fit has not seen: error {p.before:.3f} before, "
            f"{p.after:.3f} now, {p.ratio:.0%} of it; {verdict}.</p>"
        )
    parts.append(
        _table(
            ("bandwidth", "before", "now, rad/s", "gain margin", "phase margin", "limited by"),
            [
                (
                    d.name,
                    f"{d.before:.2f}",
                    f"{d.value:.2f}",
                    f"{d.gain_margin_db:.1f} dB",
                    f"{d.phase_margin_deg:.0f} deg",
                    d.limit,
                )
                for d in found.designs
            ],
        )
    )
    parts += [f"<p>{escape(line)}</p>" for line in found.warnings]
    return parts


def _checked(found: TrialIdentification) -> list[str]:
    rows = [
        (
            check.name,
            f"{check.file:.3g} {check.unit}",
            f"{check.value:.3g} ± {check.interval:.2g} {check.unit}" if check.told else "the log does not tell it",
            ("other than expected" if check.differs else "") if check.told else f"{check.would} would",
        )
        for check in found.checks
    ]
    if not rows:
        return ["<p>Not checked.</p>"]
    return [_table(("quantity", "file, or expected", "the log, 95 % interval", ""), rows)]


def _measured(found: TrialIdentification, warnings: list[str]) -> str:
    try:
        figure = new_figure(11.0, 7.0)
    except ImportError:
        warnings.append(f"no pictures: {MATPLOTLIB_MISSING}")
        return "<p>No picture.</p>"
    grid = figure.subplots(3, 1, sharex=True)
    manoeuvre, model = found.manoeuvre, found.model
    simulated, before = model.simulate(found.values), model.simulate(model.model)
    for axis, (name, unit) in enumerate(_AXES):
        measured = manoeuvre.velocity[:, axis]
        grid[axis].plot(manoeuvre.t_s, measured, color="0.6", linewidth=2.5, label="log")
        grid[axis].plot(manoeuvre.t_s, before[:, axis], color="tab:orange", linewidth=0.7, label="model before")
        grid[axis].plot(manoeuvre.t_s, simulated[:, axis], color="tab:blue", linewidth=0.9, label="model now")
        span = 1.4 * (float(np.abs(measured).max()) or 1.0)
        grid[axis].set(ylabel=f"{name} [{unit}]", ylim=(-span, span))
    grid[0].legend(loc="upper right", ncols=3)
    grid[2].set_xlabel("t [s]")
    if found.ran:
        grid[2].set_xlim(float(manoeuvre.t_s[0]), found.ran[-1].to_s + 5.0)
    return _svg(figure)


def _capability(found: TrialIdentification, warnings: list[str]) -> str:
    try:
        curves = [
            (label, polar.capability(config, directions=24))
            for label, config in (("before", found.log.config), ("now", after(found)))
        ]
    except ConfigError as error:
        return f"<p>{escape(str(error))}</p>"
    rows = [(label, f"{one.least_mps:.1f} m/s", f"{one.wind_mps[0]:.1f} m/s") for label, one in curves]
    table = _table(("", "from every direction", "from ahead"), rows)
    try:
        buffer = io.StringIO()
        polar.plot(found.log.config.title, curves, buffer)
    except ImportError:
        warnings.append(f"no pictures: {MATPLOTLIB_MISSING}")
        return table
    return table + _inner(buffer.getvalue())


def _keeping(kept: Sequence[Keeping], warnings: list[str]) -> str:
    """Table and picture of how the boat kept its place."""
    if not kept:
        return "<p>The trial did not come to it.</p>"
    rows = [
        (
            one.how,
            f"{one.seconds:.0f} s",
            f"{one.rms_m:.2f} m",
            f"{one.within_m:.2f} m",
            f"{math.degrees(one.heading_rms_rad):.1f} deg",
        )
        for one in kept
    ]
    table = _table(("", "for", "RMS from the mean place", "95 % within", "heading RMS"), rows)
    note = (
        "<p>Measured: by the boat's own estimate. Predicted: the boat as identified holds a point in simulation, "
        "in the mean wind and current of the trial, with the controller of before and of after.</p>"
    )
    try:
        return table + note + _places(kept)
    except ImportError:
        warnings.append(f"no pictures: {MATPLOTLIB_MISSING}")
        return table + note


def _places(kept: Sequence[Keeping]) -> str:
    """Where the boat was, one panel each, all to one scale; the circle holds 95 %."""
    figure = new_figure(3.6 * len(kept), 3.9)
    reach_m = 1.15 * max(float(np.hypot(one.north_m, one.east_m).max()) for one in kept) or 1.0
    turn = np.linspace(0.0, 2.0 * math.pi, 100)
    for panel, one in zip(figure.subplots(1, len(kept), squeeze=False)[0], kept, strict=True):
        panel.plot(one.east_m, one.north_m, color="tab:blue", linewidth=0.8)
        panel.plot(one.within_m * np.sin(turn), one.within_m * np.cos(turn), color="0.4", linestyle="--", linewidth=0.9)
        panel.set(xlim=(-reach_m, reach_m), ylim=(-reach_m, reach_m), aspect="equal", title=one.how)
        panel.set(xlabel="east [m]")
        panel.grid(alpha=0.3)
    figure.axes[0].set_ylabel("north [m]")
    return _svg(figure)


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    top = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><tr>{top}</tr>{body}</table>"


def _svg(figure: object) -> str:
    buffer = io.StringIO()
    figure.savefig(buffer, format="svg")  # type: ignore[attr-defined]
    return _inner(buffer.getvalue())


def _inner(text: str) -> str:
    """The svg element alone."""
    return text[text.index("<svg") :]
