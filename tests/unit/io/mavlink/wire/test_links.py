from __future__ import annotations

import os
import pty
import select
import socket
import struct
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.endpoint import DATAGRAM_BYTES, Endpoint
from companion.io.mavlink.wire.framer import Framer, frame, pack
from companion.io.mavlink.wire.links import (
    PEER_TIMEOUT_S,
    SILENCE_S,
    LinkError,
    MemoryLink,
    StreamLink,
    TcpServerLink,
    UdpLink,
    open_link,
    open_links,
)
from tests.waiting import CAP_S, wait_until

HEARTBEAT = mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)
PACKED = pack(HEARTBEAT)
BYTES = frame(PACKED, 0, 255, 190)
LONG = pack(mavlink.MAVLink_file_transfer_protocol_message(0, 1, 1, [255] * 251))


@pytest.fixture
def opened() -> Iterator[Callable[[str], Any]]:
    links: list[Any] = []

    def open_(url: str) -> Any:
        links.append(open_link(url))
        return links[-1]

    yield open_
    for link in links:
        link.close()


@pytest.fixture
def sockets() -> Iterator[Callable[[int], socket.socket]]:
    made: list[socket.socket] = []

    def make(kind: int) -> socket.socket:
        made.append(socket.socket(socket.AF_INET, kind))
        made[-1].settimeout(CAP_S)
        if kind == socket.SOCK_DGRAM:
            made[-1].bind(("127.0.0.1", 0))
        return made[-1]

    yield make
    for one in made:
        one.close()


def until(what: Callable[[], Any]) -> Any:
    """Loopback delivers soon."""
    return wait_until(what, "something comes over loopback")


# --- URLs ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("url", "says"),
    [
        ("ftp:127.0.0.1:1", "should begin with one of"),
        ("udp:127.0.0.1:1", "serial:, udpin:, udpout:, tcpin:, tcpout:; udpout: sends to that address"),
        ("can:can0", "MAVLink does not go over CAN"),
        ("udpin:127.0.0.1", "should read udpin:host:port"),
        ("udpin:127.0.0.1:99999", "0 to 65535"),
        ("udpin:127.0.0.1:0?dialect=klingon", "px4, ardupilot, generic"),
        ("udpin:127.0.0.1:0?colour=red", "unknown option 'colour'"),
        ("udpin:127.0.0.1:0?signing=maybe", "off, accept, require"),
        ("memory:?trusted=1", "trusted should be one of yes, no"),
        ("memory:?dialect=klingon", "px4, ardupilot, generic"),
        ("udpin:192.0.2.1:0", "no such address"),
        ("udpin:no.such.host.invalid:14550", "not found"),
    ],
)
def test_urls_that_cannot_be_used_say_why(url: str, says: str) -> None:
    with pytest.raises(LinkError, match=says) as refusal:
        open_link(url)
    assert "\n" not in str(refusal.value)


@pytest.mark.parametrize(("scheme", "kind"), [("udpin", socket.SOCK_DGRAM), ("tcpin", socket.SOCK_STREAM)])
def test_a_port_in_use_says_what_to_do(sockets: Any, scheme: str, kind: int) -> None:
    other = sockets(kind)
    if kind == socket.SOCK_STREAM:
        other.bind(("127.0.0.1", 0))
        other.listen()
    with pytest.raises(LinkError, match="port in use; stop the program"):
        open_link(f"{scheme}:127.0.0.1:{other.getsockname()[1]}")


def test_a_default_link_whose_port_is_taken_is_left_out_and_that_is_told(sockets: Any) -> None:
    other = sockets(socket.SOCK_STREAM)
    other.bind(("127.0.0.1", 0))
    other.listen()
    taken = f"tcpin:127.0.0.1:{other.getsockname()[1]}?dialect=ardupilot"
    told: list[str] = []
    links = open_links(["udpout:127.0.0.1:14599", "tcpin:127.0.0.1:0", taken], warn=told.append)
    assert [link.name for link in links] == ["udpout:127.0.0.1:14599", "tcpin:127.0.0.1:0"]
    assert len(told) == 1 and taken in told[0] and "going on without it" in told[0]
    for link in links:
        link.close()
    with pytest.raises(LinkError, match="port in use"):
        open_links(["tcpin:127.0.0.1:0", taken])  # one that was asked for
    with pytest.raises(LinkError, match="port in use"):
        open_links(["udpout:127.0.0.1:14599", taken], warn=told.append)  # a second companion: no server is left


