"""A log → the hull that sailed it: lines for the vessel's TOML, figures for a person and a plot of the fit."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from companion.analysis.figure import MATPLOTLIB_MISSING, new_figure
from companion.analysis.hull_fit import Drag, Estimate, HullFit, fit
from companion.analysis.hull_model import CURRENT, INERTIA, LAG, HullModel, axis_drag
from companion.analysis.log_reader import Log, LogError
from companion.analysis.manoeuvre import Manoeuvre, read_manoeuvre
from companion.config.hull import DampingConfig, HullConfig
from companion.core.progress import Told, part, tell_nobody

TOML_FILE = "identified.toml"
PLOT_FILE = "identified.png"
_AXES = (("surge", "m/s"), ("sway", "m/s"), ("yaw rate", "rad/s"))
_READ, _FITTED = 0.15, 0.9  # shares of the whole after which the log is read, and the hull fitted
_OUTSIDE = 0.6  # of the length, from the middle: farther out than a thruster that hangs over the end
_BETTER = 0.9  # of the error of the model before, from which the new one is worth having
_ENOUGH = 0.25  # relative uncertainty of a damping above which another manoeuvre is advised
_ADVICE = (
    "go ahead and astern more, at several speeds",
    "go sideways more, both ways",
    "turn more, both ways and at several rates",
)


@dataclass(frozen=True, slots=True)
class Identification:
    """`report`: for a person; `toml`: for the vessel's file, and `better`: whether it is worth having there; `plot`:
    None where matplotlib is not installed."""

    fit: HullFit
    report: str
    toml: str
    plot: Path | None
    warnings: tuple[str, ...]
    better: bool


def identify(
    log: Log,
    out: Path,
    from_s: float = 0.0,
    to_s: float = math.inf,
    hold: Sequence[str] = (),
    told: Told = tell_nobody,
) -> Identification:
    """Fit, and write `identified.toml` and `identified.png` into `out`. `hold`: quantities to leave as they are.

    Raises LogError for an unsuitable log or an unknown quantity, OSError.
    """
    warnings: list[str] = []
    told("reading the log", 0.0)
    log = log.bare
    manoeuvre = read_manoeuvre(log, warnings, from_s, to_s)
    model = HullModel(log, manoeuvre)
    unknown = [name for name in hold if name not in model.model]
    if unknown:
        raise LogError(f"nothing named {', '.join(unknown)} to hold; there is {', '.join(model.model)}")
    found = fit(log, manoeuvre, hold, told=part(told, _READ, _FITTED))
    told("drawing", _FITTED)
    warnings += advice(model, found)
    told_less = verdict(model, found)
    warnings += told_less
    toml = toml_lines(log, found, told_less)
    out.mkdir(parents=True, exist_ok=True)
    (out / TOML_FILE).write_text(toml, encoding="utf-8")
    plotted: Path | None = out / PLOT_FILE
    try:
        plot(model, found, out / PLOT_FILE)
    except ImportError:
        plotted = None
        warnings.append(f"no plot: {MATPLOTLIB_MISSING}")
    return Identification(found, report(found, manoeuvre), toml, plotted, tuple(warnings), not told_less)


def advice(model: HullModel, found: HullFit) -> list[str]:
    """A line for each axis or group of thrusters that the log hardly determines: which manoeuvres are missing."""
    lines = []
    by_name = {estimate.name: estimate for estimate in found.estimates}
    for axis, ((name, _), drag) in enumerate(zip(_AXES, found.drags, strict=True)):
        if not drag.determined:
            lines.append(f"{name} damping is hardly determined by this log: {_ADVICE[axis]}")
        elif drag.sigma > _ENOUGH * abs(drag.force):
            lines.append(f"{name} damping is uncertain by {drag.sigma / abs(drag.force):.0%}: {_ADVICE[axis]}")
        elif by_name[INERTIA[axis]].held and by_name[INERTIA[axis]].held != "as asked":
            lines.append(f"{INERTIA[axis]} is hardly determined by this log: {_ADVICE[axis]}, and change it quickly")
    length_m = model.log.config.length_m
    for group in model.groups:
        place = by_name[f"x_m {group.name}"]
        if abs(place.value) > _OUTSIDE * length_m >= abs(group.x_m):
            lines.append(
                f"{group.name} would push at {place.value:.1f} m, outside the boat of {length_m:.1f} m: is a thruster "
                "reversed, or does it get another one's command? `companion thruster-test` tells"
            )
        elif place.held not in ("", "as asked"):
            lines.append(f"where {group.name} push is hardly determined by this log: go sideways and turn with them")
    return lines


def verdict(model: HullModel, found: HullFit) -> list[str]:
    """A line where the found hull, pushed by the log's forces, moves hardly more like the log than the hull of before
    does, in the same weather and with the same lag of the thrusters."""
    values = {one.name: one.value for one in found.estimates}
    weather = {name: values[name] for name in (*model.weather, *CURRENT, LAG)}
    before, after = (
        model.manoeuvre.velocity - simulated
        for simulated in (model.simulate({**model.model, **weather}), found.simulated)
    )
    scale = np.maximum((model.manoeuvre.velocity**2).mean(axis=0), 1e-12)
    share = math.sqrt(float((after**2 / scale).mean()) / max(float((before**2 / scale).mean()), 1e-12))
    if share < _BETTER:
        return []
    return [
        "keep the figures of the vessel's file: with those below it moves no more like this log "
        f"(error {share:.2g} of before). Sail a livelier manoeuvre, or a Trial"
    ]


def report(found: HullFit, manoeuvre: Manoeuvre) -> str:
    """A line for each quantity, the damping at the speeds in the log, and how well the model follows the log."""
    seconds = sum(end - first for first, end in manoeuvre.stretches) * manoeuvre.period_s
    wind = "no wind sensor: gusts as a slow disturbance" if manoeuvre.wind_mps is None else "with the measured wind"
    lines = [
        f"{seconds:.0f} s of manoeuvre, {wind}; one-sigma uncertainties",
        f"{'':34}{'identified':>12}{'±':>10}{'model':>12}",
    ]
    for e in found.estimates:
        doubt = "-" if e.sigma is None else f"{e.sigma:.3g}"
        lines.append(f"{e.name:34}{e.value:12.4g}{doubt:>10}{e.model:12.4g}  {e.held}".rstrip())
    lines += [
        _drag_line(name, unit, axis, drag)
        for axis, ((name, unit), drag) in enumerate(zip(_AXES, found.drags, strict=True))
    ]
    lines += [
        f"{axis}: {f'{share:.1%}' if share > 0.0 else 'nothing'} of the motion explained by the forces alone, "
        f"{rms:.4f} {unit} RMS left"
        for (axis, unit), share, rms in zip(_AXES, found.explained, found.residual_rms, strict=True)
    ]
    surge, sway, yaw = found.gusts
    lines.append(f"beside the model, gusts of {surge:.2f} N, {sway:.2f} N and {yaw:.2f} Nm RMS (surge, sway, yaw)")
    return "\n".join(lines)


def _drag_line(name: str, unit: str, axis: int, drag: Drag) -> str:
    force = "Nm" if axis == 2 else "N"
    value = f"{drag.force:.3g} ± {drag.sigma:.2g} {force}"
    return f"{name} damping at {drag.speed:.3g} {unit}: {value} (model {drag.model:.3g})"


def toml_lines(log: Log, found: HullFit, doubts: Sequence[str] = ()) -> str:
    """The `[hull]` tables with the result; below them, as comments, what the fit says of the thrusters. `doubts` stand
    above them."""
    by_name = {estimate.name: estimate for estimate in found.estimates}
    hull = found.hull
    lines = [f"# identified from {log.folder.name}; ± one sigma"]
    lines += [*(f"# {doubt}" for doubt in doubts), "[hull]"]
    if hull.form is not None:  # what else follows from the dimensions, such as the wind areas, still does
        lines.append(f'form = "{hull.form}"')
    if hull.resistance:
        lines.append(f"resistance = {[list(pair) for pair in hull.resistance]}")
    for spec in fields(HullConfig):
        value = getattr(hull, spec.name)
        if isinstance(value, float):
            lines.append(_line(spec.name, value, by_name.get(spec.name)))
    lines.append("[hull.damping]")
    lines += [
        _line(s.name, getattr(hull.damping, s.name), by_name[s.name])
        for s in fields(DampingConfig)
        if s.name in by_name
    ]
    lines += ["", f"# thruster lag {by_name['lag_s'].value:.2f} s. The hull above goes with these thrusters:"]
    for before, after in zip(log.config.thrusters, found.thrusters, strict=True):
        lines.append(f"# {before.name}:")
        for key in ("x_m", "ahead_n", "astern_n", "max_n", "min_n"):
            new, old = getattr(after, key), getattr(before, key)
            lines.append(f"#   {f'{key} = {new:.3f}':22}# was {old:g}")
    return "\n".join(lines) + "\n"


def _line(name: str, value: float, estimate: Estimate | None) -> str:
    text = f"{name} = {value:.5g}"
    if estimate is None or estimate.sigma is None:
        return f"{text:24}# {'as it was: not identified' if estimate is None else estimate.held}"
    return f"{text:24}# ± {estimate.sigma:.2g}"


def plot(model: HullModel, found: HullFit, path: Path) -> None:
    """Write a picture: velocities of the log, the fitted and the old model, and damping of both over speed.

    Raises ImportError without matplotlib.
    """
    figure = new_figure(12.0, 8.0)
    grid = figure.subplots(3, 2, width_ratios=(3, 1))
    manoeuvre = model.manoeuvre
    before = model.simulate(model.model)
    for axis, (name, unit) in enumerate(_AXES):
        track, curve = grid[axis]
        shown, unit = (math.degrees(1.0), "°/s") if unit == "rad/s" else (1.0, unit)  # people read degrees
        measured = shown * manoeuvre.velocity[:, axis]
        track.plot(manoeuvre.t_s, measured, color="0.6", linewidth=3.0, label="log")
        track.plot(manoeuvre.t_s, shown * before[:, axis], color="tab:orange", linewidth=0.8, label="model before")
        track.plot(manoeuvre.t_s, shown * found.simulated[:, axis], color="tab:blue", linewidth=1.0, label="identified")
        span = float(abs(measured).max()) or 1.0
        track.set(ylabel=f"{name}, {unit}", ylim=(-1.2 * span, 1.2 * span))
        speeds = [span * (k / 40.0 - 1.0) for k in range(81)]
        for hull, colour in ((model.log.config.hull, "tab:orange"), (found.hull, "tab:blue")):
            curve.plot(speeds, [axis_drag(hull, axis, speed / shown) for speed in speeds], color=colour)
        curve.set(ylabel=("drag, N", "drag, N", "drag, Nm")[axis], xlabel=f"{name}, {unit}")
        curve.locator_params(axis="x", nbins=5)
        for panel in (track, curve):
            panel.grid(alpha=0.3)
    grid[0][0].legend(loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, frameon=False, borderaxespad=0.2)
    figure.suptitle(f"{model.log.config.title}: the velocities that the forces explain")
    grid[0][1].set_title("damping at the speeds sailed")
    grid[2][0].set_xlabel("time, s")
    figure.savefig(path, dpi=100)
