"""A log folder played back: the same messages as the feed of a running boat, at the pace of each page."""

from __future__ import annotations

import asyncio
import contextlib
import csv
import time
from bisect import bisect_right
from collections.abc import Mapping
from operator import itemgetter
from pathlib import Path
from typing import Any

from companion.analysis.log_chart import chart_of_log
from companion.analysis.log_reader import LogError, open_log, seconds
from companion.analysis.polar import polar
from companion.config.vessel import as_dict
from companion.console.board import Message, Page, text_of
from companion.console.measured import Measured
from companion.console.strips import KEPT_S, sample, series_of
from companion.console.weather import polar_message
from companion.core.geodesy import LocalFrame
from companion.core.readings import FixType
from companion.record.feed_schema import VERSION, finite, row_of
from companion.record.recorder import EVENTS, TICKS

_PERIOD_S = 0.1
_SAMPLE_S = 0.5
SPEEDS = (0.5, 1.0, 2.0, 5.0, 10.0, 30.0, 60.0)


class Recording:
    """A log, read once. A row that is incomplete or has no time is left out; for one that cannot be read otherwise, the
    last one before it that can stands."""

    def __init__(self, folder: Path) -> None:
        """Raises LogError for a folder that is no log, or has no tick."""
        log = open_log(folder)
        self.folder, self.config = folder, log.config
        self.thrusters = tuple(thruster.name for thruster in self.config.thrusters)
        self.devices = (*(row.name for row in self.config.sensors), *(row.name for row in self.config.actuators))
        self._stamps: list[tuple[int, float]] = []
        self.frame = LocalFrame(self.config.home.lat_deg, self.config.home.lon_deg)
        self._columns, self.times_s, self._lines = _rows(folder / TICKS)
        if not self.times_s:
            raise LogError(f"{folder}: {TICKS} has no rows")
        self.events = _events(folder / EVENTS)
        self.measured = Measured(folder, len(self.thrusters), self._time_of)
        self.capability: Message = {**polar_message(polar(self.config), (0.0, 0.0)), "kind": "capability"}
        self.boat: Message = {
            "kind": "boat",
            "frame": {"lat_deg": self.frame.lat_deg, "lon_deg": self.frame.lon_deg},
            "parameters": dict(log.parameters),
            **chart_of_log(folder, self.frame),
        }

    def hello(self, mode: Mapping[str, Any]) -> Message:
        """What a page gets first."""
        return {
            "kind": "hello",
            "version": VERSION,
            "configuration": as_dict(self.config),
            "columns": self._columns,
            "modes": [],
            "links": [],
            "console": {**mode, "replay": True, "log": self.folder.name},
            "series": [{"name": s.name, "strip": s.strip, "unit": s.unit} for s in series_of(self.thrusters)],
        }

    def about(self) -> Message:
        """The time line: begin, end, events."""
        return {"kind": "recording", "from_s": self.times_s[0], "to_s": self.times_s[-1], "events": self.events}

    def index(self, t_s: float) -> int:
        """Of the last row at or before that time; the first row before all of them."""
        return max(0, bisect_right(self.times_s, t_s) - 1)

    def _time_of(self, unix_ns: int) -> float:
        """The boat's time of the row that was written then."""
        if not self._stamps:
            place = self._columns.index("time_unix_ns")
            cells = (_cells(line)[place] for line in self._lines)
            times = zip(cells, self.times_s, strict=True)
            self._stamps = [(int(cell), t_s) for cell, t_s in times if cell.isdecimal()]
        at = bisect_right(self._stamps, unix_ns, key=itemgetter(0))
        return self._stamps[max(0, at - 1)][1] if self._stamps else self.times_s[0]

    def tick(self, index: int) -> Message:
        """One row as a message of the feed. What only the feed has is worked out, or missing."""
        row = self._row(index)
        lat_deg, lon_deg = self.frame.to_geodetic(row["north_m"] or 0.0, row["east_m"] or 0.0)
        variance = (row.get("position_accuracy_m") or 0.0) ** 2
        more = {
            "lat_deg": lat_deg,
            "lon_deg": lon_deg,
            "covariance_m2": [variance, 0.0, variance] if variance else None,
            "pose": row.get("cross_track_error_m") is None,
            **{name: row[name] for name in _IN_ROWS if name in row},
            **_from_columns(row),
            "feedback": self.measured.feedback(row["t_s"]),
            "health": self._health(row),
        }
        message: Message = {"kind": "tick", "sequence": index, "row": row, "more": more}
        message["sample"] = sample(message, self.thrusters)
        return message

    def _row(self, index: int) -> Message:
        for at in range(index, -1, -1):
            with contextlib.suppress(ValueError):
                row: Message = finite(row_of(self._columns, _cells(self._lines[at])))
                return row
        return dict.fromkeys(self._columns) | {"t_s": self.times_s[index], "mode": "", "failsafes": ""}

    def _health(self, row: Message) -> list[Message]:
        """Of sensors and bridges; ages and links are not in a log."""
        texts = self.measured.texts(row["t_s"])
        return [
            {"name": name, "ok": bool(row[f"{name}_ok"]), "age_s": None, "text": texts.get(name, "")}
            for name in self.devices
            if f"{name}_ok" in row
        ]

    def history(self, t_s: float) -> Message:
        """The ten minutes before a time, two samples a second."""
        kept: list[Message] = []
        last_s = float("-inf")
        for i in range(self.index(t_s - KEPT_S), self.index(t_s) + 1):
            if self.times_s[i] - last_s >= _SAMPLE_S:
                last_s = self.times_s[i]
                kept.append(self.tick(i))
        return {
            "kind": "history",
            "t_s": [one["row"]["t_s"] for one in kept],
            "values": [one["sample"] for one in kept],
            "trail": [[one["row"]["north_m"], one["row"]["east_m"]] for one in kept],
        }


