"""The bar of a long command: on a pseudo-terminal, and without a terminal."""

from __future__ import annotations

import os
import pty

import pytest

from companion.cli.coloured import console_on
from companion.cli.progress import Sailing, bar
from tests.unit.cli.test_terminal import read_all


def shown_on(writing: int, reading: int, **settings: bool) -> str:
    with bar("report", console_on(writing, **settings)) as told:
        told("drawing", 0.4)
    os.close(writing)
    text = read_all(reading)
    os.close(reading)
    return text


def test_without_a_terminal_nothing_is_shown() -> None:
    reading, writing = os.pipe()
    assert shown_on(writing, reading) == ""


def test_a_dumb_terminal_gets_nothing_either(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "dumb")
    reading, writing = pty.openpty()
    assert shown_on(writing, reading) == ""


def test_a_work_of_minutes_says_in_lines_what_it_does(monkeypatch: pytest.MonkeyPatch) -> None:
    """`companion trial report` into a file, or over ssh without a terminal, was silent for minutes."""
    clock = [100.0]
    monkeypatch.setattr("companion.cli.progress.time.monotonic", lambda: clock[0])
    reading, writing = os.pipe()
    with bar("trial report", console_on(writing), lines="it takes a minute") as told:
        for clock[0], share in ((105.0, 0.1), (121.0, 0.0), (130.0, 0.2), (145.0, 0.25)):
            told("fitting the hull", share)
    os.close(writing)
    assert read_all(reading).splitlines() == [
        "trial report: it takes a minute",
        "trial report: fitting the hull",
        "trial report: fitting the hull, about 135 s left",
    ]
    os.close(reading)


def test_a_terminal_sees_what_is_done_and_what_is_left(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("TERM", "xterm")
    reading, writing = pty.openpty()
    text = shown_on(writing, reading)
    assert "drawing" in text and " 40%" in text and "-:--:--" in text
    assert text.rstrip().endswith("\x1b[2K")


def test_runs_of_a_table_share_the_bar() -> None:
    told: list[tuple[str, float]] = []
    sailing = Sailing(lambda text, share: told.append((text, share)), "hold", 100.0, count=4)
    sailing.begin()
    sailing.step(50.0)
    sailing.begin()
    sailing.step(400.0)
    (first, a), (second, b) = told
    assert (first, a) == ("hold, run 1 of 4, 50 s sailed", pytest.approx(0.125))
    assert second == "hold, run 2 of 4, 400 s sailed"
    assert 0.49 < b < 0.5
