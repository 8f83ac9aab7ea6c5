"""The log folder of a leader module: module.csv, events.csv, manifest.json, without buffers as a vessel's."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from companion.core.decision import Event
from companion.record.recorder import EVENT_COLUMNS, Syncer, WrittenThrough, event_row

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

    def __init__(
        self, folder: Path, manifest: Mapping[str, Any], on_warning: Callable[[str], None], sync: bool
    ) -> None:
        """Raises OSError when the folder cannot be written."""
        folder.mkdir(parents=True, exist_ok=True)
        self.folder = folder
        (folder / "manifest.json").write_text(json.dumps(manifest, indent=1, default=str) + "\n", encoding="utf-8")
        self._rows = WrittenThrough(folder / "module.csv", on_warning)
        self._events = WrittenThrough(folder / "events.csv", on_warning)
        self._rows.write((",".join(COLUMNS) + "\n").encode())
        self._events.write((",".join(EVENT_COLUMNS) + "\n").encode())
        self._files: Sequence[WrittenThrough] = (self._rows, self._events)
        self._syncer = Syncer(self._files) if sync else None

    def row(self, values: Mapping[str, Any]) -> None:
        """Write a row of module.csv; `values` by the names in COLUMNS."""
        self._rows.write((",".join(_cell(values[name]) for name in COLUMNS) + "\n").encode())

    def event(self, event: Event, time_unix_ns: int) -> None:
        """Write a row of events.csv."""
        self._events.write(event_row(event, time_unix_ns).encode())

    def close(self) -> None:
        """Close all files."""
        if self._syncer is not None:
            self._syncer.close()
        for file in self._files:
            file.close()


def _cell(value: Any) -> str:
    """A value as text; empty where it is unknown."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return f"{value:d}"
    return f"{value:.9g}" if isinstance(value, float) else str(value)
