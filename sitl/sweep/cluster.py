"""Workers of a Dask cluster. They need the same code, and no folder in common: a log comes back with its row."""

from __future__ import annotations

import io
import queue
import re
import tempfile
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from sitl.sweep.plan import Run
from sitl.sweep.rows import Row, SweepError
from sitl.sweep.sailing import LOGS, Died, Sail, sailed

_CONNECTING_S = 5.0
_ADDRESS = re.compile(r"(\w+://)?\S+:\d+/?")
DASK_MISSING = "--scheduler needs Dask: pip install 'usv-companion[sweep]'"


class ClusterWorkers:
    """A `Workers` that a Dask scheduler finds. Dask itself begins a run anew whose worker dies, until its limit
    (`distributed.scheduler.allowed-failures`)."""

    def __init__(self, scheduler: str, sail: Sail, folder: Path, keep: bool = False) -> None:
        """`scheduler`: its address, `tcp://HOST:PORT`. Raises SweepError where none answers or Dask is missing."""
        try:
            import distributed
        except ImportError as error:
            raise SweepError(DASK_MISSING) from error
        if not _ADDRESS.fullmatch(scheduler):
            raise SweepError(f"--scheduler {scheduler}: write tcp://HOST:PORT")
        self._scheduler, self._sail, self._folder, self._keep = scheduler, sail, folder, keep
        client: Any = distributed.Client  # has no types
        try:
            self._client = client(scheduler, timeout=_CONNECTING_S, set_as_default=False, name="companion-sweep")
        except (OSError, ValueError) as error:
            raise SweepError(
                f"--scheduler {scheduler}: no scheduler answers there ({error}); start one by `dask scheduler`"
            ) from error
        self._ended: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._keys: dict[str, tuple[str, Any]] = {}
        self._handed = 0

    @property
    def places(self) -> int:
        """One more than each worker can sail at a time, so that none waits for us. 1 where there is no worker yet."""
        threads = self._asked(self._client.nthreads)
        return sum(threads.values()) + len(threads) or 1

    def begin(self, key: str, run: Run) -> None:
        """See `Workers`."""
        self._handed += 1
        name = f"{key}-{self._handed}"
        future = self._asked(
            self._client.submit, sail_away, key, run, self._sail, self._keep, key=name, pure=False, retries=0
        )
        self._keys[name] = key, future
        future.add_done_callback(self._ended.put)

    def finished(self, timeout_s: float) -> Sequence[Row | Died]:
        """See `Workers`."""
        try:
            future = self._ended.get(timeout=timeout_s)
        except queue.Empty:
            return []
        key, _ = self._keys.pop(future.key)
        return [self._outcome(key, future)]

    def close(self) -> None:
        """See `Workers`. Runs that a worker has in hand end with their worker's next look at its orders."""
        for _, future in self._keys.values():
            future.release()
        self._keys = {}
        self._client.close(timeout=1.0)

    def _outcome(self, key: str, future: Any) -> Row | Died:
        from distributed.scheduler import KilledWorker

        if future.status not in ("finished", "error"):
            raise self._gone("it is gone")
        try:
            row, log = self._asked(future.result)
        except KilledWorker as error:
            return Died(key, str(error), last=True)
        finally:
            future.release()
        if log is not None:
            with zipfile.ZipFile(io.BytesIO(log)) as packed:
                packed.extractall(self._folder / LOGS / key)
        found: Row = row
        return found

    def _asked(self, what: Any, *words: Any, **options: Any) -> Any:
        """What the scheduler answers. Raises SweepError where it is gone."""
        from concurrent.futures import CancelledError

        try:
            return what(*words, **options)
        except (OSError, RuntimeError, CancelledError) as error:
            raise self._gone(str(error)) from error

    def _gone(self, why: str) -> SweepError:
        return SweepError(
            f"the scheduler at {self._scheduler} does not answer any more ({why}); no finished run is lost: "
            "the same command goes on from here"
        )


def sail_away(key: str, run: Run, sail: Sail, keep: bool) -> tuple[Row, bytes | None]:
    """On a worker: the row of a run, and its log as a ZIP archive where it is kept."""
    with tempfile.TemporaryDirectory(prefix="sweep-") as temporary:
        row = sailed(key, run, sail, Path(temporary), keep)
        return row, None if row.log is None else _packed(Path(temporary) / row.log)


def _packed(folder: Path) -> bytes:
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w", zipfile.ZIP_DEFLATED) as packed:
        for path in sorted(folder.rglob("*")):
            packed.write(path, path.relative_to(folder))
    return archive.getvalue()
