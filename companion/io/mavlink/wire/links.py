"""Links to ground stations, opened by URL. No link ever blocks, or raises because of the far end or the network.

    udpout:192.168.1.20:14550   send there; also answer other senders to our socket
    udpin:0.0.0.0:14550         answer every sender; forget it after 15 s of silence
    tcpin:0.0.0.0:5760          accept clients
    tcpout:192.168.1.20:5760    connect; reconnect when the connection breaks
    serial:/dev/ttyUSB0:57600   a telemetry radio
    memory:name                 tests and lockstep: the far end is in this process

A host is an IP address or a name (`bluerov.local`). The name of a far end is looked up beside the control thread, and
again while it is not heard; that of an address of our own once, at the start.

Each takes options as `?key=value&key=value` (`link_options.py`):

    dialect=px4|ardupilot|generic       persona: what the clients of the link are told that the vehicle is
    telemetry=all|leader|high_latency   messages that are streamed without a request
    signing=off|accept|require          signatures that packets need
    trusted=no|yes                      whether the signing key may be set there
    route=yes|from|no                   forwarding between this link and the others
    proof=yes|no                        whether senders of datagrams must prove that they receive the answers
    rate=BYTES_PER_S                    capacity of the line, where lower than usual for its kind
"""

from __future__ import annotations

import socket
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from companion.core.ports import ByteStream
from companion.core.tick import DeviceHealth
from companion.io.mavlink.wire.endpoint import FAST_BYTES_PER_S, Endpoint
from companion.io.mavlink.wire.framer import Framer
from companion.io.mavlink.wire.guard import Guard
from companion.io.mavlink.wire.link_base import (
    MOST_BYTES,
    PEER_TIMEOUT_S,
    Link,
    LinkError,
    NoAddress,
    PortInUse,
    Received,
    bound_socket,
    link_health,
    take_in,
)
from companion.io.mavlink.wire.link_options import OptionError, parse_options
from companion.io.mavlink.wire.personas import Persona
from companion.io.mavlink.wire.proof import Proof, needs_proof
from companion.io.mavlink.wire.slots import MAX_PEERS, Slot, to_leave
from companion.io.mavlink.wire.tcp_server import TcpServerLink
from companion.io.transport import opener as transport
from companion.io.transport import urls
from companion.io.transport.names import Host, is_address, look_up

__all__ = [
    "PEER_TIMEOUT_S",
    "SILENCE_S",
    "Link",
    "LinkError",
    "MemoryLink",
    "NoAddress",
    "StreamLink",
    "TcpServerLink",
    "UdpLink",
    "open_link",
    "open_links",
]

SILENCE_S = 0.3  # after so long a pause inside a frame, a serial line will not finish that frame
_SCHEMES = tuple(scheme for scheme in urls.SCHEMES if scheme != "can")
_RECEIVES = 64  # datagrams read in one call, at most


def open_link(url: str, patience: float = 1.0) -> Link:
    """Open the link of a URL. `patience`: factor on the silence after which peers are forgotten, where vessel time runs
    fast.

    Raises LinkError, with one line, for a URL that cannot be used or a port in use.
    """
    body = url.strip().partition("?")[0]
    if body.startswith("memory:"):
        return MemoryLink(url)
    parsed = _parsed(url)
    persona, guard = _options(url, parsed.options)
    if parsed.scheme == "serial":
        return StreamLink(url, _opened(body), persona, guard.options.rate_bytes_per_s or parsed.baud / 10.0, guard)
    match parsed.scheme:
        case "tcpout":
            return StreamLink(url, _opened(body), persona, guard.options.rate_bytes_per_s or FAST_BYTES_PER_S, guard)
        case "tcpin":
            return TcpServerLink(url, _own_address(url, parsed), persona, patience, guard)
        case "udpin":
            return UdpLink(url, _own_address(url, parsed), persona, None, patience, guard)
        case _:
            far = Host(parsed.host)
            far.seek()
            address = ("::" if ":" in parsed.host else "0.0.0.0", parsed.port)
            return UdpLink(url, address, persona, far, patience, guard)


