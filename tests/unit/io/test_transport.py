"""Ports that come and go, on real pseudo-terminals and loopback sockets."""

from __future__ import annotations

import contextlib
import fcntl
import os
import select
import socket
import subprocess
import sys
import termios
import threading
import time
from collections.abc import Callable, Iterator
from itertools import pairwise
from pathlib import Path

import pytest

from companion.core.ports import ByteStream
from companion.io import serial_line
from companion.io.line import Line
from companion.io.serial_line import SerialLine
from companion.io.transport import TransportOpener
from companion.io.urls import Endpoint, TransportError, parse_url


@pytest.mark.parametrize(
    "text, endpoint",
    [
        ("serial:/dev/ttyUSB0:57600", Endpoint("serial", path="/dev/ttyUSB0", baud=57600)),
        ("serial:/dev/ttyUSB0", Endpoint("serial", path="/dev/ttyUSB0", baud=115200)),
        (
            "serial:/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0-port0:9600?parity=even",
            Endpoint("serial", path="/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0-port0", baud=9600, options={"parity": "even"}),
        ),
        ("udpout:192.168.1.20:14550", Endpoint("udpout", host="192.168.1.20", port=14550)),
        ("udpin:0.0.0.0:0", Endpoint("udpin", host="0.0.0.0")),
        ("tcpin:[::1]:5760?dialect=ardupilot", Endpoint("tcpin", host="::1", port=5760, options={"dialect": "ardupilot"})),
        ("tcpout:boat.local:1", Endpoint("tcpout", host="boat.local", port=1)),
    ],
)
def test_parse(text: str, endpoint: Endpoint) -> None:
    assert parse_url(text) == endpoint


@pytest.mark.parametrize(
    "text, says",
    [
        ("", "should begin with one of serial:, udpin:"),
        ("/dev/ttyUSB0", "should begin with one of"),
        ("bluetooth:x:1", "should begin with one of"),
        ("serial:", "serial:/dev/name:baud"),
        ("serial:/dev/x:7", "baud rate 7"),
        ("udpout:14550", "udpout:host:port"),
        ("udpout:host:http", "udpout:host:port"),
        ("tcpin:host:70000", "port 70000"),
        ("tcpin:host:²", "tcpin:host:port"),
        ("udpin:0.0.0.0:1?dialect", "?key=value"),
    ],
)
def test_parse_errors_are_one_line(text: str, says: str) -> None:
    with pytest.raises(TransportError) as caught:
        parse_url(text)
    assert says in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "url, says",
    [
        ("udpout:boat.local:5000", "should be an IP address"),
        ("serial:/dev/x:9600?parity=odder", "none, even, odd"),
        ("udpin:0.0.0.0:1?parity=odd", "unknown option 'parity'; known here: none"),
    ],
)
def test_opener_refuses_what_never_can_work(url: str, says: str) -> None:
    with pytest.raises(TransportError, match=says):
        TransportOpener().open("x", url)


@contextlib.contextmanager
def opened(url: str) -> Iterator[Line]:
    line = TransportOpener().open("device", url)
    try:
        assert isinstance(line, ByteStream)
        yield line
    finally:
        line.close()


def wait_readable(line: Line) -> None:
    descriptor = line.fileno()
    assert descriptor is not None
    assert select.select([descriptor], [], [], 2.0)[0]


def text_of(line: Line, now_s: float) -> bytes:
    return b"".join(data for _, data in line.read(now_s))


def wait_opened(line: Line, now_s: float) -> None:
    """Until the thread that opens the port has ended, and the line knows."""
    assert isinstance(line, SerialLine)
    if line._opening is not None:
        assert line._opening.ended.wait(5.0)
        line.read(now_s)


