"""Plant and companion as two processes that meet on pseudo-terminals only, and a ground station over UDP that a
`Station` can use."""

from __future__ import annotations

import csv
import select
import signal
import socket
import time
from pathlib import Path
from types import TracebackType
from typing import Any

from companion.config.vessel import VesselConfig, find, load
from tests.copies import Copy
from tests.protocol.driver import Driver
from tests.waiting import ended


class TwoProcesses:
    """`companion sitl VESSEL` and `companion run VESSEL --devices`. It has the face of a `Rig` as far as a `Station`
    looks: times are the boat's.

    With a `driver` both have its time, the plant first; without one, that of the wall.
    """

    def __init__(
        self, folder: Path, vessel: str, driver: Driver | None, *plant: str, links: tuple[str, ...] = ()
    ) -> None:
        self.folder, self.vessel = folder, vessel
        self._driver = driver
        self.config: VesselConfig = load(find(vessel))
        self._extra = plant
        self._links = links  # of the companion, besides the one to this station
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        self._socket.setblocking(False)
        self._peer: Any = None
        self._start_s = 0.0
        self._processes: list[Copy] = []
        self.hello: list[str] = []
        self.said = ""  # what the companion printed at its end

    @property
    def now_s(self) -> float:
        return time.monotonic() - self._start_s if self._driver is None else self._driver.now_s

    def step(self) -> None:
        """A step of the driver; in real time, wait for a packet, at most a twentieth of a second."""
        if self._driver is None:
            select.select([self._socket], [], [], 0.05)
        else:
            self._driver.step()

    def send(self, data: bytes) -> None:
        if self._peer is not None:
            self._socket.sendto(data, self._peer)

    def receive(self) -> bytes:
        data = b""
        try:
            while len(data) < 65536:
                packet, self._peer = self._socket.recvfrom(65535)
                data += packet
        except BlockingIOError:
            pass
        return data

    def type(self, text: str) -> float:
        """On the plant's console; returns the time at which it was typed."""
        stdin = self._processes[0].stdin
        stdin.write(text + "\n")
        stdin.flush()
        return self.now_s

    def events(self) -> list[dict[str, str]]:
        """What the companion has logged so far."""
        file = next((self.folder / "logs").glob("*/events.csv"))
        return list(csv.DictReader(file.read_text(encoding="utf-8").splitlines()))

    def truth(self) -> list[dict[str, float]]:
        """What the plant has logged so far."""
        file = next((self.folder / "plant").glob("*/truth.csv"))
        rows = list(csv.DictReader(file.read_text(encoding="utf-8").splitlines()))
        return [{name: float(value) for name, value in row.items()} for row in rows[:-1]]

    def leader(self) -> list[dict[str, float]]:
        """What the plant has logged of the lead boat so far."""
        file = next((self.folder / "plant").glob("*/leader.csv"))
        rows = list(csv.DictReader(file.read_text(encoding="utf-8").splitlines()))
        return [{name: float(value or "nan") for name, value in row.items()} for row in rows[:-1]]

    def __enter__(self) -> TwoProcesses:
        ports = self.folder / "ports"
        link = f"udpout:127.0.0.1:{self._socket.getsockname()[1]}"
        plant = [
            "sitl",
            self.vessel,
            "--dir",
            str(ports),
            "--log",
            str(self.folder / "plant"),
            *self._extra,
        ]
        boat = ["run", self.vessel, "--devices", str(ports), "--link", link]
        for other in self._links:
            boat += ["--link", other]
        boat += ["--state", str(self.folder / "state"), "--log", str(self.folder / "logs")]
        if self._driver is not None:
            plant.append(self._driver.option())
            boat.append(self._driver.option())
        try:
            both = self._start(plant), self._start(boat)  # either may be first
            self.hello = _lines(both[0], "for: companion run")
            _lines(both[1], "log:")
        except RuntimeError:
            self._end()
            raise
        self._start_s = time.monotonic()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        ends = self._end()
        if kind is None:
            assert all(code == 0 and not errors for code, _, errors in ends), ends
        elif error is not None:
            error.add_note(f"exit code, output and errors of each: {ends}")
        self.said = ends[-1][1]

    def _start(self, arguments: list[str]) -> Copy:
        process = Copy(arguments)
        self._processes.append(process)
        return process

    def _end(self) -> list[tuple[int, str, str]]:
        """Ctrl-C, the companion first. (exit code, stdout, stderr) of each."""
        ends = []
        for process in reversed(self._processes):
            if process.poll() is None:
                process.send_signal(signal.SIGINT)
            if self._driver is not None:
                self._driver.release()
            out, errors = ended(process, " ".join(process.args[3:5]))
            ends.append((process.returncode, out, errors))
        self._socket.close()
        return ends[::-1]


def _lines(process: Copy, until: str) -> list[str]:
    """What it says first. Raises RuntimeError with what it said if it ends instead."""
    lines: list[str] = []
    while not lines or not lines[-1].startswith(until):
        line = process.stdout.readline()
        if not line:
            raise RuntimeError(f"it did not start: {lines} {process.communicate()[1]}")
        lines.append(line.rstrip())
    return lines
