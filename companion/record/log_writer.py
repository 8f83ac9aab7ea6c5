"""Writes the files of a log folder, and begins anew in another folder after a failure.

A log stops when the medium is full or fails, or when its folder is deleted. From then on a new folder is tried every
few seconds: `NAME-2`, `NAME-3` and so on, each complete with its manifest and headers, so that every reader takes it
for a run of its own. What cannot be written meanwhile is lost, and counted.
"""

from __future__ import annotations

import contextlib
import errno
import os
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Protocol

from companion.core.log_names import next_name
from companion.record.disk import REAL_DISK, Disk

RETRY_S, MOST_RETRY_S = 5.0, 60.0  # doubled each time while the new folder does not last
_LASTING_S = 60.0
CHECK_S = 2.0  # how often it is checked that the folder is still there
MOST_BYTES = 4 << 20  # that wait for the medium: a minute's worth or more
_SYNC_PAUSE_S = 0.02
_GATHER_S = 0.01  # rows of a burst that leave with one write, and wake the thread that writes them once
_NO_FAULT = (errno.EBADF, errno.EINVAL, errno.ENOTSUP)  # closed meanwhile, or a file system that cannot sync
_CLOSING_S = 10.0
_FAILS = (errno.ENOSPC, errno.EDQUOT, errno.EROFS, errno.EIO)


def medium_fails(error: OSError) -> bool:
    """Whether the medium is full or fails: no mistake of a person, and over some day."""
    return error.errno in _FAILS


class LogContent(Protocol):
    """What a log folder begins with."""

    def headers(self) -> Mapping[str, bytes]:
        """The name of each file, and the bytes that it begins with."""
        ...

    def furnish(self, folder: Path) -> None:
        """Put the manifest, and what else is not appended to, into a new folder. Raises OSError."""
        ...


class LogSet:
    """The open files of one log folder. `folder`: the present one; `number`: how many there have been; `stopped`: why
    nothing is written now, or None; `lost_bytes`: how much could not be written."""

    def __init__(self, folder: Path, content: LogContent, disk: Disk = REAL_DISK, patient: bool = False) -> None:
        """`patient`: where the medium is full or fails, the log begins stopped. Raises OSError when the folder cannot
        be written for any other reason, which is an error at start."""
        self._first = folder
        self._content = content
        self._disk = disk
        self._descriptors: dict[str, int] = {}
        self._dirty: set[str] = set()
        self._due_s = 0.0
        self._retry_s = RETRY_S
        self._begun_s: float | None = None
        self._sync_fault: str | None = None
        self.folder = folder
        self.number = 0
        self.stopped: str | None = None
        self.lost_bytes = 0
        self._tried: Path | None = folder  # ours, made or to be made, and not yet begun
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._begin(folder)
        except OSError as error:
            if not (patient and medium_fails(error)):
                raise
            self._stop(error.strerror or str(error), 0.0)

    def put(self, rows: Mapping[str, bytes], now_s: float) -> None:
        """Append whole rows to the files of those names; lose them while the log is stopped."""
        self._mend(now_s)
        if self.stopped is None:
            try:
                for name, data in rows.items():
                    self._disk.append(self._descriptors[name], data)
                    self._dirty.add(name)
                return
            except OSError as error:
                self._stop(error.strerror or str(error), now_s)
        self.lost_bytes += sum(map(len, rows.values()))

    def sync(self) -> None:
        """Sync to the medium what was written. Another thread may do this meanwhile."""
        while self._dirty:
            try:
                self._disk.sync(self._descriptors[self._dirty.pop()])
            except KeyError:
                return  # stopped meanwhile
            except OSError as error:
                if error.errno not in _NO_FAULT:
                    self._sync_fault = error.strerror or str(error)
                return

    def close(self) -> None:
        """Close all files."""
        descriptors, self._descriptors = self._descriptors, {}
        for descriptor in descriptors.values():
            with contextlib.suppress(OSError):
                os.close(descriptor)

    def _mend(self, now_s: float) -> None:
        """Begin anew where that is due."""
        if self._begun_s is None and self.stopped is None:
            self._begun_s = now_s
        if self._sync_fault is not None:
            self._stop(self._sync_fault, now_s)
        if now_s < self._due_s:
            return
        self._due_s = now_s + CHECK_S
        if self.stopped is None:
            if not self._is_gone():
                return
            self._stop("its folder was deleted", now_s)
        try:
            self._begin(self._next_folder())
            self._begun_s, self._due_s = now_s, now_s + CHECK_S
        except OSError as error:
            self._stop(error.strerror or str(error), now_s)

    def _begin(self, folder: Path) -> None:
        try:
            self._content.furnish(folder)
            for name, header in self._content.headers().items():
                self._descriptors[name] = self._disk.begin(folder / name)
                self._disk.append(self._descriptors[name], header)
                self._dirty.add(name)
        except OSError:
            self.close()
            raise
        self.folder, self.stopped, self._sync_fault, self._tried = folder, None, None, None
        self.number += 1

    def _next_folder(self) -> Path:
        """A new folder beside the first. An attempt that failed leaves its folder, and the next one uses it. Another
        that is there is of another run: a computer that keeps no time while it is off begins many at one second."""
        number = self.number + 1
        while self._tried is None:
            folder = self._first.with_name(next_name(self._first.name, number))
            self._tried = None if folder.exists() else folder
            number += 1
        self._tried.mkdir(parents=True, exist_ok=True)
        return self._tried

    def _stop(self, why: str, now_s: float) -> None:
        self.close()
        self.stopped, self._sync_fault = why, None
        lasted = self._begun_s is not None and now_s - self._begun_s >= _LASTING_S
        self._begun_s = None
        self._retry_s = RETRY_S if lasted else min(2.0 * self._retry_s, MOST_RETRY_S)
        self._due_s = now_s + self._retry_s

    def _is_gone(self) -> bool:
        try:
            return any(os.fstat(descriptor).st_nlink == 0 for descriptor in self._descriptors.values())
        except OSError:
            return True


