"""Ports opened by the companion, and pseudo-terminals that can be pulled out."""

from __future__ import annotations

import contextlib
import os
import select
import socket
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from companion.core.ports import ByteStream
from companion.io.transport.line import Line
from companion.io.transport.opener import TransportOpener
from companion.io.transport.serial_line import SerialLine
from tests.waiting import CAP_S


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
    assert select.select([descriptor], [], [], CAP_S)[0]


def address_of(line: Line) -> tuple[str, int]:
    """Where a line that listens does so."""
    descriptor = line.fileno()
    assert descriptor is not None
    with socket.socket(fileno=os.dup(descriptor)) as same:
        host, port = same.getsockname()
    return str(host), int(port)


def text_of(line: Line, now_s: float) -> bytes:
    return b"".join(data for _, data in line.read(now_s))


def wait_opened(line: Line, now_s: float) -> None:
    """Until the thread that opens the port has ended, and the line knows."""
    assert isinstance(line, SerialLine)
    for thread in threading.enumerate():
        if thread.name == "port-opener":
            thread.join(CAP_S)
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
        self.slave = slave

    def let_go(self) -> None:
        """Close our own end of the slave, as the device side of a plugged cable has none."""
        os.close(self.slave)

    def pull(self) -> None:
        os.close(self.master)
        self.path.unlink()


def slept_s(call: Callable[[], object]) -> float:
    """Seconds that this thread slept in the call: of its wall time, what it neither worked nor waited for a
    processor."""

    def now_s() -> float:
        worked_ns, queued_ns, _ = map(int, Path("/proc/thread-self/schedstat").read_text(encoding="ascii").split())
        return time.perf_counter() - 1e-9 * (worked_ns + queued_ns)

    begin_s = now_s()
    call()
    return now_s() - begin_s
