"""Files of the log folders, read in a thread of their own: a memory card may take a tenth of a second, a tick must
not."""

from __future__ import annotations

import contextlib
import os
import shutil
import stat
import zlib
from collections.abc import Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, TypeVar

from companion.core.log_names import is_of_run

_BLOCK = 1 << 17
_KEPT_BLOCKS = 3
_MARK = "manifest.json"  # marks a log folder; written when the run begins
LOG_FILES = ("ticks.ulg", "telemetry.tlog")


@dataclass(frozen=True, slots=True)
class Entry:
    """One name in a directory; `size` None for a directory."""

    name: str
    size: int | None = None


@dataclass(frozen=True, slots=True)
class Run:
    """The log file of one run: its path (folder, file), its size, and when the run began."""

    path: tuple[str, str]
    size: int
    begun_unix_s: int


class DiskFile:
    """One open file. `size`: when it was opened. Remembers the last blocks, read or being read."""

    def __init__(self, store: LogStore, pool: ThreadPoolExecutor, descriptor: int, size: int) -> None:
        self.size = size
        self._store = store
        self._pool = pool
        self._descriptor = descriptor
        self._blocks: dict[int, Future[bytes]] = {}

    def read(self, offset: int, count: int) -> bytes | None:
        """Up to `count` bytes from `offset`; None while they are being read. Raises OSError when the disk fails."""
        count = max(0, min(count, self.size - offset))
        first, last = offset // _BLOCK, (offset + max(0, count - 1)) // _BLOCK
        for number in (first, last, last + 1):  # the next block too: it will be needed
            self._fetch(number)
        wanted = [self._blocks[number] for number in range(first, last + 1)]
        if not all(block.done() for block in wanted):
            return None
        data = b"".join(block.result() for block in wanted)
        return data[offset - first * _BLOCK :][:count]

    def crc32(self) -> Future[int]:
        """MAVLink's CRC32 of the whole file, as a future."""
        return self._pool.submit(_crc32, self._descriptor, self.size)

    def close(self) -> None:
        """Close it, after the reads that are under way."""
        self._blocks.clear()
        self._store.close_file(self._descriptor)

    def _fetch(self, number: int) -> None:
        if number in self._blocks or number * _BLOCK >= max(1, self.size):
            return
        while len(self._blocks) >= _KEPT_BLOCKS:
            del self._blocks[min(self._blocks, key=lambda kept: -abs(kept - number))]
        self._blocks[number] = self._pool.submit(os.pread, self._descriptor, _BLOCK, number * _BLOCK)


class Closable(Protocol):
    """A file that must be closed."""

    def close(self) -> None:
        """Close it."""
        ...


C = TypeVar("C", bound=Closable)


def abandon(opening: Future[C | None]) -> None:
    """Nobody waits for this file any more: it is not opened, or closed as soon as it is open."""

    def close(done: Future[C | None]) -> None:
        file = None if done.cancelled() or done.exception() is not None else done.result()
        if file is not None:
            file.close()

    if not opening.cancel():
        opening.add_done_callback(close)


