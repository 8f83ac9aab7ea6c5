"""A whole companion whose every port misbehaves: it goes on ticking, and says of each what is wrong."""

from __future__ import annotations

import csv
import os
import re
import socket
import subprocess
import sys
import threading
import time
import tty
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import common as mavlink

from companion.config import find

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
    with black_hole() as nowhere, loose_plug(tmp_path / "plug"), socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as station:
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
        command = [sys.executable, "-m", "companion", "run", str(file), "--duration", "5", "--link", f"udpout:127.0.0.1:{station.getsockname()[1]}"]
        command += ["--state", str(tmp_path / "state"), "--log", str(tmp_path / "logs")]
        done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
        said = texts(station)
    os.close(master)
    assert done.returncode == 0 and not done.stderr, done.stderr
    print(done.stdout)
    found = re.search(r"(\d+) ticks, .*, (\d+) left out", done.stdout)
    assert found is not None and int(found[1]) >= 45 and int(found[2]) <= 3, done.stdout
    rows = list(csv.DictReader(next((tmp_path / "logs").glob("*/ticks.csv")).read_text(encoding="utf-8").splitlines()))
    assert len(rows) == int(found[1])
    for device, trouble in (("gnss", "connecting"), ("wind", "refused; nothing listens there"), ("microcontroller", "nothing received yet")):
        assert re.search(rf"{device}: .*{trouble}", said), said


def texts(station: socket.socket) -> str:
    """All STATUSTEXTs that have come in, the pieces of each put together again."""
    codec = mavlink.MAVLink(None)
    codec.robust_parsing = True
    station.setblocking(False)
    said, end_s = "", time.monotonic() + 5.0
    with suppress(BlockingIOError):
        while time.monotonic() < end_s:
            for message in codec.parse_buffer(station.recv(65535)) or ():
                if message.get_type() == "STATUSTEXT":
                    said += ("\n" if message.chunk_seq == 0 else "") + message.text
    return said
