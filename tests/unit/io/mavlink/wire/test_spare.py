"""A client that comes when no descriptor is left is turned away, and the loop does not turn without end."""

from __future__ import annotations

import select
import socket
from collections.abc import Iterator
from typing import Any

import pytest

from companion.io.mavlink.wire.links import TcpServerLink, open_link
from tests.shortage import Shortage
from tests.waiting import CAP_S, wait_until


@pytest.fixture
def link() -> Iterator[Any]:
    made = open_link("tcpin:127.0.0.1:0")
    yield made
    made.close()


def test_without_descriptors_clients_are_turned_away_and_later_they_come_in(link: TcpServerLink) -> None:
    first, second, third = (socket.socket() for _ in range(3))
    with first, second, third:
        with Shortage():
            first.connect(link.address)
            wait_until(lambda: select.select(link.filenos(), (), (), 0)[0], "a client waits")
            assert link.receive(0.0) == [] and list(link.news()) == [
                f"{link.name}: refused a client: no file descriptors left"
            ]
            assert not select.select(link.filenos(), (), (), 0)[0], "nothing is left that would wake the loop"
            first.settimeout(CAP_S)
            assert first.recv(1) == b""
        second.connect(link.address)
        wait_until(lambda: link.receive(1.0) == [] and len(link.endpoints) == 1, "the next one gets in")
        with Shortage():
            third.connect(link.address)
            wait_until(lambda: select.select(link.filenos(), (), (), 0)[0], "another waits")
            link.receive(2.0)
            assert len(link.news()) == 1, "the spare descriptor is there again"