class LogStore:
    """The log folders in one directory: two levels, regular files only, symbolic links ignored. Remembers the open
    descriptors."""

    def __init__(self, directory: Path, running: str | None = None) -> None:
        """`running`: name of the log folder with which this run began. It is never erased, nor are those in which its
        log went on (`NAME-2`…)."""
        self._directory = directory
        self._running = running
        self._open_files: set[int] = set()
        self._closed = False
        self._pool = ThreadPoolExecutor(1, thread_name_prefix="log-reader")

    def entries(self, path: Sequence[str]) -> Future[list[Entry] | None]:
        """The entries of a directory, sorted by name; None where there is no such directory."""
        return self._pool.submit(self._entries, tuple(path))

    def open(self, path: Sequence[str]) -> Future[DiskFile | None]:
        """Open a file; None where there is no such file."""
        return self._pool.submit(self._open, tuple(path))

    def runs(self, most: int) -> Future[list[Run]]:
        """The newest `most` runs, oldest first, each with the first of LOG_FILES that it has; empty files do not
        count."""
        return self._pool.submit(self._runs, most)

    def erase(self) -> Future[tuple[int, int]]:
        """Delete the log folders of all other runs: (how many, their bytes). One that cannot be deleted stays."""
        return self._pool.submit(self._erase)

    def close_file(self, descriptor: int) -> None:
        """Close an open file, after the reads that are under way."""
        if not self._closed:
            self._pool.submit(self._close_file, descriptor)

    def close(self) -> None:
        """End the thread, after what it is doing, and close all files."""
        self._closed = True
        self._pool.shutdown(wait=True, cancel_futures=True)
        while self._open_files:
            os.close(self._open_files.pop())

    def _close_file(self, descriptor: int) -> None:
        if descriptor in self._open_files:
            self._open_files.discard(descriptor)
            os.close(descriptor)

    def _runs(self, most: int) -> list[Run]:
        found = []
        for folder in self._entries(()) or ():
            sizes = {entry.name: entry.size for entry in self._files_of(folder.name) if entry.size}
            name = next((name for name in LOG_FILES if name in sizes), None)
            if name is not None and _MARK in sizes:
                with contextlib.suppress(OSError):  # deleted meanwhile
                    begun_s = int((self._directory / folder.name / _MARK).stat().st_mtime)
                    found.append(Run((folder.name, name), sizes[name] or 0, begun_s))
        return sorted(found, key=lambda run: (run.begun_unix_s, run.path))[-most:]

    def _erase(self) -> tuple[int, int]:
        count = size = 0
        for folder in self._entries(()) or ():
            files = self._files_of(folder.name)
            if self._is_of_this_run(folder.name) or _MARK not in {entry.name for entry in files}:
                continue
            path = self._directory / folder.name
            shutil.rmtree(path, ignore_errors=True)
            if not path.exists():
                count += 1
                size += sum(entry.size or 0 for entry in files)
        return count, size

    def _files_of(self, folder: str) -> Sequence[Entry]:
        """The files of a folder; none of one that is not ours to read, as lost+found, or is deleted meanwhile."""
        try:
            return self._entries((folder,)) or ()
        except OSError:
            return ()

    def _is_of_this_run(self, name: str) -> bool:
        return self._running is not None and is_of_run(name, self._running)

    def _entries(self, path: tuple[str, ...]) -> list[Entry] | None:
        folder = self._below(path)
        if folder is None or not folder.is_dir() or len(path) > 2:
            return None
        found = []
        for item in sorted(folder.iterdir(), key=lambda item: item.name):
            mode = item.lstat().st_mode
            if stat.S_ISDIR(mode) and len(path) < 2:
                found.append(Entry(item.name))
            elif stat.S_ISREG(mode) and path:
                found.append(Entry(item.name, item.stat().st_size))
        return found

    def _open(self, path: tuple[str, ...]) -> DiskFile | None:
        file = self._below(path)
        if file is None or len(path) < 2:
            return None
        try:
            descriptor = os.open(file, os.O_RDONLY | os.O_NOFOLLOW | os.O_CLOEXEC | os.O_NONBLOCK)
        except OSError:
            return None
        status = os.fstat(descriptor)
        if not stat.S_ISREG(status.st_mode):
            os.close(descriptor)
            return None
        self._open_files.add(descriptor)
        return DiskFile(self, self._pool, descriptor, status.st_size)

    def _below(self, path: tuple[str, ...]) -> Path | None:
        """The path inside the directory; None where a part of it is invalid or a symbolic link."""
        place = self._directory
        for name in path:
            if name in ("", ".", "..") or "/" in name or "\0" in name:
                return None
            place = place / name
            if place.is_symlink():
                return None
        return place


def _crc32(descriptor: int, size: int) -> int:
    crc, offset = 0xFFFFFFFF, 0
    while offset < size:
        data = os.pread(descriptor, _BLOCK, offset)
        if not data:
            break
        crc = zlib.crc32(data[: size - offset], crc)
        offset += len(data)
    return crc ^ 0xFFFFFFFF
