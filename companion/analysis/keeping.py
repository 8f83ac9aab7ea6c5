"""How well a boat kept its place: from a log's Hold, or from the first point of a Trial's positioning."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from companion.analysis.log_reader import LogError, read_table
from companion.analysis.trial_log import manoeuvres

Array = NDArray[np.float64]
_POSITIONING_S = 45.0  # of `positioning`, in which the boat keeps its first point
_SETTLE_S = 10.0  # of it, in which it comes to rest
_HOLD_SETTLE_S = 30.0
_LEAST_S = 45.0  # of Hold, from which it says something


@dataclass(frozen=True, slots=True)
class Keeping:
    """Places of the boat around their mean, in m towards north and east, and its heading around the mean, rad. `how`:
    which boat and model, for people."""

    how: str
    seconds: float
    north_m: Array
    east_m: Array
    yaw_rad: Array

    @property
    def rms_m(self) -> float:
        """Distance from the mean place."""
        return math.sqrt(float((self.north_m**2 + self.east_m**2).mean()))

    @property
    def within_m(self) -> float:
        """Radius around the mean place that holds 95 % of the time."""
        return float(np.quantile(np.hypot(self.north_m, self.east_m), 0.95))

    @property
    def heading_rms_rad(self) -> float:
        """Of the heading around its mean."""
        return math.sqrt(float((self.yaw_rad**2).mean()))


def kept(path: Path, how: str, from_s: float, to_s: float) -> Keeping | None:
    """Between two times of a `ticks.csv` or `truth.csv`; None without a row. Raises LogError, OSError."""
    table = read_table(path, ("t_s", "north_m", "east_m", "yaw_rad"), [])
    t_s, north, east, yaw = (np.array(table[name]) for name in ("t_s", "north_m", "east_m", "yaw_rad"))
    use = (t_s >= from_s) & (t_s < to_s) & np.isfinite(north + east + yaw)
    if not use.any():
        return None
    turn = np.unwrap(yaw[use])
    return Keeping(how, to_s - from_s, north[use] - north[use].mean(), east[use] - east[use].mean(), turn - turn.mean())


def measured(folder: Path, how: str) -> Keeping | None:
    """Of a log's Trial, or of its longest time in Hold; None where it has neither. Raises LogError, OSError."""
    for ran in reversed(manoeuvres(folder)):
        if ran.name == "positioning":
            return kept(folder / "ticks.csv", how, ran.from_s + _SETTLE_S, ran.from_s + _POSITIONING_S)
    span = _longest_hold(folder / "ticks.csv")
    if span is None or span[1] - span[0] < _HOLD_SETTLE_S + _LEAST_S:
        return None
    return kept(folder / "ticks.csv", how, span[0] + _HOLD_SETTLE_S, span[1])


def _longest_hold(path: Path) -> tuple[float, float] | None:
    """The longest time without a break in which an armed boat was in Hold. Raises LogError, OSError."""
    changes: list[tuple[float, bool]] = []
    with path.open(encoding="utf-8", newline="", errors="replace") as file:
        last_s = 0.0
        for row in csv.DictReader(file):
            try:
                last_s = float(row["t_s"])
                holds = row["mode"] == "Hold" and row["armed"] == "1"
            except KeyError as error:
                raise LogError(f"{path}: no column {error}") from error
            except (TypeError, ValueError):
                continue  # the incomplete last line of a log that is still written
            if not changes or changes[-1][1] is not holds:
                changes.append((last_s, holds))
    ends = [*changes, (last_s, False)]
    spans = [(first[0], after[0]) for first, after in pairwise(ends) if first[1]]
    return max(spans, key=lambda span: span[1] - span[0], default=None)