class Terminal:
    """A pseudo-terminal behind a name that can be pulled out and plugged in again."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.master = -1

    def plug(self) -> None:
        self.master, slave = os.openpty()
        self.path.unlink(missing_ok=True)
        self.path.symlink_to(os.ttyname(slave))
        os.set_blocking(self.master, False)
        self._slave = slave

    def let_go(self) -> None:
        """Close our own end of the slave, as the device side of a plugged cable has none."""
        os.close(self._slave)

    def pull(self) -> None:
        os.close(self.master)
        self.path.unlink()


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
        assert "gone: unplugged, or another program reads it too; waiting for it" in (line.fault() or "") and line.fileno() is None
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
    with opened(f"serial:{tmp_path}/none:9600") as line:
        tries: list[float] = []
        line._connect = lambda: tries.append(now_s) or (_ for _ in ()).throw(error)  # type: ignore[method-assign,func-returns-value]
        for k in range(300):
            now_s = 0.1 * k
            line.read(now_s)
        gaps = [b - a for a, b in pairwise(tries)]
    assert gaps[: len(distances_s)] == pytest.approx(distances_s, abs=0.11)


def test_two_devices_with_one_port(tmp_path: Path) -> None:
    terminal = Terminal(tmp_path / "tty")
    terminal.plug()
    with opened(f"serial:{terminal.path}:9600") as first, opened(f"serial:{terminal.path}:9600") as second:
        assert first.fault() is None
        assert (second.fault() or "").endswith("busy; this companion itself has it open; stop that, or give this device another port")
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
    with subprocess.Popen([sys.executable, str(script), str(terminal.path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE) as other:
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
        fcntl.ioctl(terminal._slave, exclusive | 0x80040000, state)
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


def test_devices_of_a_simulated_boat_are_looked_for_in_their_folder(tmp_path: Path) -> None:
    opener = TransportOpener(tmp_path)
    for url, place in (
        ("serial:/dev/usv-gnss:4800", f"serial:{tmp_path}/usv-gnss:4800"),
        ("serial:/dev/serial/by-id/usb-x:9600?parity=even", f"serial:{tmp_path}/serial/by-id/usb-x:9600?parity=even"),
        ("serial:/srv/port:9600", "serial:/srv/port:9600"),
    ):
        line = opener.open("x", url)
        assert (line.fault() or "").startswith(f"{place}: no such device")
        line.close()


def test_a_driver_that_hangs_while_it_opens_holds_nobody_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal(tmp_path / "tty")
    release, closed = threading.Event(), threading.Event()
    with opened(f"serial:{terminal.path}:9600") as line:
        terminal.plug()
        really = serial_line.open_port

        def slow(endpoint: Endpoint) -> object:
            release.wait(10.0)
            port = really(endpoint)
            shut = port.close
            port.close = lambda: (shut(), closed.set())
            return port

        monkeypatch.setattr(serial_line, "open_port", slow)
        line.read(0.5)
        worst_s = max(timed(lambda now_s=0.1 * k: line.read(now_s)) for k in range(6, 40))  # type: ignore[misc]
        assert worst_s < 0.25
        assert "opening it hangs; pull its plug" in (line.fault() or "")
    release.set()
    assert closed.wait(5.0), "a port that nobody wants any more is closed when it opens at last"
    terminal.let_go()
    os.close(terminal.master)


def test_no_port_ever_blocks(tmp_path: Path) -> None:
    """A serial line and a TCP stream that nobody reads, a host that does not answer, a closed port, nobody at all: 2000 calls each."""
    terminal = Terminal(tmp_path / "tty")
    terminal.plug()
    with socket.create_server(("127.0.0.1", 0), backlog=1) as deaf, socket.create_server(("127.0.0.1", 0), backlog=0) as full:
        host, port = full.getsockname()
        fill = [socket.socket() for _ in range(4)]
        for each in fill:  # until the system drops what else knocks: a black hole
            each.setblocking(False)
            each.connect_ex((host, port))
        urls = [
            f"serial:{terminal.path}:9600",
            f"tcpout:127.0.0.1:{deaf.getsockname()[1]}",
            f"tcpout:127.0.0.1:{port}",
            "tcpout:127.0.0.1:1",
            "tcpout:192.0.2.1:4001",
            "udpout:192.0.2.1:4001",
            f"serial:{tmp_path}/none:9600",
        ]
        faults, worst_s = {}, 0.0
        for url in urls:
            with opened(url) as line:
                for k in range(2000):
                    worst_s = max(worst_s, timed(lambda now_s=0.01 * k: (line.read(now_s), line.write(bytes(1000), now_s))))  # type: ignore[misc]
                faults[url] = line.fault()
        for each in fill:
            each.close()
    terminal.let_go()
    os.close(terminal.master)
    assert worst_s < 0.25, f"{worst_s:.3f} s"
    assert faults[urls[0]] is None and faults[urls[1]] is None
    assert faults[urls[2]] in (f"{urls[2]}: connecting", f"{urls[2]}: no answer; trying again")


def timed(call: Callable[[], object]) -> float:
    """Seconds of wall time; blocking is what is looked for, so the bounds are wide."""
    begin_s = time.perf_counter()
    call()
    return time.perf_counter() - begin_s


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
        assert (line.fault() or "").endswith("permission denied; `sudo usermod -aG dialout $USER`, then log in anew")
    os.close(slave)
    os.close(master)


def test_udp_both_ways() -> None:
    with opened("udpin:127.0.0.1:0") as inward:
        port = inward._socket.getsockname()[1]  # type: ignore[attr-defined]
        inward.write(b"to nobody yet", 0.0)
        with opened(f"udpout:localhost:{port}") as outward:
            assert not inward.read(0.0)
            outward.write(b"one", 0.0)
            outward.write(b"two", 0.0)
            wait_readable(inward)
            assert list(inward.read(1.0)) == [(1.0, b"one"), (1.0, b"two")]
            inward.write(b"back", 1.0)
            wait_readable(outward)
            assert text_of(outward, 1.0) == b"back"
        with opened(f"udpin:127.0.0.1:{port}") as second:
            assert "port in use" in (second.fault() or "")


def test_udp_to_nobody_is_no_fault() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with opened(f"udpout:127.0.0.1:{port}") as line:
        for k in range(5):
            line.write(b"hello?", float(k))
            assert not line.read(float(k))
        assert line.fault() is None


def test_tcp_server_takes_a_newer_connection_and_goes_on_after_a_loss() -> None:
    with opened("tcpin:127.0.0.1:0") as server:
        address = server._listener.getsockname()  # type: ignore[attr-defined]
        assert "waiting for the device" in (server.fault() or "")
        with socket.create_connection(address) as client:
            wait_readable(server)
            server.read(0.0)
            assert server.fault() is None
            client.sendall(b"hello")
            wait_readable(server)
            assert text_of(server, 0.1) == b"hello"
            server.write(b"there", 0.1)
            assert client.recv(10) == b"there"
            with socket.create_connection(address) as newer:
                newer.sendall(b"new")
                assert select.select([server._listener], [], [], 2.0)[0]  # type: ignore[attr-defined]
                assert text_of(server, 0.2) == b"new"
                server.write(b"!", 0.3)
                assert newer.recv(10) == b"!"
        wait_readable(server)
        server.read(0.4)
        server.read(0.5)
        assert "waiting for the device" in (server.fault() or "")
        with socket.create_connection(address) as client:
            wait_readable(server)
            server.write(b"welcome", 0.6)
            assert client.recv(10) == b"welcome"


def test_tcp_client_connects_without_waiting_and_again_after_a_loss() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
        with opened(f"tcpout:127.0.0.1:{port}") as client:
            peer, _ = listener.accept()
            client.write(b"hello", 0.0)
            assert peer.recv(10) == b"hello"
            assert client.fault() is None
            peer.close()
            wait_readable(client)
            assert not client.read(1.0)
            assert "closed the connection" in (client.fault() or "")
            client.read(1.3)
            assert client.fileno() is None
            client.read(1.6)
            peer, _ = listener.accept()
            client.read(1.7)
            assert client.fault() is None
            peer.sendall(b"again")
            wait_readable(client)
            assert text_of(client, 1.8) == b"again"
            peer.close()


def test_tcp_client_refused() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
    with opened(f"tcpout:127.0.0.1:{port}") as client:
        for k in range(5):
            client.write(b"x", 0.1 * k)
        assert "refused; nothing listens there" in (client.fault() or "")


def test_a_flood_is_taken_in_small_bites_and_none_of_it_is_lost() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        line = TransportOpener().open("device", f"tcpout:127.0.0.1:{server.getsockname()[1]}")
        try:
            far, _ = server.accept()
            with far:
                far.sendall(bytes(60_000))
                heard = 0
                for _ in range(20_000):
                    bite = sum(len(data) for _, data in line.read(0.0))
                    assert bite <= 16384
                    heard += bite
                    if heard == 60_000:
                        break
                assert heard == 60_000
        finally:
            line.close()
