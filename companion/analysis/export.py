"""A log in the formats of other programs: its track for charts, its readings as tables."""

from __future__ import annotations

import csv
import math
from collections.abc import Mapping, Sequence
from dataclasses import fields
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np

from companion.analysis.log_reader import LogError
from companion.analysis.report_data import Recorded, read_log
from companion.analysis.track_files import FORMATS as TRACK_FORMATS
from companion.analysis.track_files import track_of
from companion.core.readings import KINDS, TimeOfDay
from companion.record import readings

TABLE_FORMATS = ("csv", "parquet")
FORMATS = (*TABLE_FORMATS, *TRACK_FORMATS)
_CLOCK_NS = 2e9  # by which a clock is wrong
_ARROW_MISSING = "parquet needs pyarrow: pip install 'usv-companion[export]'"

Table = Mapping[str, Sequence[Any]]


def export(folder: Path, formats: Sequence[str], out: Path, warnings: list[str]) -> list[Path]:
    """Write the log in `folder` to `out` in each of `formats`. Returns the files.

    `csv` and `parquet`: one table for each device and kind of reading, columns as in the dataclass of the kind; parquet
    also has ticks.csv, events.csv, truth.csv. The others: the track. Raises LogError for a folder that is no log, for
    parquet without pyarrow; OSError.
    """
    out.mkdir(parents=True, exist_ok=True)
    written: list[Path] = []
    tracks = [name for name in formats if name in TRACK_FORMATS]
    if tracks:
        recorded = read_log(folder)
        warnings += recorded.warnings
        track = track_of(recorded, _satellites_ns(folder, recorded, warnings))
        if not track.stretches:
            raise LogError(f"{folder}: no valid position in this log, so there is no track")
        for name in tracks:
            written.append(out / f"track.{name}")
            written[-1].write_text(TRACK_FORMATS[name](track), encoding="utf-8")
    if any(name in TABLE_FORMATS for name in formats):
        tables = reading_tables(folder, warnings)
        if "csv" in formats:
            written += [_write_csv(out / f"{name}.csv", table) for name, table in tables.items()]
        if "parquet" in formats:
            written += _write_parquet(folder, tables, out, warnings)
    return written


def _satellites_ns(folder: Path, recorded: Recorded, warnings: list[str]) -> float | None:
    """Unix time at the log's 0 s by the satellites, where the computer's clock is far from it: small computers keep
    no time while they are off. None where its clock is right, or nothing better is known."""
    path = readings.path_in(folder)
    told = readings.read_kind(path, "time", warnings) if path.exists() else []
    zeros_ns = [one.time_unix_ns - 1e9 * one.t_s for one in told if isinstance(one, TimeOfDay)]
    if not zeros_ns:
        return None
    zero_ns = float(np.median(zeros_ns))
    off_ns = recorded.ticks["time_unix_ns"] - (zero_ns + 1e9 * recorded.t_s)
    return zero_ns if float(np.max(np.abs(off_ns))) > _CLOCK_NS else None


def reading_tables(folder: Path, warnings: list[str]) -> dict[str, Table]:
    """The readings of each device and kind, as `SOURCE_KIND`: columns by name. Raises LogError without readings."""
    path = readings.path_in(folder)
    if not path.exists():
        raise LogError(f"{path}: no such file: this log was recorded without its readings")
    kind_of = {kind_type: kind for kind, kind_type in KINDS.items()}
    rows: dict[str, list[Any]] = {}
    for tick in readings.read_ticks(path, warnings):
        for reading in tick.readings:
            rows.setdefault(f"{reading.source}_{kind_of[type(reading)]}", []).append(reading)
    return {name: _columns(found) for name, found in sorted(rows.items())}


def _columns(rows: Sequence[Any]) -> Table:
    names = [field.name for field in fields(rows[0]) if field.name != "source"]
    return {name: [_plain(getattr(row, name)) for row in rows] for name in names}


def _plain(value: Any) -> Any:
    """A value that any table holds."""
    if isinstance(value, Enum):
        return value.name.lower()
    return list(value) if isinstance(value, tuple) else value


def _write_csv(path: Path, table: Table) -> Path:
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(table)
        for row in zip(*table.values(), strict=True):
            writer.writerow([" ".join(map(str, cell)) if isinstance(cell, list) else cell for cell in row])
    return path


def _write_parquet(folder: Path, tables: Mapping[str, Table], out: Path, warnings: list[str]) -> list[Path]:
    try:
        import pyarrow
        from pyarrow import csv as arrow_csv
        from pyarrow import parquet
    except ImportError as error:
        raise LogError(_ARROW_MISSING) from error
    written = []
    for name, table in tables.items():
        written.append(out / f"{name}.parquet")
        parquet.write_table(pyarrow.table(dict(table)), written[-1], compression="zstd")
    for name in ("ticks", "events", "truth"):
        source = folder / f"{name}.csv"
        if not source.exists():
            continue
        if whole := _whole_lines(source.read_bytes()):
            written.append(out / f"{name}.parquet")
            parquet.write_table(arrow_csv.read_csv(pyarrow.BufferReader(whole)), written[-1], compression="zstd")
        else:
            warnings.append(f"{source.name}: left out: it holds no whole line")
    return written


def _whole_lines(data: bytes) -> bytes:
    """Without a last line that was cut off."""
    return data[: data.rfind(b"\n") + 1]


def size_text(count: int) -> str:
    """A size for people."""
    step = min(2, int(math.log(max(count, 1), 1000)))
    return f"{count / 1000**step:.{0 if step == 0 else 1}f} {('B', 'kB', 'MB')[step]}"
