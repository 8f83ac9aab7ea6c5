"""Serial ports that come and go, on real pseudo-terminals."""

from __future__ import annotations

import contextlib
import fcntl
import os
import subprocess
import sys
import termios
import threading
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path

import pytest

from companion.io.transport import serial_line
from companion.io.transport.serial_line import SerialLine
from companion.io.transport.urls import PortUrl, parse_url
from tests.threadless import no_threads
from tests.unit.io.lines import Terminal, opened, slept_s, text_of, wait_opened, wait_readable
from tests.waiting import CAP_S


def test_serial_reads_writes_and_comes_back(tmp_path: Path) -> None:
    terminal = Terminal(tmp_path / "tty")
    with opened(f"serial:{terminal.path}:9600") as line:
        assert "no such device" in (line.fault() or "") and line.fileno() is None
        assert not line.read(0.0)
        terminal.plug()
        assert not line.read(0.4)  # not before 0.5 s are over
        line.write(b"lost", 0.45)
        line.read(0.5)
        wait_opened(line, 0.5)
        terminal.let_go()
        assert line.fault() is None
        os.write(terminal.master, b"$hello\r\n\x00\xff")
        wait_readable(line)
        assert list(line.read(1.25)) == [(1.25, b"$hello\r\n\x00\xff")]
        assert not line.read(1.3)
        line.write(b"\r\n\x03\x11ok", 1.3)
        assert os.read(terminal.master, 100) == b"\r\n\x03\x11ok"

        terminal.pull()
        assert not line.read(2.0)
        assert (
            "gone: unplugged, or another program reads it too; waiting for it" in (line.fault() or "")
            and line.fileno() is None
        )
        terminal.plug()
        for now_s in (2.1, 2.3, 2.5):
            line.read(now_s)
        wait_opened(line, 3.0)
        assert line.fault() is None
        terminal.let_go()
        os.write(terminal.master, b"again")
        wait_readable(line)
        assert text_of(line, 4.0) == b"again"
        os.close(terminal.master)
    assert line.fault() == "closed" and not line.read(9.0)


@pytest.mark.parametrize(
    ("error", "distances_s"),
    [
        (OSError(5, "Input/output error"), [0.5, 1.0, 2.0, 4.0, 5.0, 5.0, 5.0, 5.0]),
        (FileNotFoundError(2, "none"), [0.5] * 50),  # what is plugged in again is found soon
    ],
)
def test_when_a_port_is_tried_again(tmp_path: Path, error: OSError, distances_s: list[float]) -> None:
    tries: list[float] = []
    now_s = 0.0

    class Refused(SerialLine):
        """A line whose port never opens."""

        def _connect(self) -> None:
            tries.append(now_s)
            raise error

    url = f"serial:{tmp_path}/none:9600"
    line = Refused("device", url, parse_url(url))
    tries.clear()
    for k in range(300):
        now_s = 0.1 * k
        line.read(now_s)
    line.close()
    gaps = [b - a for a, b in pairwise(tries)]
    assert gaps[: len(distances_s)] == pytest.approx(distances_s, abs=0.11)


def test_two_devices_with_one_port(tmp_path: Path) -> None:
    terminal = Terminal(tmp_path / "tty")
    terminal.plug()
    with opened(f"serial:{terminal.path}:9600") as first, opened(f"serial:{terminal.path}:9600") as second:
        assert first.fault() is None
        assert (second.fault() or "").endswith(
            "busy; this companion itself has it open; stop that, or give this device another port"
        )
    terminal.let_go()
    os.close(terminal.master)


@contextlib.contextmanager
def as_a_plain_user() -> Iterator[None]:
    """Root may do what others may not: as nobody, then."""
    user = os.geteuid()
    if user == 0:
        os.seteuid(65534)
    try:
        yield
    finally:
        os.seteuid(user)


def test_the_exclusive_mode_of_another_program_is_respected() -> None:
    master, slave = os.openpty()
    os.fchmod(slave, 0o666)
    fcntl.ioctl(slave, termios.TIOCEXCL)
    with as_a_plain_user(), opened(f"serial:{os.ttyname(slave)}:9600") as line:
        assert ": busy; " in (line.fault() or "")
        fcntl.ioctl(slave, termios.TIOCNXCL)
        line.read(1.0)
        wait_opened(line, 1.1)
        assert line.fault() is None
    os.close(slave)
    os.close(master)


