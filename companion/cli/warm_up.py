"""What a run needs later is loaded beside it, once the first HEARTBEAT is out."""

from __future__ import annotations

import threading
from collections.abc import Callable

from companion.core.tick import Tick


class WarmUp:
    """A `core.ports.Recorder` that calls `load` on a thread of its own from the second tick on.

    The thread is there from the start, so that what gives threads their priority finds it before it works.
    """

    def __init__(self, load: Callable[[], object]) -> None:
        self._load = load
        self._ticks = 0
        self._go = threading.Event()
        self._thread = threading.Thread(target=self._run, name="warm-up")
        self._thread.start()

    def record(self, tick: Tick) -> None:
        """See `Recorder`."""
        self._ticks += 1
        if self._ticks == 2:
            self._go.set()

    def close(self) -> None:
        """Wait for what is being loaded."""
        self._go.set()
        self._thread.join()

    def _run(self) -> None:
        self._go.wait()
        if self._ticks >= 2:
            self._load()
