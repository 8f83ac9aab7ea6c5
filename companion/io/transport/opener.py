"""Opens the ports of devices as byte streams that never block, never raise, and come back by themselves.

serial:/dev/usv-gnss:115200     a serial port, locked to this process; `?parity=even&stopbits=2` for some devices
udpin:0.0.0.0:5000              listen for datagrams; answers go to the last sender
udpout:192.168.1.20:5000        send datagrams there and hear its answers
tcpout:192.168.1.20:4001        connect (serial servers, bridges)
tcpin:0.0.0.0:4001              wait for one device to connect; a newer connection replaces the older
can:can0                        a CAN bus (`companion/io/transport/can_line.py`)

A host is an IP address, or a name (`bluerov.local`), which is looked up beside the control thread whenever the line is
opened. A line of datagrams on which nothing is heard looks its name up again every 30 s.
"""

from __future__ import annotations

import contextlib
import errno
import os
import socket
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from companion.core.can_frame import stand_in
from companion.core.descriptors import NO_DESCRIPTORS
from companion.io.transport.line import Line
from companion.io.transport.names import Host, NameUnknown, is_address, is_name
from companion.io.transport.serial_line import PARITIES, STOPBITS, SerialLine
from companion.io.transport.tap import Tap
from companion.io.transport.tcp_loss import notice_loss
from companion.io.transport.urls import PortUrl, TransportError, parse_url

_OPTIONS: dict[str, dict[str, Sequence[str]]] = {
    "serial": {"parity": tuple(PARITIES), "stopbits": tuple(STOPBITS)},
    "can": {"interface": ("socketcan", "udp_multicast", "virtual")},
}
_CONNECT_TIMEOUT_S = 5.0
_CHUNK = 4096
_DEV = "/dev/"


class SocketLine(Line):
    """What the four kinds of socket share: one socket that carries the bytes."""

    _socket: socket.socket | None = None
    _begun = False

    def __init__(self, name: str, url: str, endpoint: PortUrl) -> None:
        self._host = Host(endpoint.host)
        super().__init__(name, url, endpoint)

    def _connect(self) -> None:
        self._begun = False
        self._host.seek()
        if self._host.fixed:
            self._begin()

    def _begin(self) -> None:
        """Open the socket; the address is known, or cannot be found. Raises OSError."""
        self._open_socket()
        self._begun = True

    @abstractmethod
    def _open_socket(self) -> None: ...

    def _established(self, now_s: float) -> bool:
        if not self._begun:
            if self._host.seeking:
                return False
            self._begin()
        return self._connected(now_s)

    def _connected(self, now_s: float) -> bool:
        return True

    def fault(self) -> str | None:
        """See `ByteStream`."""
        if self._open and not self._begun:
            return f"{self._url}: {self._host.fault or 'opening'}"
        return super().fault()

    def _explain(self, error: BaseException) -> str:
        text = super()._explain(error)
        also = None if isinstance(error, NameUnknown) else self._host.fault
        return f"{text}; {also}" if also else text

    def _new_socket(self, kind: socket.SocketKind) -> socket.socket:
        family = socket.AF_INET6 if ":" in self._host.found() else socket.AF_INET
        made = socket.socket(family, kind)
        made.setblocking(False)
        return made

    def _address(self) -> tuple[str, int]:
        return self._host.found(), self._endpoint.port

    def _disconnect(self) -> None:
        carried, self._socket = self._socket, None
        if carried is not None:
            carried.close()

    def _descriptor(self) -> int | None:
        return None if self._socket is None else self._socket.fileno()


class UdpLine(SocketLine):
    """Datagrams, listening (`udpin`) or sending first (`udpout`). Each datagram is one chunk."""

    _peer: tuple[str, int] | None = None
    _heard = False

    def _open_socket(self) -> None:
        self._socket = self._new_socket(socket.SOCK_DGRAM)
        if self._endpoint.scheme == "udpin":
            self._socket.bind(self._address())
        else:
            self._peer = self._address()

    def _connected(self, now_s: float) -> bool:
        """Look the name of a silent peer up again now and then."""
        if self._endpoint.scheme == "udpout":
            self._host.keep_up(not self._heard, now_s)
            self._heard = False
            self._peer = self._address()
        return True

    def fault(self) -> str | None:
        """See `ByteStream`; the name, where it is not found any more."""
        return super().fault() or (f"{self._url}: {self._host.fault}" if self._host.fault else None)

    def _receive(self) -> bytes:
        assert self._socket is not None
        try:
            data, peer = self._socket.recvfrom(65535)
        except (BlockingIOError, InterruptedError, ConnectionError):  # the last: nothing listens there yet
            return b""
        if self._endpoint.scheme == "udpin":
            self._peer = peer
        self._heard = True
        return data

    def _transmit(self, data: bytes) -> int:
        assert self._socket is not None
        if self._peer is not None:
            with contextlib.suppress(BlockingIOError, InterruptedError, ConnectionError):
                self._socket.sendto(data, self._peer)
        return len(data)


class TcpLine(SocketLine):
    """A TCP connection that carries the bytes, however it came about."""

    def _receive(self) -> bytes:
        if self._socket is None:
            return b""
        try:
            data = self._socket.recv(_CHUNK)
        except (BlockingIOError, InterruptedError):
            return b""
        if not data:
            raise OSError("the other side closed the connection")
        return data

    def _transmit(self, data: bytes) -> int:
        if self._socket is None:
            return len(data)
        try:
            return self._socket.send(data)
        except (BlockingIOError, InterruptedError):
            return 0


