"""How far a command that takes long has come: a bar with the time that is left, on a terminal alone.

It stands on standard error, so that what a command prints can go into a file. Without a terminal nothing is shown, but
for works of minutes, which tell it in lines.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, ProgressColumn, TaskProgressColumn, TextColumn, TimeRemainingColumn

from companion.core.progress import Told, tell_nobody, usual_share

_PERIOD_S = 0.2  # between two states of the bar
_LINES_S = 20.0  # between two lines


@contextmanager
def bar(text: str, console: Console | None = None, time_left: bool = True, lines: str = "") -> Iterator[Told]:
    """A bar that is shown until the end of the block. Call what it gives with words and the share done, 0 to 1, as
    often as you like. `console`: where to; None: standard error. `time_left`: False: the words tell it. `lines`: what a
    work of minutes says first without a terminal, and then in lines how far it has come."""
    console = console or Console(stderr=True)
    if not console.is_terminal or console.is_dumb_terminal:
        yield _in_lines(text, console, lines) if lines else tell_nobody
        return
    columns: list[ProgressColumn] = [TextColumn("{task.description}"), BarColumn(), TaskProgressColumn()]
    columns += [TimeRemainingColumn()] if time_left else []
    # lines on standard output go above the bar where both are on one terminal, and elsewhere their own way
    with Progress(*columns, console=console, transient=True, redirect_stdout=sys.stdout.isatty()) as progress:
        task = progress.add_task(text, total=1.0)
        yield _now_and_then(lambda words, share: progress.update(task, description=words, completed=share))


def _in_lines(name: str, console: Console, first: str) -> Told:
    """Lines of `console`: `first`, and every `_LINES_S` what is being done, and how long it is likely to take yet."""

    def say(line: str) -> None:
        console.print(f"{name}: {line}", highlight=False, markup=False, soft_wrap=True)

    begun_s = said_s = time.monotonic()
    say(first)

    def told(text: str, share: float) -> None:
        nonlocal said_s
        now_s = time.monotonic()
        if now_s - said_s >= _LINES_S:
            said_s = now_s
            left = f", about {(now_s - begun_s) * (1.0 - share) / share:.0f} s left" if share > 0.0 else ""
            say(f"{text}{left}")

    return told


def _now_and_then(tell: Told) -> Told:
    """`tell`, but no more often than an eye can see."""
    due_s = 0.0

    def told(text: str, share: float) -> None:
        nonlocal due_s
        now_s = time.monotonic()
        if now_s >= due_s:
            due_s = now_s + _PERIOD_S
            tell(text, min(1.0, max(0.0, share)))

    return told


class Sailing:
    """Tells how far scenarios have come: `count` runs, of about `lasts_s` seconds each."""

    def __init__(self, told: Told, name: str, lasts_s: float, count: int = 1) -> None:
        self._told = told
        self._name = name
        self._lasts_s = lasts_s
        self._count = count
        self._begun = 0
        self._sailed_s = 0.0

    def begin(self) -> None:
        """The next run begins."""
        self._begun += 1
        self._sailed_s = 0.0

    def step(self, period_s: float) -> None:
        """A tick of that length was sailed."""
        self._sailed_s += period_s
        done = usual_share(self._sailed_s, self._lasts_s)
        number = f", run {self._begun} of {self._count}" if self._count > 1 else ""
        self._told(f"{self._name}{number}, {self._sailed_s:.0f} s sailed", (self._begun - 1 + done) / self._count)
