"""The contents of a log folder for a report: ticks as arrays, events, and in simulation the truth."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import UnionType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from companion.analysis.log_reader import Log, LogError, open_log, read_table
from companion.core.geodesy import LocalFrame
from companion.record import mcap_log
from companion.record.mcap_reader import has_end

Array = NDArray[np.float64]

_POSE = ("north_m", "east_m", "yaw_rad", "surge_mps", "sway_mps", "yaw_rate_radps")
_LATER = (
    "lat_deg", "lon_deg", "fix", "satellites", "corrections_age_s", "battery_v", "battery_a", "battery_remaining",
    "wind_speed_mps", "wind_from_rad", "current_north_mps", "current_east_mps",
)  # fmt: skip
WATCHED = ("WARNING", "ERROR", "CRITICAL", "ALERT", "EMERGENCY")
"""Severities of events that a person should see."""


@dataclass(frozen=True, slots=True)
class LoggedEvent:
    """A row of events.csv."""

    t_s: float
    severity: str
    name: str
    text: str


@dataclass(frozen=True, slots=True)
class Recorded:
    """`ticks`: columns of ticks.csv by name, (n,) each; `modes`: indices into `mode_names`; `words`: columns of
    ticks.csv that are words, by name; `truth`: as `ticks`, or None; `result`: that of a scenario, or None."""

    log: Log
    manifest: Mapping[str, Any]
    ticks: Mapping[str, Array]
    modes: NDArray[np.int64]
    mode_names: Sequence[str]
    words: Mapping[str, Sequence[str]]
    events: Sequence[LoggedEvent]
    truth: Mapping[str, Array] | None
    warnings: Sequence[str]
    result: Mapping[str, Any] | None

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

    @property
    def period_s(self) -> float:
        """Of the control step."""
        return 1.0 / self.log.config.control_rate_hz


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
        words: dict[str, list[str]] = {name: [] for name in ("mode", "failsafes", *(f"{n}_condition" for n in names))}
        table = read_table(folder / "ticks.csv", columns, warnings, _LATER, words)
    except OSError as error:
        raise LogError(f"{folder}: {error.strerror}: ticks.csv") from error
    if len(table["t_s"]) < 2:
        raise LogError(f"{folder}: too few ticks: the run ended before its second one")
    ticks = {name: np.asarray(values) for name, values in table.items()}  # no copy: a day's log is large
    if not np.any(np.isfinite(ticks["lat_deg"])):
        _add_places(ticks, log)
    mode_names, modes = numbered(words["mode"])
    if (folder / mcap_log.FILE).exists() and not has_end(folder / mcap_log.FILE):
        warnings.append(f"{mcap_log.FILE}: has no end: the log was cut off, or is still written")
    events, truth = _events(folder / "events.csv"), _truth(folder, warnings)
    return Recorded(log, manifest, ticks, modes, mode_names, words, events, truth, warnings, _result(folder))


def numbered(words: Sequence[str]) -> tuple[list[str], NDArray[np.int64]]:
    """The different words in the order of their coming, and the place of each one there."""
    names: dict[str, int] = {}
    numbers = np.array([names.setdefault(word, len(names)) for word in words], dtype=np.int64)
    return list(names), numbers


def _add_places(ticks: dict[str, Array], log: Log) -> None:
    """Latitude and longitude of a log that lacks them, from home."""
    frame = LocalFrame(log.config.home.lat_deg, log.config.home.lon_deg)
    for at in np.flatnonzero(ticks["position_valid"] > 0.0):
        place = frame.to_geodetic(float(ticks["north_m"][at]), float(ticks["east_m"][at]))
        ticks["lat_deg"][at], ticks["lon_deg"][at] = place


def _result(folder: Path) -> Mapping[str, Any] | None:
    try:
        result: Any = json.loads((folder / "result.json").read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    return result if is_result(result) else None


_CHECK: Mapping[str, type[Any] | UnionType] = {
    "name": str, "value": int | float, "limit": int | float, "unit": str, "at_least": bool, "ok": bool,
}  # fmt: skip


def is_result(found: Any) -> bool:
    """Whether it is the result of a scenario, as its result.json has it."""
    if not isinstance(found, dict) or not all(
        isinstance(found.get(name) or {}, dict) for name in ("settings", "metrics")
    ):
        return False
    checks = found.get("checks") or []
    return isinstance(checks, list) and all(
        isinstance(check, dict) and all(isinstance(check.get(key), kind) for key, kind in _CHECK.items())
        for check in checks
    )


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
        table = read_table(
            folder / "truth.csv",
            ("t_s", "north_m", "east_m", "yaw_rad"),
            warnings,
            ("wind_speed_mps", "wind_from_rad", "current_north_mps", "current_east_mps"),
        )
    except (OSError, LogError):
        return None
    return {name: np.array(values) for name, values in table.items()} if table["t_s"] else None
