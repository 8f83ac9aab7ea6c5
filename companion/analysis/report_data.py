"""The contents of a log folder for a report: ticks as arrays, events, and in simulation the truth."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from companion.analysis.log_reader import Log, LogError, open_log, read_table

Array = NDArray[np.float64]

_POSE = ("north_m", "east_m", "yaw_rad", "surge_mps", "sway_mps", "yaw_rate_radps")
_MOST_SAMPLES = 6000  # a picture cannot show more


@dataclass(frozen=True, slots=True)
class LoggedEvent:
    """A row of events.csv."""

    t_s: float
    severity: str
    name: str
    text: str


@dataclass(frozen=True, slots=True)
class Recorded:
    """`ticks`: columns of ticks.csv by name, (n,) each; `modes`: indices into `mode_names`; `truth`: as `ticks`, or
    None."""

    log: Log
    manifest: Mapping[str, Any]
    ticks: Mapping[str, Array]
    modes: NDArray[np.int64]
    mode_names: Sequence[str]
    events: Sequence[LoggedEvent]
    truth: Mapping[str, Array] | None
    warnings: Sequence[str]

    @property
    def t_s(self) -> Array:
        """Time of each tick."""
        return self.ticks["t_s"]

    @property
    def thrusters(self) -> list[str]:
        """Their names."""
        return [thruster.name for thruster in self.log.config.thrusters]

    @property
    def devices(self) -> list[str]:
        """Names of sensors and bridges."""
        return [
            *(sensor.name for sensor in self.log.config.sensors),
            *(bridge.name for bridge in self.log.config.actuators),
        ]

    def thinned(self, values: Array) -> Array:
        """Every n-th sample, so that hours are drawn in seconds."""
        return values[:: max(1, math.ceil(len(values) / _MOST_SAMPLES))]


def read_log(folder: Path) -> Recorded:
    """The log in `folder`. Raises LogError where it is no log, or has no tick."""
    log = open_log(folder)
    manifest = json.loads((folder / "manifest.json").read_text(encoding="utf-8"))
    warnings: list[str] = []
    names = [thruster.name for thruster in log.config.thrusters]
    devices = [*(sensor.name for sensor in log.config.sensors), *(bridge.name for bridge in log.config.actuators)]
    columns = (
        "t_s", "time_unix_ns", "armed", *_POSE, *(f"desired_{name}" for name in _POSE),
        *(f"{what}_{axis}" for what in ("demanded", "achieved") for axis in ("surge_n", "sway_n", "yaw_nm")),
        *(f"{name}_{part}" for name in names for part in ("throttle", "azimuth_rad", "force_n")),
        "position_accuracy_m", "heading_accuracy_rad", "position_valid", "heading_valid", "cross_track_error_m",
        "mission_seq", "load",
        *(f"{name}_ok" for name in devices),
    )  # fmt: skip
    try:
        table = read_table(folder / "ticks.csv", columns, warnings)
        modes, mode_names = _modes(folder / "ticks.csv", len(table["t_s"]))
    except OSError as error:
        raise LogError(f"{folder}: {error.strerror}: ticks.csv") from error
    if len(table["t_s"]) < 2:
        raise LogError(f"{folder}: no ticks: the run ended before its first one")
    ticks = {name: np.array(values) for name, values in table.items()}
    return Recorded(
        log, manifest, ticks, modes, mode_names, _events(folder / "events.csv"), _truth(folder, warnings), warnings
    )


def _modes(path: Path, count: int) -> tuple[NDArray[np.int64], list[str]]:
    """The column of modes as numbers, and the mode of each number."""
    names: dict[str, int] = {}
    numbers: list[int] = []
    with path.open(newline="", encoding="utf-8", errors="replace") as file:
        for row in csv.DictReader(file):
            mode = row.get("mode") or ""
            if mode and len(numbers) < count:
                numbers.append(names.setdefault(mode, len(names)))
    numbers += [0] * (count - len(numbers))
    return np.array(numbers, dtype=np.int64), list(names)


def _events(path: Path) -> list[LoggedEvent]:
    events: list[LoggedEvent] = []
    try:
        with path.open(newline="", encoding="utf-8", errors="replace") as file:
            for row in csv.DictReader(file):
                try:
                    events.append(
                        LoggedEvent(float(row["t_s"]), row["severity"] or "", row["name"] or "", row["text"] or "")
                    )
                except (TypeError, ValueError, KeyError):
                    continue  # an incomplete line
    except OSError:
        return []
    return events


def _truth(folder: Path, warnings: list[str]) -> Mapping[str, Array] | None:
    try:
        table = read_table(folder / "truth.csv", ("t_s", "north_m", "east_m", "yaw_rad"), warnings)
    except (OSError, LogError):
        return None
    return {name: np.array(values) for name, values in table.items()} if table["t_s"] else None