@pytest.mark.parametrize(
    "url",
    ["udpin:127.0.0.1:0", "udpout:127.0.0.1:14599", "memory:test", "tcpout:127.0.0.1:9", "serial:/dev/no-such:57600"],
)
def test_the_persona_belongs_to_the_link(opened: Any, url: str) -> None:
    endpoint = getattr(opened(f"{url}?dialect=ardupilot"), "_endpoint", None)
    if isinstance(endpoint, Endpoint):
        assert endpoint.persona.name == "ardupilot"
    assert opened(url).health(0.0).name == url


@pytest.mark.parametrize(
    "url",
    ["udpin:127.0.0.1:0", "udpout:127.0.0.1:14599", "memory:test", "tcpout:127.0.0.1:9", "serial:/dev/no-such:57600"],
)
def test_what_is_streamed_belongs_to_the_link(opened: Any, url: str) -> None:
    for option, telemetry in (
        ("?telemetry=leader", "leader"),
        ("?dialect=ardupilot&telemetry=all", "all"),
        ("", "all"),
    ):
        link = opened(url + option)
        endpoint = getattr(link, "_endpoint", None)
        if isinstance(endpoint, Endpoint):
            assert endpoint.telemetry == telemetry
        link.close()
    with pytest.raises(LinkError, match="telemetry should be one of all, leader"):
        opened(f"{url}?telemetry=some")


# --- UDP -----------------------------------------------------------------------------------------------------------


def test_udpout_writes_first_and_hears_the_answer(opened: Any, sockets: Any) -> None:
    station = sockets(socket.SOCK_DGRAM)
    link: UdpLink = opened(f"udpout:127.0.0.1:{station.getsockname()[1]}")
    (endpoint,) = link.endpoints
    endpoint.send(PACKED, 1, 1)
    endpoint.flush(0.0)
    data, address = station.recvfrom(2048)
    assert [m.get_type() for m in Framer().feed(data)] == ["HEARTBEAT"]
    station.sendto(BYTES, address)
    ((source, message),) = until(lambda: link.receive(1.0))
    assert source is endpoint
    assert message.get_srcSystem() == 255
    assert endpoint.last_heard_s == 1.0


def test_udpout_answers_others_too_and_forgets_them_only(opened: Any, sockets: Any) -> None:
    station, other = sockets(socket.SOCK_DGRAM), sockets(socket.SOCK_DGRAM)
    link: UdpLink = opened(f"udpout:127.0.0.1:{station.getsockname()[1]}")
    link.endpoints[0].send(PACKED, 1, 1)
    link.endpoints[0].flush(0.0)
    _, address = station.recvfrom(2048)
    other.sendto(BYTES, address)
    ((source, _),) = until(lambda: link.receive(1.0))
    assert len(link.endpoints) == 2
    source.send(PACKED, 1, 1)
    source.flush(1.0)
    assert other.recvfrom(2048)[0]
    link.receive(1.0 + PEER_TIMEOUT_S + 0.1)
    assert len(link.endpoints) == 1
    assert source.gone


def test_udpin_learns_peers_from_valid_packets_only(opened: Any, sockets: Any) -> None:
    link: UdpLink = opened("udpin:127.0.0.1:0")
    station = sockets(socket.SOCK_DGRAM)
    station.sendto(b"GET / HTTP/1.1\r\n\r\n\xfd\x05", link.address)
    station.sendto(BYTES[:-3], link.address)
    for _ in range(200):
        assert link.receive(0.0) == []
    assert link.endpoints == ()
    station.sendto(BYTES + BYTES, link.address)
    assert len(until(lambda: link.receive(0.0))) == 2
    (endpoint,) = link.endpoints
    endpoint.send(PACKED, 1, 1)
    endpoint.flush(0.0)
    assert station.recvfrom(2048)[1] == link.address
    assert link.health(1.0).age_s == 1.0
    link.receive(PEER_TIMEOUT_S + 0.1)
    assert link.endpoints == ()


