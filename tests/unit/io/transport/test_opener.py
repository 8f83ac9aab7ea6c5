"""Ports that come and go, on real pseudo-terminals and loopback sockets."""

from __future__ import annotations

import os
import socket
from pathlib import Path

import pytest

from companion.io.transport.line import Line
from companion.io.transport.opener import TransportOpener
from companion.io.transport.urls import PortUrl, TransportError, parse_url
from tests.shortage import Shortage
from tests.unit.io.lines import Terminal, address_of, opened, slept_s, text_of, wait_readable
from tests.waiting import CAP_S, wait_until


@pytest.mark.parametrize(
    "text, endpoint",
    [
        ("serial:/dev/ttyUSB0:57600", PortUrl("serial", path="/dev/ttyUSB0", baud=57600)),
        ("serial:/dev/ttyUSB0", PortUrl("serial", path="/dev/ttyUSB0", baud=115200)),
        (
            "serial:/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0-port0:9600?parity=even",
            PortUrl(
                "serial",
                path="/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0-port0",
                baud=9600,
                options={"parity": "even"},
            ),
        ),
        (
            "serial:/dev/serial/by-path/platform-fd500000.pcie-usb-0:1.2:1.0-port0",
            PortUrl("serial", path="/dev/serial/by-path/platform-fd500000.pcie-usb-0:1.2:1.0-port0", baud=115200),
        ),
        ("udpout:192.168.1.20:14550", PortUrl("udpout", host="192.168.1.20", port=14550)),
        ("udpin:0.0.0.0:0", PortUrl("udpin", host="0.0.0.0")),
        (
            "tcpin:[::1]:5760?dialect=ardupilot",
            PortUrl("tcpin", host="::1", port=5760, options={"dialect": "ardupilot"}),
        ),
        ("tcpout:boat.local:1", PortUrl("tcpout", host="boat.local", port=1)),
    ],
)
def test_parse(text: str, endpoint: PortUrl) -> None:
    assert parse_url(text) == endpoint


@pytest.mark.parametrize(
    "text, says",
    [
        ("", "should begin with one of serial:, udpin:"),
        ("/dev/ttyUSB0", "should begin with one of"),
        ("bluetooth:x:1", "should begin with one of"),
        ("serial:", "serial:/dev/name:baud"),
        ("serial:/dev/x:7", "baud rate 7"),
        ("/dev/ttyUSB0:9600", "did you mean 'serial:/dev/ttyUSB0:9600'?"),
        ("serial:ttyUSB0:115200", "serial:/dev/name:baud"),
        ("serial:/dev/ttyUSB0:115k", "serial:/dev/name:baud"),
        ("serial:/dev/ttyUSB0:115200 baud", "serial:/dev/name:baud"),
        ("serial:/dev/ttyUSB0:9600:8N1", "serial:/dev/name:baud"),
        ("serial:/dev/ttyUSB0:", "serial:/dev/name:baud"),
        ("udpot:host:1", "did you mean 'udpout'?"),
        ("tcp:host:1", "tcpout: sends to that address, tcpin: listens there"),
        ("serial:/dev/usv-gnss:11520O", "baud rate 11520O should be digits alone, as 115200"),
        ("udpout:14550", "udpout:host:port"),
        ("udpout:host:http", "udpout:host:port"),
        ("tcpin:host:70000", "port 70000"),
        ("tcpin:host:²", "tcpin:host:port"),
        ("udpin:0.0.0.0:1?dialect", "?key=value"),
    ],
)
def test_parse_errors_are_one_line(text: str, says: str) -> None:
    with pytest.raises(TransportError) as caught:
        parse_url(text)
    assert says in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "url, says",
    [
        ("udpout:boat..local:5000", "should be an IP address or a host's name"),
        ("tcpout:192.168.1.300:5000", "should be an IP address or a host's name"),
        ("serial:/dev/x:9600?parity=odder", "none, even, odd"),
        ("udpin:0.0.0.0:1?parity=odd", "unknown option 'parity'; known here: none"),
    ],
)
def test_opener_refuses_what_never_can_work(url: str, says: str) -> None:
    with pytest.raises(TransportError, match=says):
        TransportOpener().open("x", url)


def test_devices_of_a_simulated_boat_are_looked_for_in_their_folder(tmp_path: Path) -> None:
    opener = TransportOpener(tmp_path)
    for url, place in (
        ("serial:/dev/usv-gnss:4800", f"serial:{tmp_path}/usv-gnss:4800"),
        ("serial:/dev/serial/by-id/usb-x:9600?parity=even", f"serial:{tmp_path}/serial/by-id/usb-x:9600?parity=even"),
        ("serial:/srv/port:9600", "serial:/srv/port:9600"),
    ):
        line = opener.open("x", url)
        assert (line.fault() or "").startswith(f"{place}: no such device")
        line.close()


