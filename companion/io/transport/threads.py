"""Threads that are begun while the boat is under way."""

from __future__ import annotations

import threading
from collections.abc import Callable


def begun(work: Callable[[], None], name: str) -> threading.Thread | None:
    """A thread that does `work`; None where the system gives no more threads, as when its limit is reached."""
    thread = threading.Thread(target=work, name=name, daemon=True)
    try:
        thread.start()
    except RuntimeError:
        return None
    return thread
