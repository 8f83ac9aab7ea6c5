"""`companion replay`: the recorded readings through today's code, compared with what the log says and with the truth where there is one.

The estimator is run on the very readings, at the very times of the ticks. With `whole`, today's controller and allocation follow on the
replayed estimate and the recorded setpoints; modes and guidance are not run again, since what ground stations asked for is not in the
file, and the boat would have moved otherwise.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from companion.allocation.allocator import Allocator
from companion.control.controller import Controller
from companion.core.angles import wrap_pi
from companion.core.types import ZERO_WRENCH, Allocation, NavState, SetpointKind, Wrench
from companion.nav.estimator import Estimator
from companion.record import readings
from companion.record.log_reader import Log, LogError, parameters_of, read_table
from companion.record.readings import RecordedTick, read_ticks

_POSE = ("north_m", "east_m", "yaw_rad", "surge_mps", "sway_mps", "yaw_rate_radps")
_WRENCH = ("surge_n", "sway_n", "yaw_nm")
_TRUTH_REACH_S = 0.06  # a row of the truth this near to a tick is of that tick


@dataclass(slots=True)
class Spread:
    """Largest and RMS of a difference."""

    unit: str
    largest: float = 0.0
    count: int = 0
    _squares: float = 0.0

    def add(self, difference: float) -> None:
        size = abs(difference) if math.isfinite(difference) else math.inf
        self.largest = max(self.largest, size)
        self._squares += size * size
        self.count += 1

    @property
    def rms(self) -> float:
        return math.sqrt(self._squares / self.count) if self.count else 0.0


@dataclass(slots=True)
class Comparison:
    """How far two accounts of the same motion are apart."""

    position: Spread = field(default_factory=lambda: Spread("m"))
    heading: Spread = field(default_factory=lambda: Spread("rad"))
    velocity: Spread = field(default_factory=lambda: Spread("m/s"))
    yaw_rate: Spread = field(default_factory=lambda: Spread("rad/s"))

    def add(self, pose: Sequence[float], other: Sequence[float]) -> None:
        """Both as `RecordedTick.pose`."""
        self.position.add(math.hypot(pose[0] - other[0], pose[1] - other[1]))
        self.heading.add(wrap_pi(pose[2] - other[2]))
        self.velocity.add(math.hypot(pose[3] - other[3], pose[4] - other[4]))
        self.yaw_rate.add(pose[5] - other[5])

    def rows(self) -> list[tuple[str, Spread]]:
        return [("position", self.position), ("heading", self.heading), ("velocity", self.velocity), ("yaw rate", self.yaw_rate)]


@dataclass(slots=True)
class Replay:
    """What came of it. `against_truth` is None without truth.csv; it counts only ticks at which the recorded run was armed."""

    ticks: int
    against_log: Comparison
    against_truth: Comparison | None
    wrenches: dict[str, Spread]
    warnings: list[str]

    def largest_in_log(self) -> float:
        """Over all quantities that were compared with the log, each in its own unit."""
        return max(spread.largest for spread in (*(s for _, s in self.against_log.rows()), *self.wrenches.values()))

    def report(self) -> str:
        """For a person: a line for each quantity."""
        lines = [f"{self.ticks} ticks" + " " * 22 + "largest          RMS"]
        groups = [("against the log", self.against_log.rows()), ("", list(self.wrenches.items()))]
        if self.against_truth is not None:
            groups.append(("against the truth (armed)", self.against_truth.rows()))
        for title, rows in groups:
            lines += [title] if title else []
            lines += [f"  {name:22} {spread.largest:12.3e} {spread.rms:12.3e} {spread.unit}" for name, spread in rows]
        return "\n".join(lines)


class _Again:
    """Today's blocks, fed from the recording. Remembers what the vessel would: the achieved wrench."""

    def __init__(self, log: Log, warnings: list[str], whole: bool) -> None:
        self._warnings = warnings
        self.parameters = parameters_of(log, warnings)
        self._period_s = 1.0 / log.config.control_rate_hz
        self._estimator = Estimator(log.config, self.parameters)
        self._controller = Controller(log.config, self.parameters) if whole else None
        self._allocator = Allocator(log.config, self.parameters)
        self._thrusters = len(log.config.thrusters)
        self._achieved: Wrench = ZERO_WRENCH

    def estimate(self, tick: RecordedTick) -> NavState:
        for name, value in tick.parameters:
            if (refusal := self.parameters.set(name, value)) is not None:
                self._warnings.append(f"parameter {name} = {value:g} not taken over: {refusal.name.lower().replace('_', ' ')}")
        return self._estimator.update(tick.readings, tick.t_s)

    def control(self, tick: RecordedTick, nav: NavState) -> tuple[Wrench, Wrench] | None:
        """(demanded, achieved), None without control."""
        if self._controller is None:
            return None
        for i in range(self._thrusters):
            self._allocator.set_failed(i, i in tick.left_out)
        demanded = self._controller.update(tick.setpoint, nav, self._achieved, self._period_s)
        allocation = self._allocate(tick, demanded)
        self._achieved = allocation.achieved
        return demanded, allocation.achieved

    def _allocate(self, tick: RecordedTick, demanded: Wrench) -> Allocation:
        setpoint = tick.setpoint
        if not tick.armed or setpoint.kind is SetpointKind.NEUTRAL:
            return self._allocator.neutral()
        if setpoint.kind is SetpointKind.THRUSTERS and setpoint.thrusters is not None:
            return self._allocator.direct(setpoint.thrusters)
        return self._allocator.update(demanded, self._period_s)


