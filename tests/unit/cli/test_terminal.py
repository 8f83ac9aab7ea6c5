"""The thread that writes the lines of a run: to a pipe, the journal and a pseudo-terminal; and nobody reads."""

from __future__ import annotations

import os
import pty
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from companion.cli.coloured import ColouredScreen, console_on
from companion.cli.terminal import PlainScreen, Terminal, journal_of, screen_on
from companion.core.decision import Event, TextKind
from companion.core.tick import DeviceHealth, Tick
from tests.unit.record.ticks import tick

WELL = (DeviceHealth("gnss", True, 0.1),)


def said(t_s: float, *texts: str) -> Tick:
    events = tuple(Event(t_s, TextKind.ALARM, "test", text) for text in texts)
    return replace(tick(t_s), events=events, health=WELL)


def terminal(fd: int, journal: bool = False, **settings: bool) -> Terminal:
    screen = ColouredScreen(console_on(fd, **settings)) if settings else screen_on(fd, {})
    return Terminal(screen, (), lambda: "gnss", lambda: 0, journal)


def read_all(fd: int) -> str:
    parts = []
    while True:
        try:
            part = os.read(fd, 1 << 16)
        except OSError:  # what a pseudo-terminal says when its other end is closed
            part = b""
        if not part:
            return b"".join(parts).decode()
        parts.append(part)


def test_a_pipe_gets_plain_lines() -> None:
    reading, writing = os.pipe()
    shown = terminal(writing)
    shown.record(said(0.1, "Leader lost [x]"))
    shown.record(said(1.7))
    shown.close()
    os.close(writing)
    assert (
        read_all(reading)
        == "0:00:00.1  CRITICAL   Leader lost [x]\n0:00:01.7  INFO       All devices and links are open\n"
    )
    os.close(reading)
    assert not shown.stuck


def test_the_journal_gets_priorities() -> None:
    reading, writing = os.pipe()
    state = os.fstat(writing)
    assert journal_of({"JOURNAL_STREAM": f"{state.st_dev}:{state.st_ino}"}, writing)
    assert not journal_of({"JOURNAL_STREAM": f"{state.st_dev}:{state.st_ino + 1}"}, writing)
    assert not journal_of({}, writing)
    shown = terminal(writing, journal=True)
    shown.record(said(0.1, "Leader lost"))
    shown.close()
    os.close(writing)
    assert read_all(reading) == "<2>Leader lost\n"
    os.close(reading)


def test_control_characters_of_a_text_do_not_reach_a_pipe() -> None:
    reading, writing = os.pipe()
    shown = terminal(writing)
    shown.record(said(0.1, "a\ab\rc :x: [red]"))
    shown.close()
    os.close(writing)
    assert read_all(reading) == "0:00:00.1  CRITICAL   abc :x: [red]\n"
    os.close(reading)


def test_colours_are_for_who_looks_or_asks_for_them() -> None:
    reading, writing = os.pipe()
    far, near = pty.openpty()
    assert not screen_on(writing, {}).has_status and screen_on(near, {}).has_status
    assert isinstance(screen_on(writing, {"FORCE_COLOR": "1"}), ColouredScreen)
    assert isinstance(screen_on(writing, {"FORCE_COLOR": ""}), PlainScreen)
    for descriptor in (reading, writing, far, near):
        os.close(descriptor)


def test_a_long_line_is_not_folded_in_a_pipe() -> None:
    reading, writing = os.pipe()
    shown = terminal(writing)
    shown.record(said(0.1, "word " * 100))
    shown.close()
    os.close(writing)
    assert read_all(reading).count("\n") == 1
    os.close(reading)


def test_who_does_not_read_loses_lines_and_costs_no_tick() -> None:
    reading, writing = os.pipe()
    shown = terminal(writing)
    for n in range(5000):  # far more than a pipe holds; a write on this thread would wait for ever
        shown.record(said(0.1 * n, f"{n} " + "x" * 1000))
    shown.close()
    assert shown.stuck
    os.close(reading)  # ends the thread
    shown.close()
    assert not shown.stuck
    os.close(writing)


def test_lost_lines_are_counted() -> None:
    reading, writing = os.pipe()
    shown = terminal(writing)
    for n in range(5000):
        shown.record(said(0.0, f"{n} " + "x" * 1000))
    os.set_blocking(reading, True)
    text = ""
    while len(re.findall(r"^0.*x$", text, re.M)) < 400:
        text += os.read(reading, 1 << 16).decode()
    shown.record(said(0.0, "the last"))
    while "the last\n" not in text:
        text += os.read(reading, 1 << 16).decode()
    shown.close()
    lost = sum(int(count) for count in re.findall(r"WARNING    (\d+) lines lost: nobody read", text))
    assert lost + len(re.findall(r"CRITICAL   \d+ x+$", text, re.M)) == 5000
    os.close(writing)
    os.close(reading)


def test_a_terminal_gets_colours_and_a_status_line() -> None:
    far, near = pty.openpty()
    shown = terminal(near, force_terminal=True)
    shown.record(said(0.1, "Leader lost"))
    shown.close()
    os.close(near)
    text = read_all(far)
    os.close(far)
    assert "\x1b[1;31m" in text and "Leader lost" in text
    assert "Hold armed | RTK fixed 0.02 m | heading 17° (gnss)" in text
    assert text.rstrip().endswith("\x1b[2K")  # the status line does not stay


RUN = (
    "run",
    "revolt",
    "--sitl",
    "--speed",
    "60",
    "--duration",
    "16",
    "--fault",
    "gnss_unplugged@6+6",
    "--link",
    "udpout:127.0.0.1:9",
)
EVENTS = """\
0:00:00.0  INFO       Heading source: gnss
0:00:01.1  INFO       Home set here
0:00:01.5  INFO       All devices and links are open
"""


def run_it(folder: Path, out: int) -> None:
    arguments = [*RUN, "--state", str(folder / "state"), "--log", str(folder / "log")]
    environment = {**os.environ, "COLUMNS": "200", "TERM": "xterm"}
    subprocess.run([sys.executable, "-m", "companion", *arguments], stdout=out, check=True, env=environment)


@pytest.mark.process
def test_a_fault_and_its_recovery_in_a_pipe(tmp_path: Path) -> None:
    with (tmp_path / "out").open("wb") as out:
        run_it(tmp_path, out.fileno())
    text = (tmp_path / "out").read_text()
    assert "\x1b" not in text
    assert EVENTS in text
    lost, back = text.index("gnss: "), text.index("gnss: back")
    assert text.index(EVENTS) < lost < back
    assert re.search(r"^0:00:0[6-8]\.\d  WARNING    gnss: ", text, re.M)
    assert re.search(r"^0:00:1[2-4]\.\d  INFO       gnss: back$", text, re.M)
    assert "armed 0 s of 16 s, sailed 0 m\nfailsafes: none\nlog:   " in text


@pytest.mark.process
def test_a_fault_and_its_recovery_on_a_terminal(tmp_path: Path) -> None:
    far, near = pty.openpty()
    run_it(tmp_path, near)
    os.close(near)
    text = read_all(far)
    os.close(far)
    assert re.search(r"\x1b\[33m0:00:0[6-8]\.\d  WARNING    gnss: ", text)
    assert "Manual disarmed" in text and "\x1b[?25h" in text  # the cursor is back
    assert "armed 0 s of 16 s, sailed 0 m" in text
