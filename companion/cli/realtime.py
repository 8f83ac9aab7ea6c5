"""`companion run --realtime`: the boat's threads come before all ordinary programs, and its memory is not swapped out.

The control thread holds the interpreter's lock by turns with the other threads of the process. So all of them get a
real-time priority, and the control thread a higher one: else a program that takes every processor would hold up a
thread that holds the lock.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import resource
import threading
from collections.abc import Callable
from pathlib import Path

from companion.core.tick import Tick

THREADS, CONTROL = 10, 20  # SCHED_FIFO priorities; the unit of `companion service` allows up to 20
_LOOK_S = 2.0
_LAST = 19
_CURRENT, _FUTURE, _ON_FAULT = 1, 2, 4  # mlockall(2): what is there, what comes, but only pages that are used

Lock = Callable[[], None]
Schedule = Callable[[int], None]
ThreadSchedule = Callable[[int, int], None]


def before_threads(lock: Lock | None = None, schedule: Schedule | None = None) -> list[str]:
    """Lock the memory, and give this process its priority; threads made later inherit it. Returns what the system
    refused, in a line each with the remedy."""
    refused = _tried(schedule or _schedule, THREADS, "RLIMIT_RTPRIO", resource.RLIMIT_RTPRIO)
    try:
        (lock or _lock_memory)()
    except OSError as error:
        refused.append(f"memory not locked: {error.strerror}; {_remedy('RLIMIT_MEMLOCK', resource.RLIMIT_MEMLOCK)}")
    return refused


def control_thread(schedule: Schedule | None = None) -> list[str]:
    """Raise the calling thread above the others. Returns what the system refused."""
    return _tried(schedule or _schedule, CONTROL, "RLIMIT_RTPRIO", resource.RLIMIT_RTPRIO)


def after_all_others() -> None:
    """This process computes only while no other program wants to, and with one thread: what it does can wait."""
    os.environ.update(dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"))
    with contextlib.suppress(OSError):
        os.sched_setscheduler(0, os.SCHED_IDLE, os.sched_param(0))
    with contextlib.suppress(OSError):
        os.nice(_LAST)


class Priorities:
    """A `core.ports.Recorder` that sees to threads made later: they inherit the control thread's priority, which is its
    alone. It looks every 2 s."""

    def __init__(self, threads: Callable[[], list[int]] | None = None, schedule: ThreadSchedule | None = None) -> None:
        """`threads`: the ids of all threads; `schedule(thread, priority)`. A test gives its own."""
        self._threads = threads or _threads
        self._schedule = schedule or _schedule_thread
        self._known = {threading.get_native_id()}
        self._due_s = 0.0

    def record(self, tick: Tick) -> None:
        """See `Recorder`."""
        if tick.t_s < self._due_s:
            return
        self._due_s = tick.t_s + _LOOK_S
        with contextlib.suppress(OSError):  # no descriptor is left to look with
            for thread in self._threads():
                self._see_to(thread)

    def _see_to(self, thread: int) -> None:
        if thread in self._known:
            return
        self._known.add(thread)
        with contextlib.suppress(OSError):  # it has ended
            self._schedule(thread, THREADS)

    def close(self) -> None:
        """See `Recorder`."""


def _tried(schedule: Schedule, priority: int, name: str, limit: int) -> list[str]:
    try:
        schedule(priority)
    except OSError as error:
        return [f"not real-time: SCHED_FIFO {priority}: {error.strerror}; {_remedy(name, limit)}"]
    return []


def _remedy(name: str, limit: int) -> str:
    return f"{name} is {resource.getrlimit(limit)[0]}; `companion service install` sets it, or run as root"


def _schedule(priority: int) -> None:
    _schedule_thread(0, priority)


def _schedule_thread(thread: int, priority: int) -> None:
    os.sched_setscheduler(thread, os.SCHED_FIFO, os.sched_param(priority))


def _threads() -> list[int]:
    return [int(path.name) for path in Path("/proc/self/task").iterdir()]


def _lock_memory() -> None:
    library = ctypes.CDLL(None, use_errno=True)
    if library.mlockall(_CURRENT | _FUTURE | _ON_FAULT) != 0:
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number))
