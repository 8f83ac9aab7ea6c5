"""The companion as a process of its own, for clients that we did not write."""

from __future__ import annotations

import contextlib
import csv
import os
import signal
import socket
import subprocess
import sys
import weakref
from pathlib import Path
from types import TracebackType

from tests.copies import Copy
from tests.protocol.driver import Driver
from tests.waiting import ended, wait_until


def free_port(kind: int = socket.SOCK_DGRAM) -> int:
    """A port that nobody uses now."""
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class Companion:
    """`companion run VESSEL --sitl`, or of a `vessel` that is a file without the plant, on free ports: UDP towards
    `udp_port`, TCP listening on `tcp_port`.

    With a `driver` its time is the test's, else that of the wall, `speed` times as fast. It begins as a copy of a process
    that has loaded its modules; `anew`, or `within` a command that runs this one, as that of an `Island`, as
    `python -m companion`.
    """

    def __init__(
        self,
        folder: Path,
        speed: float = 1.0,
        extra: tuple[str, ...] = (),
        links: tuple[str, ...] | None = None,
        vessel: str | Path = "revolt",
        driver: Driver | None = None,
        within: tuple[str, ...] = (),
        anew: bool = False,
    ) -> None:
        taken = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        taken.bind(("127.0.0.1", 0))
        self._udp_port = int(taken.getsockname()[1])
        self._give_up_port = weakref.finalize(self, taken.close)
        self.tcp_port = free_port(socket.SOCK_STREAM)
        self.folder = folder
        self.links = (
            links if links is not None else (f"udpout:127.0.0.1:{self._udp_port}", f"tcpin:127.0.0.1:{self.tcp_port}")
        )
        self._driver = driver
        self._within = within
        self._anew = anew or bool(within)
        self._what = (str(vessel),) if isinstance(vessel, Path) else (vessel, "--sitl", f"--speed={speed}")
        self.extra = extra
        self.process: subprocess.Popen[str] | Copy | None = None
        self.hello: list[str] = []

    def start(self) -> Companion:
        """Returns when the process has said its first lines. Raises RuntimeError with what it said if it ends
        instead."""
        arguments = ["run", *self._what]
        arguments += [f"--state={self.folder / 'state'}", f"--log={self.folder / 'logs'}", *self.extra]
        for link in self.links:
            arguments += ["--link", link]
        if self._driver is not None:
            arguments.append(self._driver.option())
        self.process = self._begun(arguments)
        self.hello = self.read_hello()
        return self

    def _begun(self, arguments: list[str]) -> subprocess.Popen[str] | Copy:
        if not self._anew:
            return Copy(arguments)
        return subprocess.Popen(
            [*self._within, sys.executable, "-m", "companion", *arguments],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, "PYTHONUNBUFFERED": "1"},
        )

    def read_hello(self) -> list[str]:
        """The first lines of the process, or of one that has begun anew in its place."""
        assert self.process is not None and self.process.stdout is not None
        hello: list[str] = []
        while len(hello) < 4:
            line = self.process.stdout.readline()
            if not line:
                raise RuntimeError(f"the companion did not start: {hello} {self.stop()}")
            if hello or line.startswith("USV companion"):  # before it: events of the run that ended
                hello.append(line.strip())
        return hello

    @property
    def udp_port(self) -> int:
        """Where it sends to. Kept from other programs until a test asks for it: whoever listened there would be heard
        as a ground station."""
        self._give_up_port()
        return self._udp_port

    @property
    def log_folder(self) -> Path:
        return Path(self.hello[3].removeprefix("log:").strip())

    def rows(self, name: str = "ticks.csv") -> list[dict[str, str]]:
        """What the log has by now, whole rows only."""
        file = self.log_folder / name
        lines = file.read_text(encoding="utf-8").splitlines(keepends=True) if file.exists() else []
        return list(csv.DictReader(line for line in lines if line.endswith("\n")))

    @property
    def now_s(self) -> float:
        """The boat's time, by its log; that of a driver without a look into it."""
        if self._driver is not None:
            return self._driver.now_s
        last = (self.log_folder / "ticks.csv").read_bytes().rpartition(b"\n")[0].rpartition(b"\n")[2].partition(b",")[0]
        return float(last) if last and last != b"t_s" else 0.0

    def sail(self, duration_s: float) -> None:
        """Until so much of the boat's time has passed."""
        if self._driver is not None:
            self._driver.run(duration_s)
            return
        end_s = self.now_s + duration_s
        wait_until(lambda: self.now_s >= end_s, f"{duration_s:g} s of the boat's time")

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
        if self._driver is not None:
            self._driver.release()
        _, errors = ended(self.process, "the companion")
        return self.process.returncode, errors

    def __enter__(self) -> Companion:
        return self.start()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self.process is not None and self.process.poll() is None:
            if kind is None:
                code, errors = self.stop()
                assert code == 0 and not errors, f"exit code {code}: {errors}"
            else:
                with contextlib.suppress(AssertionError):
                    self.stop()
