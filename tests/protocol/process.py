"""The companion as a process of its own, for clients that we did not write."""

from __future__ import annotations

import contextlib
import os
import signal
import socket
import subprocess
import sys
from pathlib import Path
from types import TracebackType


def free_port(kind: int = socket.SOCK_DGRAM) -> int:
    """A port that nobody uses now."""
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class Companion:
    """`companion run revolt --sitl`, or of another `vessel` without the plant, on free ports: UDP towards `udp_port`, TCP listening on `tcp_port`."""

    def __init__(
        self, folder: Path, speed: float = 1.0, extra: tuple[str, ...] = (), links: tuple[str, ...] | None = None, vessel: Path | None = None
    ) -> None:
        self.udp_port = free_port()
        self.tcp_port = free_port(socket.SOCK_STREAM)
        self.folder = folder
        self._links = links if links is not None else (f"udpout:127.0.0.1:{self.udp_port}", f"tcpin:127.0.0.1:{self.tcp_port}")
        self._what = ("revolt", "--sitl", f"--speed={speed}") if vessel is None else (str(vessel),)
        self.extra = extra
        self.process: subprocess.Popen[str] | None = None
        self.hello: list[str] = []

    def start(self) -> Companion:
        """Returns when the process has said its first lines. Raises RuntimeError with what it said if it ends instead."""
        command = [sys.executable, "-m", "companion", "run", *self._what]
        command += [f"--state={self.folder / 'state'}", f"--log={self.folder / 'logs'}", *self.extra]
        for link in self._links:
            command += ["--link", link]
        environment = {**os.environ, "PYTHONUNBUFFERED": "1"}
        self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment)
        assert self.process.stdout is not None
        self.hello = []
        while len(self.hello) < 4:
            line = self.process.stdout.readline()
            if not line:
                raise RuntimeError(f"the companion did not start: {self.hello} {self.stop()}")
            self.hello.append(line.strip())
        return self

    @property
    def log_folder(self) -> Path:
        return Path(self.hello[3].removeprefix("log:").strip())

    def kill(self) -> None:
        """As a power cut: no handler of ours runs."""
        assert self.process is not None
        self.process.send_signal(signal.SIGKILL)
        self.process.communicate()

    def stop(self) -> tuple[int, str]:
        """Ctrl-C. Returns the exit code and what went to stderr."""
        assert self.process is not None
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        try:
            _, errors = self.process.communicate(timeout=15.0)
        except subprocess.TimeoutExpired:
            self.process.kill()
            _, errors = self.process.communicate()
            raise RuntimeError(f"the companion did not end: {errors}") from None
        return self.process.returncode, errors

    def __enter__(self) -> Companion:
        return self.start()

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if self.process is not None and self.process.poll() is None:
            if kind is None:
                code, errors = self.stop()
                assert code == 0 and not errors, f"exit code {code}: {errors}"
            else:
                with contextlib.suppress(RuntimeError):
                    self.stop()
