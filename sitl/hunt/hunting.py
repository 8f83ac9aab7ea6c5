"""The hunt: ask the search, sail, shrink what violates a property, until the time is over."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from sitl.hunt.search import Known, Search, fault_names, margins_of, violations
from sitl.hunt.shrink import shrunk
from sitl.sweep.plan import Run
from sitl.sweep.rows import Row

_BATCH = 2  # runs a worker that are asked for together: the same answers give the same questions, whoever is faster


@dataclass(frozen=True, slots=True)
class Finding:
    """A violation. `run`: its smallest case; `found`: the run by which it was found."""

    prop: str
    run: Run
    margin: float
    found: Run

    def row(self) -> dict[str, Any]:
        """For a file."""
        return {**asdict(self), "command": self.run.command, "found_command": self.found.command}


class TimeOver(Exception):
    """The hunt may begin no further run. `rows`: of the runs that were asked for, those that are there."""

    def __init__(self, rows: Sequence[Row]) -> None:
        super().__init__()
        self.rows = rows


class Sailor:
    """Sails runs, or knows them from before. `sail`: sails some, and may leave out the last ones where the time is
    over; `most`: how many runs in all, those from before with them; None: no limit."""

    def __init__(self, sail: Callable[[Sequence[Run]], Sequence[Row]], most: int | None) -> None:
        self._sail, self._most = sail, most
        self._rows: dict[Run, Row] = {}

    @property
    def rows(self) -> Sequence[Row]:
        """All rows so far, in the order in which they were asked for."""
        return list(self._rows.values())

    def __call__(self, runs: Sequence[Run]) -> list[Row]:
        """The rows of runs. Raises TimeOver where the time is over before all of them are there."""
        new = [run for run in dict.fromkeys(runs) if run not in self._rows]
        if self._most is not None:
            new = new[: max(0, self._most - len(self._rows))]
        for row in self._sail(new) if new else ():
            self._rows[row.run] = row
        rows = [self._rows[run] for run in runs if run in self._rows]
        if len(rows) < len(runs):
            raise TimeOver(rows)
        return rows


def hunt(
    search: Search,
    sailor: Sailor,
    defaults: Mapping[str, str],
    places: int,
    tell: Callable[[Finding], None],
    on_row: Callable[[Row], None] = lambda row: None,
) -> list[Finding]:
    """Hunt until the time is over. `places`: runs at a time; `tell` is told each finding, `on_row` each row of the
    search."""
    findings: list[Finding] = []
    over = False
    while not over:
        asked = [search.ask() for _ in range(_BATCH * places)]
        rows, over = _as_many_as_there_are(sailor, [run for _, run in asked])
        of_run = {row.run: row for row in rows}
        for number, run in asked:
            if run in of_run:
                search.tell(number, margins_of(of_run[run]))
                on_row(of_run[run])
        for row in rows:
            for prop in violations(row):
                if not search.is_known(prop, row.run):
                    finding = _shrunk(prop, row, sailor, defaults, places)
                    findings.append(finding)
                    search.know(Known(prop, fault_names(finding.run)))
                    tell(finding)
    return findings


def _as_many_as_there_are(sailor: Sailor, runs: Sequence[Run]) -> tuple[Sequence[Row], bool]:
    """The rows of runs, and whether the time was over before all of them were there."""
    try:
        return sailor(runs), False
    except TimeOver as over:
        return over.rows, True


def _shrunk(prop: str, row: Row, sailor: Sailor, defaults: Mapping[str, str], places: int) -> Finding:
    """The smallest case of a row's violation; as small as it got where the time is over."""
    best = row

    def lasts(runs: Sequence[Run]) -> list[bool]:
        nonlocal best
        rows, over = _as_many_as_there_are(sailor, runs)
        answers = [prop in violations(one) for one in rows]
        best = next((one for one, yes in zip(rows, answers, strict=True) if yes), best)
        if over:
            raise TimeOver(rows)
        return answers

    with contextlib.suppress(TimeOver):
        shrunk(row.run, defaults, lasts, places)
    return Finding(prop, best.run, margins_of(best)[prop], row.run)