def test_no_port_ever_blocks(tmp_path: Path) -> None:
    """A serial line and a TCP stream that nobody reads, a host that does not answer, a closed port, nobody at all: 2000
    calls each."""
    terminal = Terminal(tmp_path / "tty")
    terminal.plug()
    with (
        socket.create_server(("127.0.0.1", 0), backlog=1) as deaf,
        socket.create_server(("127.0.0.1", 0), backlog=0) as full,
    ):
        host, port = full.getsockname()
        fill = [socket.socket() for _ in range(4)]
        for each in fill:  # until the system drops what else knocks: a black hole
            each.setblocking(False)
            each.connect_ex((host, port))
        urls = [
            f"serial:{terminal.path}:9600",
            f"tcpout:127.0.0.1:{deaf.getsockname()[1]}",
            f"tcpout:127.0.0.1:{port}",
            "tcpout:127.0.0.1:1",
            "tcpout:192.0.2.1:4001",
            "udpout:192.0.2.1:4001",
            f"serial:{tmp_path}/none:9600",
        ]
        faults, worst_s = {}, 0.0
        for url in urls:
            with opened(url) as line:
                for k in range(2000):
                    worst_s = max(
                        worst_s, slept_s(lambda now_s=0.01 * k: (line.read(now_s), line.write(bytes(1000), now_s)))
                    )  # type: ignore[misc]
                faults[url] = line.fault()
        for each in fill:
            each.close()
    terminal.let_go()
    os.close(terminal.master)
    print(f"the longest of {2000 * len(urls)} calls slept {1e3 * worst_s:.1f} ms")
    assert worst_s < 0.25
    assert faults[urls[0]] is None and faults[urls[1]] is None
    assert faults[urls[2]] in (f"{urls[2]}: connecting", f"{urls[2]}: no answer; trying again")


def test_udp_both_ways() -> None:
    with opened("udpin:127.0.0.1:0") as inward:
        port = address_of(inward)[1]
        inward.write(b"to nobody yet", 0.0)
        with opened(f"udpout:localhost:{port}") as outward:
            assert not inward.read(0.0)
            outward.write(b"one", 0.0)
            outward.write(b"two", 0.0)
            wait_readable(inward)
            assert list(inward.read(1.0)) == [(1.0, b"one"), (1.0, b"two")]
            inward.write(b"back", 1.0)
            wait_readable(outward)
            assert text_of(outward, 1.0) == b"back"
        with opened(f"udpin:127.0.0.1:{port}") as second:
            assert "port in use" in (second.fault() or "")


def test_udp_to_nobody_is_no_fault() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    with opened(f"udpout:127.0.0.1:{port}") as line:
        for k in range(5):
            line.write(b"hello?", float(k))
            assert not line.read(float(k))
        assert line.fault() is None


def test_without_descriptors_a_newer_connection_waits_and_the_older_stays() -> None:
    """The good connection was hung up for the want of a descriptor for another."""
    with (
        opened("tcpin:127.0.0.1:0") as server,
        socket.socket() as newer,
        socket.create_connection(address_of(server)) as client,
    ):
        wait_readable(server)
        server.read(0.0)
        address = address_of(server)
        with Shortage():
            newer.connect(address)
            client.sendall(b"hello")
            wait_readable(server)
            assert text_of(server, 0.1) == b"hello" and server.fault() is None
            server.write(b"there", 0.2)
            assert client.recv(10) == b"there"
        newer.sendall(b"new")
        wait_until(lambda: text_of(server, 0.3) == b"new", "the newer connection is heard")


def test_without_descriptors_a_connection_that_waits_does_not_wake_the_loop() -> None:
    with opened("tcpin:127.0.0.1:0") as server, socket.socket() as client:
        address = address_of(server)
        with Shortage():
            client.connect(address)
            wait_readable(server)
            server.read(0.0)
            assert server.fileno() is None and "waiting for the device" in (server.fault() or "")
        client.sendall(b"hello")
        wait_until(lambda: text_of(server, 0.1) == b"hello", "it gets in")


