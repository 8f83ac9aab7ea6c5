"""Names of hosts: looked up beside the caller, again after a loss. The tests stand in for the system's look-up."""

from __future__ import annotations

import socket
import threading
from collections.abc import Iterator

import pytest

from companion.io.mavlink.wire.links import UdpLink, open_link
from companion.io.transport import names
from companion.io.transport.names import LOOK_AGAIN_S, Host, NameUnknown, is_name
from companion.io.transport.opener import TransportOpener
from tests.threadless import no_threads
from tests.unit.io.transport.test_opener import wait_readable
from tests.waiting import wait_until

NAME = "bluerov.local"


class Network:
    """What the system knows of names; `slow`: look-ups wait for `answer`."""

    def __init__(self) -> None:
        self.addresses: dict[str, str] = {}
        self.asked = 0
        self.answer = threading.Event()
        self.answer.set()

    def look_up(self, host: str) -> str:
        self.asked += 1
        self.answer.wait()
        if host not in self.addresses:
            raise socket.gaierror(-2, "Name or service not known")
        return self.addresses[host]


@pytest.fixture
def network(monkeypatch: pytest.MonkeyPatch) -> Iterator[Network]:
    made = Network()
    monkeypatch.setattr(names, "look_up", made.look_up)
    yield made
    made.answer.set()


@pytest.mark.parametrize("host", [NAME, "boat", "a-b.c1", "boat.", "1.pool.ntp.org"])
def test_names(host: str) -> None:
    assert is_name(host)


@pytest.mark.parametrize("host", ["", "a..b", "-a", "a b", "192.168.1.300", "10.1", "x" * 64, ("x" * 60 + ".") * 5])
def test_no_names(host: str) -> None:
    assert not is_name(host)


def test_an_address_is_never_looked_up(network: Network) -> None:
    for text, address in (("10.0.0.1", "10.0.0.1"), ("::1", "::1"), ("localhost", "127.0.0.1")):
        host = Host(text)
        host.seek()
        assert host.found() == address and not host.seeking
    assert network.asked == 0


def test_nobody_waits_for_a_look_up(network: Network) -> None:
    network.answer.clear()
    host = Host(NAME)
    host.seek()
    host.seek()
    assert host.seeking and host.fault == f"looking up '{NAME}'"
    with pytest.raises(NameUnknown, match="looking up"):
        host.found()
    network.answer.set()
    settle(host)
    assert network.asked == 1
    assert "is that computer on" in (host.fault or "")


def settle(host: Host) -> None:
    wait_until(lambda: not host.seeking, "the look-up ends")


def test_a_name_that_is_gone_keeps_its_last_address(network: Network) -> None:
    network.addresses[NAME] = "10.0.0.7"
    host = Host(NAME)
    host.seek()
    settle(host)
    assert host.found() == "10.0.0.7" and host.fault is None
    del network.addresses[NAME]
    host.seek()
    settle(host)
    assert host.found() == "10.0.0.7" and "its last address 10.0.0.7" in (host.fault or "")


def test_without_threads_a_name_is_looked_up_later(network: Network) -> None:
    network.addresses[NAME] = "10.0.0.7"
    host = Host(NAME)
    with no_threads():
        host.seek()
    assert not host.seeking and "has no address" in (host.fault or "")
    host.seek()
    settle(host)
    assert host.found() == "10.0.0.7" and host.fault is None


def test_a_silent_host_is_looked_up_now_and_then(network: Network) -> None:
    network.addresses[NAME] = "10.0.0.7"
    host = Host(NAME)
    host.seek()
    settle(host)
    for second in range(100):
        host.keep_up(second < 10 or second > 20, float(second))
        settle(host)
    assert network.asked == 1 + int((100 - 21) // (LOOK_AGAIN_S + 1.0))


def test_a_tcp_line_waits_for_its_name_and_looks_it_up_again_after_a_loss(network: Network) -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        network.answer.clear()
        line = TransportOpener().open("wind", f"tcpout:{NAME}:{server.getsockname()[1]}")
        assert line.fault() == f"tcpout:{NAME}:{server.getsockname()[1]}: looking up '{NAME}'"
        network.answer.set()
        wait_until(lambda: not line.read(0.0) and "has no address" in (line.fault() or ""), "the name is not known")
        network.addresses[NAME] = "127.0.0.1"
        clock = iter(range(1, 100000))
        wait_until(lambda: not line.read(float(next(clock))) and line.fault() is None, "it is connected")
        device, _ = server.accept()
        device.sendall(b"$WIMWV")
        wait_readable(line)
        assert [data for _, data in line.read(float(next(clock)))] == [b"$WIMWV"]
        asked = network.asked
        device.close()
        wait_until(lambda: not line.read(float(next(clock))) and network.asked > asked, "the name is looked up again")
        wait_until(lambda: not line.read(float(next(clock))) and line.fault() is None, "it is connected again")
        line.close()


def test_datagrams_follow_a_name_to_its_new_address(network: Network) -> None:
    with (
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as first,
        socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as next_,
    ):
        first.bind(("127.0.0.1", 0))
        port = first.getsockname()[1]
        next_.bind(("127.0.0.2", port))
        network.addresses[NAME] = "127.0.0.1"
        line = TransportOpener().open("bus", f"udpout:{NAME}:{port}")
        wait_until(lambda: not line.read(0.0) and line.fault() is None, "the name is known")
        line.write(b"one", 0.0)
        network.addresses[NAME] = "127.0.0.2"
        clock = iter(range(1, 100000))
        wait_until(lambda: not line.read(float(next(clock))) and network.asked > 1, "the name is looked up again")
        wait_until(
            lambda: not line.read(float(next(clock))) and arrived(line, next_), "datagrams go to the new address"
        )
        line.close()
        assert first.recv(100) == b"one"


def arrived(line: object, there: socket.socket) -> bool:
    line.write(b"two", 1e6)  # type: ignore[attr-defined]
    there.settimeout(0.05)
    try:
        return there.recv(100) == b"two"
    except TimeoutError:
        return False


def test_a_link_has_its_endpoint_when_the_name_is_known(network: Network) -> None:
    link = open_link(f"udpout:{NAME}:14550")
    assert isinstance(link, UdpLink)
    wait_until(lambda: "has no address" in link.health(0.0).text, "the name is not known")
    assert not link.health(0.0).ok and not link.endpoints
    network.addresses[NAME] = "127.0.0.3"
    clock = iter(range(1, 100000))
    wait_until(lambda: not link.receive(float(next(clock))) and bool(link.endpoints), "the name is found")
    assert link.health(1.0).ok
    (before,) = link.endpoints
    network.addresses[NAME] = "127.0.0.4"
    wait_until(lambda: not link.receive(float(next(clock))) and link.endpoints != (before,), "the name has moved")
    assert before.gone and "127.0.0.4:14550" in link.endpoints[0].name
    link.close()
