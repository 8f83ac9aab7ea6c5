"""A medium that stalls, is full or gone when a test says so. Nothing here looks at a clock."""

from __future__ import annotations

import errno
import os
import threading
from pathlib import Path

from companion.record.disk import Owner, RealDisk
from tests.waiting import CAP_S, wait_until


class FaultyDisk(RealDisk):
    """`stall()` holds every call until `go_on()`; `fail_with(number)` raises an OSError in every call until
    `fail_with(None)`."""

    def __init__(self) -> None:
        self._may_go = threading.Event()
        self._may_go.set()
        self._fault: int | None = None
        self.stalled = threading.Semaphore(0)  # released by each call that stalls
        self.replaced: list[str] = []  # names of files, in the order in which they became durable

    def stall(self) -> None:
        self._may_go.clear()

    def go_on(self) -> None:
        self._may_go.set()

    def fail_with(self, number: int | None = errno.ENOSPC) -> None:
        self._fault = number

    def wait_for_stall(self) -> None:
        wait_until(lambda: self.stalled.acquire(blocking=False), "a call to the medium")

    def replace(self, directory: Path, name: str, data: bytes, mode: int, owner: Owner | None) -> None:
        self._call()
        super().replace(directory, name, data, mode, owner)
        self.replaced.append(name)

    def begin(self, path: Path) -> int:
        self._call()
        return super().begin(path)

    def append(self, descriptor: int, data: bytes) -> None:
        self._call()
        super().append(descriptor, data)

    def sync(self, descriptor: int) -> None:
        self._call()

    def _call(self) -> None:
        if not self._may_go.is_set():
            self.stalled.release()
            assert self._may_go.wait(CAP_S)
        if self._fault is not None:
            raise OSError(self._fault, os.strerror(self._fault))