def test_tcp_server_takes_a_newer_connection_and_goes_on_after_a_loss() -> None:
    with opened("tcpin:127.0.0.1:0") as server:
        address = address_of(server)
        assert "waiting for the device" in (server.fault() or "")
        with socket.create_connection(address) as client:
            wait_readable(server)
            server.read(0.0)
            assert server.fault() is None
            client.sendall(b"hello")
            wait_readable(server)
            assert text_of(server, 0.1) == b"hello"
            server.write(b"there", 0.1)
            assert client.recv(10) == b"there"
            with socket.create_connection(address) as newer:
                newer.sendall(b"new")
                wait_until(lambda: text_of(server, 0.2) == b"new", "the newer connection is heard")
                server.write(b"!", 0.3)
                assert newer.recv(10) == b"!"
        wait_readable(server)
        server.read(0.4)
        server.read(0.5)
        assert "waiting for the device" in (server.fault() or "")
        with socket.create_connection(address) as client:
            wait_readable(server)
            server.write(b"welcome", 0.6)
            assert client.recv(10) == b"welcome"


def test_tcp_client_connects_without_waiting_and_again_after_a_loss() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
        with opened(f"tcpout:127.0.0.1:{port}") as client:
            peer, _ = listener.accept()
            client.write(b"hello", 0.0)
            assert peer.recv(10) == b"hello"
            assert client.fault() is None
            peer.close()
            wait_readable(client)
            assert not client.read(1.0)
            assert "closed the connection" in (client.fault() or "")
            client.read(1.3)
            assert client.fileno() is None
            client.read(1.6)
            peer, _ = listener.accept()
            client.read(1.7)
            assert client.fault() is None
            peer.sendall(b"again")
            wait_readable(client)
            assert text_of(client, 1.8) == b"again"
            peer.close()


def test_the_system_asks_a_silent_far_end_whether_it_is_still_there() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        with opened(f"tcpout:127.0.0.1:{listener.getsockname()[1]}") as client:
            listener.accept()[0].close()
            client.write(b"x", 0.0)
            assert_asks(client)
        with opened("tcpin:127.0.0.1:0") as server, socket.create_connection(address_of(server)):
            wait_readable(server)
            server.read(0.0)
            assert_asks(server)


def assert_asks(line: Line) -> None:
    descriptor = line.fileno()
    assert descriptor is not None
    with socket.socket(fileno=os.dup(descriptor)) as ours:
        assert ours.getsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE)
        assert ours.getsockopt(socket.IPPROTO_TCP, socket.TCP_KEEPIDLE) == 5
        assert ours.getsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT) == 15_000


def test_tcp_client_refused() -> None:
    with socket.create_server(("127.0.0.1", 0)) as listener:
        port = listener.getsockname()[1]
    with opened(f"tcpout:127.0.0.1:{port}") as client:
        for k in range(5):
            client.write(b"x", 0.1 * k)
        assert "refused; nothing listens there" in (client.fault() or "")


def test_a_flood_is_taken_in_small_bites_and_none_of_it_is_lost() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        line = TransportOpener().open("device", f"tcpout:127.0.0.1:{server.getsockname()[1]}")
        try:
            far, _ = server.accept()
            with far:
                far.sendall(bytes(60_000))
                heard = 0
                for _ in range(20_000):
                    bite = sum(len(data) for _, data in line.read(0.0))
                    assert bite <= 16384
                    heard += bite
                    if heard == 60_000:
                        break
                assert heard == 60_000
        finally:
            line.close()


def test_two_sensors_share_a_port() -> None:
    """A receiver and an AIS receiver behind one multiplexer: both hear all of it, one opens and closes it."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    opener = TransportOpener()
    first, second = opener.open("gnss", f"udpin:127.0.0.1:{port}"), opener.open("ais", f"udpin:127.0.0.1:{port}")
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as multiplexer:
        multiplexer.sendto(b"$GPHDT,1.0,T*01\r\n", ("127.0.0.1", port))
        multiplexer.sendto(b"!AIVDM\r\n", ("127.0.0.1", port))
        found: list[tuple[float, bytes]] = []
        for k in range(1000):
            found += first.read(0.001 * k)
            if len(found) == 2:
                break
        assert [data for _, data in found] == [b"$GPHDT,1.0,T*01\r\n", b"!AIVDM\r\n"]
        assert second.read(1.0) == found and second.read(1.0) == []
        second.write(b"to the device", 1.0)
        multiplexer.settimeout(CAP_S)
        assert multiplexer.recv(100) == b"to the device"
    assert second.fault() is None and second.fileno() is None
    second.close()
    assert first.fault() is None
    first.close()
    assert second.fault() == "closed"
