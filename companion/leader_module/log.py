"""The log folder of a leader module: module.csv, log.mcap, events.csv, manifest.json, written as a vessel's."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from companion.core.decision import Event
from companion.core.readings import Reading
from companion.record import mcap_log
from companion.record.disk import REAL_DISK, Disk
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

    def __init__(self, folder: Path, manifest: Mapping[str, Any], beside: bool, disk: Disk = REAL_DISK) -> None:
        """`beside`: write and sync it by threads. A medium that is full or fails takes it later. Raises OSError when
        the folder cannot be written for any other reason."""
        self._manifest = manifest
        self._encoder = mcap_log.McapEncoder()
        files = LogSet(folder, self, disk, patient=True)
        self._out: LogOutput = ThreadLog(files) if beside else DirectLog(files)
        self._now_s = 0.0
        self._closed = False

    @property
    def output(self) -> LogOutput:
        """Where the rows go."""
        return self._out

    def headers(self) -> Mapping[str, bytes]:
        """As `LogContent.headers`."""
        return {
            _ROWS: (",".join(COLUMNS) + "\n").encode(),
            EVENTS: (",".join(EVENT_COLUMNS) + "\n").encode(),
            mcap_log.FILE: self._encoder.header(),
        }

    def furnish(self, folder: Path) -> None:
        """As `LogContent.furnish`."""
        text = json.dumps(self._manifest, indent=1, default=str) + "\n"
        (folder / "manifest.json").write_text(text, encoding="utf-8")

    def row(self, values: Mapping[str, Any]) -> None:
        """Write a row of module.csv; `values` by the names in COLUMNS."""
        self._now_s = float(values["t_s"])
        self._out.put(_ROWS, (",".join(_cell(values[name]) for name in COLUMNS) + "\n").encode(), self._now_s)

    def readings(self, readings: Sequence[Reading], t_s: float, time_unix_ns: int) -> None:
        """Write the readings of a tick to log.mcap."""
        if self._out.stopped is not None:
            self._encoder.drop()
        self._encoder.lone_readings(readings, t_s, time_unix_ns)
        if chunk := self._encoder.due():
            self._out.put(mcap_log.FILE, chunk, t_s)

    def event(self, event: Event, time_unix_ns: int) -> None:
        """Write a row of events.csv."""
        self._out.put(EVENTS, event_row(event, time_unix_ns).encode(), self._now_s)

    def close(self) -> None:
        """Write what waits, and close all files. Once closed, it does nothing."""
        if not self._closed:
            self._closed = True
            self._out.put(mcap_log.FILE, self._encoder.end(), self._now_s)
            self._out.close()


def _cell(value: Any) -> str:
    """A value as text; empty where it is unknown."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return f"{value:d}"
    return f"{value:.9g}" if isinstance(value, float) else str(value)
