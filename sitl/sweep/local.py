"""Workers on this machine: one process a core.

Each is a ProcessPoolExecutor of one process. One executor of many would fail every run in hand when a single process
dies (BrokenProcessPool), and a Dask LocalCluster would need Dask, sockets and a nanny for what stays on one machine.
"""

from __future__ import annotations

import contextlib
import functools
import multiprocessing
import os
import signal
import threading
from collections.abc import Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import forkserver
from pathlib import Path

from sitl.sweep.interrupts import held_back
from sitl.sweep.plan import Run
from sitl.sweep.rows import Row
from sitl.sweep.sailing import Died, Sail, sailed

_IMPORTED_ONCE = ["sitl.sweep.sailing", "sitl.scenarios"]


def cores() -> int:
    """How many processes this one may run at a time."""
    return len(os.sched_getaffinity(0))


class LocalWorkers:
    """A `Workers` of `count` processes. Logs go into `folder`; `keep`: those of good runs too."""

    def __init__(self, count: int, sail: Sail, folder: Path, keep: bool = False) -> None:
        self._sail, self._folder, self._keep = sail, folder, keep
        self._free = [_Place() for _ in range(count)]
        self._taken: dict[Future[Row], tuple[str, _Place]] = {}
        self._count = count

    @property
    def places(self) -> int:
        """See `Workers`."""
        return self._count

    def begin(self, key: str, run: Run) -> None:
        """See `Workers`."""
        place = self._free.pop()
        work = functools.partial(sailed, key, run, self._sail, self._folder, self._keep)
        try:
            future = place.executor.submit(work)
        except BrokenProcessPool:  # it died with nothing in hand
            place.end()
            place = _Place()
            future = place.executor.submit(work)
        self._taken[future] = key, place

    def finished(self, timeout_s: float) -> Sequence[Row | Died]:
        """See `Workers`."""
        done, _ = wait(self._taken, timeout_s, FIRST_COMPLETED)
        return [self._outcome(future) for future in done]

    def close(self) -> None:
        """See `Workers`."""
        places = [*self._free, *(place for _, place in self._taken.values())]
        for place in places:
            place.end()
        self._free, self._taken = [], {}

    def _outcome(self, future: Future[Row]) -> Row | Died:
        key, place = self._taken.pop(future)
        try:
            row = future.result()
        except BrokenProcessPool:
            place.end()
            self._free.append(_Place())
            return Died(key, "the process ended in mid-run")
        self._free.append(place)
        return row


class _Place:
    """A process that sails one run after another."""

    def __init__(self) -> None:
        context = multiprocessing.get_context("forkserver")  # imports once; a fork of ours would inherit its threads
        context.set_forkserver_preload(_IMPORTED_ONCE)
        with held_back():
            forkserver.ensure_running()
        self.executor = ProcessPoolExecutor(1, mp_context=context, initializer=_end_with_the_sweep)
        self._pid = self.executor.submit(os.getpid)

    def end(self) -> None:
        """Kill the process, with what it has in hand."""
        with contextlib.suppress(BrokenProcessPool, ProcessLookupError):
            os.kill(self._pid.result(), signal.SIGKILL)
        self.executor.shutdown(wait=False, cancel_futures=True)


def _end_with_the_sweep() -> None:
    """In a worker: Ctrl-C is for the sweep, which ends its workers; a sweep that was killed leaves none behind."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    sweep = multiprocessing.parent_process()
    assert sweep is not None

    def watch() -> None:
        sweep.join()
        os._exit(1)

    threading.Thread(target=watch, name="end with the sweep", daemon=True).start()
