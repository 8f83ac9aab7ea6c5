"""The links on which ground stations are met. None of them ever blocks or raises for what the other side or the network does.

    udpout:192.168.1.20:14550   send there, and answer whoever else writes to our socket
    udpin:0.0.0.0:14550         answer whoever writes first; forgotten after 15 s of silence
    tcpin:0.0.0.0:5760          any number of clients connect
    tcpout:192.168.1.20:5760    connect, and again when the connection breaks
    serial:/dev/ttyUSB0:57600   a telemetry radio
    memory:name                 tests and lockstep: the other end is in this process

`?dialect=px4|ardupilot|generic` behind any of them chooses what the clients of that link are told that we are.
"""

from __future__ import annotations

import contextlib
import errno
import socket
from collections.abc import Sequence
from typing import Any, Protocol

from companion.core.ports import ByteStream
from companion.core.types import DeviceHealth
from companion.io import transport, urls
from companion.io.mavlink.dialects import DEFAULT_DIALECT, DIALECTS, Dialect
from companion.io.mavlink.endpoint import FAST_BYTES_PER_S, Endpoint
from companion.io.mavlink.framer import Framer, UnknownMessage

PEER_TIMEOUT_S = 15.0
SILENCE_S = 0.3  # a serial line that pauses this long in mid-frame will not finish it
_MAX_PEERS = 16
_RECEIVES = 64  # datagrams or chunks in a call: a flooding peer must not hold the vessel
_CHUNK = 65536
_SEND_BUFFER = 1 << 18

Received = list[tuple[Endpoint, Any]]


class LinkError(Exception):
    """A link that cannot be had; one line that says what to do."""


class Link(Protocol):
    """One link with any number of endpoints."""

    name: str

    @property
    def endpoints(self) -> Sequence[Endpoint]:
        """The remotes that can be written to now."""
        ...

    def receive(self, now_s: float) -> Received:
        """Messages that came in since the last call, each with where it came from."""
        ...

    def filenos(self) -> Sequence[int]:
        """Descriptors that become readable when something arrives."""
        ...

    def health(self, now_s: float) -> DeviceHealth: ...

    def close(self) -> None: ...


def open_link(url: str) -> Link:
    """The link of a URL. Raises LinkError with one line for a URL that cannot be used or a port that is taken."""
    body = url.strip().partition("?")[0]
    if body.startswith("memory:"):
        return MemoryLink(url)
    try:
        parsed = urls.parse_url(url)
    except urls.TransportError as error:
        raise LinkError(str(error)) from error
    dialect = _dialect(url, parsed.options)
    if parsed.scheme == "serial":
        return StreamLink(url, _opened(body), dialect, parsed.baud / 10.0)
    address = _resolved(url, parsed.host, parsed.port)
    match parsed.scheme:
        case "tcpout":
            host = f"[{address[0]}]" if ":" in address[0] else address[0]
            return StreamLink(url, _opened(f"tcpout:{host}:{address[1]}"), dialect, FAST_BYTES_PER_S)
        case "tcpin":
            return TcpServerLink(url, address, dialect)
        case _:
            return UdpLink(url, address, dialect, listens=parsed.scheme == "udpin")


def _dialect(url: str, options: Any) -> Dialect:
    for key in options:
        if key != "dialect":
            raise LinkError(f"'{url}': unknown option '{key}'; known here: dialect")
    name = options.get("dialect", DEFAULT_DIALECT.name)
    if name not in DIALECTS:
        raise LinkError(f"'{url}': dialect should be one of {', '.join(DIALECTS)}")
    return DIALECTS[name]


def _opened(url: str) -> ByteStream:
    try:
        return transport.TransportOpener().open(url, url)
    except urls.TransportError as error:
        raise LinkError(str(error)) from error


def _resolved(url: str, host: str, port: int) -> tuple[str, int]:
    """The address behind a host name, looked up once."""
    try:
        found = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)
    except (OSError, UnicodeError) as error:
        raise LinkError(f"'{url}': there is no host '{host}'; give its IP address") from error
    address = found[0][4]
    return str(address[0]), int(address[1])


def _socket(url: str, address: tuple[str, int], kind: socket.SocketKind, bind: bool) -> socket.socket:
    made = socket.socket(socket.AF_INET6 if ":" in address[0] else socket.AF_INET, kind)
    made.setblocking(False)
    try:
        if kind == socket.SOCK_STREAM:
            made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        else:
            made.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        if bind:
            made.bind(address)
    except (OSError, OverflowError) as error:
        made.close()
        raise LinkError(f"'{url}': {_why_not_bound(error)}") from error
    return made


