"""What links admit under each policy, and that packets without a valid signature have no effect."""

from __future__ import annotations

import contextlib
import socket
from collections.abc import Iterator
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from companion.io.mavlink.wire.framer import Framer, pack
from companion.io.mavlink.wire.links import Link, MemoryLink, TcpServerLink, UdpLink, open_link
from companion.io.mavlink.wire.signing import SignatureVerdict, Signing, SigningState

KEY, OTHER_KEY = bytes(range(32)), bytes(range(1, 33))
NOW_NS = 1_780_000_000_000_000_000
STAMP = (NOW_NS - 1_420_070_400_000_000_000) // 10_000


def signing(key: bytes | None = KEY) -> Signing:
    return Signing(lambda: NOW_NS, SigningState(key, 0), lambda state: None)


def codec(key: bytes | None = None, system: int = 255) -> Any:
    made = mavlink.MAVLink(None, srcSystem=system, srcComponent=190)
    if key is not None:
        made.signing.secret_key, made.signing.timestamp, made.signing.sign_outgoing = key, STAMP, True
    return made


def heartbeat(by: Any) -> bytes:
    return bytes(mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3).pack(by))


def radio_status(by: Any) -> bytes:
    return bytes(mavlink.MAVLink_radio_status_message(200, 190, 90, 20, 20, 0, 0).pack(by))


@pytest.fixture
def opened() -> Iterator[Any]:
    links: list[Link] = []

    def open_(url: str, key: bytes | None = KEY) -> Any:
        link = open_link(url)
        link.guard.signing = signing(key)
        links.append(link)
        return link

    yield open_
    for link in links:
        link.close()


@pytest.mark.parametrize(
    ("policy", "vessel_key", "admitted"),
    [  # of: unsigned, ours, another key
        ("off", KEY, (True, True, True)),
        ("accept", KEY, (True, True, False)),
        ("accept", None, (True, True, True)),
        ("require", KEY, (False, True, False)),
        ("require", None, (False, False, False)),
    ],
)
def test_policies(opened: Any, policy: str, vessel_key: bytes | None, admitted: tuple[bool, ...]) -> None:
    for by, wanted in zip((codec(), codec(KEY), codec(OTHER_KEY)), admitted, strict=True):
        link: MemoryLink = opened(f"memory:?signing={policy}", vessel_key)
        link.to_vessel(heartbeat(by))
        assert bool(link.receive(5.0)) is wanted
        assert (link.endpoints[0].last_heard_s == 5.0) is wanted
        assert (link.endpoints[0].receptions.of(255, 190) is not None) is wanted
        assert sum(link.guard.refused.values()) == (0 if wanted else 1)


def test_the_modem_needs_no_signature_and_does_not_count_as_heard(opened: Any) -> None:
    link: MemoryLink = opened("memory:?signing=require")
    link.to_vessel(radio_status(codec(system=255)))
    ((_, message),) = link.receive(5.0)
    assert message.get_type() == "RADIO_STATUS"
    assert link.endpoints[0].last_heard_s is None and link.endpoints[0].receptions.of(255, 190) is None


def test_what_is_sent_is_signed_where_the_link_asks_for_it(opened: Any) -> None:
    for policy, signed in (("off", False), ("accept", True), ("require", True)):
        link: MemoryLink = opened(f"memory:?signing={policy}")
        link.guard.number = 7
        (endpoint,) = link.endpoints
        endpoint.send(pack(mavlink.MAVLink_heartbeat_message(11, 12, 0, 0, 4, 3)), 1, 1)
        endpoint.flush(0.0)
        (message,) = Framer().feed(link.from_vessel())
        data = bytes(message.get_msgbuf())
        assert bool(data[2] & 1) is signed
        if signed:
            assert data[-13] == 7 and signing().judge(data) is SignatureVerdict.GENUINE


@pytest.mark.parametrize("elsewhere", ["off", "accept", "require"])
def test_a_packet_heard_on_one_link_does_not_count_again_on_another(opened: Any, elsewhere: str) -> None:
    first, second = opened(f"memory:?signing={elsewhere}"), opened("memory:?signing=require")
    second.guard.signing = first.guard.signing
    overheard = heartbeat(codec(KEY))
    first.to_vessel(overheard)
    second.to_vessel(overheard)
    assert len(first.receive(0.0)) == 1 and second.receive(0.0) == []
    assert second.guard.refused == {SignatureVerdict.STALE: 1}


def test_health_says_what_was_refused_and_that_there_is_no_key(opened: Any) -> None:
    link: MemoryLink = opened("memory:?signing=require")
    assert link.health(0.0).text == "nobody heard yet"
    stranger, peer = codec(OTHER_KEY), codec(KEY)
    genuine = heartbeat(peer)
    link.to_vessel(genuine + genuine + heartbeat(codec()) + heartbeat(codec()) + heartbeat(stranger))
    assert len(link.receive(0.0)) == 1
    health = link.health(0.0)
    assert health.ok and health.text == "4 packets refused: 1 stale, 2 unsigned, 1 forged"
    assert "requires signatures but has no key" in opened("memory:?signing=require", None).health(0.0).text


def test_strangers_take_no_place_on_a_udp_link(opened: Any) -> None:
    """Nor are they told anything; without that, sixteen of them would keep everybody else out."""
    link: UdpLink = opened("udpin:127.0.0.1:0?signing=require")
    strangers = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(20)]
    for stranger in strangers:
        for data in (heartbeat(codec()), heartbeat(codec(OTHER_KEY)), radio_status(codec())):
            stranger.sendto(data, link.address)
    for _ in range(5):
        assert link.receive(0.0) == []
    assert link.endpoints == () and link.guard.refused == {SignatureVerdict.UNSIGNED: 20, SignatureVerdict.FORGED: 20}
    strangers[0].sendto(heartbeat(codec(KEY)), link.address)
    assert len(link.receive(1.0)) == 1 and len(link.endpoints) == 1
    for stranger in strangers:
        stranger.close()


def test_a_tcp_client_without_the_key_is_closed(opened: Any) -> None:
    link: TcpServerLink = opened("tcpin:127.0.0.1:0?signing=require")
    client = socket.create_connection(link.address)
    client.setblocking(False)
    stranger = codec(OTHER_KEY)
    flood = b"".join(heartbeat(stranger) for _ in range(400))
    for _ in range(200):
        with contextlib.suppress(BlockingIOError, ConnectionError):
            client.send(flood)
        assert link.receive(0.0) == []
        if link.guard.refused and not link.endpoints:
            break
    assert link.endpoints == () and any("no valid MAVLink" in text for text in link.news())
    client.close()
