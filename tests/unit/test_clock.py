"""Clocks, and a run of the loop by them."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator, Sequence
from types import SimpleNamespace
from typing import Any

import pytest

from companion.clock import DrivenClock, PacedClock, SimulatedClock, WallClock
from companion.loop import run
from tests.waiting import CAP_S

EPOCH_NS = 1_780_000_000_000_000_000


def test_a_simulated_clock_moves_only_by_its_runner() -> None:
    clock = SimulatedClock(EPOCH_NS)
    assert (clock.now_s(), clock.time_unix_ns()) == (0.0, EPOCH_NS)
    assert clock.wait(12.5, ()) is False
    assert (clock.now_s(), clock.time_unix_ns()) == (12.5, EPOCH_NS + 12_500_000_000)


def test_a_paced_clock_spans_whole_ticks_whatever_the_wall_does() -> None:
    clock = PacedClock(1e9, EPOCH_NS)
    for n in range(1, 100):
        assert clock.wait(n * 0.1, ()) is False
        assert clock.now_s() == n * 0.1


@pytest.mark.parametrize("make", [lambda: PacedClock(1.0, EPOCH_NS), WallClock], ids=["paced", "wall"])
def test_waiting_ends_early_for_a_readable_descriptor(make: Any) -> None:
    clock = make()  # here, and not when tests are collected: it runs from then on
    reader, writer = os.pipe()
    try:
        os.write(writer, b"x")
        assert clock.wait(clock.now_s() + 60.0, [reader]) is True
        assert clock.wait(clock.now_s(), [reader]) is False, "a deadline is a deadline, whatever is readable"
    finally:
        os.close(reader)
        os.close(writer)


def test_a_descriptor_that_was_closed_meanwhile_does_not_end_the_run() -> None:
    reader, writer = os.pipe()
    os.close(reader)
    os.close(writer)
    clock = WallClock()
    assert clock.wait(clock.now_s() + 0.01, [reader]) in (True, False)


@pytest.fixture
def driven() -> Iterator[tuple[DrivenClock, socket.socket]]:
    """A driven clock, and the other end of its connection."""
    with socket.create_server(("127.0.0.1", 0)) as listener:
        clock = DrivenClock(listener.getsockname(), EPOCH_NS)
        other, _ = listener.accept()
    with other:
        other.settimeout(CAP_S)
        yield clock, other
    clock.close()


def test_a_driven_clock_goes_as_far_as_is_granted_and_says_so(driven: tuple[DrivenClock, socket.socket]) -> None:
    clock, other = driven
    assert clock.wait(0.0, ()) is False, "the first tick needs no grant"
    other.sendall(b"0.25\n")
    assert [clock.wait(until_s, ()) for until_s in (0.1, 0.2)] == [False, False] and clock.now_s() == 0.2
    reader, writer = os.pipe()
    try:
        os.write(writer, b"x")
        assert clock.wait(0.3, [reader]) is True, "links are served while no time passes"
        assert clock.now_s() == 0.2
    finally:
        os.close(reader)
        os.close(writer)
    other.sendall(b"0.25\n0.5\n")
    assert clock.wait(0.3, ()) is False and clock.busy_s() == 0.0
    assert clock.time_unix_ns() == EPOCH_NS + 300_000_000


def test_a_driven_clock_answers_once_the_work_is_done(driven: tuple[DrivenClock, socket.socket]) -> None:
    clock, other = driven
    other.sendall(b"0.1\n")
    assert clock.wait(0.1, ()) is False
    other.setblocking(False)
    with pytest.raises(BlockingIOError):
        other.recv(100)
    other.settimeout(CAP_S)
    other.shutdown(socket.SHUT_WR)
    assert clock.wait(0.2, ()) is False, "nobody drives any more: the wall clock does"
    assert other.recv(100) == b"0.1\n" and clock.now_s() == 0.2


class ScriptedClock:
    """Each tick costs what the script says."""

    def __init__(self, costs_s: Sequence[float]) -> None:
        self.costs_s = list(costs_s)
        self.now = self.released = 0.0

    def now_s(self) -> float:
        return self.now

    def time_unix_ns(self) -> int:
        return 0

    def wait(self, until_s: float, filenos: Sequence[int]) -> bool:
        self.now = self.released = max(self.now, until_s)
        return False

    def busy_s(self) -> float:
        return self.now - self.released


def test_work_counts_in_vessel_time() -> None:
    """At ten times the speed a moment of work is ten times as long for the boat; in lockstep it is none."""
    paced, simulated = PacedClock(1e6, EPOCH_NS), SimulatedClock(EPOCH_NS)
    for clock in (paced, simulated):
        clock.wait(0.1, ())
    sum(range(1000))
    assert paced.busy_s() > 1.0 and simulated.busy_s() == 0.0


def test_deadlines_are_absolute_and_missed_ones_are_skipped() -> None:
    clock = ScriptedClock([0.03, 0.03, 0.25, 0.03, 0.03])
    ticks: list[float] = []
    vessel = SimpleNamespace(period_s=0.1, load=0.0, filenos=lambda: (), serve=lambda now_s: None)

    def tick(now_s: float) -> None:
        ticks.append(now_s)
        clock.now += clock.costs_s[len(ticks) - 1]

    vessel.tick = tick
    punctuality = run(vessel, clock, lambda: len(ticks) == 5)  # type: ignore[arg-type]
    assert ticks == pytest.approx([0.0, 0.1, 0.2, 0.5, 0.6])
    assert (punctuality.ticks, punctuality.late, punctuality.skipped) == (5, 0, 2)
    assert vessel.load == pytest.approx(0.3)


def test_ticks_that_begin_late_are_counted() -> None:
    clock, late_s = ScriptedClock([]), [0.0, 0.004, 0.03, 0.006]
    vessel = SimpleNamespace(
        period_s=0.1, load=0.0, filenos=lambda: (), serve=lambda now_s: None, tick=lambda now_s: late_s.pop(0)
    )

    def wait(until_s: float, filenos: Sequence[int]) -> bool:
        clock.now = until_s + late_s[0]
        return False

    clock.wait = wait  # type: ignore[method-assign]
    punctuality = run(vessel, clock, lambda: not late_s)  # type: ignore[arg-type]
    assert (punctuality.ticks, punctuality.late, punctuality.skipped) == (4, 2, 0)
    assert punctuality.worst_s == pytest.approx(0.03) and "latest start 30.0 ms late (at 0.2 s)" in punctuality.text


def test_a_wall_clock_may_run_faster() -> None:
    clock = WallClock(1e6)
    assert clock.wait(clock.now_s() + 100.0, ()) is False
    assert clock.now_s() > 100.0
