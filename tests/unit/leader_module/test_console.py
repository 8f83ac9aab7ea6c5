"""The terminal of a leader module, on a real pty."""

from __future__ import annotations

import io
import os
import select
import termios
import threading
from pathlib import Path

from companion.leader_module.console import Console
from tests.waiting import CAP_S


def test_keys_come_one_by_one_and_the_line_is_written_over() -> None:
    master, slave = os.openpty()
    with (
        os.fdopen(os.dup(slave), "w", encoding="utf-8") as out,
        os.fdopen(os.dup(slave), "r", encoding="utf-8") as source,
    ):
        before = termios.tcgetattr(slave)
        console = Console(out, source)
        assert console.typed() == ""
        os.write(master, b"ma")
        assert console.typed() == "ma", "without Enter"
        console.show("a line", 0.0)
        console.say("something was said")
        console.show("another", 0.2)
        shown = ""
        while "another" not in shown and select.select([master], [], [], CAP_S)[0]:
            shown += os.read(master, 4096).decode()
        assert "ma" not in shown, "what is typed is not echoed"
        assert (
            shown.index("a line") < shown.index("something was said") < shown.index("another")
            and shown.count("\n") == 1
        )
        console.close()
        assert termios.tcgetattr(slave) == before
    os.close(slave)
    os.close(master)


def test_without_a_terminal_a_line_goes_out_every_five_seconds(tmp_path: Path) -> None:
    out = io.StringIO()
    with (tmp_path / "nothing").open("w+", encoding="utf-8") as source:
        console = Console(out, source)
        for n in range(101):
            console.show(f"line {n}", 0.1 * n)
            assert console.typed() == ""
        console.say("said")
        console.close()
    assert out.getvalue().splitlines() == ["line 0", "line 50", "line 100", "said"]


def test_an_output_that_stands_still_holds_nobody_up(tmp_path: Path) -> None:
    """Ctrl-S, or a laptop whose connection to the module is cut; here a pipe that nobody reads."""
    reading, writing = os.pipe()
    with os.fdopen(writing, "w", encoding="utf-8") as out, (tmp_path / "nothing").open("w+") as source:
        console = Console(out, source)

        def a_while() -> None:
            for n in range(2000):
                console.say(f"{n:078d}")
            console.close()

        caller = threading.Thread(target=a_while, daemon=True)
        caller.start()
        caller.join(0.1 * CAP_S)
        stuck = caller.is_alive()
        os.close(reading)  # which ends what is written
        caller.join(CAP_S)
    assert not stuck


def test_a_terminal_that_goes_away_is_given_up() -> None:
    master, slave = os.openpty()
    with (
        os.fdopen(os.dup(slave), "w", encoding="utf-8") as out,
        os.fdopen(os.dup(slave), "r", encoding="utf-8") as source,
    ):
        os.close(slave)
        console = Console(out, source)
        os.close(master)
        for n in range(3):
            console.show("a line", float(n))
            console.say("text")
            assert console.typed() == ""
        assert console.fileno() is None
        console.close()