def test_an_unfinished_frame_does_not_reach_into_the_next_datagram(opened: Any, sockets: Any) -> None:
    link: UdpLink = opened("udpin:127.0.0.1:0")
    station = sockets(socket.SOCK_DGRAM)
    station.sendto(BYTES, link.address)
    until(lambda: link.receive(0.0))
    station.sendto(BYTES[:12], link.address)
    station.sendto(BYTES, link.address)
    assert [message.get_type() for _, message in until(lambda: link.receive(0.0))] == ["HEARTBEAT"]


def test_peers_are_bounded(opened: Any, sockets: Any) -> None:
    link: UdpLink = opened("udpin:127.0.0.1:0")
    for _ in range(40):
        sockets(socket.SOCK_DGRAM).sendto(BYTES, link.address)
    for _ in range(200):
        link.receive(0.0)
    assert len(link.endpoints) == 16


def test_many_ports_of_one_address_shut_nobody_out(opened: Any, sockets: Any) -> None:
    link: UdpLink = opened("udpin:127.0.0.1:0")
    for _ in range(40):
        sockets(socket.SOCK_DGRAM).sendto(BYTES, link.address)
    until(lambda: link.receive(0.0) and len(link.endpoints) == 16)
    station = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    with station:
        station.bind(("127.0.0.2", 0))
        station.sendto(BYTES, link.address)
        until(lambda: link.receive(0.1) and any("127.0.0.2" in endpoint.name for endpoint in link.endpoints))
        sockets(socket.SOCK_DGRAM).sendto(BYTES, link.address)
        link.receive(0.2)
    assert len(link.endpoints) == 16 and any("127.0.0.2" in endpoint.name for endpoint in link.endpoints)


def test_no_listener_is_no_error(opened: Any, sockets: Any) -> None:
    gone = sockets(socket.SOCK_DGRAM)
    port = gone.getsockname()[1]
    gone.close()
    link: UdpLink = opened(f"udpout:127.0.0.1:{port}")
    for i in range(50):
        link.endpoints[0].send(PACKED, 1, 1)
        link.endpoints[0].flush(float(i))
        assert link.receive(float(i)) == []
    assert len(link.filenos()) == 1


# --- TCP -----------------------------------------------------------------------------------------------------------


def connected(link: TcpServerLink, sockets: Any) -> tuple[socket.socket, Endpoint]:
    known = set(link.endpoints)
    client = sockets(socket.SOCK_STREAM)
    client.connect(link.address)
    until(lambda: link.receive(0.0) or len(link.endpoints) > len(known))
    (endpoint,) = set(link.endpoints) - known
    return client, endpoint


def fill(link: TcpServerLink, sockets: Any) -> None:
    """All places taken, by clients that were heard."""
    for _ in range(16):
        client, endpoint = connected(link, sockets)
        client.sendall(BYTES)
        until(lambda endpoint=endpoint: link.receive(1.0) and endpoint.last_heard_s is not None)


def test_tcpin_keeps_clients_apart(opened: Any, sockets: Any) -> None:
    link: TcpServerLink = opened("tcpin:127.0.0.1:0")
    one, first = connected(link, sockets)
    two, second = connected(link, sockets)
    one.sendall(BYTES[:10])
    two.sendall(BYTES)
    ((source, _),) = until(lambda: link.receive(1.0))
    assert source is second
    one.sendall(BYTES[10:])
    ((source, _),) = until(lambda: link.receive(1.0))
    assert source is first
    first.send(PACKED, 1, 1)
    first.flush(1.0)
    assert Framer().feed(one.recv(2048))[0].get_type() == "HEARTBEAT"
    assert len(link.filenos()) == 3


@pytest.mark.parametrize("abrupt", [False, True])
def test_a_client_that_vanishes(opened: Any, sockets: Any, abrupt: bool) -> None:
    link: TcpServerLink = opened("tcpin:127.0.0.1:0")
    client, endpoint = connected(link, sockets)
    if abrupt:  # a reset, where a full close would be polite
        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
    client.close()
    for i in range(200):
        endpoint.send(PACKED, 1, 1)
        endpoint.flush(float(i))
        link.receive(float(i))
    assert endpoint.gone
    assert link.endpoints == ()
    connected(link, sockets)
    assert len(link.endpoints) == 1