def test_who_has_a_busy_port_is_named(tmp_path: Path) -> None:
    terminal = Terminal(tmp_path / "tty")
    terminal.plug()
    script = tmp_path / "gpsd.py"
    script.write_text(
        "import fcntl, os, sys; fcntl.flock(os.open(sys.argv[1], os.O_RDWR | os.O_NOCTTY), fcntl.LOCK_EX); print('has it', flush=True); sys.stdin.read()"
    )
    with subprocess.Popen(
        [sys.executable, str(script), str(terminal.path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE
    ) as other:
        assert other.stdout is not None and other.stdout.readline()
        terminal.let_go()
        with opened(f"serial:{terminal.path}:9600") as line:
            fault = line.fault() or ""
            assert f"busy; process {other.pid} (gpsd.py {terminal.path}"[:70] in fault and "\n" not in fault
            assert other.stdin is not None
            other.stdin.close()
            other.wait(5.0)
            line.read(1.0)
            line.read(1.6)
            wait_opened(line, 1.7)
            assert line.fault() is None
    os.close(terminal.master)


def test_a_locked_port_is_closed_to_all_and_free_again_afterwards(tmp_path: Path) -> None:
    """The exclusive mode would stay with a pseudo-terminal, which outlives whoever had it open."""
    terminal = Terminal(tmp_path / "tty")
    terminal.plug()
    exclusive = 0x5440  # TIOCGEXCL
    state = bytearray(4)

    def locked() -> bool:
        fcntl.ioctl(terminal.slave, exclusive | 0x80040000, state)
        return bool(state[0])

    with opened(f"serial:{terminal.path}:9600"):
        assert locked()
    assert not locked()
    terminal.let_go()
    os.close(terminal.master)


@pytest.mark.parametrize("make", [Path.touch, Path.mkdir, os.mkfifo])
def test_what_is_no_serial_port_is_said(tmp_path: Path, make: Callable[[Path], None]) -> None:
    path = tmp_path / "thing"
    make(path)
    with opened(f"serial:{path}:9600") as line:
        assert "is no serial port but a file or folder" in (line.fault() or "")


def test_a_renamed_port_is_found_under_its_lasting_name(tmp_path: Path) -> None:
    """ttyUSB0 comes back as ttyUSB1; the link of udev points there, and the vessel's file names the link."""
    by_id = tmp_path / "by-id"
    by_id.mkdir()
    first, second = Terminal(tmp_path / "ttyUSB0"), Terminal(tmp_path / "ttyUSB1")
    name = by_id / "usb-FTDI_FT232R_A10KZP45-if00-port0"
    first.plug()
    name.symlink_to(first.path)
    with opened(f"serial:{name}:9600") as line:
        assert line.fault() is None
        first.let_go()
        first.pull()
        line.read(1.0)
        assert "gone: unplugged" in (line.fault() or "")
        second.plug()
        line.read(1.5)
        assert "no such device" in (line.fault() or "")
        name.unlink()
        name.symlink_to(second.path)
        line.read(2.6)
        wait_opened(line, 2.7)
        second.let_go()
        os.write(second.master, b"here")
        wait_readable(line)
        assert text_of(line, 3.0) == b"here"
        os.close(second.master)


def test_a_driver_that_hangs_while_it_opens_holds_nobody_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal(tmp_path / "tty")
    release, closed = threading.Event(), threading.Event()
    with opened(f"serial:{terminal.path}:9600") as line:
        terminal.plug()
        really = serial_line.open_port

        def slow(endpoint: PortUrl) -> object:
            release.wait(CAP_S)
            port = really(endpoint)
            shut = port.close
            port.close = lambda: (shut(), closed.set())
            return port

        monkeypatch.setattr(serial_line, "open_port", slow)
        line.read(0.5)
        worst_s = max(slept_s(lambda now_s=0.1 * k: line.read(now_s)) for k in range(6, 40))  # type: ignore[misc]
        assert worst_s < 0.25
        assert "opening it hangs; pull its plug" in (line.fault() or "")
    release.set()
    assert closed.wait(CAP_S), "a port that nobody wants any more is closed when it opens at last"
    terminal.let_go()
    os.close(terminal.master)


def test_without_threads_a_port_that_is_pulled_raises_nothing_and_comes_back_later(tmp_path: Path) -> None:
    terminal = Terminal(tmp_path / "tty")
    terminal.plug()
    with opened(f"serial:{terminal.path}:9600") as line:
        terminal.let_go()
        with no_threads():
            terminal.pull()
            assert not line.read(1.0) and line.fileno() is None
            terminal.plug()
            assert not line.read(1.6)
            assert "no threads left; trying again" in (line.fault() or "")
        line.read(3.0)
        wait_opened(line, 3.1)
        assert line.fault() is None
        terminal.let_go()
    os.close(terminal.master)


def test_a_full_serial_line_drops_whole_messages(tmp_path: Path) -> None:
    """Nobody reads: writing never blocks, and what arrives in the end is whole messages."""
    terminal = Terminal(tmp_path / "tty")
    terminal.plug()
    with opened(f"serial:{terminal.path}:9600") as line:
        for k in range(3000):
            line.write(b"%06d....................\n" % k, 0.001 * k)
        got = b""
        for k in range(200):
            with contextlib.suppress(BlockingIOError):
                got += os.read(terminal.master, 65536)
            line.read(4.0 + k)
        messages = got.split(b"\n")
        assert messages[-1] == b"" and len(messages) > 10
        assert all(len(text) == 26 and text[:6].isdigit() for text in messages[:-1])
        assert len(messages) < 3000
    terminal.let_go()
    os.close(terminal.master)


def test_permission_denied_says_what_to_do() -> None:
    master, slave = os.openpty()
    os.fchmod(slave, 0)
    with as_a_plain_user(), opened(f"serial:{os.ttyname(slave)}:9600") as line:
        assert (line.fault() or "").endswith("permission denied; `sudo usermod -aG dialout $USER`, then log in again")
    os.close(slave)
    os.close(master)
