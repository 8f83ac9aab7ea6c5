"""What the computer lacks, with hysteresis, and steps of its clock."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from companion.core.events import EventLog
from companion.io.host import DESCRIPTORS, MEMORY, HostWatch, count_descriptors_left, memory_share_left


def seen(host: HostWatch, now_s: float) -> tuple[str, ...]:
    return tuple(host.faults(now_s))


def test_little_is_told_until_there_is_enough_again() -> None:
    state: dict[str, Any] = {"memory": 0.5, "descriptors": 900}
    host = HostWatch(EventLog().say, lambda: state["memory"], lambda: state["descriptors"])
    assert seen(host, 0.0) == ()
    state.update(memory=0.03, descriptors=3)
    assert seen(host, 1.0) == (), "it looks every two seconds"
    assert seen(host, 2.0) == (MEMORY, DESCRIPTORS)
    state.update(memory=0.06, descriptors=12)
    assert seen(host, 4.0) == (MEMORY, DESCRIPTORS)
    state.update(memory=0.09, descriptors=None)
    assert seen(host, 6.0) == ()
    state.update(memory=None)
    assert seen(host, 8.0) == ()


def test_the_machine_says_what_it_has() -> None:
    share, left = memory_share_left(), count_descriptors_left()
    assert share is None or 0.0 < share < 1.0
    assert left is None or left > 0


def test_a_step_of_the_clock_is_announced_and_slow_drift_is_not() -> None:
    events, unix_ns = EventLog(), 1_780_000_000_000_000_000
    host = HostWatch(events.say)
    for number in range(100):
        unix_ns += 100_000_000 + 50_000  # 500 ppm, as much as NTP slews
        unix_ns += {30: 3_600_000_000_000, 60: -3_600_000_000_000}.get(number, 0)
        tick: Any = SimpleNamespace(t_s=0.1 * number, time_unix_ns=unix_ns)
        host.record(tick)
    assert [event.text for event in events.drain()] == [
        "Computer's clock stepped by +3600 s",
        "Computer's clock stepped by -3600 s",
    ]
