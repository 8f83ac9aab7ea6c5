"""One row a run: what came of it, in a journal while a sweep goes on and in a Parquet file for whoever looks at it."""

from __future__ import annotations

import contextlib
import fcntl
import json
import os
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any

from sitl.sweep.plan import Run

JOURNAL, PARQUET = "runs.jsonl", "runs.parquet"
ARROW_MISSING = "a sweep needs pyarrow: pip install 'usv-companion[sweep]'"


class SweepError(Exception):
    """A sweep that cannot go on: one line that says why and what to do."""


@dataclass(frozen=True, slots=True)
class Row:
    """What came of a run.

    `margin`: how far the check that came nearest to failing was from it, as a share of its limit; below 0 it fails;
    `tightest`: the name of that check. Both are None of a run without a result, or whose checks only count. `error`:
    why there is no result. `safety`: the margin of each safety property, by its name. `log`: the folder of its log,
    from the sweep's folder; None where the log was deleted. `cpu_s`: of the processor; `duration_s`: by the clock.
    """

    key: str
    scenario: str
    vessel: str
    seed: int
    settings: Mapping[str, str]
    point: str
    factors: Mapping[str, float]
    ok: bool
    error: str | None
    failed_checks: tuple[str, ...]
    margin: float | None
    tightest: str | None
    metrics: Mapping[str, float]
    duration_s: float
    commit: str
    versions: Mapping[str, str] = field(default_factory=dict)
    host: str = ""
    log: str | None = None
    cpu_s: float = 0.0
    faults: tuple[str, ...] = ()
    safety: Mapping[str, float] = field(default_factory=dict)

    @property
    def run(self) -> Run:
        """The run that it is the row of."""
        settings = tuple(sorted(self.settings.items()))
        return Run(self.scenario, self.vessel, self.seed, settings, self.point, self.factors, self.faults)


class Journal:
    """The rows of a sweep's folder, a line each, written as the runs end. A line that was cut off is no row.

    One process writes: a second one is refused. `rows` holds the newest row of each run, by its key; `folder`: where.
    """

    def __init__(self, folder: Path) -> None:
        """Raises SweepError where another process writes, OSError."""
        folder.mkdir(parents=True, exist_ok=True)
        self.folder = folder
        self._file = (folder / JOURNAL).open("a+b")
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            self._file.close()
            raise SweepError(f"{folder}: another sweep writes there; wait for it, or choose another --out") from error
        self.rows = {row.key: row for row in read_journal(folder)}
        self._end_line()

    def add(self, row: Row) -> None:
        """Keep a row. It is on the medium when this returns."""
        self.rows[row.key] = row
        self._file.write(json.dumps(asdict(row)).encode() + b"\n")
        self._file.flush()
        os.fsync(self._file.fileno())

    def close(self) -> None:
        """Let others write."""
        self._file.close()

    def __enter__(self) -> Journal:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _end_line(self) -> None:
        """A line that was cut off gets its end, so that the next row has a line of its own."""
        if self._file.seek(0, os.SEEK_END) == 0:
            return
        self._file.seek(-1, os.SEEK_END)
        if self._file.read(1) != b"\n":
            self._file.write(b"\n")


def read_journal(folder: Path) -> list[Row]:
    """The newest row of each run; none where there is no journal."""
    found: dict[str, Row] = {}
    with contextlib.suppress(FileNotFoundError):
        for line in (folder / JOURNAL).read_bytes().splitlines():
            with contextlib.suppress(ValueError, TypeError):  # cut off
                row = _row(json.loads(line))
                found[row.key] = row
    return list(found.values())


def read_rows(folder: Path) -> list[Row]:
    """The rows of a sweep's folder, in the order of the Parquet file. Raises SweepError where there are none."""
    rows = read_journal(folder) or read_parquet(folder / PARQUET)
    if not rows:
        raise SweepError(f"{folder}: no runs of a sweep there: neither {JOURNAL} nor {PARQUET}")
    return in_order(rows)


