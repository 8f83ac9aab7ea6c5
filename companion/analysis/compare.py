"""Compare two logs of one run, tick by tick: where they first differ, and the largest differences."""

from __future__ import annotations

import csv
import itertools
import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

from companion.analysis.log_reader import seconds
from companion.core.angles import wrap_pi

_GROUPS = (
    ("position", "m", ("north_m", "east_m")),
    ("heading", "rad", ("yaw_rad",)),
    ("velocity", "m/s", ("surge_mps", "sway_mps")),
    ("yaw rate", "rad/s", ("yaw_rate_radps",)),
    ("desired position", "m", ("desired_north_m", "desired_east_m")),
    ("desired heading", "rad", ("desired_yaw_rad",)),
    ("demanded force", "N", ("demanded_surge_n", "demanded_sway_n")),
    ("demanded moment", "Nm", ("demanded_yaw_nm",)),
    ("achieved force", "N", ("achieved_surge_n", "achieved_sway_n")),
    ("achieved moment", "Nm", ("achieved_yaw_nm",)),
)
_WORDS = ("mode", "armed", "failsafes", "mission_seq")
_SHOWN = 4
_ROUNDED_S = 0.00051  # both files have milliseconds
_NOT_OURS = frozenset({"link", "storage"})  # events of sockets and disks, which a replay does not have


@dataclass(slots=True)
class Largest:
    """The largest difference of one quantity, and its time."""

    name: str
    unit: str
    size: float = 0.0
    t_s: float = 0.0


@dataclass(slots=True)
class LogDifference:
    """What the comparison found. `first`: a line for the first tick that differs, empty for none. `words`: number of
    ticks with another mode, arming, failsafe or mission item. `missing_ticks`: those that only one log has.
    `lost_ticks`: those at the log's end whose inputs it has lost, so that they were not done again."""

    ticks: int = 0
    differing: int = 0
    first: str = ""
    first_event: str = ""
    largest: list[Largest] = field(default_factory=lambda: [Largest(name, unit) for name, unit, _ in _GROUPS])
    words: dict[str, int] = field(default_factory=lambda: dict.fromkeys(_WORDS, 0))
    missing_ticks: int = 0
    lost_ticks: int = 0
    warnings: list[str] = field(default_factory=list)

    @property
    def same(self) -> bool:
        """Whether both agree to the last digit of ticks.csv and in every event."""
        return not self.differing and not self.missing_ticks and not self.first_event

    def within(self, tolerance: float) -> bool:
        """Whether no quantity differs by more than `tolerance`, in its own unit, and no decision differs."""
        return (
            not self.missing_ticks
            and not any(self.words.values())
            and all(one.size <= tolerance for one in self.largest)
        )

    def report(self) -> str:
        """The comparison for a person."""
        lost = [f"{self.lost_ticks} ticks at the end are not done again: the log has lost their inputs"]
        lost = lost if self.lost_ticks else []
        if self.same:
            return "\n".join([f"{self.ticks} ticks: the same to the last digit, events too", *lost])
        lines = [f"{self.ticks} ticks, {self.differing} of them different from the log", *lost]
        lines += [f"{self.missing_ticks} ticks are in only one of the two"] if self.missing_ticks else []
        lines += [f"first: {self.first}"] if self.first else []
        lines += [f"first event: {self.first_event}"] if self.first_event else []
        lines += [
            f"  {one.name:18} {one.size:12.3e} {one.unit:6} at {one.t_s:.1f} s"
            for one in self.largest
            if one.size > 0.0
        ]
        lines += [f"  another {name} in {count} ticks" for name, count in self.words.items() if count]
        return "\n".join(lines)


def compare(recorded: Path, again: Path, done: int, warnings: list[str]) -> LogDifference:
    """Compare `ticks.csv` and `events.csv` of two log folders. `done`: how many ticks were done again. Raises
    OSError."""
    result, last_s = LogDifference(warnings=warnings), -math.inf
    both = itertools.zip_longest(_rows(recorded / "ticks.csv"), _rows(again / "ticks.csv"))
    for number, (then, now) in enumerate(both):
        if then is None or now is None:
            lost = now is None and number >= done
            result.lost_ticks += lost
            result.missing_ticks += not lost
            continue
        result.ticks += 1
        last_s = float(then["t_s"])
        if then != now:
            _add(result, then, now)
    result.first_event = _first_event(recorded / "events.csv", again / "events.csv", last_s + _ROUNDED_S)
    return result


def _add(result: LogDifference, then: dict[str, str], now: dict[str, str]) -> None:
    columns = [name for name in then if name in now and then[name] != now[name]]
    if not columns:
        return
    t_s = float(then["t_s"])
    result.differing += 1
    if not result.first:
        shown = ", ".join(f"{name} {then[name] or 'none'} → {now[name] or 'none'}" for name in columns[:_SHOWN])
        more = f" and {len(columns) - _SHOWN} more" if len(columns) > _SHOWN else ""
        result.first = f"at {t_s:.1f} s in {then['mode']}: {shown}{more}"
    for name in _WORDS:
        result.words[name] += name in columns
    for largest, (_, unit, names) in zip(result.largest, _GROUPS, strict=True):
        size = math.hypot(*(_distance(then.get(name, ""), now.get(name, ""), unit) for name in names))
        if size > largest.size:
            largest.size, largest.t_s = size, t_s


def _distance(then: str, now: str, unit: str) -> float:
    """Difference of two cells; 0 where a value is missing in one of them."""
    if not then or not now:
        return 0.0
    difference = float(now) - float(then)
    if unit == "rad":
        difference = wrap_pi(difference)
    return difference if math.isfinite(difference) else math.inf


def _rows(path: Path) -> Iterator[dict[str, str]]:
    """Whole rows with a time; an incomplete last one is omitted."""
    with path.open(encoding="utf-8", errors="replace", newline="\n") as file:
        for row in csv.DictReader(line for line in file if line.endswith("\n")):
            if None not in row.values() and seconds(row.get("t_s")) is not None:
                yield row


def _first_event(recorded: Path, again: Path, until_s: float) -> str:
    thens, nows = (
        [row for row in _rows(path) if row["name"] not in _NOT_OURS and float(row["t_s"]) <= until_s]
        for path in (recorded, again)
    )
    for then, now in itertools.zip_longest(thens, nows):
        if then != now:
            row = then or now or {}
            said, says = (one["text"] if one else "nothing" for one in (then, now))
            return f"at {float(row['t_s']):.1f} s: was “{said}”, now “{says}”"
    return ""
