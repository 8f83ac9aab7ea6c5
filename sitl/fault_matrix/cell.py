"""One cell: a fault begins on a stage, and what happens is judged by the boat's log and the plant's truth."""

from __future__ import annotations

import csv
import itertools
import json
import math
import re
import struct
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from companion.core.log_names import next_name
from sitl.fault_matrix import deeds
from sitl.fault_matrix.branch import branch
from sitl.fault_matrix.stages import PX4_MODES, Stage, begin
from sitl.fault_matrix.table import NOTHING, Expected, FaultRow, Table, VesselRow
from sitl.scenarios.measure import between, read_events, read_truth
from sitl.scenarios.rig import Composer

SAID_S = 1.0  # after it is knowable
_STILL_S = 2.0  # without thrust at the end: neutral
_SAME_TEXT = 45  # characters; a link cuts longer texts
_LEAST_ROOM_S = 0.25  # by which the time of a row may be late
_MAGIC, _HEADER, _EXTRA, _SIGNATURE = 0xFD, 10, 2, 13
_STAMP = 8
_SEEN = "seen.json"
_MOST, _TEXT = 12, 120  # events and texts that are kept, and characters of each
_ROUNDED_S = 0.011


@dataclass(frozen=True, slots=True)
class Observed:
    """What happened in one cell. `after`: the mode, and whether it is neutral or disarmed; `known_s`: since when it
    could be known, after the onset; None for never. `events`: (s after the onset, name, text) of the log; `heard`:
    (s after the onset, text) as the ground station got it. `off_m`: greatest distance; None while sticks steer. `log`:
    what is wrong with the log."""

    vessel: str
    mode: str
    fault: str
    after: str
    known_s: float | None
    events: tuple[tuple[float, str, str], ...]
    heard: tuple[tuple[float, str], ...]
    off_m: float | None
    log: tuple[str, ...]

    def said(self, expected: Expected) -> tuple[float, str] | None:
        """(s after the onset, text) of what is expected to be said; None where it is not said."""
        if expected.hears:
            return next(((t_s, text) for t_s, text in self.heard if re.fullmatch(expected.hears, text)), None)
        names = "" if expected.says == NOTHING else expected.says
        return next(((t_s, text) for t_s, name, text in self.events if names and re.fullmatch(names, name)), None)

    def row(self) -> dict[str, Any]:
        """For a file of results."""
        return asdict(self)


def observed_of(row: Mapping[str, Any]) -> Observed:
    """From a file of results."""
    events = tuple((t_s, name, text) for t_s, name, text in row["events"])
    heard = tuple((t_s, text) for t_s, text in row["heard"])
    return Observed(**{**row, "events": events, "heard": heard, "log": tuple(row["log"])})


def judge(table: Table, seen: Observed) -> list[str]:
    """What is not as expected; empty for a green cell."""
    fault, row = table.fault(seen.fault), table.vessel(seen.vessel)
    expected = table.expected(seen.vessel, seen.mode, fault)
    limit_m = limit_of(row, seen.mode, expected)
    problems = [*_wrong_mode(seen, expected, row), *_wrong_text(seen, expected, watched_s(fault, expected))]
    if limit_m is not None and seen.off_m is not None and seen.off_m > limit_m:
        problems.append(f"{seen.off_m:.2f} m away")
    return [*problems, *seen.log]


def limit_of(row: VesselRow, mode: str, expected: Expected) -> float | None:
    """The greatest distance that is expected, m; None where none is promised."""
    reach_m = row.reach_m.get(mode)
    return None if reach_m is None or expected.far == 0.0 else expected.far * reach_m


def watched_s(fault: FaultRow, expected: Expected) -> float:
    """How long a cell is watched, s."""
    return max(fault.watch_s, expected.knowable_s + SAID_S + _STILL_S)


def run_stage(
    table: Table,
    vessel: str,
    mode: str,
    compose: Composer,
    folder: Path,
    faults: Sequence[FaultRow] | None = None,
    seed: int = 0,
) -> list[Observed]:
    """All faults (None: those that exist there) on one vessel in one mode."""
    stage = begin(table.vessel(vessel), mode, compose, folder / "stage", seed)
    found = []
    for fault in table.faults_in(vessel, mode) if faults is None else faults:
        into, expected = folder / fault.name, table.expected(vessel, mode, fault)
        into.parent.mkdir(parents=True, exist_ok=True)
        done = branch(folder / "stage", into, _future(stage, fault, expected, into))
        found.append(_read(into / _SEEN) if done else _broken(vessel, mode, fault.name))
    stage.rig.close()
    return found


def _future(stage: Stage, fault: FaultRow, expected: Expected, folder: Path) -> Callable[[], None]:
    def sail() -> None:
        seen = sail_cell(stage, fault, expected, folder)
        (folder / _SEEN).write_text(json.dumps(seen.row()) + "\n", encoding="utf-8")

    return sail


def _read(path: Path) -> Observed:
    return observed_of(json.loads(path.read_text(encoding="utf-8")))


def _broken(vessel: str, mode: str, fault: str) -> Observed:
    return Observed(vessel, mode, fault, "", None, (), (), None, ("the run broke off",))


