"""What all links to ground stations have in common."""

from __future__ import annotations

import errno
import socket
from collections.abc import Sequence
from typing import Any, Protocol

from companion.core.types import DeviceHealth
from companion.io.mavlink.endpoint import Endpoint
from companion.io.mavlink.framer import UnknownMessage
from companion.io.mavlink.guard import RADIO_STATUS, Guard

PEER_TIMEOUT_S = 15.0
MAX_PEERS = 16
MOST_BYTES = 16384  # in a call: a flooding peer must not hold the vessel; what is left keeps the descriptor readable

Received = list[tuple[Endpoint, Any]]


class LinkError(Exception):
    """A link that cannot be had; one line that says what to do."""


class Link(Protocol):
    """One link with any number of endpoints. `guard`: what it lets in and signs."""

    name: str
    guard: Guard

    @property
    def endpoints(self) -> Sequence[Endpoint]:
        """The remotes that can be written to now."""
        ...

    def receive(self, now_s: float) -> Received:
        """Messages that came in, each with where it came from: some 16 kB at a time, the rest at the next call."""
        ...

    def filenos(self) -> Sequence[int]:
        """Descriptors that become readable when something arrives."""
        ...

    def health(self, now_s: float) -> DeviceHealth: ...

    def news(self) -> Sequence[str]:
        """What people should know of the link, since the last call."""
        ...

    def close(self) -> None: ...


def bound_socket(url: str, address: tuple[str, int], kind: socket.SocketKind, bind: bool) -> socket.socket:
    """A socket that does not block, bound to `address` where asked. Raises LinkError with what to do."""
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
        raise LinkError(f"'{url}': {why_not_bound(error)}") from error
    return made


def why_not_bound(error: Exception) -> str:
    """What is wrong with an address, for people."""
    number = getattr(error, "errno", None)
    if number == errno.EADDRINUSE:
        return "port in use; stop the program that listens there, or choose another port with --link"
    if number == errno.EADDRNOTAVAIL:
        return "this computer has no such address; use 0.0.0.0 for all"
    if number in (errno.EACCES, errno.EPERM):
        return "permission denied; choose a port above 1023"
    return str(error)


def take_in(endpoint: Endpoint, messages: list[Any], now_s: float, out: Received) -> None:
    """Add the messages that the link's guard admits to `out`; their sender has been heard if one of them is certain to be a message.

    What is refused leaves no trace but in the guard's count. By RADIO_STATUS, which needs no signature, only the modem has been heard.
    """
    for message in messages:
        if not endpoint.guard.admits(message):
            continue
        out.append((endpoint, message))
        certain = message.__class__ is not UnknownMessage
        endpoint.traffic.received += certain
        if message.get_msgId() == RADIO_STATUS:
            continue
        endpoint.receptions.take(message.get_srcSystem(), message.get_srcComponent(), message.get_seq())
        if certain:
            endpoint.last_heard_s = now_s


def link_health(name: str, endpoints: Sequence[Endpoint], fault: str | None, now_s: float, guard: Guard | None = None) -> DeviceHealth:
    """Of a link: well unless it has a fault; its age is that of the newest message. `guard`: tells what was refused."""
    heard = [endpoint.last_heard_s for endpoint in endpoints if endpoint.last_heard_s is not None]
    age_s = now_s - max(heard) if heard else None
    texts = (fault, None if heard else "nobody heard yet", None if guard is None else guard.text)
    return DeviceHealth(name, fault is None, age_s, fault or "; ".join(text for text in texts if text))
