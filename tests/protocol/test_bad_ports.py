"""A whole companion whose every port misbehaves: it goes on ticking, and says of each what is wrong."""

from __future__ import annotations

import csv
import os
import re
import socket
import threading
import tty
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import common as mavlink

from companion.config.vessel import find
from tests.copies import Copy
from tests.waiting import ended

pytestmark = pytest.mark.process


@contextmanager
def black_hole() -> Iterator[str]:
    """An address at which nobody answers, not even with a refusal: its queue is full."""
    with socket.create_server(("127.0.0.1", 0), backlog=0) as full:
        fill = [socket.socket() for _ in range(4)]
        for each in fill:
            each.setblocking(False)
            each.connect_ex(full.getsockname())
        yield f"tcpout:127.0.0.1:{full.getsockname()[1]}"
        for each in fill:
            each.close()


@contextmanager
def loose_plug(link: Path) -> Iterator[None]:
    """A port that is there for half a second at a time and talks nonsense as fast as it can."""
    stop = threading.Event()

    def wobble() -> None:
        while not stop.is_set():
            master, slave = os.openpty()
            tty.setraw(slave)
            os.set_blocking(master, False)
            link.unlink(missing_ok=True)
            link.symlink_to(os.ttyname(slave))
            os.close(slave)
            for _ in range(25):
                with suppress(OSError):
                    os.write(master, os.urandom(2000))
                if stop.wait(0.02):
                    break
            os.close(master)
            stop.wait(0.2)

    wobbler = threading.Thread(target=wobble)
    wobbler.start()
    try:
        yield
    finally:
        stop.set()
        wobbler.join()


def test_the_loop_goes_on_whatever_the_ports_do(tmp_path: Path) -> None:
    master, deaf = os.openpty()  # whose other end does not read
    tty.setraw(deaf)
    text = find("aboat").read_text(encoding="utf-8")
    with (
        black_hole() as nowhere,
        loose_plug(tmp_path / "plug"),
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as station,
    ):
        station.bind(("127.0.0.1", 0))
        for port, place in (
            ("serial:/dev/usv-gnss:115200", nowhere),
            ("serial:/dev/usv-imu:115200", f"serial:{tmp_path}/plug:115200"),
            ("serial:/dev/usv-wind:4800", "tcpout:127.0.0.1:1"),
            ("serial:/dev/usv-mcu:115200", f"serial:{os.ttyname(deaf)}:115200"),
        ):
            text = text.replace(port, place)
        file = tmp_path / "boat.toml"
        file.write_text(text, encoding="utf-8")
        os.close(deaf)
        both = [
            started(vessel, tmp_path / name, f"udpout:127.0.0.1:{station.getsockname()[1]}")
            for name, vessel in (("ill", str(file)), ("well", "aboat"))
        ]
        (printed, errors), (beside, _) = (ended(process, "the companion") for process in both)
        said = texts(station)
    os.close(master)
    assert both[0].returncode == 0 and not errors, errors
    print(printed, beside)
    file = next((tmp_path / "ill").glob("logs/*/ticks.csv"))
    rows = list(csv.DictReader(file.read_text(encoding="utf-8").splitlines()))
    assert len(rows) == ticks(printed)
    assert len(rows) > 0.7 * ticks(beside), "as many as a boat whose ports are merely not there, at the same time"
    for device, trouble in (
        ("gnss", "(connecting|no answer)"),
        ("wind", "refused; nothing listens there"),
        ("microcontroller", "nothing received yet"),
    ):
        assert re.search(rf"{device}: .*{trouble}", said), said


def started(vessel: str, folder: Path, link: str) -> Copy:
    """`companion run` for eight seconds: the first texts come after five."""
    arguments = ["run", vessel, "--duration", "8", "--link", link]
    return Copy([*arguments, "--state", str(folder / "state"), "--log", str(folder / "logs")])


def ticks(printed: str) -> int:
    """Of a run, by its last line."""
    found = re.search(r"(\d+) ticks: ", printed)
    assert found is not None, printed
    return int(found[1])


def texts(station: socket.socket) -> str:
    """All STATUSTEXTs that have come in, the pieces of each put together again."""
    codec = mavlink.MAVLink(None)
    codec.robust_parsing = True
    station.setblocking(False)
    said = ""
    with suppress(BlockingIOError):
        while True:
            for message in codec.parse_buffer(station.recv(65535)) or ():
                if message.get_type() == "STATUSTEXT":
                    said += ("\n" if message.chunk_seq == 0 else "") + message.text
    return said
