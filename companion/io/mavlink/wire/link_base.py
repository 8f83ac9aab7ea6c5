"""The interface of all links to ground stations, and what they share."""

from __future__ import annotations

import errno
import socket
from collections.abc import Sequence
from typing import Any, Protocol

from companion.core.tick import DeviceHealth
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.endpoint import Endpoint
from companion.io.mavlink.wire.framer import UnknownMessage
from companion.io.mavlink.wire.guard import RADIO_STATUS, Guard

PEER_TIMEOUT_S = 15.0
MOST_BYTES = 16384  # read in one call: a flood must not hold the vessel up; the rest keeps the descriptor readable

Received = list[tuple[Endpoint, Any]]


class LinkError(Exception):
    """A link that cannot be opened; the message is one line that says what to do."""


class PortInUse(LinkError):
    """Another program listens at the link's port."""


class NoAddress(LinkError):
    """An address of its own that this computer does not have; while it starts, it may have it yet."""


class Link(Protocol):
    """One link with any number of endpoints. `guard`: its options, applied to each packet."""

    name: str
    guard: Guard

    @property
    def endpoints(self) -> Sequence[Endpoint]:
        """The endpoints that can be written to now."""
        ...

    def receive(self, now_s: float) -> Received:
        """Messages that came in, each with its endpoint. At most about 16 kB; the rest comes with the next call."""
        ...

    def filenos(self) -> Sequence[int]:
        """File descriptors that become readable when bytes arrive."""
        ...

    def health(self, now_s: float) -> DeviceHealth:
        """State of the link, for the display of devices."""
        ...

    def news(self) -> Sequence[str]:
        """Texts to announce that have come up since the last call."""
        ...

    def close(self) -> None:
        """Close all sockets and ports of the link."""
        ...


def bound_socket(url: str, address: tuple[str, int], kind: socket.SocketKind, bind: bool) -> socket.socket:
    """A non-blocking socket, bound to `address` if `bind`. Raises LinkError with what to do."""
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
        raise not_bound(url, error) from error
    return made


def not_bound(url: str, error: Exception) -> LinkError:
    """Why the socket of a link could not be bound, and what to do, in words."""
    if getattr(error, "errno", None) == errno.EADDRINUSE:
        text = "port in use; stop the program that listens there, or choose another port with --link"
        return PortInUse(f"'{url}': {text}")
    if getattr(error, "errno", None) == errno.EADDRNOTAVAIL:
        return NoAddress(f"'{url}': this computer has no such address; use 0.0.0.0 for all")
    return LinkError(f"'{url}': {_why_not_bound(error)}")


def _why_not_bound(error: Exception) -> str:
    number = getattr(error, "errno", None)
    if number in (errno.EACCES, errno.EPERM):
        return "permission denied; choose a port above 1023"
    return str(error)


def take_in(endpoint: Endpoint, messages: list[Any], now_s: float, out: Received) -> None:
    """Add the messages that the link's guard admits to `out`, and update the endpoint's counts.

    The endpoint counts as heard if one of them is of a known id. A refused message changes only the guard's counts.
    RADIO_STATUS comes from the modem and needs no signature, so it does not count as the far end being heard. It tells
    how much the modem can pass on.
    """
    for message in messages:
        if not endpoint.guard.admits(message):
            continue
        out.append((endpoint, message))
        certain = message.__class__ is not UnknownMessage
        endpoint.traffic.received += certain
        if message.get_msgId() == RADIO_STATUS:
            endpoint.radio_status(message.txbuf, now_s)
            continue
        endpoint.receptions.take(message.get_srcSystem(), message.get_srcComponent(), message.get_seq())
        if certain:
            _note_heard(endpoint, message, now_s)


def _note_heard(endpoint: Endpoint, message: Any, now_s: float) -> None:
    endpoint.last_heard_s = now_s
    if endpoint.first_heard_s is None:
        endpoint.first_heard_s = now_s
    if message.get_msgId() != mavlink.MAVLINK_MSG_ID_HEARTBEAT:
        endpoint.asked_s = now_s
    endpoint.trusted = endpoint.trusted or endpoint.guard.trusts(message)


def link_health(
    name: str, endpoints: Sequence[Endpoint], fault: str | None, now_s: float, guard: Guard | None = None
) -> DeviceHealth:
    """Health of a link: good unless it has a fault. Its age is that of the newest message. `guard`: adds what it
    refused. A radio that cannot keep up with its line is told of."""
    heard = [endpoint.last_heard_s for endpoint in endpoints if endpoint.last_heard_s is not None]
    age_s = now_s - max(heard) if heard else None
    slow = next((one for one in endpoints if one.bytes_per_s < one.line_bytes_per_s), None)
    radio = None if slow is None else f"radio passes on {slow.bytes_per_s:.0f} of {slow.line_bytes_per_s:.0f} bytes/s"
    if fault is not None:  # who shows it puts the name before it
        fault = fault.removeprefix(f"{name}: ").removeprefix(f"{name.partition('?')[0]}: ")
    texts = (fault, None if heard else "nobody heard yet", None if guard is None else guard.text, radio)
    return DeviceHealth(name, fault is None, age_s, fault or "; ".join(text for text in texts if text))
