"""Runs of two autopilots on the same tasks and seeds, kept in a file as they are sailed, and compared in a table."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

OWN, ROVER = "companion", "ArduRover"


@dataclass(frozen=True, slots=True)
class Row:
    """One run. `figures`: as `sitl.evaluate.figures` names them, less is better; empty where `error` says why."""

    task: str
    vessel: str
    seed: int
    autopilot: str
    version: str
    date: str
    figures: Mapping[str, float]
    error: str = ""


class Rows:
    """The rows in a file. Each is written at once, so that a comparison that was cut off goes on where it was."""

    def __init__(self, file: Path) -> None:
        """Raises ValueError for a file that holds something else."""
        self._file = file
        self._rows: list[Row] = []
        if file.is_file():
            try:
                self._rows = [Row(**row) for row in json.loads(file.read_text(encoding="utf-8"))["rows"]]
            except (KeyError, TypeError) as error:
                raise ValueError(f"{file} holds no rows of runs") from error

    def has(self, task: str, seed: int, autopilot: str) -> bool:
        """Whether that run was sailed."""
        return any((row.task, row.seed, row.autopilot) == (task, seed, autopilot) for row in self._rows)

    def add(self, row: Row) -> None:
        """Keep a run."""
        self._rows.append(row)
        part = self._file.with_suffix(".part")
        part.write_text(json.dumps({"rows": [asdict(row) for row in self._rows]}, indent=1) + "\n", encoding="utf-8")
        part.replace(self._file)

    def table(self) -> Iterator[str]:
        """Markdown: means of both, in brackets the worst, and how many times worse ArduRover is. Only seeds that both
        completed count."""
        yield f"| task | figure | {OWN} | {ROVER} | {ROVER} / {OWN} |"
        yield "|---|---|---:|---:|---:|"
        for task in dict.fromkeys(row.task for row in self._rows):
            own, rover = (self._done(task, autopilot) for autopilot in (OWN, ROVER))
            both = sorted(own.keys() & rover.keys())
            if both:
                yield from _lines(self._title(task, len(both)), [own[s] for s in both], [rover[s] for s in both])

    def _done(self, task: str, autopilot: str) -> Mapping[int, Mapping[str, float]]:
        return {
            row.seed: row.figures
            for row in self._rows
            if (row.task, row.autopilot) == (task, autopilot) and row.figures
        }

    def _title(self, task: str, both: int) -> str:
        seeds = len({row.seed for row in self._rows if row.task == task})
        return f"{task} ({both} of {seeds} seeds)"


def _lines(title: str, own: Sequence[Mapping[str, float]], rover: Sequence[Mapping[str, float]]) -> Iterator[str]:
    for name in own[0]:
        ours = [figures[name] for figures in own]
        theirs = [figures[name] for figures in rover if name in figures]
        ratio = f"{sum(theirs) / sum(ours):.2f}" if theirs and sum(ours) > 0.0 else "–"
        yield f"| {title} | {name} | {_cell(ours)} | {_cell(theirs)} | {ratio} |"
        title = ""


def _cell(values: Sequence[float]) -> str:
    return f"{sum(values) / len(values):.3g} ({max(values):.3g})" if values else "not held"
