"""Broken frames on every kind of link: nothing raises, and the next good frame is heard."""

from __future__ import annotations

import contextlib
import os
import socket
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.framer import frame, pack
from companion.io.mavlink.wire.links import Link, open_link
from tests.protocol.process import free_port
from tests.protocol.test_bad_input import broken_frames

GOOD = frame(pack(mavlink.MAVLink_ping_message(424242, 7, 0, 0)), 1, 255, 190)
FRAMES = 25_000  # on each of the four kinds

Send = Callable[[bytes], Any]


@contextlib.contextmanager
def udp(scheme: str) -> Iterator[tuple[Link, Send]]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as peer:
        peer.bind(("127.0.0.1", 0))
        port = free_port() if scheme == "udpin" else peer.getsockname()[1]
        link = open_link(f"{scheme}:127.0.0.1:{port}")
        try:
            if scheme == "udpout":
                link.endpoints[0].send_bytes(GOOD)
                link.endpoints[0].flush(0.0)
                address = peer.recvfrom(65535)[1]
            else:
                address = link.address  # type: ignore[attr-defined]
            yield link, lambda data: peer.sendto(data, address)
        finally:
            link.close()


@contextlib.contextmanager
def tcp(scheme: str) -> Iterator[tuple[Link, Send]]:
    link = open_link(f"{scheme}:127.0.0.1:{free_port(socket.SOCK_STREAM)}")
    try:
        with socket.create_connection(link.address) as client:  # type: ignore[attr-defined]
            yield link, client.sendall
    finally:
        link.close()


@contextlib.contextmanager
def pty(scheme: str) -> Iterator[tuple[Link, Send]]:
    ours, theirs = os.openpty()
    link = open_link(f"{scheme}:{os.ttyname(theirs)}:115200")
    try:
        yield link, lambda data: os.write(ours, data)
    finally:
        link.close()
        os.close(ours)
        os.close(theirs)


@pytest.mark.parametrize(
    ("opened", "scheme"),
    [(udp, "udpin"), (udp, "udpout"), (tcp, "tcpin"), (pty, "serial")],
    ids=["udpin", "udpout", "tcpin", "serial"],
)
def test_broken_frames_cost_nothing_but_themselves(opened: Callable[[str], Any], scheme: str) -> None:
    with opened(scheme) as (link, send):
        now_s = 0.0
        batch = b""
        for n, data in enumerate(broken_frames(7, FRAMES)):
            batch += data
            if n % 20 == 19:
                send(batch if n % 400 != 399 else batch + GOOD)  # who never sends a good frame is hung up on
                batch = b""
                now_s += 0.001
                link.receive(now_s)
        heard: list[Any] = []
        for _ in range(200):
            send(GOOD)
            now_s += 0.5
            heard += [m for _, m in link.receive(now_s) if m.get_type() == "PING" and m.time_usec == 424242]
            if heard:
                break
        assert heard, f"{scheme}: a good frame was not heard after the bad ones"
        assert link.health(now_s).name
