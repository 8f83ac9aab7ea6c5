"""Ports opened by the companion, and pseudo-terminals that can be pulled out."""

from __future__ import annotations

import contextlib
import os
import select
import time
from collections.abc import Callable, Iterator
from pathlib import Path

from companion.core.ports import ByteStream
from companion.io.line import Line
from companion.io.serial_line import SerialLine
from companion.io.transport import TransportOpener


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


def timed(call: Callable[[], object]) -> float:
    """Seconds of wall time; blocking is what is looked for, so the bounds are wide."""
    begin_s = time.perf_counter()
    call()
    return time.perf_counter() - begin_s