class TcpClientLine(TcpLine):
    """`tcpout`: connects, without waiting for it."""

    _made = False
    _give_up_s: float | None = None

    def _open_socket(self) -> None:
        self._made = False
        self._give_up_s = None
        self._socket = self._new_socket(socket.SOCK_STREAM)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        notice_loss(self._socket)
        result = self._socket.connect_ex(self._address())
        if result not in (0, errno.EINPROGRESS):
            raise OSError(result, os.strerror(result))

    def _connected(self, now_s: float) -> bool:
        if self._made:
            return True
        assert self._socket is not None
        result = self._socket.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
        if result:
            raise OSError(result, os.strerror(result))
        try:
            self._socket.getpeername()
            self._made = True
        except OSError:
            self._give_up_s = now_s + _CONNECT_TIMEOUT_S if self._give_up_s is None else self._give_up_s
            if now_s >= self._give_up_s:
                raise OSError("no answer") from None
        return self._made

    def _descriptor(self) -> int | None:
        return super()._descriptor() if self._made else None

    def fault(self) -> str | None:
        """See `ByteStream`; "connecting" until the connection is made."""
        return f"{self._url}: connecting" if self._begun and self._open and not self._made else super().fault()


class TcpServerLine(TcpLine):
    """`tcpin`: one peer at a time. A newer connection replaces the older, which may be dead without a sign."""

    _listener: socket.socket | None = None
    _full = False  # a peer waits, and there is no descriptor for it

    def _open_socket(self) -> None:
        if self._listener is None:
            listener = self._new_socket(socket.SOCK_STREAM)
            self._listener = listener
            listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            listener.bind(self._address())
            listener.listen(2)

    def _disconnect(self) -> None:
        super()._disconnect()
        listener, self._listener = self._listener, None
        if listener is not None:
            listener.close()

    def _connected(self, now_s: float) -> bool:
        assert self._listener is not None
        self._full = False
        with contextlib.suppress(BlockingIOError, InterruptedError, ConnectionError):
            newer = self._accepted(self._listener)
            if newer is None:
                return self._socket is not None
            newer.setblocking(False)
            newer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            notice_loss(newer)
            self._hang_up()
            self._socket = newer
        return self._socket is not None

    def _accepted(self, listener: socket.socket) -> socket.socket | None:
        """The peer that waits; None while there is no descriptor for it: the one that is there stays."""
        try:
            return listener.accept()[0]
        except OSError as error:
            self._full = error.errno in NO_DESCRIPTORS
            if not self._full:
                raise
        return None

    def _hang_up(self) -> None:
        self._pending = b""
        super()._disconnect()

    def _drop(self, fault: str, now_s: float) -> None:
        self._hang_up()  # and go on listening

    def _descriptor(self) -> int | None:
        if self._socket is not None:
            return super()._descriptor()
        return None if self._listener is None or self._full else self._listener.fileno()  # full: wake nobody

    def fault(self) -> str | None:
        """See `ByteStream`; "waiting" until a device has connected."""
        return (
            f"{self._url}: waiting for the device to connect"
            if self._begun and self._open and self._socket is None
            else super().fault()
        )


_LINES: dict[str, type[Line]] = {
    "serial": SerialLine,
    "udpin": UdpLine,
    "udpout": UdpLine,
    "tcpin": TcpServerLine,
    "tcpout": TcpClientLine,
}


class TransportOpener:
    """Opens real ports (a `StreamOpener`). Remembers them: a second open of the same port shares it."""

    def __init__(self, devices: Path | None = None) -> None:
        """`devices`: a folder in which the serial port /dev/NAME is found as NAME, and for which UDP multicast stands
        in for CAN channels. Every other port is where its URL says."""
        self._devices = devices
        self._lines: dict[str, Line] = {}

    def open(self, name: str, url: str) -> Line | Tap:
        """The port of device `name`. A port that is not there now is opened later. Raises TransportError for a URL that
        can never be opened."""
        if url in self._lines:
            return self._lines[url].tap(name)
        asked, endpoint = url, device_endpoint(url)
        if self._devices is not None and endpoint.scheme == "serial" and endpoint.path.startswith(_DEV):
            path = str(self._devices / endpoint.path.removeprefix(_DEV))
            url, endpoint = url.replace(endpoint.path, path, 1), replace(endpoint, path=path)
        if self._devices is not None and endpoint.scheme == "can" and "interface" not in endpoint.options:
            group, port = stand_in(str(self._devices), endpoint.path)
            url, endpoint = (
                f"{url} by {group}:{port}",
                replace(endpoint, path=group, port=port, options={"interface": "udp_multicast"}),
            )
        line = self._lines[asked] = _line_kind(endpoint.scheme)(name, url, endpoint)
        return line


def _line_kind(scheme: str) -> type[Line]:
    if scheme == "can":
        from companion.io.transport.can_line import CanLine  # only a boat with a CAN bus needs python-can

        return CanLine
    return _LINES[scheme]


def device_endpoint(url: str) -> PortUrl:
    """The parsed URL of a device's port. Raises TransportError, with the remedy, for a URL that can never be opened."""
    endpoint = parse_url(url)
    _check_options(url, endpoint)
    if endpoint.scheme not in ("serial", "can"):
        check_host(url, endpoint.host)
    return endpoint


def _check_options(url: str, endpoint: PortUrl) -> None:
    known = _OPTIONS.get(endpoint.scheme, {})
    for key, value in endpoint.options.items():
        if key not in known:
            raise TransportError(f"'{url}': unknown option '{key}'; known here: {', '.join(known) or 'none'}")
        if value not in known[key]:
            raise TransportError(f"'{url}': {key} should be one of {', '.join(known[key])}")


def check_host(url: str, host: str) -> None:
    """Raises TransportError for what is neither an IP address nor a name. Looks nothing up."""
    if not (is_address(host) or is_name(host)):
        raise TransportError(f"'{url}': '{host}' should be an IP address or a host's name")
