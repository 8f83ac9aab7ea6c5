"""What a fault of the program costs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest

from companion.containment import Containment
from companion.core.decision import TextKind
from companion.core.readings import Reading
from companion.core.tick import DeviceHealth


def raising(error: Exception) -> Any:
    raise error


def contained() -> tuple[Containment, list[str], list[tuple[TextKind, str]]]:
    """One that reports, what it reports, and what it announces."""
    said: list[tuple[TextKind, str]] = []
    containment, traces = Containment(lambda _, kind, name, text: said.append((kind, text))), []
    containment.report = traces.append
    return containment, traces, said


class Gnss:
    """A driver that is well, unless it is asked for its health while `unwell`."""

    name = "gnss"
    unwell = False

    def health(self, now_s: float) -> DeviceHealth:
        if self.unwell:
            raise KeyError("x")
        return DeviceHealth("gnss", ok=True, age_s=0.1)

    def read(self, now_s: float) -> Sequence[Reading]:
        return ()

    def fileno(self) -> int | None:
        return None

    def close(self) -> None:
        pass


def test_a_driver_is_faulty_until_two_seconds_after_it_last_failed() -> None:
    containment, traces, _ = contained()
    gnss = Gnss()
    assert containment.driver("gnss", lambda: (1,), (), 0.0) == (1,)
    assert containment.health(gnss, 0.0).ok
    for now_s in (1.0, 2.0):
        assert containment.driver("gnss", lambda: raising(ValueError("x")), (), now_s) == ()
    assert containment.health(gnss, 3.9) == DeviceHealth("gnss", False, 0.1, "driver fails (ValueError)")
    assert containment.health(gnss, 4.0).ok
    assert len(traces) == 1, "once for each place"
    gnss.unwell = True
    assert containment.health(gnss, 5.0) == DeviceHealth("gnss", False, None, "driver fails (KeyError)")
    assert len(traces) == 2
    gnss.unwell = False
    assert not containment.health(gnss, 6.9).ok
    assert containment.health(gnss, 7.0).ok


def test_a_driver_without_memory_leaves_the_tick_out() -> None:
    containment, _, _ = contained()
    with pytest.raises(MemoryError):
        containment.driver("gnss", lambda: raising(MemoryError()), (), 0.0)
    assert containment.health(Gnss(), 0.0).ok


def test_twenty_ticks_in_a_row_may_fail() -> None:
    containment, traces, said = contained()
    for _ in range(2):
        for _ in range(20):
            containment.tick_failed(ValueError("no trace"), 0.0)
        containment.tick_done()
    assert set(said) == {(TextKind.ALARM, "Tick left out: ValueError, unknown place")}
    assert len(traces) == 1
    for _ in range(20):
        containment.tick_failed(ValueError("no trace"), 0.0)
    with pytest.raises(ValueError, match="no trace"):
        containment.tick_failed(ValueError("no trace"), 0.0)


def test_an_announcement_fits_a_statustext() -> None:
    containment, _, said = contained()
    containment.tick_failed(type("A" * 60, (Exception,), {})(), 0.0)
    assert len(said[0][1]) == 50


def test_nothing_but_want_of_memory_is_contained_where_nobody_takes_the_report() -> None:
    containment, _, said = contained()
    containment.report = None
    with pytest.raises(ValueError, match="x"):
        containment.tick_failed(ValueError("x"), 0.0)
    with pytest.raises(ValueError, match="x"):
        containment.driver("gnss", lambda: raising(ValueError("x")), (), 0.0)
    containment.tick_failed(MemoryError(), 0.0)
    assert said == [(TextKind.ATTENTION, "Computer: out of memory, a tick is left out")]
