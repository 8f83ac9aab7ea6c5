"""Who sails the runs of a sweep or a hunt, and when that ends: what both commands take and do."""

from __future__ import annotations

import argparse
import contextlib
import os
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from companion.cli.common import Interrupt, UsageError

if TYPE_CHECKING:
    from sitl.sweep.rows import Journal
    from sitl.sweep.sailing import Sail, Workers

_COMPARE = "choose another --out, and compare both by `companion sweep report DIR --against DIR2`"


def add_crew_to(parser: argparse.ArgumentParser) -> None:
    """Add the options that say who sails."""
    parser.add_argument("--jobs", type=int, metavar="N", help="runs at a time on this machine; default: one a core")
    parser.add_argument(
        "--scheduler", metavar="URL", help="sail on the cluster of this Dask scheduler, tcp://HOST:PORT"
    )
    parser.add_argument("--keep", action="store_true", help="keep the logs of good runs too")


def _check(arguments: argparse.Namespace) -> None:
    """Raises UsageError for a number that makes no sense."""
    if arguments.jobs is not None and arguments.jobs < 1:
        raise UsageError(f"--jobs {arguments.jobs}: must be at least 1")
    if arguments.minutes is not None and not arguments.minutes > 0.0:
        raise UsageError(f"--minutes {arguments.minutes:g}: must be above 0")


def sail_to_the_end(arguments: argparse.Namespace, task: Callable[[Callable[[], bool]], int]) -> int:
    """Returns what `task(interrupted)` returns, which Ctrl-C asks to end; then that of a command that was ended. Raises
    UsageError for a number that makes no sense, and for what cannot be sailed."""
    from sitl.sweep.rows import SweepError

    _check(arguments)
    interrupt = Interrupt()
    try:
        code = task(lambda: interrupt.received)
    except SweepError as error:
        raise UsageError(str(error)) from error
    if interrupt.received:
        raise KeyboardInterrupt
    return code


class Ending:
    """Says when to stop: at once where it is asked to, and with no further run after `minutes`."""

    def __init__(self, minutes: float | None, interrupted: Callable[[], bool]) -> None:
        self._due_s = None if minutes is None else time.monotonic() + 60.0 * minutes
        self._interrupted = interrupted

    def stopped(self, what: str) -> bool:
        """As `sail_all` asks."""
        return self._interrupted() or (what == "begin" and self._is_late)

    @property
    def _is_late(self) -> bool:
        return self._due_s is not None and time.monotonic() >= self._due_s

    @property
    def words(self) -> str:
        """Why not all was sailed, to follow the count."""
        if self._interrupted():
            return "; interrupted: the same command goes on from here"
        return "; the time is over: the same command goes on from here" if self._is_late else ""


@contextlib.contextmanager
def workers_of(arguments: argparse.Namespace, sail: Sail, folder: Path, most: int) -> Iterator[Workers]:
    """The workers, until the end of the block. Raises SweepError."""
    from sitl.sweep.cluster import ClusterWorkers
    from sitl.sweep.local import LocalWorkers, cores

    workers: Workers
    if arguments.scheduler is not None:
        workers = ClusterWorkers(arguments.scheduler, sail, folder, arguments.keep)
    else:
        # one core a run: a library's own threads would only get in the way; the workers take it over as they start
        os.environ.setdefault("OMP_NUM_THREADS", "1")
        workers = LocalWorkers(min(arguments.jobs or cores(), most), sail, folder, arguments.keep)
    try:
        yield workers
    finally:
        workers.close()


def refuse_other_code(journal: Journal, folder: Path, commit: str) -> None:
    """Raises SweepError where the folder holds runs of another commit, or with a vessel as its file was before."""
    from sitl.sweep.plan import vessel_changed
    from sitl.sweep.rows import SweepError

    changed = sorted({row.vessel for row in journal.rows.values() if vessel_changed(row.key, row.run)})
    if changed:
        raise SweepError(f"{folder}: holds runs with {', '.join(changed)} before its file changed; {_COMPARE}")
    others = sorted({row.commit for row in journal.rows.values()} - {commit})
    if others:
        raise SweepError(f"{folder}: holds runs of {', '.join(others)}, and this is {commit}; {_COMPARE}")
