"""What the system refuses is said, with the remedy, and the boat goes on."""

from __future__ import annotations

import errno
import os
import threading
from types import SimpleNamespace
from typing import Any

from companion.cli.realtime import CONTROL, THREADS, Priorities, before_threads, control_thread


def test_threads_first_then_the_control_thread_above_them() -> None:
    asked: list[int] = []
    locked: list[bool] = []
    assert before_threads(lambda: locked.append(True), asked.append) == []
    assert control_thread(asked.append) == []
    assert asked == [THREADS, CONTROL] and THREADS < CONTROL and locked == [True]


def test_what_is_refused_is_said() -> None:
    def refuse(*_: int) -> None:
        raise OSError(errno.EPERM, os.strerror(errno.EPERM))

    schedule, memory = before_threads(refuse, refuse)
    assert schedule.startswith("not real-time: SCHED_FIFO 10: Operation not permitted; RLIMIT_RTPRIO is ")
    assert memory.startswith("memory not locked: Operation not permitted; RLIMIT_MEMLOCK is ")
    assert "companion service install" in schedule and "companion service install" in memory
    assert len(control_thread(refuse)) == 1


def test_threads_made_later_do_not_keep_the_control_threads_priority() -> None:
    ours, lowered = threading.get_native_id(), []
    there = [ours, 11]

    def schedule(thread: int, priority: int) -> None:
        lowered.append((thread, priority))
        if thread == 12:
            raise ProcessLookupError

    priorities = Priorities(lambda: there, schedule)
    for t_s in (0.0, 0.1, 1.9):
        tick: Any = SimpleNamespace(t_s=t_s)
        priorities.record(tick)
    there += [12, 13]
    tick = SimpleNamespace(t_s=2.1)
    priorities.record(tick)
    assert lowered == [(11, THREADS), (12, THREADS), (13, THREADS)]


def test_without_a_descriptor_to_look_with_nothing_ends() -> None:
    def none_left() -> list[int]:
        raise OSError(errno.EMFILE, os.strerror(errno.EMFILE))

    tick: Any = SimpleNamespace(t_s=0.0)
    Priorities(none_left).record(tick)
