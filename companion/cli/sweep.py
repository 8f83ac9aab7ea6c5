"""`companion sweep FILE | report DIR`: a design of experiments, sailed on many cores, and what came of it."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from companion.cli.common import UsageError, typed
from companion.cli.crew import Ending, add_crew_to, refuse_other_code, sail_to_the_end, workers_of
from companion.cli.progress import bar
from companion.cli.sweep_progress import SweepProgress
from companion.config.vessel import ConfigError, text_of

if TYPE_CHECKING:
    from sitl.scenarios.rig import Conditions, Rig
    from sitl.sweep.plan import Run
    from sitl.sweep.rows import Journal
    from sitl.sweep.sailing import Sail
    from sitl.sweep.summary import Comparison

_SWEEPS = Path("out") / "sweeps"


def add_to(commands: Any) -> None:
    """Add the command to `commands`, argparse's subparsers."""
    sweep = commands.add_parser(
        "sweep",
        help="sail a design of experiments on all cores, and report on it",
        description="`companion sweep FILE` is short for `companion sweep run FILE`.",
    )
    sweep.tasks = ("run", "report")
    tasks = sweep.add_subparsers(required=True, metavar="FILE | report DIR")
    run = tasks.add_parser("run", help="sail what the design asks for and has not been sailed yet")
    run.add_argument("file", type=Path, metavar="FILE", help="the design, a TOML file")
    run.add_argument("--out", type=Path, metavar="DIR", help="folder of the sweep; default: out/sweeps/NAME/COMMIT")
    add_crew_to(run)
    run.add_argument("--minutes", type=float, metavar="M", help="begin no run after this time; default: of the design")
    run.set_defaults(command=_run)
    report = tasks.add_parser(
        "report", help="failure rates, distributions and worst cases of a sweep, as one HTML file"
    )
    report.add_argument("folder", type=Path, metavar="DIR", help="the folder of a sweep")
    report.add_argument("--against", type=Path, metavar="DIR2", help="compare with this sweep, paired by seed")
    report.add_argument("--by", metavar="KEY", help="compare the values of a setting, as law, paired by seed")
    report.add_argument("--out", type=Path, metavar="HTML", help="default: report.html in the sweep's folder")
    report.set_defaults(command=_report)


def sail(run: Run, folder: Path) -> None:
    """Sail a run of a sweep in lockstep; a `sitl.sweep.sailing.Sail`. Raises Refused for a setting that the scenario
    does not take."""
    from companion.cli.rig import LockstepRig
    from sitl.scenarios import SCENARIOS
    from sitl.scenarios import scenario as scenarios
    from sitl.sweep.sailing import Refused

    composed = False

    def compose(conditions: Conditions, folder: Path) -> Rig:
        nonlocal composed
        rig = LockstepRig(conditions, folder)
        composed = True
        return rig

    try:
        scenarios.run(
            SCENARIOS[run.scenario], compose, folder, run.seed, run.vessel, dict(run.settings), faults=run.faults
        )
    except (scenarios.ScenarioError, ConfigError, UsageError, ValueError) as error:
        if composed:
            raise
        raise Refused(f"{run.command}: {error}") from error


# --- run -----------------------------------------------------------------------------------------------------------


def _run(arguments: argparse.Namespace) -> int:
    """Exit code 0 where all runs that were sailed are good, else 1."""
    return sail_to_the_end(arguments, lambda interrupted: sweep(arguments, sail, interrupted))


def sweep(arguments: argparse.Namespace, sail: Sail, interrupted: Callable[[], bool]) -> int:
    """`companion sweep run` with its arguments. `sail`: how a run is sailed; `interrupted`: whether to end now. Raises
    ConfigError for a design with errors, SweepError, OSError."""
    from sitl.scenarios import SCENARIOS
    from sitl.sweep.design import parse_design
    from sitl.sweep.plan import key_of, runs_of
    from sitl.sweep.provenance import commit
    from sitl.sweep.rows import PARQUET, Journal, arrow, pending, write_parquet

    arrow()
    text = text_of(arguments.file)
    design = parse_design(text, str(arguments.file), SCENARIOS)
    runs = [(key_of(run), run) for run in runs_of(design, SCENARIOS)]
    folder = arguments.out or _SWEEPS / design.name / commit()
    minutes = design.minutes if arguments.minutes is None else arguments.minutes
    with Journal(folder) as journal:
        refuse_other_code(journal, folder, commit())
        (folder / "design.toml").write_text(text, encoding="utf-8")
        left = pending(runs, journal.rows, commit())
        before = f", {len(runs) - len(left)} of them before" if len(left) < len(runs) else ""
        print(f"{design.name}: {len(runs)} runs{before}; {folder}", flush=True)
        try:
            over = _sail_rest(arguments, sail, journal, folder, left, Ending(minutes, interrupted)) if left else ""
        finally:
            write_parquet(journal.rows.values(), folder / PARQUET)
        rows = [journal.rows[key] for key, _ in runs if key in journal.rows]
    failed = sum(not row.ok for row in rows)
    print(f"{len(rows)} of {len(runs)} runs sailed, {failed} failed{over}")
    print(f"written: {folder / PARQUET}; `{typed('sweep', 'report', folder)}` reports on it")
    return 1 if failed else 0


def _sail_rest(
    arguments: argparse.Namespace,
    sail: Sail,
    journal: Journal,
    folder: Path,
    left: Sequence[tuple[str, Run]],
    ending: Ending,
) -> str:
    """Sail what is left. Returns why some of it was not sailed, in words."""
    from sitl.sweep.rows import Row
    from sitl.sweep.sailing import sail_all

    taken = 0
    with workers_of(arguments, sail, folder, len(left)) as workers, bar("sweep", time_left=False) as told:
        progress = SweepProgress(told, len(left), time.monotonic(), lines=not sys.stderr.isatty())

        def take(row: Row) -> None:
            nonlocal taken
            taken += 1
            journal.add(row)
            progress.take(row, time.monotonic())

        sail_all(left, workers, take, ending.stopped)
    return ending.words if taken < len(left) else ""


# --- report --------------------------------------------------------------------------------------------------------


def _report(arguments: argparse.Namespace) -> int:
    from companion.cli.sweep_page import compare_by, print_comparisons, print_summaries, write_page
    from sitl.sweep.rows import JOURNAL, PARQUET, SweepError, read_rows, write_parquet
    from sitl.sweep.summary import compared, summaries

    try:
        rows = read_rows(arguments.folder)
        journal = arguments.folder / JOURNAL
        if journal.exists():  # a sweep that goes on, or was killed, has rows that are not in the file
            write_parquet(rows, arguments.folder / PARQUET)
        found = summaries(rows)
        comparisons: dict[str, Sequence[Comparison]] = {}
        if arguments.against is not None:
            title = f"{arguments.folder} against {arguments.against}"
            comparisons[title] = compared(read_rows(arguments.against), rows, arguments.by)
        elif arguments.by is not None:
            comparisons = compare_by(rows, arguments.by)
    except SweepError as error:
        raise UsageError(str(error)) from error
    print_summaries(found)
    print_comparisons(comparisons)
    out = arguments.out or arguments.folder / "report.html"
    with bar("report") as told:
        hint = write_page(out, arguments.folder, rows, found, comparisons, told)
    if hint:
        print(hint)
    print(f"written: {out}")
    return 0
