"""The companion as a process of its own that begins as a copy of one that has loaded its modules
(`tests/fork_server.py`): the same program, without the processor second in which they are loaded. What is tested of
the beginning itself starts `python -m companion`."""

from __future__ import annotations

import atexit
import json
import math
import os
import select
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Sequence
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import IO, Any

from tests.fork_server import LARGEST_REQUEST
from tests.waiting import ended

ROOT = Path(__file__).parents[1]


class Copy:
    """`companion ARGUMENTS`, with the face of a `subprocess.Popen` in text mode whose streams are all pipes."""

    def __init__(self, arguments: Sequence[str], environment: dict[str, str] | None = None) -> None:
        self.args = [sys.executable, "-m", "companion", *arguments]
        self.returncode: int | None = None
        near, far = [], []
        for reads in (False, True, True, True):  # stdin, stdout, stderr, and what the keeper tells
            ends = os.pipe()
            near.append(ends[0] if reads else ends[1])
            far.append(ends[1] if reads else ends[0])
        request = {
            "arguments": list(arguments),
            "environment": {**os.environ, **(environment or {})},
            "folder": str(Path.cwd()),
        }
        data = json.dumps(request).encode()
        assert len(data) < LARGEST_REQUEST
        socket.send_fds(_fork_server(), [data], far)
        for descriptor in far:
            os.close(descriptor)
        self.stdin: IO[str] = os.fdopen(near[0], "w", encoding="utf-8")
        self.stdout: IO[str] = os.fdopen(near[1], encoding="utf-8")
        self.stderr: IO[str] = os.fdopen(near[2], encoding="utf-8")
        self._told = os.fdopen(near[3], "rb", buffering=0)
        self.pid = int(self._told.readline())

    def poll(self) -> int | None:
        """The exit code, or None while it runs."""
        return self._result(0.0)

    def wait(self, timeout: float | None = None) -> int:
        """The exit code. Raises subprocess.TimeoutExpired."""
        if (code := self._result(math.inf if timeout is None else timeout)) is None:
            raise subprocess.TimeoutExpired(self.args, timeout or 0.0)
        return code

    def send_signal(self, number: int) -> None:
        if self.poll() is None:
            with suppress(ProcessLookupError):  # it has ended since
                os.kill(self.pid, number)

    def terminate(self) -> None:
        self.send_signal(signal.SIGTERM)

    def kill(self) -> None:
        self.send_signal(signal.SIGKILL)

    def communicate(self, timeout: float | None = None) -> tuple[str, str]:
        """What it still writes to stdout and stderr, after its stdin has been closed. Raises
        subprocess.TimeoutExpired."""
        end_s = math.inf if timeout is None else time.monotonic() + timeout
        self.stdin.close()
        heard: dict[IO[str], bytes] = {self.stdout: b"", self.stderr: b""}
        open_ones = [stream for stream in heard if not stream.closed]
        while open_ones:
            for stream in self._ready(open_ones, end_s - time.monotonic()):
                data = os.read(stream.fileno(), 65536)
                heard[stream] += data
                if not data:
                    stream.close()
                    open_ones.remove(stream)
        self.wait(end_s - time.monotonic())
        return heard[self.stdout].decode(), heard[self.stderr].decode()

    def _result(self, timeout_s: float) -> int | None:
        if self.returncode is None and _ready([self._told], timeout_s):
            self.returncode = int(self._told.readline())
            self._told.close()
        return self.returncode

    def _ready(self, streams: list[IO[str]], timeout_s: float) -> list[IO[str]]:
        if not (ready := _ready(streams, timeout_s)):
            raise subprocess.TimeoutExpired(self.args, timeout_s)
        return ready


def run_to_end(*arguments: str) -> subprocess.CompletedProcess[str]:
    """`companion ARGUMENTS`, a command that ends by itself, with what it wrote."""
    copy = Copy(arguments)
    out, errors = ended(copy, "the companion")
    return subprocess.CompletedProcess(copy.args, copy.wait(), out, errors)


def _ready(streams: list[Any], timeout_s: float) -> list[Any]:
    return select.select(streams, (), (), None if timeout_s == math.inf else max(0.0, timeout_s))[0]


@cache
def _fork_server() -> socket.socket:
    """The way to the process that is copied, which lives as long as this one."""
    near, far = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
    with far:
        command = [sys.executable, "-m", "tests.fork_server", str(far.fileno())]
        process = subprocess.Popen(command, cwd=ROOT, pass_fds=[far.fileno()], stdin=subprocess.DEVNULL)
    atexit.register(_end, near, process)
    return near


def _end(way: socket.socket, process: subprocess.Popen[bytes]) -> None:
    way.close()
    process.wait()