def _why_not_bound(error: Exception) -> str:
    number = getattr(error, "errno", None)
    if number == errno.EADDRINUSE:
        return "port in use; stop the program that listens there, or choose another port with --link"
    if number == errno.EADDRNOTAVAIL:
        return "this computer has no such address; use 0.0.0.0 for all"
    if number in (errno.EACCES, errno.EPERM):
        return "permission denied; choose a port above 1023"
    return str(error)


def _heard(endpoint: Endpoint, messages: list[Any], now_s: float, out: Received) -> None:
    for message in messages:
        out.append((endpoint, message))
    if messages:
        endpoint.last_heard_s = now_s


def _health(name: str, endpoints: Sequence[Endpoint], fault: str | None, now_s: float) -> DeviceHealth:
    heard = [endpoint.last_heard_s for endpoint in endpoints if endpoint.last_heard_s is not None]
    age_s = now_s - max(heard) if heard else None
    return DeviceHealth(name, fault is None, age_s, fault or ("" if heard else "nobody heard yet"))


class UdpLink:
    """Datagrams. `udpout` has one endpoint from the start; others, and all of `udpin`'s, are learned from their first valid message."""

    def __init__(self, url: str, address: tuple[str, int], dialect: Dialect, listens: bool) -> None:
        self.name = url
        self._dialect = dialect
        self._socket = _socket(url, address, socket.SOCK_DGRAM, bind=listens)
        self._fault: str | None = None
        self._static: Endpoint | None = None
        self._peers: dict[Any, Endpoint] = {}
        if not listens:
            self._static = self._endpoint(address, Framer())
            self._peers[address] = self._static

    @property
    def address(self) -> tuple[str, int]:
        """Where this link's socket is bound."""
        bound = self._socket.getsockname()
        return bound[0], bound[1]

    @property
    def endpoints(self) -> Sequence[Endpoint]:
        return tuple(self._peers.values())

    def receive(self, now_s: float) -> Received:
        out: Received = []
        for _ in range(_RECEIVES):
            try:
                data, address = self._socket.recvfrom(_CHUNK)
            except (BlockingIOError, InterruptedError):
                break
            except ConnectionError:  # nobody listens where we sent to, as yet
                continue
            except OSError as error:
                self._fault = f"{self.name}: {error}"
                break
            self._take(data, address[:2], now_s, out)
        self._forget(now_s)
        return out

    def filenos(self) -> Sequence[int]:
        number = self._socket.fileno()
        return (number,) if number >= 0 else ()

    def health(self, now_s: float) -> DeviceHealth:
        return _health(self.name, self.endpoints, self._fault, now_s)

    def close(self) -> None:
        self._socket.close()

    def _take(self, data: bytes, address: Any, now_s: float, out: Received) -> None:
        endpoint = self._peers.get(address)
        framer = Framer() if endpoint is None else endpoint.framer
        messages = framer.feed(data) + framer.flush()  # a frame does not span datagrams
        if endpoint is None:
            if len(self._peers) >= _MAX_PEERS or all(isinstance(message, UnknownMessage) for message in messages):
                return
            endpoint = self._peers[address] = self._endpoint(address, framer)
        _heard(endpoint, messages, now_s, out)

    def _forget(self, now_s: float) -> None:
        for address, endpoint in list(self._peers.items()):
            heard_s = endpoint.last_heard_s
            if endpoint is not self._static and heard_s is not None and now_s - heard_s > PEER_TIMEOUT_S:
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

        return Endpoint(f"{self.name} {address[0]}:{address[1]}", self._dialect, transmit, datagrams=True, framer=framer)


