"""Bollard pull: a thruster's force against its throttle, measured with a scale at the quay, as lines for the vessel's
TOML."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from companion.analysis.figure import new_figure

Array = NDArray[np.float64]

COLUMNS = ("throttle", "force_n")
_LEAST = 4  # fewest points with force on one side
_LEAST_THROTTLES = 2  # of which so many differ: a throttle measured again tells nothing of the shape
_PERCENT = 1.5  # throttles beyond this are in percent
_ODD_EXPONENT = 0.35  # an exponent further from 2 than this is reported
_POOR = 0.08  # residual RMS over the largest pull that is reported


class BollardError(ValueError):
    """A table to which no curve can be fitted: one line that says why and what to do."""


@dataclass(frozen=True, slots=True)
class Side:
    """One direction of turning: force at full throttle in N, its standard error, the best-fitting exponent, points."""

    full_n: float
    sigma_n: float
    exponent: float
    most_n: float  # largest pull measured
    points: int


@dataclass(frozen=True, slots=True)
class BollardFit:
    """F = K u|u| beyond the dead band, 0 inside. `astern` is None where not measured. `rms_n`: residual of the fit."""

    ahead: Side
    astern: Side | None
    dead_band: float
    rms_n: float
    throttle: Array  # (n,)
    force_n: Array  # (n,)

    def curve_n(self, throttle: Array) -> Array:
        """Force of the fitted curve, (n,) → (n,); NaN astern where that was not fitted."""
        full = np.where(throttle >= 0.0, self.ahead.full_n, math.nan if self.astern is None else self.astern.full_n)
        return np.where(np.abs(throttle) < self.dead_band, 0.0, full * throttle * np.abs(throttle))


def read_pulls(path: Path) -> tuple[Array, Array]:
    """(throttle, force_n), each (n,), from a CSV with these two columns. Throttle is −1 to 1, or in percent.

    Raises BollardError with the line, OSError.
    """
    throttle: list[float] = []
    force: list[float] = []
    try:
        with path.open(newline="", encoding="utf-8-sig") as file:
            lines = ["" if line.lstrip().startswith("#") else line.strip() for line in file]
    except UnicodeDecodeError as error:
        raise BollardError(f"{path}: not UTF-8 text: have the spreadsheet save it as CSV UTF-8") from error
    above = next((i for i, line in enumerate(lines) if line), 0)
    reader = csv.DictReader(lines[above:], skipinitialspace=True)
    missing = [name for name in COLUMNS if name not in (reader.fieldnames or ())]
    if missing:
        raise BollardError(
            f"{path}: no column {' and no column '.join(missing)}; the first line should read {','.join(COLUMNS)}"
        )
    for row in reader:
        try:
            u, n = float(row["throttle"]), float(row["force_n"])
        except (TypeError, ValueError) as error:
            raise BollardError(
                f"{path}:{above + reader.line_num}: {row['throttle']}, {row['force_n']}: must be two numbers"
            ) from error
        if not (math.isfinite(u) and math.isfinite(n)):
            raise BollardError(f"{path}:{above + reader.line_num}: not a finite number")
        throttle.append(u)
        force.append(n)
    u_all = np.array(throttle)
    if len(u_all) and np.max(np.abs(u_all)) > _PERCENT:
        u_all = u_all / 100.0
    if len(u_all) and np.max(np.abs(u_all)) > 1.0 + 1e-9:
        raise BollardError(f"{path}: throttles should be −1 to 1, or −100 to 100 percent")
    return u_all, np.array(force)


def fit(throttle: Array, force_n: Array) -> BollardFit:
    """The curve of least squares. The dead band is tried between each two measured throttles; each K has a closed form.

    A scale shows no sign: if all forces are positive, those at negative throttle count as astern. Raises BollardError
    where there are too few points.
    """
    if np.any(throttle < 0.0) and np.all(force_n >= 0.0):
        force_n = np.where(throttle < 0.0, -force_n, force_n)
    if np.sum(throttle * force_n) < 0.0:
        raise BollardError(
            "the force is opposite to the throttle: change the thruster's direction ('reversed' in the vessel's file), "
            "or the sign of the scale"
        )
    sizes = np.unique(np.abs(throttle))
    borders = [0.0, *(0.5 * (sizes[:-1] + sizes[1:]))]
    best: tuple[float, float] | None = None
    for border in borders:
        if border >= 0.5:
            break
        error = float(np.sum((force_n - _curve(throttle, force_n, border)) ** 2))
        if best is None or error < best[0] * (1.0 - 1e-9):
            best = error, border
    if best is None:
        raise BollardError("no measurements: throttle, force_n in at least four rows ahead")
    dead_band = float(best[1])
    ahead = _side(throttle, force_n, dead_band, 1.0)
    if ahead is None or ahead.most_n <= 0.0:
        raise BollardError(f"too few measurements ahead: at least {_LEAST} throttles that pull, from low to full")
    rms_n = math.sqrt(best[0] / len(throttle))
    return BollardFit(ahead, _side(throttle, force_n, dead_band, -1.0), dead_band, rms_n, throttle, force_n)


def _curve(throttle: Array, force_n: Array, dead_band: float) -> Array:
    curve = np.zeros_like(force_n)
    for sign in (1.0, -1.0):
        at = (sign * throttle >= dead_band) & (throttle != 0.0) & (np.sign(throttle) == sign)
        if np.any(at):
            shape = throttle[at] * np.abs(throttle[at])
            curve[at] = shape * max(0.0, float(np.sum(shape * force_n[at]) / np.sum(shape * shape)))
    return curve


def _side(throttle: Array, force_n: Array, dead_band: float, sign: float) -> Side | None:
    at = (sign * throttle > 0.0) & (np.abs(throttle) >= dead_band)
    size, pull = np.abs(throttle[at]), sign * force_n[at]
    if len(size) < _LEAST or len(np.unique(size)) < _LEAST_THROTTLES:
        return None
    shape = size * size
    full_n = float(np.sum(shape * pull) / np.sum(shape * shape))
    if full_n <= 0.0:
        return None
    left = pull - full_n * shape
    sigma_n = math.sqrt(float(np.sum(left * left)) / max(1, len(pull) - 1) / float(np.sum(shape * shape)))
    positive = pull > 0.0
    exponent = (
        float(np.polyfit(np.log(size[positive]), np.log(pull[positive]), 1)[0])
        if np.count_nonzero(positive) >= 3 and len(np.unique(size[positive])) >= _LEAST_THROTTLES
        else 2.0
    )
    return Side(full_n, sigma_n, exponent, float(np.max(pull)), int(np.count_nonzero(at)))


def report(found: BollardFit) -> str:
    """The fitted values for a person, and doubts about them."""
    lines = []
    for name, side in (("ahead", found.ahead), ("astern", found.astern)):
        if side is None:
            lines.append(f"{name}: too few points, not fitted")
            continue
        lines.append(
            f"{name}: {side.full_n:.1f} ± {side.sigma_n:.1f} N at full throttle, "
            f"from {side.points} points up to {side.most_n:.1f} N"
        )
        if abs(side.exponent - 2.0) > _ODD_EXPONENT:
            lines.append(
                f"  the force grows as throttle^{side.exponent:.1f}, not as its square: "
                "does the motor controller regulate current, not speed?"
            )
    lines.append(f"dead band: {100.0 * found.dead_band:.1f} % of throttle")
    share = found.rms_n / found.ahead.most_n
    lines.append(f"residual of the curve: {found.rms_n:.2f} N RMS ({100.0 * share:.1f} % of the largest pull)")
    if share > _POOR:
        lines.append("  that is large: did the boat lie still, the scale settle, the battery hold its voltage?")
    return "\n".join(lines)


def toml_lines(found: BollardFit, name: str) -> str:
    """Lines for the thruster's table in the vessel's file."""
    lines = [
        f"# thruster '{name}', by bollard pull",
        f"ahead_n = {found.ahead.full_n:.4g}",
        f"max_n = {min(found.ahead.full_n, found.ahead.most_n):.4g}",
    ]
    if found.astern is not None:
        lines += [
            f"astern_n = {found.astern.full_n:.4g}",
            f"min_n = {-min(found.astern.full_n, found.astern.most_n):.4g}",
        ]
    lines += [f"dead_band = {found.dead_band:.3f}", ""]
    return "\n".join(lines)


def plot(found: BollardFit, name: str, path: Path) -> None:
    """Write a picture of the measured pulls, the curve and the residual. Raises ImportError without matplotlib."""
    figure = new_figure(9.0, 6.0)
    pull, left = figure.subplots(2, 1, height_ratios=(3, 1), sharex=True)
    low = float(min(0.0, np.min(found.throttle)))
    at = np.linspace(low, 1.0, 801)
    pull.plot(at, found.curve_n(at), color="tab:blue", label="fitted")
    pull.plot(found.throttle, found.force_n, "o", color="tab:orange", label="measured")
    pull.axvspan(-found.dead_band, found.dead_band, color="tab:gray", alpha=0.2, label="dead band")
    pull.set_ylabel("force, N")
    pull.set_title(f"bollard pull of {name}")
    left.plot(found.throttle, found.force_n - found.curve_n(found.throttle), "o", color="tab:orange")
    left.set_xlabel("throttle")
    left.set_ylabel("residual, N")
    for axes in (pull, left):
        axes.grid(alpha=0.3)
    pull.legend(loc="upper left")
    figure.savefig(path, dpi=80)
