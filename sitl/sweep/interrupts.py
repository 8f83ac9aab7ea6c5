"""Ctrl-C for a program with workers: the program ends them, they take no notice."""

from __future__ import annotations

import contextlib
import signal
from collections.abc import Iterator
from multiprocessing import resource_tracker


@contextlib.contextmanager
def held_back() -> Iterator[None]:
    """Ctrl-C waits until the end of the block, and never reaches the processes that are started in it. A terminal
    sends it to all of them, and one that still imports would print a traceback. For the main thread."""
    resource_tracker.ensure_running()  # where it begins in the block, it would let the signal through
    heard: list[int] = []
    # the mask is what processes inherit; another thread of this one may still take the signal
    handler = signal.signal(signal.SIGINT, lambda number, _: heard.append(number))
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
        signal.signal(signal.SIGINT, handler)
        if heard:
            signal.raise_signal(signal.SIGINT)