class LogOutput(Protocol):
    """Takes the rows of a log."""

    def put(self, name: str, data: bytes, now_s: float) -> None:
        """Append whole rows to the file of that name. Never waits, and never raises."""
        ...

    @property
    def folder(self) -> Path:
        """The folder that is written to."""
        ...

    @property
    def number(self) -> int:
        """Grows with each new folder."""
        ...

    @property
    def stopped(self) -> str | None:
        """Why nothing is written now; None while all is well."""
        ...

    @property
    def lost_bytes(self) -> int:
        """How much could not be written."""
        ...

    def close(self) -> None:
        """Write what waits, and close the files."""
        ...


class _FolderLog:
    """What is told of the log folder, for both kinds of `LogOutput`."""

    def __init__(self, files: LogSet) -> None:
        self._files = files

    @property
    def folder(self) -> Path:
        """As `LogOutput.folder`."""
        return self._files.folder

    @property
    def number(self) -> int:
        """As `LogOutput.number`."""
        return self._files.number

    @property
    def stopped(self) -> str | None:
        """As `LogOutput.stopped`."""
        return self._files.stopped

    @property
    def lost_bytes(self) -> int:
        """As `LogOutput.lost_bytes`."""
        return self._files.lost_bytes


class DirectLog(_FolderLog):
    """A `LogOutput` that writes at once, in the caller's thread. Each row leaves the process with one call."""

    def put(self, name: str, data: bytes, now_s: float) -> None:
        """As `LogOutput.put`, except that it waits for the medium."""
        self._files.put({name: data}, now_s)

    def close(self) -> None:
        """As `LogOutput.close`."""
        self._files.close()


class ThreadLog(_FolderLog):
    """A `LogOutput` with two threads: one writes what `put` hands over, the other syncs it to the medium.

    `kill -9` loses at most what the first had not written yet, a power cut what the second had not synced.
    """

    def __init__(self, files: LogSet, clock: Callable[[], float] = time.monotonic) -> None:
        """`clock`: seconds, for the time between two attempts."""
        super().__init__(files)
        self._clock = clock
        self._wake = threading.Condition()
        self._waiting: dict[str, list[bytes]] = {}
        self._bytes = 0
        self._dropped = 0
        self._closed = threading.Event()
        self._threads = [
            threading.Thread(target=self._write_all, name="log-writer", daemon=True),
            threading.Thread(target=self._sync_all, name="log-sync", daemon=True),
        ]
        for thread in self._threads:
            thread.start()

    def put(self, name: str, data: bytes, now_s: float) -> None:
        """As `LogOutput.put`. Rows that find the queue full are lost."""
        with self._wake:
            if self._bytes + len(data) > MOST_BYTES:
                self._dropped += len(data)
                return
            self._bytes += len(data)
            self._waiting.setdefault(name, []).append(data)
            self._wake.notify()

    @property
    def lost_bytes(self) -> int:
        """As `LogOutput.lost_bytes`."""
        return self._dropped + super().lost_bytes

    def close(self) -> None:
        """As `LogOutput.close`. Gives up on a medium that does not answer."""
        with self._wake:
            self._closed.set()
            self._wake.notify()
        for thread in self._threads:
            thread.join(_CLOSING_S)
        if not any(thread.is_alive() for thread in self._threads):
            self._files.sync()
            self._files.close()

    def _write_all(self) -> None:
        while True:
            with self._wake:
                self._wake.wait_for(lambda: self._waiting or self._closed.is_set())
            self._closed.wait(_GATHER_S)
            with self._wake:
                waiting, self._waiting = self._waiting, {}
            if not waiting:
                return
            rows = {name: b"".join(parts) for name, parts in waiting.items()}
            self._files.put(rows, self._clock())
            with self._wake:
                self._bytes -= sum(map(len, rows.values()))

    def _sync_all(self) -> None:
        while not self._closed.wait(_SYNC_PAUSE_S):
            self._files.sync()
