"""The log folder of a leader module: module.csv, events.csv, manifest.json, written as a vessel's."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from companion.core.decision import Event
from companion.record.log_writer import DirectLog, LogOutput, LogSet, ThreadLog
from companion.record.recorder import EVENT_COLUMNS, EVENTS, event_row

_ROWS = "module.csv"
COLUMNS = (
    "t_s",
    "time_unix_ns",
    "placed",
    "heading_valid",
    "lat_deg",
    "lon_deg",
    "north_mps",
    "east_mps",
    "yaw_rad",
    "yaw_rate_radps",
    "position_accuracy_m",
    "wish",
    "presses",
    "surge",
    "yaw",
    "link_counter",
    "follower_mode",
    "follower_armed",
    "follower_age_s",
    "gap_m",
    "throttle",
    "nozzle_deg",
)


class LeaderLog:
    """Recorder of a leader module's run."""

    def __init__(self, folder: Path, manifest: Mapping[str, Any], beside: bool) -> None:
        """`beside`: write and sync it by threads. Raises OSError when the folder cannot be written."""
        self._manifest = manifest
        files = LogSet(folder, self)
        self._out: LogOutput = ThreadLog(files) if beside else DirectLog(files)
        self._now_s = 0.0

    @property
    def output(self) -> LogOutput:
        """Where the rows go."""
        return self._out

    def headers(self) -> Mapping[str, bytes]:
        """As `LogContent.headers`."""
        return {_ROWS: (",".join(COLUMNS) + "\n").encode(), EVENTS: (",".join(EVENT_COLUMNS) + "\n").encode()}

    def furnish(self, folder: Path) -> None:
        """As `LogContent.furnish`."""
        text = json.dumps(self._manifest, indent=1, default=str) + "\n"
        (folder / "manifest.json").write_text(text, encoding="utf-8")

    def row(self, values: Mapping[str, Any]) -> None:
        """Write a row of module.csv; `values` by the names in COLUMNS."""
        self._now_s = float(values["t_s"])
        self._out.put(_ROWS, (",".join(_cell(values[name]) for name in COLUMNS) + "\n").encode(), self._now_s)

    def event(self, event: Event, time_unix_ns: int) -> None:
        """Write a row of events.csv."""
        self._out.put(EVENTS, event_row(event, time_unix_ns).encode(), self._now_s)

    def close(self) -> None:
        """Write what waits, and close all files."""
        self._out.close()


def _cell(value: Any) -> str:
    """A value as text; empty where it is unknown."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return f"{value:d}"
    return f"{value:.9g}" if isinstance(value, float) else str(value)
