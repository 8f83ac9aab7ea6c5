"""A tick that comes late is told."""

from __future__ import annotations

import pytest

from companion.core.events import EventLog
from companion.supervisor.standstill import Standstill


@pytest.mark.parametrize(("times_s", "texts"), [
    ((0.0, 0.1, 0.2, 0.6, 1.05), []),
    ((0.0, 0.1, 3.2), ["The program stood still for 3.1 s"]),
    ((100.0, 100.1), []),
])  # fmt: skip
def test_a_late_tick_is_told(times_s: tuple[float, ...], texts: list[str]) -> None:
    events = EventLog()
    watch = Standstill(events)
    for t_s in times_s:
        watch.update(t_s)
    assert [event.text for event in events.drain()] == texts
