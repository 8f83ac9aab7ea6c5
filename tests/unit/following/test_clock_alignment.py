"""Clock alignment with round trips: a link whose latency grows, and a clock that is set."""

from __future__ import annotations

import math
import random
from collections.abc import Callable

import pytest

from companion.following.clock_alignment import ClockAlignment

Course = Callable[[float], float]


def errors_s(latency_s: Course, clock_s: Course, duration_s: float = 240.0) -> list[tuple[float, float]]:
    """(time at which it was stamped, error of that time as found) for messages at 20 Hz, with a question for the time
    every 10 s. `latency_s`, `clock_s` of the sender: at a time."""
    rng = random.Random(1)
    coming: list[tuple[float, float, float | None]] = []
    for i in range(int(20.0 * duration_s)):
        coming.append((0.05 * i + latency_s(0.05 * i) + rng.expovariate(50.0), 0.05 * i, None))
    for i in range(int(duration_s / 10.0)):
        asked_s = 3.0 + 10.0 * i
        there_s = asked_s + latency_s(asked_s)
        coming.append((there_s + latency_s(there_s), asked_s, there_s + clock_s(there_s)))
    clock, found = ClockAlignment(), []
    for now_s, begun_s, theirs_s in sorted(coming, key=lambda one: one[0]):
        if theirs_s is not None:
            clock.exchanged(begun_s, theirs_s, now_s)
        elif begun_s > 20.0:
            found.append((begun_s, clock.arrived(begun_s + clock_s(begun_s), now_s, 0.1) - begun_s))
        else:
            clock.arrived(begun_s + clock_s(begun_s), now_s, 0.1)
    return found


@pytest.mark.parametrize(
    "latency_s",
    [
        lambda t_s: 0.1 if t_s < 60.0 else 1.0,
        lambda t_s: 0.1 + min(2.5, max(0.0, 0.02 * (t_s - 60.0))),
        lambda t_s: 0.1 + max(0.0, min(2.0, 0.05 * (t_s - 60.0), 0.05 * (200.0 - t_s))),
    ],
    ids=["step", "slow growth", "growth and back"],
)
def test_a_latency_that_grows_does_not_make_messages_younger(latency_s: Course) -> None:
    assert max(abs(error_s) for _, error_s in errors_s(latency_s, lambda t_s: 1000.0)) < 0.1


def test_a_clock_that_is_set_is_known_again_after_half_a_minute() -> None:
    found = errors_s(lambda t_s: 0.1, lambda t_s: 1000.0 - (0.6 if t_s > 63.5 else 0.0))
    assert max(abs(error_s) for t_s, error_s in found if t_s < 63.0 or t_s > 93.0) < 0.1
    assert all(math.isfinite(error_s) and abs(error_s) < 0.7 for _, error_s in found)