def judge_url(url: str) -> None:
    """Check a URL without opening it. Raises LinkError, as `open_link` does, for one that can never be a link."""
    _options(url, _parsed(url).options)


def _parsed(url: str) -> urls.PortUrl:
    if url.strip().startswith("can:"):
        raise LinkError(f"'{url}': MAVLink does not go over CAN")
    try:
        parsed = urls.parse_url(url, _SCHEMES)
    except urls.TransportError as error:
        raise LinkError(str(error)) from error
    if parsed.host:
        try:
            transport.check_host(url, parsed.host)
        except urls.TransportError as error:
            raise LinkError(str(error)) from error
    return parsed


def open_links(urls: Sequence[str], patience: float = 1.0, warn: Callable[[str], None] | None = None) -> list[Link]:
    """Open all of them, or none. Raises LinkError for the first that cannot be opened.

    With `warn` a link whose port is in use is left out, and that is told, as long as another TCP server could be
    opened: where every port is taken, this is a second companion.
    """
    opened: list[Link] = []
    taken: list[LinkError] = []
    try:
        for url in urls:
            try:
                opened.append(open_link(url, patience))
            except PortInUse as error:
                taken.append(error)
        if taken and (warn is None or not any(isinstance(link, TcpServerLink) for link in opened)):
            raise taken[0]
    except LinkError:
        for link in opened:
            link.close()
        raise
    if warn is not None:
        for left_out in taken:
            warn(f"{left_out}; going on without it")
    return opened


def _options(url: str, given: Mapping[str, str]) -> tuple[Persona, Guard]:
    """Persona and guard from the options of a URL."""
    try:
        persona, options = parse_options(given)
    except OptionError as error:
        raise LinkError(f"'{url}': {error}") from error
    return persona, Guard(options)


def _opened(url: str) -> ByteStream:
    try:
        return transport.TransportOpener().open(url, url)
    except urls.TransportError as error:
        raise LinkError(str(error)) from error


def _own_address(url: str, parsed: urls.PortUrl) -> tuple[str, int]:
    """IP address and port at which a link listens."""
    if is_address(parsed.host):
        return parsed.host, parsed.port
    try:
        return look_up(parsed.host), parsed.port
    except (OSError, UnicodeError) as error:
        raise NoAddress(f"'{url}': host '{parsed.host}' not found; give its IP address") from error


