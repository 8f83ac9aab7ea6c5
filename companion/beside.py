"""Work beside the control thread: a bell that wakes it, and a worker that computes for it in threads.

In lockstep the work is done at once instead (`core/work.py`), behind the same interface. So results are the same.
"""

from __future__ import annotations

import gc
import os
import queue
import threading
import time
from collections.abc import Callable
from concurrent.futures import Future
from typing import Any, TypeVar

from companion.core.tick import Tick
from companion.core.work import settle

T = TypeVar("T")

_LONG_S = 0.05  # of processor time


class Bell:
    """Implements `core.ports.Waker` with a descriptor that counts rings."""

    def __init__(self) -> None:
        self._descriptor = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        self._lock = threading.Lock()
        self._closed = False

    def fileno(self) -> int:
        """Becomes readable when the bell rings."""
        return self._descriptor

    def ring(self) -> None:
        """Wake the control thread, now or when it next waits."""
        with self._lock:
            if not self._closed:
                os.eventfd_write(self._descriptor, 1)

    def silence(self) -> None:
        """The control thread has heard it."""
        try:
            os.eventfd_read(self._descriptor)
        except BlockingIOError:
            return

    def close(self) -> None:
        """Close the descriptor. Later rings do nothing."""
        with self._lock:
            if not self._closed:
                self._closed = True
                os.close(self._descriptor)


class ThreadWorker:
    """Implements `core.ports.Worker` with two threads: urgent work passes all other. Rings the bell after each piece of
    work."""

    def __init__(self, bell: Bell) -> None:
        self._usual, self._urgent = _Lane("worker", bell), _Lane("urgent-worker", bell)

    def submit(self, work: Callable[[], T], urgent: bool = False) -> Future[T]:
        """As `Worker.submit`."""
        return (self._urgent if urgent else self._usual).submit(work)

    def close(self) -> None:
        """Cancel what waits, and end after what runs."""
        for lane in (self._usual, self._urgent):
            lane.close()


class _Lane:
    """A thread that does one piece of work after the other.

    What long work has made usually stays. It is taken out of the garbage collector's sight, since a full collection
    would stop all threads for tens of milliseconds.
    """

    def __init__(self, name: str, bell: Bell) -> None:
        self._bell = bell
        self._waiting: queue.SimpleQueue[tuple[Callable[[], Any], Future[Any]] | None] = queue.SimpleQueue()
        self._closed = threading.Event()
        self._thread = threading.Thread(target=self._run, name=name, daemon=True)
        self._thread.start()

    def submit(self, work: Callable[[], T]) -> Future[T]:
        future: Future[T] = Future()
        self._waiting.put((work, future))
        return future

    def close(self) -> None:
        self._closed.set()
        self._waiting.put(None)
        self._thread.join()

    def _run(self) -> None:
        while (job := self._waiting.get()) is not None:
            work, future = job
            if self._closed.is_set():
                future.cancel()
            elif future.set_running_or_notify_cancel():
                begun_s = time.thread_time()
                settle(future, work)
                if time.thread_time() - begun_s > _LONG_S:
                    gc.collect(1)
                    gc.freeze()
                self._bell.ring()
            del work, future, job  # they may hold the largest objects of the boat


class Beside:
    """The bell and the worker of one vessel. As a recorder it only ends them, after all others."""

    def __init__(self) -> None:
        self.bell = Bell()
        self.worker = ThreadWorker(self.bell)

    def record(self, tick: Tick) -> None:
        """Nothing to record."""

    def close(self) -> None:
        """End the worker's threads and close the bell."""
        self.worker.close()
        self.bell.close()
