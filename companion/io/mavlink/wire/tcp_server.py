"""The link that accepts ground stations over TCP."""

from __future__ import annotations

import contextlib
import math
import socket
from collections.abc import Sequence
from dataclasses import dataclass

from companion.core.tick import DeviceHealth
from companion.io.mavlink.wire.endpoint import FAST_BYTES_PER_S, Endpoint
from companion.io.mavlink.wire.guard import Guard
from companion.io.mavlink.wire.link_base import (
    MAX_PEERS,
    MOST_BYTES,
    PEER_TIMEOUT_S,
    Received,
    bound_socket,
    link_health,
    not_bound,
    take_in,
)
from companion.io.mavlink.wire.personas import Persona

_LEAST_SHARE = 1024  # bytes read from each client in one call, at least
_MOST_USELESS_BYTES = 100_000  # from a client that does not speak MAVLink
_SEND_BUFFER = 1 << 18
_TCP_OPTIONS = (  # detect a client whose network is gone within about 15 s, where the operating system can
    ("IPPROTO_TCP", "TCP_NODELAY", 1),
    ("SOL_SOCKET", "SO_SNDBUF", _SEND_BUFFER),
    ("SOL_SOCKET", "SO_KEEPALIVE", 1),
    ("IPPROTO_TCP", "TCP_KEEPIDLE", 5),
    ("IPPROTO_TCP", "TCP_KEEPINTVL", 5),
    ("IPPROTO_TCP", "TCP_KEEPCNT", 2),
    ("IPPROTO_TCP", "TCP_USER_TIMEOUT", round(PEER_TIMEOUT_S * 1000)),
)


@dataclass(slots=True)
class _Client:
    """A TCP client. `useless`: bytes since its last admitted frame."""

    socket: socket.socket
    host: str
    endpoint: Endpoint
    useless: int = 0


class TcpServerLink:
    """A listening socket. Each client is an endpoint while it is connected.

    Remembers the clients in order of arrival. It closes a client that does not send MAVLink. To make room for a new
    client, it closes one that was never heard, or the one that has been silent longest.
    """

    def __init__(
        self, url: str, address: tuple[str, int], persona: Persona, patience: float = 1.0, guard: Guard | None = None
    ) -> None:
        self.name = url
        self.guard = Guard() if guard is None else guard
        self._persona = persona
        self._timeout_s = PEER_TIMEOUT_S * patience
        self._listener = bound_socket(url, address, socket.SOCK_STREAM, bind=True)
        try:
            self._listener.listen(8)
        except OSError as error:
            self._listener.close()
            raise not_bound(url, error) from error
        self._clients: list[_Client] = []
        self._news: list[str] = []

    @property
    def address(self) -> tuple[str, int]:
        """(host, port) that this link listens on."""
        bound = self._listener.getsockname()
        return bound[0], bound[1]

    @property
    def endpoints(self) -> Sequence[Endpoint]:
        """As `Link.endpoints`."""
        return tuple(client.endpoint for client in self._clients)

    def receive(self, now_s: float) -> Received:
        """As `Link.receive`."""
        self._accept(now_s)
        out: Received = []
        share = max(_LEAST_SHARE, MOST_BYTES // max(1, len(self._clients)))
        for client in tuple(self._clients):
            if not client.endpoint.gone:
                self._read(client, share, now_s, out)
            if client.endpoint.gone:
                self._drop(client)
        return out

    def filenos(self) -> Sequence[int]:
        """As `Link.filenos`."""
        sockets = (self._listener, *(client.socket for client in self._clients))
        return [one.fileno() for one in sockets if one.fileno() >= 0]

    def health(self, now_s: float) -> DeviceHealth:
        """As `Link.health`."""
        return link_health(self.name, self.endpoints, None, now_s, self.guard)

    def news(self) -> Sequence[str]:
        """As `Link.news`."""
        news, self._news = self._news, []
        return news

    def close(self) -> None:
        """As `Link.close`."""
        self._listener.close()
        for client in tuple(self._clients):
            self._drop(client)

    def _accept(self, now_s: float) -> None:
        for _ in range(MAX_PEERS):
            try:
                accepted, address = self._listener.accept()
            except OSError:  # no client is waiting, or it has gone again
                return
            if len(self._clients) >= MAX_PEERS and not self._make_room(now_s):
                accepted.close()
                self._news.append(f"{self.name}: refused {address[0]}: {MAX_PEERS} clients are connected and active")
                continue
            accepted.setblocking(False)
            for level, option, value in _TCP_OPTIONS:
                if hasattr(socket, option):
                    with contextlib.suppress(OSError):
                        accepted.setsockopt(getattr(socket, level), getattr(socket, option), value)
            endpoint = self._endpoint(accepted, f"{self.name} {address[0]}:{address[1]}")
            self._clients.append(_Client(accepted, address[0], endpoint))

    def _make_room(self, now_s: float) -> bool:
        """Close the client that was silent longest. False where all were heard lately."""

        def last_heard_s(client: _Client) -> float:
            heard_s = client.endpoint.last_heard_s
            return -math.inf if heard_s is None else heard_s

        quietest = min(self._clients, key=last_heard_s)
        silence_s = now_s - last_heard_s(quietest)
        if silence_s < self._timeout_s and not quietest.endpoint.gone:
            return False
        how = "never heard" if math.isinf(silence_s) else f"silent for {silence_s:.0f} s"
        self._news.append(f"{self.name}: closed a client at {quietest.host}, {how}, to make room for another")
        self._drop(quietest)
        return True

    def _drop(self, client: _Client) -> None:
        client.endpoint.gone = True
        client.socket.close()
        self._clients.remove(client)

    def _endpoint(self, client: socket.socket, name: str) -> Endpoint:
        def transmit(data: bytes, now_s: float) -> int:
            try:
                return client.send(data)
            except (BlockingIOError, InterruptedError):
                return 0
            except OSError:
                endpoint.gone = True
                return 0

        rate = self.guard.options.rate_bytes_per_s or FAST_BYTES_PER_S
        endpoint = Endpoint(name, self._persona, transmit, bytes_per_s=rate, guard=self.guard)
        return endpoint

    def _read(self, client: _Client, most: int, now_s: float, out: Received) -> None:
        try:
            data = client.socket.recv(most)
        except (BlockingIOError, InterruptedError):
            return
        except OSError:
            data = b""
        endpoint = client.endpoint
        if not data:
            endpoint.gone = True
            return
        received = endpoint.traffic.received
        take_in(endpoint, endpoint.framer.feed(data), now_s, out)
        client.useless = 0 if endpoint.traffic.received != received else client.useless + len(data)
        if client.useless > _MOST_USELESS_BYTES:
            endpoint.gone = True
            self._news.append(f"{self.name}: closed a client at {client.host}: it sends no valid MAVLink")
