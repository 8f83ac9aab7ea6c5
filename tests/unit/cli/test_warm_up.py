"""What a run needs later is loaded beside it, and not before its first tick is told."""

from __future__ import annotations

import threading
from types import SimpleNamespace
from typing import Any

from companion.cli.warm_up import WarmUp

TICK: Any = SimpleNamespace()


def test_loading_begins_with_the_second_tick() -> None:
    begun = threading.Event()
    warm_up = WarmUp(begun.set)
    warm_up.record(TICK)
    assert not begun.is_set()
    warm_up.record(TICK)
    assert begun.wait(30.0)
    warm_up.close()


def test_a_run_that_ends_at_once_loads_nothing() -> None:
    loaded: list[int] = []
    warm_up = WarmUp(lambda: loaded.append(1))
    warm_up.record(TICK)
    warm_up.close()
    assert loaded == [] and all(thread.name != "warm-up" for thread in threading.enumerate())


def test_the_end_waits_for_what_is_being_loaded() -> None:
    loaded: list[int] = []
    warm_up = WarmUp(lambda: loaded.append(1))
    for _ in range(3):
        warm_up.record(TICK)
    warm_up.close()
    assert loaded == [1]