_IN_ROWS = (
    "wind_speed_mps",
    "wind_from_rad",
    "current_north_mps",
    "current_east_mps",
)
"""What a log's rows may have, that the feed has in `more`."""


_EVENT = ("severity", "name", "text")
_FIXES = {int(kind): kind.name for kind in FixType}


def _from_columns(row: Mapping[str, Any]) -> Message:
    """Fix, battery and corrections, where the row has them."""
    found: Message = {}
    if row.get("fix") is not None:
        found |= {"fix": _FIXES.get(row["fix"], f"fix {row['fix']:g}"), "satellites": row.get("satellites")}
    if row.get("battery_v") is not None:
        found["battery"] = {
            "voltage_v": row["battery_v"],
            "current_a": row.get("battery_a"),
            "remaining": row.get("battery_remaining"),
        }
    if row.get("corrections_age_s") is not None:
        found["corrections"] = {"source": "", "age_s": row["corrections_age_s"], "station": None}
    return found


class Player:
    """Plays a recording to one page. `order` takes what the page asks for."""

    def __init__(self, recording: Recording, page: Page, mode: Mapping[str, Any]) -> None:
        self._recording, self._page = recording, page
        self._t_s, self._speed, self._playing = recording.times_s[0], 1.0, True
        for message in (recording.hello(mode), recording.boat, recording.about(), recording.capability):
            page.put(message["kind"], text_of(message))
        self._seek(self._t_s)

    def order(self, asked: Mapping[str, Any]) -> None:
        """`playing`, `speed`, `t_s`: those that change. What is not understood is ignored."""
        if isinstance(asked.get("playing"), bool):
            self._playing = asked["playing"]
            if self._playing and self._t_s >= self._recording.times_s[-1]:
                self._seek(self._recording.times_s[0])
        if asked.get("speed") in SPEEDS:
            self._speed = float(asked["speed"])
        t_s = asked.get("t_s")
        if isinstance(t_s, int | float) and t_s == t_s:
            self._seek(float(t_s))
        self._show()

    def _seek(self, t_s: float) -> None:
        times_s = self._recording.times_s
        self._t_s = min(times_s[-1], max(times_s[0], t_s))
        self._page.put("history", text_of(self._recording.history(self._t_s)))
        self._show()

    def _show(self) -> None:
        message = self._recording.tick(self._recording.index(self._t_s))
        message["replay"] = {"t_s": self._t_s, "playing": self._playing, "speed": self._speed}
        message["made_unix_ns"] = time.time_ns()
        self._page.put("tick", text_of(message))

    async def play(self) -> None:
        """For ever, ten frames a second."""
        loop = asyncio.get_running_loop()
        last_s = loop.time()
        while True:
            await asyncio.sleep(_PERIOD_S)
            now_s = loop.time()
            if self._playing:
                self._t_s = min(self._recording.times_s[-1], self._t_s + (now_s - last_s) * self._speed)
                self._playing = self._t_s < self._recording.times_s[-1]
            last_s = now_s
            self._show()


def _cells(line: bytes) -> list[str]:
    return line.decode("utf-8", "replace").split(",")


def _rows(path: Path) -> tuple[list[str], list[float], list[bytes]]:
    """Columns, times, and the line of each row: its cells apart take ten times as much memory."""
    try:
        lines = path.read_bytes().split(b"\n")[:-1]
    except OSError as error:
        raise LogError(f"{path}: {error.strerror}") from error
    if not lines:
        raise LogError(f"{path}: empty")
    columns = _cells(lines[0])
    if "t_s" not in columns:
        raise LogError(f"{path}: no column t_s")
    place, times_s, kept = columns.index("t_s"), [], []
    for line in lines[1:]:
        cells = _cells(line)
        t_s = seconds(cells[place]) if len(cells) == len(columns) else None
        if t_s is not None:
            times_s.append(t_s)
            kept.append(line)
    return columns, times_s, kept


def _events(path: Path) -> list[dict[str, Any]]:
    """A row without a time, as damage leaves it, is left out."""
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError:
        return []
    lines = [line for line in text.splitlines(keepends=True) if line.endswith("\n")]
    timed = ((row, seconds(row.get("t_s"))) for row in csv.DictReader(lines))
    return [
        {"kind": "event", **{name: row.get(name) or "" for name in _EVENT}, "t_s": t_s}
        for row, t_s in timed
        if t_s is not None
    ]