class TcpServerLink:
    """A listening socket; each client is an endpoint for as long as it stays."""

    def __init__(self, url: str, address: tuple[str, int], dialect: Dialect) -> None:
        self.name = url
        self._dialect = dialect
        self._listener = _socket(url, address, socket.SOCK_STREAM, bind=True)
        try:
            self._listener.listen(8)
        except OSError as error:
            self._listener.close()
            raise LinkError(f"'{url}': {_why_not_bound(error)}") from error
        self._clients: dict[socket.socket, Endpoint] = {}

    @property
    def address(self) -> tuple[str, int]:
        """Where this link listens."""
        bound = self._listener.getsockname()
        return bound[0], bound[1]

    @property
    def endpoints(self) -> Sequence[Endpoint]:
        return tuple(self._clients.values())

    def receive(self, now_s: float) -> Received:
        self._accept()
        out: Received = []
        for client, endpoint in list(self._clients.items()):
            if not endpoint.gone:
                self._read(client, endpoint, now_s, out)
            if endpoint.gone:
                del self._clients[client]
                client.close()
        return out

    def filenos(self) -> Sequence[int]:
        return [s.fileno() for s in (self._listener, *self._clients) if s.fileno() >= 0]

    def health(self, now_s: float) -> DeviceHealth:
        return _health(self.name, self.endpoints, None, now_s)

    def close(self) -> None:
        for client in (self._listener, *self._clients):
            client.close()
        self._clients.clear()

    def _accept(self) -> None:
        for _ in range(_MAX_PEERS):
            try:
                client, address = self._listener.accept()
            except OSError:  # nobody waits, or who did has gone again
                return
            if len(self._clients) >= _MAX_PEERS:
                client.close()
                continue
            client.setblocking(False)
            with contextlib.suppress(OSError):
                client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                client.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER)
            self._clients[client] = self._endpoint(client, f"{self.name} {address[0]}:{address[1]}")

    def _endpoint(self, client: socket.socket, name: str) -> Endpoint:
        def transmit(data: bytes, now_s: float) -> int:
            try:
                return client.send(data)
            except (BlockingIOError, InterruptedError):
                return 0
            except OSError:
                endpoint.gone = True
                return 0

        endpoint = Endpoint(name, self._dialect, transmit)
        return endpoint

    @staticmethod
    def _read(client: socket.socket, endpoint: Endpoint, now_s: float, out: Received) -> None:
        for _ in range(_RECEIVES):
            try:
                data = client.recv(_CHUNK)
            except (BlockingIOError, InterruptedError):
                return
            except OSError:
                data = b""
            if not data:
                endpoint.gone = True
                return
            _heard(endpoint, endpoint.framer.feed(data), now_s, out)


class StreamLink:
    """One remote behind a byte stream that opens and reopens by itself: a serial port, a TCP connection that we make."""

    def __init__(self, url: str, stream: ByteStream, dialect: Dialect, bytes_per_s: float) -> None:
        self.name = url
        self._stream = stream
        self._fed_s = 0.0
        self._noisy = bytes_per_s < FAST_BYTES_PER_S  # a line that loses bytes in mid-frame
        self._endpoint = Endpoint(url, dialect, self._transmit, bytes_per_s=bytes_per_s)

    @property
    def endpoints(self) -> Sequence[Endpoint]:
        return (self._endpoint,) if self._stream.fault() is None else ()

    def receive(self, now_s: float) -> Received:
        out: Received = []
        framer = self._endpoint.framer
        for t_s, data in self._stream.read(now_s):
            self._fed_s = t_s
            _heard(self._endpoint, framer.feed(data), now_s, out)
        if self._noisy and framer.pending and now_s - self._fed_s > SILENCE_S:
            _heard(self._endpoint, framer.flush(), now_s, out)
        return out

    def filenos(self) -> Sequence[int]:
        number = self._stream.fileno()
        return () if number is None else (number,)

    def health(self, now_s: float) -> DeviceHealth:
        return _health(self.name, (self._endpoint,), self._stream.fault(), now_s)

    def close(self) -> None:
        self._stream.close()

    def _transmit(self, data: bytes, now_s: float) -> int:
        self._stream.write(data, now_s)
        return len(data)


class MemoryLink:
    """A link whose other end is in this process: `to_vessel` puts bytes in, `from_vessel` takes out what the vessel has sent."""

    _MOST_BYTES = 16 << 20

    def __init__(self, url: str = "memory:") -> None:
        self.name = url
        query = url.partition("?")[2]
        options = dict(part.partition("=")[::2] for part in query.split("&")) if query else {}
        self._in = bytearray()
        self._out = bytearray()
        self._endpoint = Endpoint(url, _dialect(url, options), self._transmit)

    def to_vessel(self, data: bytes) -> None:
        self._in += data

    def from_vessel(self) -> bytes:
        """Everything that the vessel has sent since the last call."""
        data = bytes(self._out)
        self._out.clear()
        return data

    @property
    def endpoints(self) -> Sequence[Endpoint]:
        return (self._endpoint,)

    def receive(self, now_s: float) -> Received:
        out: Received = []
        if self._in:
            data = bytes(self._in)
            self._in.clear()
            _heard(self._endpoint, self._endpoint.framer.feed(data), now_s, out)
        return out

    def filenos(self) -> Sequence[int]:
        return ()

    def health(self, now_s: float) -> DeviceHealth:
        return _health(self.name, self.endpoints, None, now_s)

    def close(self) -> None:
        self._endpoint.gone = True

    def _transmit(self, data: bytes, now_s: float) -> int:
        if len(self._out) + len(data) <= self._MOST_BYTES:
            self._out += data
        return len(data)
