"""The manoeuvres of a Trial in a log: when each ran, by the texts that the mode announced."""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from pathlib import Path

_RUNS = re.compile(r"Trial: (\d+)/(\d+) (.+), -?\d+ min left")
_RAN = re.compile(r"Trial: (\d+)/(\d+) (done|at the circle)")


@dataclass(frozen=True, slots=True)
class Ran:
    """One manoeuvre: its name, its time in the log, and whether the circle ended it."""

    name: str
    from_s: float
    to_s: float
    cut: bool


def manoeuvres(folder: Path) -> tuple[Ran, ...]:
    """All manoeuvres of the log's trials, in their order; empty for a log without one. Raises OSError."""
    path = folder / "events.csv"
    if not path.exists():
        return ()
    found: list[Ran] = []
    begun: tuple[str, float] | None = None
    with path.open(encoding="utf-8", errors="replace", newline="") as file:
        for row in csv.DictReader(file):
            try:
                text, t_s = row.get("text") or "", float(row["t_s"])
            except (KeyError, TypeError, ValueError):
                continue  # what a power cut left of a row
            if match := _RUNS.fullmatch(text):
                begun = match[3], t_s
            elif begun is not None and (match := _RAN.fullmatch(text)):
                found.append(Ran(begun[0], begun[1], t_s, match[3] != "done"))
                begun = None
    return tuple(found)