def replay(log: Log, out: Path, whole: bool = False) -> Replay:
    """Do a run's estimate again and write it to `out` as CSV, one row a tick. Raises LogError when nothing was recorded, OSError for a file."""
    path = log.folder / readings.FILE
    if not path.exists():
        raise LogError(f"{path}: not there: this log was recorded without its readings")
    warnings: list[str] = []
    again = _Again(log, warnings, whole)
    truth = _truth(log.folder, warnings)
    result = Replay(0, Comparison(), None if truth is None else Comparison(), _spreads() if whole else {}, warnings)
    with out.open("w", encoding="utf-8") as file:
        file.write(",".join(("t_s", *_POSE, *(f"recorded_{name}" for name in _POSE), *(_columns() if whole else ()))) + "\n")
        for tick in read_ticks(path, warnings):
            nav = again.estimate(tick)
            pose = (nav.north_m, nav.east_m, nav.yaw_rad, nav.surge_mps, nav.sway_mps, nav.yaw_rate_radps)
            result.ticks += 1
            result.against_log.add(pose, tick.pose)
            if truth is not None and result.against_truth is not None and tick.armed and (row := truth.at(tick.t_s)) is not None:
                result.against_truth.add(pose, row)
            wrenches = again.control(tick, nav)
            if wrenches is not None:
                _compare(result.wrenches, tick, *wrenches)
            file.write(_row(tick, pose, wrenches))
    if not result.ticks:
        raise LogError(f"{path}: holds no whole tick")
    return result


def _columns() -> Iterable[str]:
    return (f"{what}_{name}" for what in ("demanded", "achieved") for name in _WRENCH)


def _spreads() -> dict[str, Spread]:
    return {f"{what} {axis}": Spread(unit) for what in ("demanded", "achieved") for axis, unit in (("surge", "N"), ("sway", "N"), ("yaw", "Nm"))}


def _compare(spreads: dict[str, Spread], tick: RecordedTick, demanded: Wrench, achieved: Wrench) -> None:
    for what, now, then in (("demanded", demanded, tick.demanded), ("achieved", achieved, tick.achieved)):
        spreads[f"{what} surge"].add(now.surge_n - then.surge_n)
        spreads[f"{what} sway"].add(now.sway_n - then.sway_n)
        spreads[f"{what} yaw"].add(now.yaw_nm - then.yaw_nm)


def _row(tick: RecordedTick, pose: Sequence[float], wrenches: tuple[Wrench, Wrench] | None) -> str:
    values = [*pose, *tick.pose]
    for wrench in wrenches or ():
        values += [wrench.surge_n, wrench.sway_n, wrench.yaw_nm]
    return f"{tick.t_s:.6f}," + ",".join(f"{value:.9g}" for value in values) + "\n"


class _Truth:
    """Rows of truth.csv, looked up in the order of time."""

    def __init__(self, times_s: list[float], rows: list[tuple[float, ...]]) -> None:
        self._times_s, self._rows = times_s, rows
        self._at = 0

    def at(self, t_s: float) -> tuple[float, ...] | None:
        """The row nearest to `t_s`, None where there is none near. `t_s` must not go back."""
        times_s = self._times_s
        while self._at + 1 < len(times_s) and abs(times_s[self._at + 1] - t_s) <= abs(times_s[self._at] - t_s):
            self._at += 1
        return self._rows[self._at] if times_s and abs(times_s[self._at] - t_s) <= _TRUTH_REACH_S else None


def _truth(folder: Path, warnings: list[str]) -> _Truth | None:
    path = folder / "truth.csv"
    if not path.exists():
        return None
    table = read_table(path, ("t_s", *_POSE), warnings)
    return _Truth(table["t_s"], list(zip(*(table[name] for name in _POSE), strict=True)))
