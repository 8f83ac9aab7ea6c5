"""`companion identify`: a log → the hull that sailed it, as lines for the vessel's TOML, figures for a person and a plot of the fit."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path

from companion.config import DampingConfig, HullConfig
from companion.record.hull_fit import Drag, Estimate, HullFit, fit
from companion.record.hull_model import INERTIA, HullModel, axis_drag
from companion.record.log_reader import Log, LogError
from companion.record.manoeuvre import Manoeuvre, read_manoeuvre

TOML_FILE = "identified.toml"
PLOT_FILE = "identified.png"
_AXES = (("surge", "m/s"), ("sway", "m/s"), ("yaw rate", "rad/s"))
_ENOUGH = 0.25  # relative uncertainty of a damping above which the manoeuvre should have been another
_ADVICE = (
    "go ahead and astern more, at several speeds",
    "go sideways more, both ways",
    "turn more, both ways and at several rates",
)


@dataclass(frozen=True, slots=True)
class Identification:
    """`report` is for a person, `toml` for the vessel's file; `plot` is None where matplotlib is not installed."""

    fit: HullFit
    report: str
    toml: str
    plot: Path | None
    warnings: tuple[str, ...]


def identify(log: Log, out: Path, from_s: float = 0.0, to_s: float = math.inf, hold: Sequence[str] = ()) -> Identification:
    """Fit, and write `identified.toml` and `identified.png` into `out`. Raises LogError for a log that does not do or a quantity to hold
    that is none, OSError for a file."""
    warnings: list[str] = []
    manoeuvre = read_manoeuvre(log, warnings, from_s, to_s)
    model = HullModel(log, manoeuvre)
    unknown = [name for name in hold if name not in model.model]
    if unknown:
        raise LogError(f"nothing named {', '.join(unknown)} to hold; there is {', '.join(model.model)}")
    found = fit(log, manoeuvre, hold)
    warnings += advice(model, found)
    toml = toml_lines(log, found)
    out.mkdir(parents=True, exist_ok=True)
    (out / TOML_FILE).write_text(toml, encoding="utf-8")
    plotted: Path | None = out / PLOT_FILE
    try:
        plot(model, found, out / PLOT_FILE)
    except ImportError:
        plotted = None
        warnings.append("no plot: matplotlib is not installed (pip install 'usv-companion[report]')")
    return Identification(found, report(found, manoeuvre), toml, plotted, tuple(warnings))


def advice(model: HullModel, found: HullFit) -> list[str]:
    """Which manoeuvres are missing, one line for each axis or group of thrusters of which the log tells too little."""
    lines = []
    by_name = {estimate.name: estimate for estimate in found.estimates}
    for axis, ((name, _), drag) in enumerate(zip(_AXES, found.drags, strict=True)):
        if not drag.told:
            lines.append(f"{name} damping is not told by this log and stays as it was: {_ADVICE[axis]}")
        elif drag.sigma > _ENOUGH * abs(drag.force):
            lines.append(f"{name} damping is uncertain by {drag.sigma / abs(drag.force):.0%}: {_ADVICE[axis]}")
        elif by_name[INERTIA[axis]].held and by_name[INERTIA[axis]].held != "as asked":
            lines.append(f"{INERTIA[axis]} is not told by this log and stays as it was: {_ADVICE[axis]}, and change it quickly")
    for group in model.groups:
        if by_name[f"x_m {group.name}"].held not in ("", "as asked"):
            lines.append(f"where {group.name} push is not told by this log: go sideways and turn with them")
    return lines


def report(found: HullFit, manoeuvre: Manoeuvre) -> str:
    """A line for each quantity, the damping at the speeds sailed, and how well the model follows the log."""
    seconds = sum(end - first for first, end in manoeuvre.stretches) * manoeuvre.period_s
    wind = "no wind sensor: gusts as a slow disturbance" if manoeuvre.wind_mps is None else "with the measured wind"
    lines = [f"{seconds:.0f} s of manoeuvre, {wind}; one-sigma uncertainties", f"{'':34}{'identified':>12}{'±':>10}{'model':>12}"]
    for e in found.estimates:
        doubt = "held" if e.sigma is None else f"{e.sigma:.3g}"
        lines.append(f"{e.name:34}{e.value:12.4g}{doubt:>10}{e.model:12.4g}  {e.held}".rstrip())
    lines += [_drag_line(name, unit, axis, drag) for axis, ((name, unit), drag) in enumerate(zip(_AXES, found.drags, strict=True))]
    lines += [
        f"{axis}: {share:.1%} of the motion explained by the forces alone, {rms:.4f} {unit} RMS left"
        for (axis, unit), share, rms in zip(_AXES, found.explained, found.residual_rms, strict=True)
    ]
    surge, sway, yaw = found.gusts
    lines.append(f"beside the model, gusts of {surge:.2f} N, {sway:.2f} N and {yaw:.2f} Nm RMS (surge, sway, yaw)")
    return "\n".join(lines)