class UdpLink:
    """A UDP link. `udpout` has one endpoint from the start, which moves where its name moves. All others are added at
    their first valid message, and removed after PEER_TIMEOUT_S of silence."""

    def __init__(
        self,
        url: str,
        address: tuple[str, int],
        persona: Persona,
        far: Host | None = None,
        patience: float = 1.0,
        guard: Guard | None = None,
    ) -> None:
        """`address`: where it listens; with a `far` host only its port counts: that of the far end."""
        self.name = url
        self.guard = Guard() if guard is None else guard
        self._far = far
        self._far_port = address[1]
        self._patience = patience
        self._timeout_s = PEER_TIMEOUT_S * patience
        self._rate = self.guard.options.rate_bytes_per_s or FAST_BYTES_PER_S
        self._persona = persona
        self._socket = bound_socket(url, address, socket.SOCK_DGRAM, bind=far is None)
        self._fault: str | None = None
        self._static: Endpoint | None = None
        self._static_address: tuple[str, int] | None = None
        self._peers: dict[Any, Endpoint] = {}
        self._follow_far()

    @property
    def address(self) -> tuple[str, int]:
        """(host, port) that this link's socket is bound to."""
        bound = self._socket.getsockname()
        return bound[0], bound[1]

    @property
    def endpoints(self) -> Sequence[Endpoint]:
        """As `Link.endpoints`."""
        return tuple(self._peers.values())

    def receive(self, now_s: float) -> Received:
        """As `Link.receive`."""
        self._seek_far(now_s)
        out: Received = []
        left = MOST_BYTES
        for _ in range(_RECEIVES):
            if left <= 0:
                break
            try:
                data, address = self._socket.recvfrom(MOST_BYTES)
            except (BlockingIOError, InterruptedError):
                break
            except ConnectionError:  # no program listens yet at the address that we sent to
                continue
            except OSError as error:
                self._fault = f"{self.name}: {error}"
                break
            left -= len(data)
            self._take(data, address[:2], now_s, out)
        self._forget(now_s)
        return out

    def filenos(self) -> Sequence[int]:
        """As `Link.filenos`."""
        number = self._socket.fileno()
        return (number,) if number >= 0 else ()

    def health(self, now_s: float) -> DeviceHealth:
        """As `Link.health`."""
        health = link_health(self.name, self.endpoints, self._fault or self._far_fault, now_s, self.guard)
        unproven = [host for (host, _), one in self._peers.items() if one.proof is not None and not one.proof.proven]
        if not health.ok or not unproven:
            return health
        text = f"{', '.join(sorted(set(unproven)))} has not proved that it hears us, and gets little"
        return replace(health, text="; ".join(part for part in (health.text, text) if part))

    def news(self) -> Sequence[str]:
        """As `Link.news`."""
        return ()

    def close(self) -> None:
        """As `Link.close`."""
        self._socket.close()

    @property
    def _far_fault(self) -> str | None:
        text = None if self._far is None else self._far.fault
        return None if text is None else f"{self.name}: {text}; trying again"

    def _seek_far(self, now_s: float) -> None:
        """While the far end is not heard, look its name up now and then, and follow it to a new address."""
        if self._far is None or self._far.fixed:
            return
        self._follow_far()
        heard_s = None if self._static is None else self._static.last_heard_s
        self._far.keep_up(heard_s is None or now_s - heard_s > self._timeout_s, now_s, self._patience)

    def _follow_far(self) -> None:
        """Let the endpoint of the far end have the address that its name has now."""
        if self._far is None or self._far.address is None:
            return
        address = (self._far.address, self._far_port)
        if address == self._static_address:
            return
        for left in (self._static_address, address):
            if (endpoint := self._peers.pop(left, None)) is not None:
                endpoint.gone = True
        self._static, self._static_address = self._endpoint(address, Framer()), address
        self._peers[address] = self._static

    def _take(self, data: bytes, address: Any, now_s: float, out: Received) -> None:
        known = self._peers.get(address)
        endpoint = self._newcomer(address) if known is None else known
        taken: Received = []
        if endpoint.proof is not None:
            endpoint.proof.received(len(data))
        # a frame does not span datagrams
        take_in(endpoint, endpoint.framer.feed(data) + endpoint.framer.flush(), now_s, taken)
        if known is None and not self._has_room(endpoint, address, now_s):
            return
        self._peers[address] = endpoint
        out += taken

    def _newcomer(self, address: Any) -> Endpoint:
        endpoint = self._endpoint(address, Framer())
        if self.guard.proves and needs_proof(address[0]):
            endpoint.proof = Proof()
        return endpoint

    def _has_room(self, newcomer: Endpoint, address: Any, now_s: float) -> bool:
        """Whether a new sender gets a slot, in place of another where all are taken. It needs a valid message."""
        if newcomer.last_heard_s is None:
            return False
        if len(self._peers) < MAX_PEERS:
            return True
        slots = {Slot(known[0], one): known for known, one in self._peers.items() if one is not self._static}
        left = to_leave(tuple(slots), address[0], newcomer.trusted, now_s, self._timeout_s)
        if left is None:
            return False
        left.endpoint.gone = True
        del self._peers[slots[left]]
        return True

    def _forget(self, now_s: float) -> None:
        for address, endpoint in list(self._peers.items()):
            heard_s = endpoint.last_heard_s
            if endpoint is not self._static and heard_s is not None and now_s - heard_s > self._timeout_s:
                endpoint.gone = True
                del self._peers[address]

    def _endpoint(self, address: Any, framer: Framer) -> Endpoint:
        def transmit(data: bytes, now_s: float) -> int:
            try:
                sent = self._socket.sendto(data, address)
                self._fault = None
                return sent
            except (BlockingIOError, InterruptedError, ConnectionError):
                return 0
            except OSError as error:  # the network is down; the next datagram tries again
                self._fault = f"{self.name}: {error.strerror or error}"
                return 0

        return Endpoint(
            f"{self.name} {address[0]}:{address[1]}",
            self._persona,
            transmit,
            datagrams=True,
            bytes_per_s=self._rate,
            framer=framer,
            guard=self.guard,
        )