def in_order(rows: Iterable[Row]) -> list[Row]:
    """By scenario, vessel, settings, faults and seed: whoever sailed them, and whenever, the order is the same."""

    def place(row: Row) -> tuple[object, ...]:
        return row.scenario, row.vessel, sorted(row.settings.items()), row.faults, row.seed, row.key

    return sorted(rows, key=place)


def write_parquet(rows: Iterable[Row], path: Path) -> None:
    """A table with a column for each field, `setting.NAME`, `factor.NAME`, `metric.NAME`, `safety.NAME` and
    `version.NAME`; empty where a run has none. Written whole or not at all. Raises SweepError without pyarrow,
    OSError."""
    pyarrow, parquet = arrow()
    flat = [_flat(row) for row in in_order(rows)]
    names = list(dict.fromkeys(name for row in flat for name in row))
    order = [*(name for name in names if "." not in name), *sorted(name for name in names if "." in name)]
    schema = pyarrow.schema([(name, _kind(pyarrow, name)) for name in order])
    unfinished = path.with_suffix(".part")
    parquet.write_table(pyarrow.Table.from_pylist(flat, schema=schema), unfinished, compression="zstd")
    unfinished.replace(path)


def read_parquet(path: Path) -> list[Row]:
    """The rows of a file of `write_parquet`; none where there is no file. Raises SweepError for another file."""
    if not path.is_file():
        return []
    pyarrow, parquet = arrow()
    try:
        return [_from_flat(flat) for flat in parquet.read_table(path).to_pylist()]
    except (pyarrow.ArrowException, KeyError, TypeError) as error:
        raise SweepError(f"{path}: not the rows of a sweep ({error!r})") from error


def arrow() -> tuple[Any, Any]:
    """pyarrow and its module parquet. Raises SweepError where it is not installed."""
    try:
        import pyarrow
        from pyarrow import parquet
    except ImportError as error:
        raise SweepError(ARROW_MISSING) from error
    return pyarrow, parquet


_TABLES = {
    "settings": "setting",
    "factors": "factor",
    "metrics": "metric",
    "safety": "safety",
    "versions": "version",
}


def _row(data: Mapping[str, Any]) -> Row:
    return Row(**{**data, "failed_checks": tuple(data["failed_checks"]), "faults": tuple(data.get("faults", ()))})


def _flat(row: Row) -> dict[str, Any]:
    flat = {name: value for name, value in asdict(row).items() if name not in _TABLES}
    flat |= {"failed_checks": list(row.failed_checks), "faults": list(row.faults)}
    for name, short in _TABLES.items():
        flat |= {f"{short}.{key}": value for key, value in getattr(row, name).items()}
    return flat


def _from_flat(flat: Mapping[str, Any]) -> Row:
    data = {name: value for name, value in flat.items() if "." not in name}
    for name, short in _TABLES.items():
        mine = {key.removeprefix(f"{short}."): value for key, value in flat.items() if key.startswith(f"{short}.")}
        data[name] = {key: value for key, value in mine.items() if value is not None}
    return _row(data)


def _kind(pyarrow: Any, name: str) -> Any:
    """The type of a column: of the same name the same type, whatever the rows hold."""
    if name.startswith(("metric.", "factor.", "safety.")) or name in ("margin", "duration_s", "cpu_s"):
        return pyarrow.float64()
    texts = pyarrow.list_(pyarrow.string())
    kinds = {"seed": pyarrow.int64(), "ok": pyarrow.bool_(), "failed_checks": texts, "faults": texts}
    return kinds.get(name, pyarrow.string())


def pending(runs: Sequence[tuple[str, Run]], rows: Mapping[str, Row], of_commit: str) -> list[tuple[str, Run]]:
    """The runs, each with its key, that have no row of this commit yet."""
    return [(key, run) for key, run in runs if key not in rows or rows[key].commit != of_commit]