def _drag_line(name: str, unit: str, axis: int, drag: Drag) -> str:
    force = "Nm" if axis == 2 else "N"
    return f"{name} damping at {drag.speed:.3g} {unit}: {drag.force:.3g} ± {drag.sigma:.2g} {force} (model {drag.model:.3g})"


def toml_lines(log: Log, found: HullFit) -> str:
    """The `[hull]` tables with what was found, and below them, as comments, what the fit says of the thrusters."""
    by_name = {estimate.name: estimate for estimate in found.estimates}
    hull = found.hull
    lines = [f"# identified from {log.folder.name}; ± one sigma", "[hull]"]
    for spec in fields(HullConfig):
        value = getattr(hull, spec.name)
        if isinstance(value, float):
            lines.append(_line(spec.name, value, by_name.get(spec.name)))
    lines.append("[hull.damping]")
    lines += [_line(s.name, getattr(hull.damping, s.name), by_name[s.name]) for s in fields(DampingConfig) if s.name in by_name]
    lines += ["", f"# thruster lag {by_name['lag_s'].value:.2f} s. The hull above goes with these thrusters:"]
    for before, after in zip(log.config.thrusters, found.thrusters, strict=True):
        lines.append(
            f"# {before.name}: x_m = {after.x_m:.3f} (was {before.x_m:g}), ahead_n = {after.ahead_n:.3f} (was {before.ahead_n:g}), "
            f"astern_n = {after.astern_n:.3f} (was {before.astern_n:g})"
        )
    return "\n".join(lines) + "\n"


def _line(name: str, value: float, estimate: Estimate | None) -> str:
    text = f"{name} = {value:.2f}"
    if estimate is None or estimate.sigma is None:
        return f"{text:24}# as it was: {estimate.held if estimate is not None and estimate.held else 'not identified'}"
    return f"{text:24}# ± {estimate.sigma:.2g}"


def plot(model: HullModel, found: HullFit, path: Path) -> None:
    """The log's velocities with those of the fitted and of the old model, and the damping of both over the speeds sailed. Raises ImportError
    without matplotlib."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(12.0, 8.0), layout="constrained")
    FigureCanvasAgg(figure)
    grid = figure.subplots(3, 2, width_ratios=(3, 1))
    manoeuvre = model.manoeuvre
    before = model.simulate(model.model)
    for axis, (name, unit) in enumerate(_AXES):
        track, curve = grid[axis]
        measured = manoeuvre.velocity[:, axis]
        track.plot(manoeuvre.t_s, measured, color="0.6", linewidth=3.0, label="log")
        track.plot(manoeuvre.t_s, before[:, axis], color="tab:orange", linewidth=0.8, label="model before")
        track.plot(manoeuvre.t_s, found.simulated[:, axis], color="tab:blue", linewidth=1.0, label="identified")
        span = float(abs(measured).max()) or 1.0
        track.set(ylabel=f"{name} [{unit}]", ylim=(-1.4 * span, 1.4 * span))
        speeds = [span * (k / 40.0 - 1.0) for k in range(81)]
        for hull, colour in ((model.log.config.hull, "tab:orange"), (found.hull, "tab:blue")):
            curve.plot(speeds, [axis_drag(hull, axis, speed) for speed in speeds], color=colour)
        curve.set(ylabel=("drag [N]", "drag [N]", "drag [Nm]")[axis], xlabel=f"{name} [{unit}]")
        curve.locator_params(axis="x", nbins=5)
        for panel in (track, curve):
            panel.grid(alpha=0.3)
    grid[0][0].legend(loc="upper right", ncols=3)
    grid[0][0].set_title(f"{model.log.config.title}: the velocities that the forces explain")
    grid[0][1].set_title("damping at the speeds sailed")
    grid[2][0].set_xlabel("t [s]")
    figure.savefig(path, dpi=100)