class StreamLink:
    """A link with one endpoint on a byte stream that reopens by itself: a serial port, or a TCP connection that we
    make."""

    def __init__(
        self, url: str, stream: ByteStream, persona: Persona, bytes_per_s: float, guard: Guard | None = None
    ) -> None:
        self.name = url
        self.guard = Guard() if guard is None else guard
        self._stream = stream
        self._fed_s = 0.0
        self._noisy = bytes_per_s < FAST_BYTES_PER_S  # a line that may lose bytes inside a frame
        self._endpoint = Endpoint(url, persona, self._transmit, bytes_per_s=bytes_per_s, guard=self.guard)

    @property
    def endpoints(self) -> Sequence[Endpoint]:
        """As `Link.endpoints`."""
        return (self._endpoint,) if self._stream.fault() is None else ()

    def receive(self, now_s: float) -> Received:
        """As `Link.receive`."""
        out: Received = []
        framer = self._endpoint.framer
        for t_s, data in self._stream.read(now_s):
            self._fed_s = t_s
            take_in(self._endpoint, framer.feed(data), now_s, out)
        if self._noisy and framer.pending and now_s - self._fed_s > SILENCE_S:
            take_in(self._endpoint, framer.flush(), now_s, out)
        return out

    def filenos(self) -> Sequence[int]:
        """As `Link.filenos`."""
        number = self._stream.fileno()
        return () if number is None else (number,)

    def health(self, now_s: float) -> DeviceHealth:
        """As `Link.health`."""
        return link_health(self.name, (self._endpoint,), self._stream.fault(), now_s, self.guard)

    def news(self) -> Sequence[str]:
        """As `Link.news`."""
        return ()

    def close(self) -> None:
        """As `Link.close`."""
        self._stream.close()

    def _transmit(self, data: bytes, now_s: float) -> int:
        self._stream.write(data, now_s)
        return len(data)


class MemoryLink:
    """A link whose far end is in this process: `to_vessel` puts bytes in, `from_vessel` takes out what the vessel
    sent."""

    _MOST_BYTES = 16 << 20

    def __init__(self, url: str = "memory:") -> None:
        self.name = url
        query = url.partition("?")[2]
        options = dict(part.partition("=")[::2] for part in query.split("&")) if query else {}
        self._in = bytearray()
        self._out = bytearray()
        persona, self.guard = _options(url, options)
        rate = self.guard.options.rate_bytes_per_s or FAST_BYTES_PER_S
        self._endpoint = Endpoint(url, persona, self._transmit, bytes_per_s=rate, guard=self.guard)

    def to_vessel(self, data: bytes) -> None:
        """Bytes that the vessel receives at its next `receive`."""
        self._in += data

    def from_vessel(self) -> bytes:
        """All bytes that the vessel has sent since the last call."""
        data = bytes(self._out)
        self._out.clear()
        return data

    @property
    def endpoints(self) -> Sequence[Endpoint]:
        """As `Link.endpoints`."""
        return (self._endpoint,)

    def receive(self, now_s: float) -> Received:
        """As `Link.receive`."""
        out: Received = []
        if self._in:
            data = bytes(self._in)
            self._in.clear()
            take_in(self._endpoint, self._endpoint.framer.feed(data), now_s, out)
        return out

    def filenos(self) -> Sequence[int]:
        """As `Link.filenos`."""
        return ()

    def health(self, now_s: float) -> DeviceHealth:
        """As `Link.health`."""
        return link_health(self.name, self.endpoints, None, now_s, self.guard)

    def news(self) -> Sequence[str]:
        """As `Link.news`."""
        return ()

    def close(self) -> None:
        """As `Link.close`."""
        self._endpoint.gone = True

    def _transmit(self, data: bytes, now_s: float) -> int:
        if len(self._out) + len(data) <= self._MOST_BYTES:
            self._out += data
        return len(data)
