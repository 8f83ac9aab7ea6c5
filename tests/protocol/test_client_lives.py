"""Clients come and go, in order and otherwise: afterwards the boat has as many descriptors, threads and objects as
before."""

from __future__ import annotations

import gc
import resource
import socket
import struct
import sys
import threading
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

from companion.app import Surroundings, build, load_vessel
from companion.clock import SimulatedClock
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.framer import frame, pack
from companion.io.mavlink.wire.links import open_link
from companion.record.state_file import StateFile
from sitl.world import EPOCH_UNIX_NS, World, WorldConditions

HEARTBEAT = mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)
AFTER_S = 16.0  # of the boat's time, in which it forgets who is silent


class Boat:
    """A ReVolt with writers and worker in threads of their own, and links as on a boat."""

    def __init__(self, folder: Path) -> None:
        config = load_vessel("revolt")
        self._world, self._clock = World(config, WorldConditions(seed=5)), SimulatedClock(EPOCH_UNIX_NS)
        self.links: list[Any] = [open_link("tcpin:127.0.0.1:0"), open_link("udpin:127.0.0.1:0")]
        self._state = StateFile(folder / "state")
        world = self._world
        around = Surroundings(self._clock, world, world, self.links, self._state, folder / "logs" / "run", beside=True)
        self.vessel = build(config, around)
        self._ticks = 0
        self._sequence = 0

    def tick(self, count: int = 1) -> None:
        for _ in range(count):
            self._clock.wait(self._ticks * self.vessel.period_s, ())
            self.vessel.tick(self._clock.now_s())
            self._ticks += 1

    def framed(self, *messages: Any) -> bytes:
        out = b""
        for message in messages:
            self._sequence = self._sequence + 1 & 0xFF
            out += frame(pack(message), self._sequence, 100 + self._sequence % 100, 190)
        return out

    def close(self) -> None:
        self.vessel.close()
        self._state.close()


def ftp(opcode: int, data: bytes = b"", offset: int = 0, size: int | None = None, number: int = 1) -> Any:
    head = struct.pack("<HBBBBBBI", number, 0, opcode, len(data) if size is None else size, 0, 0, 0, offset)
    payload = (head + data).ljust(251, b"\0")
    return mavlink.MAVLink_file_transfer_protocol_message(0, 1, 1, list(payload))


def item(seq: int) -> Any:
    return mavlink.MAVLink_mission_item_int_message(
        1, 1, seq, 3, 16, 0, 1, 0, 0, 0, 0, 634_400_000 + 1000 * seq, 103_990_000, 0, 0
    )


def over_tcp(boat: Boat, *steps: bytes, vanish: bool = False) -> None:
    """Connect, send each of `steps` before the boat's next tick, and hang up; `vanish`: with a reset."""
    with socket.create_connection(boat.links[0].address) as client:
        client.setblocking(False)
        for step in steps:
            client.send(step)
            boat.tick()
            try:
                client.recv(1 << 20)
            except BlockingIOError:
                continue
        if vanish:
            client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    boat.tick()


def over_udp(boat: Boat, *steps: bytes) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as client:
        client.bind(("127.0.0.1", 0))
        for step in steps:
            client.sendto(step, boat.links[1].address)
            boat.tick()


def tcp(boat: Boat) -> None:
    hello = boat.framed(HEARTBEAT, mavlink.MAVLink_param_request_list_message(1, 1))
    over_tcp(boat, hello, boat.framed(HEARTBEAT))


def udp(boat: Boat) -> None:
    hello = boat.framed(HEARTBEAT, mavlink.MAVLink_param_request_list_message(1, 1))
    over_udp(boat, hello, boat.framed(mavlink.MAVLink_mission_request_list_message(1, 1, 0)))


