"""CAN ports: within the process, over UDP multicast, and where there is none."""

from __future__ import annotations

import builtins
import os
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest

from companion.core.can_frame import pack, unpack
from companion.io.mavlink.wire.links import LinkError, open_link
from companion.io.transport.line import Line
from companion.io.transport.opener import TransportOpener
from companion.io.transport.urls import PortUrl, TransportError, parse_url
from tests.waiting import wait_until

PORT = 21_000 + os.getpid() % 20_000
VIRTUAL = "can:test?interface=virtual"
MULTICAST = f"can:239.74.163.2:{PORT}?interface=udp_multicast"


@contextmanager
def opened(url: str) -> Iterator[tuple[Line, Line]]:
    ends = TransportOpener().open("one", url), TransportOpener().open("other", url)
    try:
        yield ends
    finally:
        for end in ends:
            end.close()


def test_urls() -> None:
    assert parse_url("can:can0") == PortUrl("can", path="can0")
    assert parse_url(MULTICAST) == PortUrl(
        "can", path="239.74.163.2", port=PORT, options={"interface": "udp_multicast"}
    )
    for url, says in (("can:", "should read can:channel"), ("can:x:70000", "port 70000")):
        with pytest.raises(TransportError, match=says):
            parse_url(url)
    with pytest.raises(TransportError, match="interface should be one of socketcan, udp_multicast, virtual"):
        TransportOpener().open("x", "can:can0?interface=telegraph")
    with pytest.raises(LinkError, match="MAVLink does not go over CAN"):
        open_link("can:can0")


@pytest.mark.parametrize("url", [VIRTUAL, MULTICAST], ids=["in the process", "over UDP multicast"])
def test_frames_cross(url: str) -> None:
    with opened(url) as (one, other):
        assert one.fault() is None, f"{one.fault()}: this machine carries no {url}"
        frames = pack(0x1DF40616, b"12345678") + pack(0x18EAFF32, b"\x01\x02\x03")
        one.write(frames, 0.0)
        received = b""

        def whole() -> bool:
            nonlocal received
            received += b"".join(data for _, data in other.read(0.1))
            return len(received) == len(frames)

        wait_until(whole, "both frames")
        assert unpack(received) == ([(0x1DF40616, b"12345678"), (0x18EAFF32, b"\x01\x02\x03")], 0)
        assert (one.fileno() is None) == ("virtual" in url)


def test_a_flood_is_taken_in_pieces_and_a_half_frame_is_not_sent() -> None:
    with opened(VIRTUAL) as (one, other):
        for _ in range(2000):
            one.write(pack(0x1DF40616, b"x" * 8) + b"half", 0.0)
        first = sum(len(data) for _, data in other.read(0.0))
        assert 0 < first <= 17_408, "one call takes no more than 16 KiB and a chunk"
        rest = sum(len(data) for _ in range(20) for _, data in other.read(0.0))
        assert first + rest == 2000 * 16


def test_without_an_interface_it_says_what_to_do_and_tries_again() -> None:
    line = TransportOpener().open("motors", "can:usv_none0")
    fault = line.fault()
    assert fault is not None and (
        "ip link set usv_none0 up" in fault or "modprobe can_raw" in fault or "udp_multicast" in fault
    ), fault
    line.write(pack(1, b""), 0.1)
    assert line.read(0.2) == () and line.fileno() is None
    line.close()
    assert line.fault() == "closed"


def test_without_the_package_it_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    real = builtins.__import__

    def without(name: str, *arguments: Any, **more: Any) -> Any:
        if name == "can":
            raise ModuleNotFoundError("No module named 'can'", name="can")
        return real(name, *arguments, **more)

    monkeypatch.setattr(builtins, "__import__", without)
    fault = TransportOpener().open("motors", VIRTUAL).fault()
    assert fault is not None and "pip install 'usv-companion[can]'" in fault
