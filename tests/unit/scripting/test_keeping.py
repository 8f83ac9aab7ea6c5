"""When a script is started, ended and started again; time is the test's."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from companion.scripting.keeping import MOST_FAILURES, STEADY_S, Deed, Keeping, Restart, Seen


class Computer:
    """A script that does what the test says, looked at every 0.1 s."""

    def __init__(self, restart: Restart = "failure", watchdog_s: float = 10.0) -> None:
        self.keeping = Keeping("survey", restart, watchdog_s, 2.0)
        self.now_s = 100.0
        self.enabled, self.runs, self.beats, self.obeys = True, False, True, True
        self.code: int | None = None
        self.beat_s = 0.0
        self.starts: list[float] = []
        self.deeds: list[Deed] = []
        self.texts: list[str] = []

    def end(self, code: int) -> None:
        self.runs, self.code = False, code

    def sail(self, duration_s: float) -> None:
        for _ in range(round(10.0 * duration_s)):
            self.now_s += 0.1
            self.beat_s = self.now_s if self.beats else self.beat_s
            deed = self.keeping.update(Seen(self.runs, self.code, self.beat_s), self.enabled, self.now_s)
            if not self.runs:
                self.code = None
            if deed is not Deed.NOTHING:
                self.deeds.append(deed)
            if deed is Deed.START:
                self.starts.append(self.now_s)
                self.runs = True
            if deed is Deed.KILL or (deed is Deed.ASK_TO_END and self.obeys):
                self.end(-9 if deed is Deed.KILL else -15)
            self.texts += [news.text for news in self.keeping.news()]


def test_failures_in_a_row_are_given_up_with_longer_and_longer_pauses() -> None:
    computer = Computer()
    for _ in range(MOST_FAILURES + 2):
        computer.sail(40.0)
        if computer.runs:
            computer.end(1)
    assert len(computer.starts) == MOST_FAILURES
    assert computer.keeping.fault == f"given up after {MOST_FAILURES} failures: exit code 1"
    assert computer.keeping.over


def test_the_pause_doubles() -> None:
    computer, pauses = Computer(), []
    for _ in range(4):
        computer.sail(20.0)
        computer.end(1)
        ended_s = computer.now_s
        computer.sail(20.0)
        pauses.append(computer.starts[-1] - ended_s)
    assert pauses == pytest.approx([2.1, 4.1, 8.1, 16.1], abs=0.15)


def test_a_steady_run_forgets_failures() -> None:
    computer = Computer()
    for _ in range(3 * MOST_FAILURES):
        computer.sail(STEADY_S + 10.0)
        computer.end(1)
    assert len(computer.starts) == 3 * MOST_FAILURES


@pytest.mark.parametrize(("restart", "starts"), [("never", 1), ("failure", 1), ("always", 3)])
def test_work_that_is_done(restart: Restart, starts: int) -> None:
    computer = Computer(restart)
    for _ in range(3):
        computer.sail(5.0)
        if computer.runs:
            computer.end(0)
    computer.sail(0.2)
    assert len(computer.starts) == starts and computer.keeping.fault is None
    assert computer.texts[:2] == ["Script survey started", "Script survey has ended"]


def test_a_hung_script_is_asked_and_then_killed() -> None:
    computer = Computer("never")
    computer.sail(1.0)
    computer.beats = computer.obeys = False
    computer.sail(20.0)
    assert computer.deeds == [Deed.START, Deed.ASK_TO_END, Deed.KILL]
    assert computer.keeping.fault == "hung for 10 s" and computer.texts[-1] == "Script survey failed: hung for 10 s"


def test_no_watchdog() -> None:
    computer = Computer("never", watchdog_s=0.0)
    computer.beats = False
    computer.sail(300.0)
    assert computer.deeds == [Deed.START]


def test_switched_off_and_on() -> None:
    computer = Computer()
    computer.sail(1.0)
    computer.enabled = False
    computer.sail(10.0)
    assert not computer.runs and computer.keeping.fault == "switched off: SCR_ENABLE"
    assert not any("failed" in text for text in computer.texts)
    computer.enabled = True
    computer.sail(1.0)
    assert computer.runs and computer.keeping.fault is None


def test_switching_off_and_on_starts_one_that_was_given_up() -> None:
    computer = Computer("never")
    computer.sail(1.0)
    computer.end(1)
    computer.sail(10.0)
    assert not computer.runs
    computer.enabled = False
    computer.sail(1.0)
    computer.enabled = True
    computer.sail(1.0)
    assert computer.runs


@given(st.lists(st.tuples(st.sampled_from(("wait", "end", "fail", "off", "on")), st.floats(0.1, 30.0)), max_size=12))
def test_it_is_never_started_twice_at_once_nor_while_switched_off(story: list[tuple[str, float]]) -> None:
    computer = Computer("always")
    for what, wait_s in story:
        if what in ("end", "fail") and computer.runs:
            computer.end(0 if what == "end" else 1)
        computer.enabled = {"off": False, "on": True}.get(what, computer.enabled)
        before, ran = len(computer.starts), computer.runs
        computer.sail(wait_s)
        if not computer.enabled:
            assert len(computer.starts) == before
        if ran and what == "wait":
            assert len(computer.starts) == before or not computer.enabled
    assert all(later > earlier for earlier, later in zip(computer.starts, computer.starts[1:], strict=False))
