"""Ctrl-C and the processes that a program starts."""

from __future__ import annotations

import os
import signal
import subprocess
import threading

import pytest

from sitl.sweep.interrupts import held_back

_HEARD_S = 60.0  # ends with the signal


def blocked_in_a_child() -> bool:
    """Whether a process that is started now holds Ctrl-C back."""
    lines = subprocess.run(["cat", "/proc/self/status"], capture_output=True, text=True, check=True).stdout.splitlines()
    blocked = next(line.split()[1] for line in lines if line.startswith("SigBlk"))
    return bool(int(blocked, 16) & 1 << (signal.SIGINT - 1))


def hears_afterwards(taken: bool = False) -> bool:
    """Whether the block goes on to its end, and Ctrl-C is heard behind it. `taken`: another thread takes the signal. It
    is no longer pending then, but that thread may come to tell of it after the block has ended."""
    steps = ["before"]
    with pytest.raises(KeyboardInterrupt):
        with held_back():
            os.kill(os.getpid(), signal.SIGINT)
            while taken and signal.SIGINT in signal.sigpending():
                os.sched_yield()
            steps.append("behind")
        threading.Event().wait(_HEARD_S)
    return steps[-1] == "behind"


def test_a_process_that_is_started_meanwhile_never_hears_it_and_the_program_hears_it_afterwards() -> None:
    """A worker that still imported printed a traceback."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        assert not blocked_in_a_child()
        with held_back():
            assert blocked_in_a_child()
        assert not blocked_in_a_child()
        assert hears_afterwards()
    finally:
        signal.signal(signal.SIGINT, before)


def test_nor_does_it_where_another_thread_takes_the_signal() -> None:
    """That thread does not hold it back."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    over = threading.Event()
    other = threading.Thread(target=over.wait)
    other.start()
    try:
        assert hears_afterwards(taken=True)
    finally:
        over.set()
        other.join()
        signal.signal(signal.SIGINT, before)
