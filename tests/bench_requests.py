"""The part of `make bench` that a ground station waits for: start, uploads and commands."""

from __future__ import annotations

import os
import socket
import statistics
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import common as mavlink

from tests.bench_console import Line
from tests.protocol.process import Companion

REQUEST, ACK = mavlink.MAVLINK_MSG_ID_MISSION_REQUEST_INT, mavlink.MAVLINK_MSG_ID_MISSION_ACK


def median_and_range(values: list[float], form: str) -> str:
    """`median (smallest to largest)`."""
    return f"{statistics.median(values):{form}} ({min(values):{form}}…{max(values):{form}})"


def mission_items(count: int) -> list[Any]:
    """Waypoints, as many as a mission may have at most."""
    return [
        mavlink.MAVLink_mission_item_int_message(
            1, 1, seq, 3, 16, 0, 1, 0.0, 0.0, 0.0, float("nan"), 634389000 + seq, 103990000 + 37 * (seq % 100), 0.0
        )
        for seq in range(min(count, 10_000))
    ]


def frames(datagram: bytes) -> Iterator[tuple[int, bytes]]:
    """(number of the message, its content) of each MAVLink 2 frame of a datagram."""
    at = 0
    while at < len(datagram):
        size, signed = datagram[at + 1], datagram[at + 2] & 1
        yield int.from_bytes(datagram[at + 7 : at + 10], "little"), datagram[at + 10 : at + 10 + size]
        at += 12 + size + 13 * signed


class Client:
    """A ground station on UDP, with pymavlink."""

    def __init__(self, companion: Companion) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", companion.udp_port))
        self._socket.settimeout(2.0)
        self._vehicle: Any = None
        self._codec = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)
        self._codec.robust_parsing = True

    def send(self, message: Any) -> None:
        """Send a message."""
        self._socket.sendto(message.pack(self._codec), self._vehicle)
        self._codec.seq = (self._codec.seq + 1) % 256

    def wait_for(self, *kinds: str) -> Any:
        """The next message of a type."""
        while True:
            data, self._vehicle = self._socket.recvfrom(65535)
            for message in self._codec.parse_buffer(data) or ():
                if message.get_type() in kinds:
                    return message

    def upload(self, count: int) -> tuple[int, float]:
        """(MAV_MISSION_RESULT, seconds)."""
        items = mission_items(count)
        started_s = time.perf_counter()
        self.send(mavlink.MAVLink_mission_count_message(1, 1, count))
        while True:
            message = self.wait_for("MISSION_REQUEST_INT", "MISSION_ACK")
            if message.get_type() == "MISSION_ACK":
                return message.type, time.perf_counter() - started_s
            self.send(items[message.seq])

    def upload_packed(self, count: int) -> float:
        """As `upload`, all packed beforehand and read without pymavlink, whose own time is most of the wait; returns
        seconds."""
        packed = [item.pack(self._codec) for item in mission_items(count)]
        begin = mavlink.MAVLink_mission_count_message(1, 1, count).pack(self._codec)
        started_s = time.perf_counter()
        self._socket.sendto(begin, self._vehicle)
        while True:
            for number, content in frames(self._socket.recv(65535)):
                if number == REQUEST:  # zeros at the end of a content are not sent
                    self._socket.sendto(packed[int.from_bytes(content[:2], "little")], self._vehicle)
                elif number == ACK:
                    return time.perf_counter() - started_s

    def refusal_time_s(self) -> float:
        """Time from sending an unknown command to its acknowledgement."""
        started_s = time.perf_counter()
        self.send(mavlink.MAVLink_command_long_message(1, 1, 35, 0, 0, 0, 0, 0, 0, 0, 0))
        self.wait_for("COMMAND_ACK")
        return time.perf_counter() - started_s

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


def start_up(folder: Path, line: Line, runs: int = 7) -> None:
    """Time from the start of the process to its first HEARTBEAT."""
    times_s = []
    for n in range(runs):
        companion = Companion(folder / f"start{n}", anew=True)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
            listener.bind(("127.0.0.1", companion.udp_port))
            listener.settimeout(20.0)
            codec = mavlink.MAVLink(None)
            codec.robust_parsing = True
            started_s = time.perf_counter()
            with companion:
                while not any(m.get_type() == "HEARTBEAT" for m in codec.parse_buffer(listener.recv(65535)) or ()):
                    pass
                times_s.append(time.perf_counter() - started_s)
    line("process start to first HEARTBEAT", median_and_range(times_s, ".2f") + " s", "0.35 s")


def transfers(folder: Path, line: Line) -> None:
    """Speed of mission uploads and commands; processor and memory of the process."""
    with Companion(folder / "transfers", anew=True) as companion:
        client = Client(companion)
        client.wait_for("HEARTBEAT")
        rates = []
        for _ in range(5):
            result, took_s = client.upload(2000)
            assert result == mavlink.MAV_MISSION_ACCEPTED
            rates.append(2000 / took_s)
        line(
            "mission upload over UDP loopback, pymavlink client",
            median_and_range(rates, ".0f") + " items/s",
            "10000 items/s",
        )
        line(
            "the same, client that has packed them before",
            median_and_range([2000 / client.upload_packed(2000) for _ in range(5)], ".0f") + " items/s",
            "10000 items/s",
        )
        waits_s = sorted(client.refusal_time_s() for _ in range(500))
        text = f"median {1e3 * statistics.median(waits_s):.2f} ms, p99 {1e3 * waits_s[494]:.2f} ms"
        line("unknown command to its UNSUPPORTED", text, "under 10 ms")
        result, took_s = client.upload(10_000)
        line("largest mission accepted", f"10000: result {result}, {took_s:.1f} s", "10000 items")
        result, _ = client.upload(20_000)
        line("  20000 items", f"refused with {result} (NO_SPACE is 4)", "refused")
        assert companion.process is not None
        before_s, wall_s = cpu_s(companion.process.pid), time.perf_counter()
        time.sleep(10.0)
        share = (cpu_s(companion.process.pid) - before_s) / (time.perf_counter() - wall_s)
        line("whole process with plant, real time, one ground station", f"{100 * share:.1f} % of a core", "-")
        line("peak memory of that process", f"{peak_mb(companion.process.pid):.0f} MB", "110 MB")
        client.close()


def cpu_s(pid: int) -> float:
    """Processor time of a process."""
    fields = Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def peak_mb(pid: int) -> float:
    """Peak memory of a process."""
    status = Path(f"/proc/{pid}/status").read_text()
    return next(int(row.split()[1]) / 1024 for row in status.splitlines() if row.startswith("VmHWM"))
