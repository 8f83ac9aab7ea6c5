"""The terminal and the journal of `companion run`: a recorder whose lines another thread writes.

A terminal that stands still (Ctrl-S, a pipe that nobody reads) costs lines, which are counted, and never a tick.
"""

from __future__ import annotations

import os
import threading
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

from companion.cli.run_lines import FirstLook, Line, RunSummary, event_line, status_text
from companion.core.decision import Severity, TextKind
from companion.core.tick import Tick

_MOST_WAITING = 500  # lines
_PATIENCE_S = 1.0  # for the last lines at the end
_UNPRINTED = dict.fromkeys(b"\a\b\v\f\r")
_FOR_COLOURS = ("FORCE_COLOR", "TTY_COMPATIBLE")  # what rich reads, besides the descriptor


class Descriptor:
    """The file that a screen writes to: a descriptor, without a buffer whose lock would outlive the thread.

    A line that cannot be written any more, since the terminal is gone, is lost.
    """

    encoding = "utf-8"
    errors = "replace"

    def __init__(self, fd: int) -> None:
        self._fd = fd

    def write(self, text: str) -> int:
        """Write all of it; waits as long as the reader does not read."""
        rest = text.encode("utf-8", "replace")
        try:
            while rest:
                rest = rest[os.write(self._fd, rest) :]
        except OSError:
            pass
        return len(text)

    def flush(self) -> None:
        """Nothing waits here."""

    def isatty(self) -> bool:
        """Whether a person may look at it."""
        return os.isatty(self._fd)

    def fileno(self) -> int:
        """The descriptor."""
        return self._fd


def journal_of(environment: Mapping[str, str], fd: int) -> bool:
    """Whether `fd` leads to systemd's journal, which reads a priority `<N>` before each line. Source: sd-daemon(3),
    systemd.exec(5) of JOURNAL_STREAM."""
    device, _, inode = environment.get("JOURNAL_STREAM", "").partition(":")
    state = os.fstat(fd)
    return (device, inode) == (str(state.st_dev), str(state.st_ino))


class Screen(Protocol):
    """Where the lines of a run go. The thread that writes calls all of it, between `begin` and `end`."""

    @property
    def has_status(self) -> bool:
        """Whether it shows a status line."""
        ...

    def begin(self) -> None:
        """Before the first line."""
        ...

    def end(self) -> None:
        """After the last line."""
        ...

    def line(self, text: str, severity: Severity | None) -> None:
        """Add a line. `severity`: for its colour; None: none."""
        ...

    def status(self, text: str) -> None:
        """Show another status line."""
        ...


class PlainScreen:
    """A `Screen` of lines alone, for a pipe, a file or the journal."""

    has_status = False

    def __init__(self, file: Descriptor) -> None:
        self._file = file

    def begin(self) -> None:
        """See `Screen`."""

    def end(self) -> None:
        """See `Screen`."""

    def line(self, text: str, severity: Severity | None) -> None:
        """See `Screen`."""
        self._file.write(text.translate(_UNPRINTED) + "\n")

    def status(self, text: str) -> None:
        """See `Screen`."""


def screen_on(fd: int, environment: Mapping[str, str]) -> Screen:
    """The screen of a descriptor. rich is loaded only where a person may look, for it takes 20 ms and 3 MB."""
    if not os.isatty(fd) and not any(environment.get(name) for name in _FOR_COLOURS):
        return PlainScreen(Descriptor(fd))
    from companion.cli.coloured import ColouredScreen, console_on

    return ColouredScreen(console_on(fd))


class Terminal:
    """A `core.ports.Recorder` that shows the run.

    `screen`: where to. `links`: names of the links. `heading_source`: names the sensor in use. `late`: counts the ticks
    that began late. `journal`: a priority stands before each line. `status_s`: boat time between two states of the
    status line.
    """

    def __init__(
        self,
        screen: Screen,
        links: Sequence[str],
        heading_source: Callable[[], str | None],
        late: Callable[[], int],
        journal: bool = False,
        status_s: float = 0.5,
    ) -> None:
        self.summary = RunSummary()
        self._screen = screen
        self._links = tuple(links)
        self._heading_source = heading_source
        self._late = late
        self._journal = journal
        self._first_look = FirstLook()
        self._waiting: deque[Line] = deque()
        self._lost = 0  # written by the control thread alone, as `_told_lost` by the other
        self._told_lost = 0
        self._status_s = status_s
        self._status = ""
        self._status_due_s = 0.0
        self._wake = threading.Event()
        self._ended = False
        self._thread = threading.Thread(target=self._write, name="terminal", daemon=True)
        self._thread.start()

    def record(self, tick: Tick) -> None:
        """See `Recorder`. Hands the tick's lines to the thread."""
        self.summary.take(tick)
        for line in (*map(event_line, tick.events), *self._first_look.take(tick)):
            if len(self._waiting) < _MOST_WAITING:
                self._waiting.append(line)
                self._wake.set()
            else:
                self._lost += 1
        if self._screen.has_status and tick.t_s >= self._status_due_s:
            self._status_due_s = tick.t_s + self._status_s
            self._status = status_text(tick, self._links, self._heading_source(), self._late())
            self._wake.set()

    def close(self) -> None:
        """Write what waits, for a second at most."""
        self._ended = True
        self._wake.set()
        self._thread.join(_PATIENCE_S)

    @property
    def stuck(self) -> bool:
        """After the end: whether nobody reads, so that a further line would wait for ever."""
        return self._thread.is_alive()

    def _write(self) -> None:
        self._screen.begin()
        shown = ""
        while True:
            self._wake.wait()
            self._wake.clear()
            ended = self._ended
            self._write_lines()
            if self._status != shown:
                shown = self._status
                self._screen.status(shown)
            if ended:
                self._screen.end()
                return

    def _write_lines(self) -> None:
        while self._waiting:
            line = self._waiting.popleft()
            if lost := self._lost - self._told_lost:
                self._told_lost += lost
                self._show(Line(line.t_s, TextKind.ATTENTION.severity, f"{lost} lines lost: nobody read this output"))
            self._show(line)

    def _show(self, line: Line) -> None:
        if self._journal:
            self._screen.line(f"<{line.severity.value}>{line.text}", None)
        else:
            self._screen.line(line.plain, line.severity)