def test_a_client_that_does_not_read_costs_messages_not_time_or_memory(opened: Any, sockets: Any) -> None:
    link: TcpServerLink = opened("tcpin:127.0.0.1:0")
    client, endpoint = connected(link, sockets)
    for _ in range(20000):
        endpoint.send(LONG, 1, 1)
        endpoint.flush(0.0)
    assert endpoint.traffic.dropped > 0
    assert endpoint.backlog <= 65536
    assert endpoint.busy
    framer, heard = Framer(), 0
    client.setblocking(False)
    while True:  # what did get through is whole frames in their order
        endpoint.flush(0.0)
        try:
            heard += len(framer.feed(client.recv(1 << 20)))
        except BlockingIOError:
            break
    assert framer.garbage == 0
    assert heard == framer.received > 100


def test_tcpout_comes_back_after_a_refusal(opened: Any, sockets: Any) -> None:
    listener = sockets(socket.SOCK_STREAM)
    listener.bind(("127.0.0.1", 0))
    port = listener.getsockname()[1]
    link: StreamLink = opened(f"tcpout:127.0.0.1:{port}")
    now_s = 0.0
    for _ in range(50):
        now_s += 0.1
        assert link.receive(now_s) == []
    assert link.endpoints == ()
    assert not link.health(now_s).ok
    listener.listen()

    def connected_at_last() -> bool:
        nonlocal now_s
        now_s += 0.1
        link.receive(now_s)
        return bool(link.endpoints)

    wait_until(connected_at_last, "the listener is found")
    server, _ = listener.accept()
    server.sendall(BYTES)
    ((endpoint, _),) = until(lambda: link.receive(now_s))
    endpoint.send(PACKED, 1, 1)
    endpoint.flush(now_s)
    server.settimeout(CAP_S)
    assert Framer().feed(server.recv(2048))[0].get_type() == "HEARTBEAT"
    server.close()


