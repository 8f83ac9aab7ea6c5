"""The link that accepts ground stations over TCP."""

from __future__ import annotations

import contextlib
import socket
from collections.abc import Sequence
from dataclasses import dataclass

from companion.core.descriptors import NO_DESCRIPTORS
from companion.core.tick import DeviceHealth
from companion.io.mavlink.wire.endpoint import FAST_BYTES_PER_S, Endpoint
from companion.io.mavlink.wire.guard import Guard
from companion.io.mavlink.wire.link_base import (
    MOST_BYTES,
    PEER_TIMEOUT_S,
    Received,
    bound_socket,
    link_health,
    not_bound,
    take_in,
)
from companion.io.mavlink.wire.personas import Persona
from companion.io.mavlink.wire.slots import IDLE_S, MAX_PEERS, Slot, to_leave
from companion.io.mavlink.wire.spare import SpareDescriptor
from companion.io.transport.tcp_loss import notice_loss

_LEAST_SHARE = 1024  # bytes read from each client in one call, at least
_WAIT_S = 3.0  # for the first message of a client that has no slot
_MOST_USELESS_BYTES = 100_000  # from a client that does not speak MAVLink
_SEND_BUFFER = 1 << 18


@dataclass(slots=True)
class _Client:
    """A TCP client. `useless`: bytes since its last admitted frame. `waits_s`: since when it waits for a slot, which
    it gets only if it shows that it is an operator; None: it has one."""

    socket: socket.socket
    host: str
    endpoint: Endpoint
    waits_s: float | None = None
    useless: int = 0


class TcpServerLink:
    """A listening socket. Each client is an endpoint while it is connected.

    Remembers the clients in order of arrival. It closes a client that does not send MAVLink. Where all slots are taken,
    `slots.to_leave` says who makes room for a new client. One for whom nobody does waits a moment: if its first message
    shows an operator, it gets in.
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
        self._spare = SpareDescriptor()
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
        return tuple(client.endpoint for client in self._clients if client.waits_s is None)

    def receive(self, now_s: float) -> Received:
        """As `Link.receive`."""
        self._accept(now_s)
        out: Received = []
        share = max(_LEAST_SHARE, MOST_BYTES // max(1, len(self._clients)))
        for client in tuple(self._clients):
            if not client.endpoint.gone:
                self._read(client, share, now_s, out)
            if client.waits_s is not None and not client.endpoint.gone:
                self._judge(client, client.waits_s, now_s)
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
        self._spare.close()
        for client in tuple(self._clients):
            self._drop(client)

    def _accept(self, now_s: float) -> None:
        for _ in range(MAX_PEERS):
            try:
                accepted, address = self._listener.accept()
            except OSError as error:  # no client is waiting, or it has gone again
                if error.errno in NO_DESCRIPTORS and self._spare.turn_away(self._listener):
                    self._news.append(f"{self.name}: refused a client: no file descriptors left")
                return
            waits_s = None if self._has_room(address[0], False, now_s) else now_s
            if waits_s is not None and any(client.waits_s is not None for client in self._clients):
                accepted.close()
                self._refuse(address[0])
                continue
            accepted.setblocking(False)
            with contextlib.suppress(OSError):
                accepted.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                accepted.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, _SEND_BUFFER)
            notice_loss(accepted)
            endpoint = self._endpoint(accepted, f"{self.name} {address[0]}:{address[1]}")
            self._clients.append(_Client(accepted, address[0], endpoint, waits_s))

    def _judge(self, client: _Client, waits_s: float, now_s: float) -> None:
        """A client that waits gets a slot if it is trusted; it is closed after its first message, or a while."""
        if client.endpoint.trusted and self._has_room(client.host, True, now_s):
            client.waits_s = None
        elif client.endpoint.last_heard_s is not None or now_s - waits_s > _WAIT_S:
            client.endpoint.gone = True
            self._refuse(client.host)

    def _refuse(self, host: str) -> None:
        self._news.append(f"{self.name}: refused {host}: {MAX_PEERS} clients are connected and active")

    def _has_room(self, host: str, trusted: bool, now_s: float) -> bool:
        """Whether a new client gets a slot, in place of another where all are taken."""
        seated = {Slot(client.host, client.endpoint): client for client in self._clients if client.waits_s is None}
        if len(seated) < MAX_PEERS:
            return True
        left = to_leave(tuple(seated), host, trusted, now_s, self._timeout_s)
        if left is None:
            return False
        heard_s = left.endpoint.last_heard_s
        silence_s = None if heard_s is None else now_s - heard_s
        how = ", never heard" if silence_s is None else f", silent for {silence_s:.0f} s" if silence_s > IDLE_S else ""
        self._news.append(f"{self.name}: closed a client at {left.host}{how}, to make room for {host}")
        self._drop(seated[left])
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
