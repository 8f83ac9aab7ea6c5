"""`companion identify`: a log → the hull that sailed it, as lines for the vessel's TOML, figures for a person and a plot of the fit."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path

from companion.config import DampingConfig, HullConfig
from companion.record.hull_fit import Estimate, HullFit, HullModel, fit
from companion.record.log_reader import Log, LogError
from companion.record.manoeuvre import Manoeuvre, read_manoeuvre

TOML_FILE = "identified.toml"
PLOT_FILE = "identified.png"
_AXES = (("surge", "m/s"), ("sway", "m/s"), ("yaw rate", "rad/s"))
_POOR = 0.5  # of the variance explained; below, the fit says little


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
    warnings += [
        f"{axis}: the fitted model explains {max(share, 0.0):.0%} of the motion; sail a livelier manoeuvre"
        for (axis, _), share in zip(_AXES, found.explained, strict=True)
        if share < _POOR
    ]
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


def report(found: HullFit, manoeuvre: Manoeuvre) -> str:
    """A line for each quantity, and how well the model follows the log."""
    seconds = sum(end - first for first, end in manoeuvre.stretches) * manoeuvre.period_s
    lines = [f"{seconds:.0f} s of manoeuvre; one-sigma uncertainties", f"{'':34}{'identified':>12}{'±':>10}{'model':>12}"]
    for e in found.estimates:
        doubt = "held" if e.sigma is None else f"{e.sigma:.3g}"
        lines.append(f"{e.name:34}{e.value:12.4g}{doubt:>10}{e.model:12.4g}  {e.held}".rstrip())
    lines += [
        f"{axis}: {share:.1%} of the motion explained, {rms:.4f} {unit} RMS left"
        for (axis, unit), share, rms in zip(_AXES, found.explained, found.residual_rms, strict=True)
    ]
    return "\n".join(lines)


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
            curve.plot(speeds, [_drag(hull, axis, speed) for speed in speeds], color=colour)
        curve.set(ylabel=("drag [N]", "drag [N]", "drag [Nm]")[axis], xlabel=f"{name} [{unit}]")
        curve.locator_params(axis="x", nbins=5)
        for panel in (track, curve):
            panel.grid(alpha=0.3)
    grid[0][0].legend(loc="upper right", ncols=3)
    grid[0][0].set_title(f"{model.log.config.title}: the velocities that the forces explain")
    grid[0][1].set_title("damping at the speeds sailed")
    grid[2][0].set_xlabel("t [s]")
    figure.savefig(path, dpi=100)


def _drag(hull: HullConfig, axis: int, speed: float) -> float:
    """Damping of one axis at its own speed alone."""
    d = hull.damping
    linear, quadratic, cubic = ((d.x_u, d.x_uu, d.x_uuu), (d.y_v, d.y_vv, 0.0), (d.n_r, d.n_rr, 0.0))[axis]
    return speed * (linear + abs(speed) * (quadratic + abs(speed) * cubic))