def sail_cell(stage: Stage, fault: FaultRow, expected: Expected, folder: Path) -> Observed:
    """Begin the fault, watch, and gather what happened from the log in `folder`."""
    from_s = stage.rig.now_s
    measure = stage.measure()
    deeds.begin(fault, stage)
    stage.sail(watched_s(fault, expected))
    to_s = stage.rig.now_s
    folders = [folder, *_later_folders(folder, stage)]
    ticks = [row for one in folders for row in _ticks(one) if float(row["t_s"]) > from_s]
    events = [event for one in folders for event in read_events(one) if event.t_s > from_s - 1e-3]
    heard = [(t_s, text) for t_s, text in zip(stage.gcs.heard_s, stage.gcs.texts, strict=True) if t_s > from_s]
    truth = between(read_truth(folder), from_s, to_s)
    known_s = 0.0 if stage.knowable is None else None if stage.known_s is None else stage.known_s - from_s
    return Observed(
        stage.row.name,
        stage.mode,
        fault.name,
        _after(stage, ticks, to_s),
        known_s,
        tuple((round(event.t_s - from_s, 2), event.name, event.text[:_TEXT]) for event in events[:_MOST]),
        tuple((round(t_s - from_s, 2), text) for t_s, text in heard[:_MOST]),
        None if measure is None else round(max(measure(row["north_m"], row["east_m"]) for row in truth), 2),
        tuple(_wrong_log(folders, ticks, fault)),
    )


def _later_folders(folder: Path, stage: Stage) -> list[Path]:
    """Where the log went on after its medium had failed: beside the stage's, whose name it has."""
    stages = folder.with_name("stage")
    found = []
    number = 2
    while (there := stages.with_name(next_name("stage", number))).is_dir():
        here = folder / there.name
        there.rename(here)
        if (here / "ticks.csv").is_file():
            found.append(here)
        number += 1
    return found


def _ticks(folder: Path) -> list[dict[str, str]]:
    with (folder / "ticks.csv").open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def _after(stage: Stage, ticks: Sequence[Mapping[str, str]], to_s: float) -> str:
    """The mode at the end, as ground stations hear it."""
    beat = stage.gcs.last["HEARTBEAT"]
    mode = next((name for name, number in PX4_MODES.items() if number == beat.custom_mode), hex(beat.custom_mode))
    if not beat.base_mode & 128:
        return f"{mode}, disarmed"
    last = [row for row in ticks if float(row["t_s"]) > to_s - _STILL_S]
    still = last and all(float(row[name]) == 0.0 for row in last for name in row if name.endswith("_throttle"))
    return f"{mode}, neutral" if still else mode


def _wrong_mode(seen: Observed, expected: Expected, row: VesselRow) -> list[str]:
    """A boat that keeps to a watch circle has no thrust while it drifts inside. A boat that could not know of its fault
    yet is not judged."""
    if seen.known_s is None:
        return []
    mode = seen.mode if expected.after in ("same", "neutral") else expected.after
    wanted = f"{mode}, neutral" if expected.after == "neutral" else mode
    drifts = row.drifts and mode in ("Hold", "RTL") and seen.after == f"{wanted}, neutral"
    return [] if seen.after == wanted or drifts else [f"{seen.after}, not {wanted}"]


def _wrong_text(seen: Observed, expected: Expected, until_s: float) -> list[str]:
    """What became knowable too late to be said while the boat was watched is not judged."""
    if expected.says == NOTHING and not expected.hears:
        return []
    said = seen.said(expected)
    if said is None:
        in_time = seen.known_s is not None and seen.known_s + expected.knowable_s + SAID_S <= until_s
        return ["not said"] if in_time else []
    after_s = 0.0 if seen.known_s is None else said[0] - seen.known_s - expected.knowable_s
    if after_s > SAID_S + _ROUNDED_S:
        return [f"said {after_s:.1f} s after it was knowable"]
    return [] if any(said[1][:_SAME_TEXT] in text for _, text in seen.heard) else ["said to nobody"]


def _wrong_log(folders: Sequence[Path], ticks: Sequence[Mapping[str, str]], fault: FaultRow) -> list[str]:
    """Rows without a gap, but for those that a fault of process or medium explains; packets that end with the file."""
    problems = []
    times = [float(row["t_s"]) for row in ticks]
    gaps = [b - a for a, b in itertools.pairwise(times)]
    if any(gap <= 0.0 for gap in gaps):
        problems.append("rows of the log in the wrong order")
    if max(gaps, default=math.inf) > _LEAST_ROOM_S and fault.group not in ("process", "medium"):
        problems.append("rows of the log are missing")
    if any(None in row.values() or row["mode"] == "" for row in ticks):
        problems.append("a row of the log is cut")
    problems += ["packets of the log are cut" for one in folders if not _whole_packets(one / "telemetry.tlog")]
    return problems


def _whole_packets(path: Path) -> bool:
    """Whether a telemetry log is packets with their times and nothing else. (MAVLink 2 alone is on these links.)"""
    data = path.read_bytes()
    at = 0
    while at + _STAMP + _HEADER <= len(data):
        magic, length, flags = struct.unpack_from("BBB", data, at + _STAMP)
        if magic != _MAGIC:
            return False
        at += _STAMP + _HEADER + length + _EXTRA + (_SIGNATURE if flags & 1 else 0)
    return at == len(data)
