"""The recorded readings through today's estimator, compared with the log, and with the truth where there is one.

The estimator gets the same readings at the same times of the ticks. `rerun` does the whole tick again.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from companion.analysis.log_reader import Log, LogError, parameters_of, read_table
from companion.baselines.ahrs import ThesisAhrs
from companion.core.actuation import Wrench
from companion.core.angles import wrap_pi
from companion.nav.estimator import Estimator
from companion.record import readings
from companion.record.readings import read_ticks

_POSE = ("north_m", "east_m", "yaw_rad", "surge_mps", "sway_mps", "yaw_rate_radps")
_TRUTH_REACH_S = 0.06  # largest time between a tick and its row of the truth


@dataclass(slots=True)
class Spread:
    """Largest and RMS of a difference."""

    unit: str
    largest: float = 0.0
    count: int = 0
    _squares: float = 0.0

    def add(self, difference: float) -> None:
        """Include one difference; one that is not finite counts as infinite."""
        size = abs(difference) if math.isfinite(difference) else math.inf
        self.largest = max(self.largest, size)
        self._squares += size * size
        self.count += 1

    @property
    def rms(self) -> float:
        """Root mean square; 0 of none."""
        return math.sqrt(self._squares / self.count) if self.count else 0.0


@dataclass(slots=True)
class Comparison:
    """Differences between two records of the same motion."""

    position: Spread = field(default_factory=lambda: Spread("m"))
    heading: Spread = field(default_factory=lambda: Spread("rad"))
    velocity: Spread = field(default_factory=lambda: Spread("m/s"))
    yaw_rate: Spread = field(default_factory=lambda: Spread("rad/s"))

    def add(self, pose: Sequence[float], other: Sequence[float]) -> None:
        """Include one tick; both poses as `RecordedTick.pose`."""
        self.position.add(math.hypot(pose[0] - other[0], pose[1] - other[1]))
        self.heading.add(wrap_pi(pose[2] - other[2]))
        self.velocity.add(math.hypot(pose[3] - other[3], pose[4] - other[4]))
        self.yaw_rate.add(pose[5] - other[5])

    def rows(self) -> list[tuple[str, Spread]]:
        """(name, spread) of each quantity."""
        return [
            ("position", self.position),
            ("heading", self.heading),
            ("velocity", self.velocity),
            ("yaw rate", self.yaw_rate),
        ]


@dataclass(slots=True)
class Replay:
    """The result. `against_truth`: None without truth.csv; it counts only ticks at which the recorded run was armed."""

    ticks: int
    against_log: Comparison
    against_truth: Comparison | None
    warnings: list[str]

    def largest_in_log(self) -> float:
        """The largest difference from the log over all quantities, each in its own unit."""
        return max(spread.largest for _, spread in self.against_log.rows())

    def report(self) -> str:
        """A line for each quantity, for a person."""
        lines = [f"{self.ticks} ticks" + " " * 22 + "largest          RMS"]
        groups = [("against the log", self.against_log.rows())]
        if self.against_truth is not None:
            groups.append(("against the truth (armed)", self.against_truth.rows()))
        for title, rows in groups:
            lines.append(title)
            lines += [f"  {name:22} {spread.largest:12.3e} {spread.rms:12.3e} {spread.unit}" for name, spread in rows]
        return "\n".join(lines)


def replay(log: Log, out: Path) -> Replay:
    """Compute a run's estimates again and write them to `out` as CSV, one row a tick.

    Raises LogError where the log has no readings, OSError.
    """
    path = readings.path_in(log.folder)
    if not path.exists():
        raise LogError(f"{path}: no such file: this log was recorded without its readings")
    warnings: list[str] = []
    parameters = parameters_of(log, warnings)
    estimator = Estimator(log.config, parameters, baseline_ahrs=ThesisAhrs)
    truth = _truth(log.folder, warnings)
    result = Replay(0, Comparison(), None if truth is None else Comparison(), warnings)
    thrust: Wrench | None = None  # as recorded: it moves the estimate while the receiver is silent
    with out.open("w", encoding="utf-8") as file:
        file.write(",".join(("t_s", *_POSE, *(f"recorded_{name}" for name in _POSE))) + "\n")
        for tick in read_ticks(path, warnings):
            for name, value in tick.parameters:
                if (refusal := parameters.set(name, value)) is not None:
                    warnings.append(f"parameter {name} = {value:g} refused: {refusal.name.lower().replace('_', ' ')}")
            nav = estimator.update(tick.readings, tick.t_s, thrust)
            thrust = tick.achieved if tick.armed else None
            pose = (nav.north_m, nav.east_m, nav.yaw_rad, nav.surge_mps, nav.sway_mps, nav.yaw_rate_radps)
            result.ticks += 1
            result.against_log.add(pose, tick.pose)
            if (
                truth is not None
                and result.against_truth is not None
                and tick.armed
                and (row := truth.at(tick.t_s)) is not None
            ):
                result.against_truth.add(pose, row)
            file.write(f"{tick.t_s:.6f}," + ",".join(f"{value:.9g}" for value in (*pose, *tick.pose)) + "\n")
    if not result.ticks:
        raise LogError(f"{path}: no whole tick")
    return result


class _Truth:
    """Rows of truth.csv, read in order of time."""

    def __init__(self, times_s: Sequence[float], rows: list[tuple[float, ...]]) -> None:
        self._times_s, self._rows = times_s, rows
        self._at = 0

    def at(self, t_s: float) -> tuple[float, ...] | None:
        """The row nearest to `t_s`; None where none is near. `t_s` must not decrease."""
        times_s = self._times_s
        while self._at + 1 < len(times_s) and abs(times_s[self._at + 1] - t_s) <= abs(times_s[self._at] - t_s):
            self._at += 1
        return self._rows[self._at] if times_s and abs(times_s[self._at] - t_s) <= _TRUTH_REACH_S else None


def _truth(folder: Path, warnings: list[str]) -> _Truth | None:
    path = folder / "truth.csv"
    if not path.exists():
        return None
    try:
        table = read_table(path, ("t_s", *_POSE), warnings)
    except LogError as error:
        warnings.append(str(error))
        return None
    return _Truth(table["t_s"], list(zip(*(table[name] for name in _POSE), strict=True)))
