"""Ctrl-C for a program with workers: the program ends them, they take no notice."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Iterator
from multiprocessing import resource_tracker


@contextlib.contextmanager
def held_back() -> Iterator[None]:
    """Ctrl-C waits until the end of the block, and never reaches the processes that are started in it. A terminal
    sends it to all of them, and one that still imports would print a traceback."""
    resource_tracker.ensure_running()  # where it begins in the block, it would let the signal through
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