@pytest.fixture
def eaten(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Bytes given to framers, feed by feed."""
    sizes: list[int] = []
    feed = Framer.feed

    def counted(self: Framer, data: bytes) -> list[Any]:
        sizes.append(len(data))
        return feed(self, data)

    monkeypatch.setattr(Framer, "feed", counted)
    return sizes


def pushed(client: socket.socket, data: bytes) -> None:
    """As much as the buffers take."""
    client.setblocking(False)
    try:
        while data:
            data = data[client.send(data) :]
    except (BlockingIOError, ConnectionError):
        pass


@pytest.mark.parametrize("flood", [b"\xfe", b"\xfd\xff", b"\xfd\xff\x00", b"GET / HTTP/1.1\r\n"])
def test_a_flooding_client_is_read_in_small_parts_and_closed(
    opened: Any, sockets: Any, eaten: list[int], flood: bytes
) -> None:
    link: TcpServerLink = opened("tcpin:127.0.0.1:0")
    flooding, endpoint = connected(link, sockets)
    data = flood * ((1 << 20) // len(flood))
    news: list[str] = []
    for _ in range(1000):
        pushed(flooding, data)
        before = sum(eaten)
        link.receive(1.0)
        assert sum(eaten) - before <= 16384
        news += link.news()
        if endpoint.gone:
            break
    assert endpoint.gone
    assert sum(eaten) <= 100_000 + 16384
    assert link.endpoints == ()
    assert news == [f"{link.name}: closed a client at 127.0.0.1: it sends no valid MAVLink"]


def test_a_client_that_sends_much_is_heard_whole_part_by_part(opened: Any, sockets: Any, eaten: list[int]) -> None:
    link: TcpServerLink = opened("tcpin:127.0.0.1:0")
    flooding, _ = connected(link, sockets)
    busy, endpoint = connected(link, sockets)
    pushed(flooding, b"\xfe" * (1 << 20))
    busy.sendall(BYTES * 3000)
    heard = calls = 0
    while heard < 3000:
        assert select.select(link.filenos(), (), (), CAP_S)[0], "what is left keeps the descriptor readable"
        before = sum(eaten)
        heard += sum(source is endpoint for source, _ in link.receive(1.0))
        assert sum(eaten) - before <= 16384
        calls += 1
        assert calls < 1000
    assert (heard, endpoint.framer.garbage) == (3000, 0)


def test_datagrams_are_read_in_small_parts_and_none_is_lost(opened: Any, sockets: Any, eaten: list[int]) -> None:
    link: UdpLink = opened("udpin:127.0.0.1:0")
    station = sockets(socket.SOCK_DGRAM)
    for _ in range(60):
        station.sendto(BYTES * 50, link.address)
    heard = 0
    while heard < 3000:
        assert select.select(link.filenos(), (), (), CAP_S)[0]
        before = sum(eaten)
        heard += len(link.receive(1.0))
        assert sum(eaten) - before <= 16384 + len(BYTES) * 50
    assert heard == 3000


def test_newer_clients_take_the_place_of_the_silent(opened: Any, sockets: Any) -> None:
    link: TcpServerLink = opened("tcpin:127.0.0.1:0")
    clients = [connected(link, sockets) for _ in range(16)]
    for n, (client, endpoint) in enumerate(clients):
        if n != 5:  # which is never heard
            client.sendall(BYTES)
            until(lambda n=n, endpoint=endpoint: link.receive(float(n)) and endpoint.last_heard_s is not None)
    assert link.news() == []
    newer = sockets(socket.SOCK_STREAM)
    newer.connect(link.address)
    until(lambda: link.receive(15.5) or clients[5][1].gone)
    assert [n for n, (_, endpoint) in enumerate(clients) if endpoint.gone] == [5]
    (news,) = link.news()
    assert "never heard" in news
    newer.sendall(BYTES)
    until(lambda: link.receive(15.5))
    newest = sockets(socket.SOCK_STREAM)
    newest.connect(link.address)
    until(lambda: link.receive(15.5) or clients[0][1].gone)
    assert [n for n, (_, endpoint) in enumerate(clients) if endpoint.gone] == [0, 5]
    (news,) = link.news()
    assert "silent for 16 s" in news
    assert len(link.endpoints) == 16


def test_clients_that_are_heard_are_not_dropped_for_newer_ones(opened: Any, sockets: Any) -> None:
    link: TcpServerLink = opened("tcpin:127.0.0.1:0")
    fill(link, sockets)
    late = sockets(socket.SOCK_STREAM)
    late.connect(link.address)
    late.sendall(BYTES)
    news = until(lambda: (link.receive(2.0) and None) or link.news())
    assert "refused 127.0.0.1" in news[0]
    assert late.recv(10) == b""
    assert not any(endpoint.gone for endpoint in link.endpoints)


def test_who_has_only_sent_heartbeats_leaves_after_a_while(opened: Any, sockets: Any) -> None:
    link: TcpServerLink = opened("tcpin:127.0.0.1:0")
    fill(link, sockets)
    first = link.endpoints[0]
    sockets(socket.SOCK_STREAM).connect(link.address)
    until(lambda: link.receive(12.0) or first.gone)
    assert len(link.endpoints) == 16


def test_an_operator_gets_in_where_all_places_are_taken(opened: Any, sockets: Any) -> None:
    link: TcpServerLink = opened("tcpin:127.0.0.1:0")
    link.guard.operators = frozenset({77})
    fill(link, sockets)
    operator = sockets(socket.SOCK_STREAM)
    operator.connect(link.address)
    operator.sendall(frame(PACKED, 0, 77, 190))
    until(lambda: link.receive(2.0) or any(endpoint.trusted for endpoint in link.endpoints))
    assert len(link.endpoints) == 16


def test_a_client_that_waits_and_says_nothing_is_closed(opened: Any, sockets: Any) -> None:
    link: TcpServerLink = opened("tcpin:127.0.0.1:0")
    fill(link, sockets)
    late = sockets(socket.SOCK_STREAM)
    late.connect(link.address)
    until(lambda: link.receive(2.0) or len(link.filenos()) == 18)
    assert len(link.endpoints) == 16
    link.receive(5.1)
    assert len(link.filenos()) == 17 and late.recv(10) == b""


def test_dead_clients_are_noticed_by_the_system(opened: Any, sockets: Any) -> None:
    link: TcpServerLink = opened("tcpin:127.0.0.1:0")
    connected(link, sockets)
    _, client = link.filenos()
    with socket.socket(fileno=os.dup(client)) as theirs:
        assert theirs.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE)
        if hasattr(socket, "TCP_USER_TIMEOUT"):
            assert theirs.getsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT) == 15_000


def test_peers_of_a_vessel_in_fast_motion_are_given_more_of_its_time(sockets: Any) -> None:
    link = open_link("udpin:127.0.0.1:0", patience=20.0)
    assert isinstance(link, UdpLink)
    sockets(socket.SOCK_DGRAM).sendto(BYTES, link.address)
    until(lambda: link.receive(0.0))
    link.receive(20.0 * PEER_TIMEOUT_S - 0.1)
    assert len(link.endpoints) == 1
    link.receive(20.0 * PEER_TIMEOUT_S + 0.1)
    assert link.endpoints == ()
    link.close()


# --- serial --------------------------------------------------------------------------------------------------------


def test_serial_both_ways_and_a_stray_byte(opened: Any) -> None:
    far, near = pty.openpty()
    try:
        link: StreamLink = opened(f"serial:{os.ttyname(near)}:57600")
        (endpoint,) = link.endpoints
        assert endpoint.bytes_per_s == 5760.0
        endpoint.send(PACKED, 1, 1)
        endpoint.flush(0.0)
        assert Framer().feed(os.read(far, 1000))[0].get_type() == "HEARTBEAT"
        # noise that poses as the start of a long frame delays what follows until the line falls silent
        os.write(far, b"\xfd\xff\x00" + BYTES)
        heard = [*link.receive(1.0), *link.receive(1.1), *link.receive(1.2 + SILENCE_S)]
        assert [message.get_type() for _, message in heard] == ["HEARTBEAT"]
    finally:
        os.close(far)
        os.close(near)


def test_a_slow_line_is_given_what_it_carries() -> None:
    sent = bytearray()

    def transmit(data: bytes, now_s: float) -> int:
        sent.extend(data)
        return len(data)

    endpoint = Endpoint("radio", open_link("memory:").endpoints[0].persona, transmit, bytes_per_s=1000.0)
    for i in range(1, 101):
        for _ in range(3):
            endpoint.send(LONG, 1, 1)
        endpoint.flush(0.1 * i)
    assert 10_000 <= len(sent) + 300 <= 10_800  # ten seconds, and what was saved up before
    assert endpoint.traffic.dropped > 200
    assert endpoint.backlog <= 1024


# --- endpoints -----------------------------------------------------------------------------------------------------


def test_messages_share_datagrams_and_are_not_cut() -> None:
    datagrams: list[bytes] = []

    def transmit(data: bytes, now_s: float) -> int:
        datagrams.append(data)
        return len(data)

    endpoint = Endpoint("udp", open_link("memory:").endpoints[0].persona, transmit, datagrams=True)
    for _ in range(20):
        endpoint.send(LONG, 1, 1)
        endpoint.send(PACKED, 1, 1)
    endpoint.flush(0.0)
    assert all(len(data) <= DATAGRAM_BYTES for data in datagrams)
    heard = [message for data in datagrams for message in Framer().feed(data)]
    assert [message.get_seq() for message in heard] == list(range(40))
    assert len(datagrams) < 12
    assert endpoint.traffic.sent_bytes == sum(map(len, datagrams))


def test_sequence_numbers_wrap() -> None:
    link = MemoryLink()
    for _ in range(258):
        link.endpoints[0].send(PACKED, 1, 1)
    link.endpoints[0].flush(0.0)
    assert [message.get_seq() for message in Framer().feed(link.from_vessel())] == [*range(256), 0, 1]


@pytest.mark.parametrize("options", ["", "?dialect=ardupilot"])
def test_a_fault_is_told_without_the_name_that_stands_before_it(options: str) -> None:
    link = open_link(f"serial:/dev/no-such-radio:57600{options}")
    try:
        link.receive(0.0)
        health = link.health(0.0)
    finally:
        link.close()
    assert health.name == f"serial:/dev/no-such-radio:57600{options}"
    assert health.text.startswith("no such device; is it plugged in?")
