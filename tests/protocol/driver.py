"""The time of processes that were started with `--clock`: they stand still between two steps of the test, so that a
slow machine makes a slow test and nothing else."""

from __future__ import annotations

import os
import select
import socket
import tty
from collections.abc import Callable
from typing import Any

from tests.waiting import CAP_S


def raw_pty() -> tuple[int, int]:
    """Both ends of a pseudo-terminal that changes no byte."""
    ends = os.openpty()
    for end in ends:
        tty.setraw(end)
    return ends


class Driver:
    """Grants time, in the boat's seconds. The processes are moved one after the other, in the order in which they were
    added with `option()`.

    A message that was sent before a step has been heard in it, and what a process sends in a step can be read after it.
    """

    def __init__(self, step_s: float = 0.1) -> None:
        self.now_s = 0.0
        self.step_s = step_s
        self.between: list[Callable[[float], object]] = []  # called with the time before each step
        self._probe = raw_pty()
        self._waiting: list[socket.socket] = []
        self._driven: list[socket.socket] = []

    def option(self) -> str:
        """The command line's part, for one process more."""
        listener = socket.create_server(("127.0.0.1", 0))
        listener.settimeout(CAP_S)
        self._waiting.append(listener)
        return f"--clock=127.0.0.1:{listener.getsockname()[1]}"

    def step(self) -> None:
        """All processes go on by `step_s`."""
        self._meet()
        for action in self.between:
            action(self.now_s)
        self._settle()
        self.now_s = round(self.now_s + self.step_s, 6)
        for process in self._driven:
            process.sendall(b"%r\n" % self.now_s)
            answer = b""
            while not answer.endswith(b"\n"):
                data = process.recv(4096)
                assert data, f"a process ended while it was driven, at {self.now_s:g} s"
                answer += data
            assert float(answer) == self.now_s
            self._settle()

    def _settle(self) -> None:
        """Until what was written to pseudo-terminals can be read: the kernel carries it in a queue of work, in which
        a byte of ours comes after it."""
        near, far = self._probe
        os.write(near, b"x")
        assert select.select([far], [], [], CAP_S)[0]
        os.read(far, 16)

    def run(self, duration_s: float) -> None:
        for _ in range(round(duration_s / self.step_s)):
            self.step()

    def until(self, what: str, condition: Callable[[], Any], within_s: float = 60.0) -> None:
        """Step until `condition()`. Fails when it takes longer than `within_s` of the boat's time."""
        end_s = self.now_s + within_s
        while not condition():
            assert self.now_s < end_s, f"{what}: not within {within_s:g} s of the boat's time"
            self.step()

    def release(self) -> None:
        """Let go of all processes: their time goes on by the wall clock, which is how they end."""
        for end in (*self._driven, *self._waiting):
            end.close()
        self._driven, self._waiting = [], []

    def __del__(self) -> None:
        for end in self._probe:
            os.close(end)

    def _meet(self) -> None:
        """The processes that have just been started."""
        for listener in self._waiting:
            connection, _ = listener.accept()
            listener.close()
            connection.settimeout(CAP_S)
            connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._driven.append(connection)
        self._waiting = []