def ftp_open(boat: Boat) -> None:
    """Opens a log and a description, reads a part, and is gone; the second open is under way."""
    opened = boat.framed(ftp(4, b"logs/run/telemetry.tlog")), boat.framed(ftp(5, size=200, number=2))
    over_tcp(boat, *opened, boat.framed(ftp(15, size=239, number=3), ftp(4, b"logs/run/manifest.json", number=4)))


def log_download(boat: Boat) -> None:
    """Asks for a log several times before the disk has answered, and is gone in the middle."""
    wanted = [mavlink.MAVLink_log_request_data_message(1, 1, 0, at, 90 * 512) for at in (0, 9000, 0)]
    over_tcp(boat, boat.framed(mavlink.MAVLink_log_request_list_message(1, 1, 0, 0xFFFF)), boat.framed(*wanted))


def half_upload(boat: Boat) -> None:
    begun = mavlink.MAVLink_mission_count_message(1, 1, 9, 0), mavlink.MAVLink_mission_count_message(1, 1, 5, 1)
    over_tcp(boat, boat.framed(*begun), boat.framed(item(0), item(1)), vanish=True)


def upload(boat: Boat) -> None:
    over_tcp(boat, boat.framed(mavlink.MAVLink_mission_count_message(1, 1, 1, 0)), boat.framed(item(0)))


def shell(boat: Boat) -> None:
    asked = list(b"help\n".ljust(70, b"\0"))
    over_tcp(boat, boat.framed(mavlink.MAVLink_serial_control_message(10, 6, 0, 0, 5, asked)), vanish=True)


def mid_frame(boat: Boat) -> None:
    whole = boat.framed(HEARTBEAT, item(0))
    over_tcp(boat, whole[:-7], vanish=True)
    over_udp(boat, whole[:-7])


def stranger(boat: Boat) -> None:
    over_tcp(boat, b"GET / HTTP/1.1\r\nHost: boat\r\n\r\n" * 50)


LIVES: Mapping[str, Callable[[Boat], None]] = {
    life.__name__: life for life in (tcp, udp, ftp_open, log_download, half_upload, upload, shell, mid_frame, stranger)
}


def descriptors() -> int:
    return sum(1 for _ in Path("/proc/self/fd").iterdir())


def counts() -> dict[str, int]:
    """What could grow: descriptors, threads, and objects of the boat's own classes."""
    gc.collect()
    objects = sum(1 for one in gc.get_objects() if str(type(one).__module__).startswith("companion"))
    return {"descriptors": descriptors(), "threads": threading.active_count(), "objects": objects}


def settled(boat: Boat) -> dict[str, int]:
    boat.tick(round(AFTER_S / boat.vessel.period_s))
    return counts()


@pytest.fixture
def boat(tmp_path: Path) -> Iterator[Boat]:
    made = Boat(tmp_path)
    made.tick(20)
    yield made
    made.close()


def judge(before: dict[str, int], after: dict[str, int]) -> None:
    assert after["descriptors"] <= before["descriptors"], (before, after)
    assert after["threads"] <= before["threads"], (before, after)
    assert after["objects"] <= before["objects"] + 60, (before, after)  # the newest tick and its events vary


def test_a_few_of_each_kind_leave_nothing_behind(boat: Boat) -> None:
    for life in LIVES.values():
        life(boat)
    before = settled(boat)
    for life in LIVES.values():
        life(boat)
    judge(before, settled(boat))


@pytest.mark.sweep
def test_ten_thousand_leave_nothing_behind(boat: Boat) -> None:
    each = 10_000 // len(LIVES) + 1
    for life in LIVES.values():
        for _ in range(20):
            life(boat)
    before, begin_kb = settled(boat), peak_kb()
    print("before", before, f"{begin_kb} kB", flush=True)
    for name, life in LIVES.items():
        for _ in range(each):
            life(boat)
        print(name, each, "lives:", settled(boat), f"{peak_kb()} kB", flush=True)
    judge(before, settled(boat))
    assert peak_kb() - begin_kb < 8_000


def peak_kb() -> int:
    size = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return size if sys.platform == "linux" else size // 1024
