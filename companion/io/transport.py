"""Opens the ports of devices as byte streams that never block, never raise, and come back by themselves.

serial:/dev/usv-gnss:115200     a serial port, locked to this process (`?parity=even&stopbits=2` where a device needs it)
udpin:0.0.0.0:5000              listen for datagrams; answers go to the last sender
udpout:192.168.1.20:5000        send datagrams there and hear its answers
tcpout:192.168.1.20:4001        connect (serial servers, bridges)
tcpin:0.0.0.0:4001              wait for one device to connect; a newer connection replaces the older
can:can0                        a CAN bus (`companion/io/can_line.py`)
"""

from __future__ import annotations

import contextlib
import errno
import os
import socket
import termios
from abc import ABC, abstractmethod
from collections.abc import Sequence

import serial

from companion.io.urls import Endpoint, TransportError, parse_url

_RETRY_FIRST_S = 0.5
_RETRY_LAST_S = 5.0
_CONNECT_TIMEOUT_S = 5.0
_CHUNK = 4096
_CHUNKS_PER_READ = 16  # and
_BYTES_PER_READ = 16384  # a flooding peer must not hold the caller; what is left keeps the descriptor readable
_PARITIES = {"none": serial.PARITY_NONE, "even": serial.PARITY_EVEN, "odd": serial.PARITY_ODD}
_STOPBITS = {"1": serial.STOPBITS_ONE, "2": serial.STOPBITS_TWO}
_OPTIONS: dict[str, dict[str, Sequence[str]]] = {
    "serial": {"parity": tuple(_PARITIES), "stopbits": tuple(_STOPBITS)},
    "can": {"interface": ("socketcan", "udp_multicast", "virtual")},
}
_NOT_NOW = (errno.EAGAIN, errno.EWOULDBLOCK, errno.EINTR)
_LINE_ERRORS = (OSError, ValueError, termios.error)  # whatever the system says about a port, at any time


class Line(ABC):
    """A ByteStream over one endpoint: what serial ports and sockets have in common.

    Remembers the descriptor, what of a write is still to go out, the last fault, and when to try again: after 0.5 s, doubling to 5 s
    until bytes have come in. Times are those of the callers.
    """

    def __init__(self, name: str, url: str, endpoint: Endpoint) -> None:
        self.name = name
        self._url = url
        self._endpoint = endpoint
        self._pending = b""
        self._fault: str | None = "not open yet"
        self._open = False
        self._closed = False
        self._retry_s = _RETRY_FIRST_S
        self._next_try_s: float | None = None  # None: at once
        self._try()

    def read(self, now_s: float) -> Sequence[tuple[float, bytes]]:
        """See `ByteStream`: everything that has come in, stamped with `now_s`."""
        if not self._ready(now_s):
            return ()
        chunks: list[tuple[float, bytes]] = []
        left = _BYTES_PER_READ
        try:
            for _ in range(_CHUNKS_PER_READ):
                data = self._receive() if left > 0 else b""
                if not data:
                    break
                chunks.append((now_s, data))
                left -= len(data)
            self._flush()
        except _LINE_ERRORS as error:
            self._drop(self._explain(error), now_s)
        if chunks:
            self._retry_s = _RETRY_FIRST_S
        return chunks

    def write(self, data: bytes, now_s: float) -> None:
        """See `ByteStream`: while an earlier message is still half sent, this one is dropped whole."""
        if not self._ready(now_s):
            return
        try:
            self._flush()
            if not self._pending:
                self._pending = bytes(data)
                self._flush()
        except _LINE_ERRORS as error:
            self._drop(self._explain(error), now_s)

    def fault(self) -> str | None:
        return self._fault

    def fileno(self) -> int | None:
        return self._descriptor() if self._open else None

    def close(self) -> None:
        self._closed = True
        self._shut()
        self._fault = "closed"

    def _ready(self, now_s: float) -> bool:
        if self._closed:
            return False
        if not self._open:
            if self._next_try_s is not None and now_s < self._next_try_s:
                return False
            self._try()
            if not self._open:
                self._wait(now_s)
                return False
        try:
            return self._established(now_s)
        except _LINE_ERRORS as error:
            self._drop(self._explain(error), now_s)
            return False

    def _try(self) -> None:
        try:
            self._connect()
            self._open = True
            self._fault = None
        except _LINE_ERRORS as error:
            self._fault = self._explain(error)
            self._shut()

    def _wait(self, now_s: float) -> None:
        self._next_try_s = now_s + self._retry_s
        self._retry_s = min(2.0 * self._retry_s, _RETRY_LAST_S)

    def _drop(self, fault: str, now_s: float) -> None:
        self._shut()
        self._fault = fault
        self._wait(now_s)

    def _shut(self) -> None:
        self._open = False
        self._pending = b""
        with contextlib.suppress(*_LINE_ERRORS):
            self._disconnect()

    def _flush(self) -> None:
        if self._pending:
            self._pending = self._pending[self._transmit(self._pending) :]

    def _explain(self, error: BaseException) -> str:
        """One line: what is wrong and what to do."""
        number = getattr(error, "errno", None)
        where = self._url
        if number in (errno.ENOENT, errno.ENXIO, errno.ENODEV):
            return f"{where}: no such device; is it plugged in? `companion devices` lists what is there"
        if number in (errno.EACCES, errno.EPERM):
            if self._endpoint.scheme == "serial":
                return f"{where}: permission denied; `sudo usermod -aG dialout $USER`, then log in again"
            return f"{where}: permission denied; ports below 1024 belong to root, choose a higher one"
        if number == errno.EADDRINUSE:
            return f"{where}: port in use; stop the program that listens there or choose another port"
        if number == errno.EADDRNOTAVAIL:
            return f"{where}: this computer has no address {self._endpoint.host}; use 0.0.0.0 for all"
        if number in (errno.EBUSY, *_NOT_NOW) and self._endpoint.scheme == "serial":
            return f"{where}: busy; another program has it open, stop that (ModemManager and gpsd do this too)"
        if number == errno.ECONNREFUSED:
            return f"{where}: refused; nothing listens there yet"
        return f"{where}: {' '.join(str(error).split()) or type(error).__name__}; trying again"

    @abstractmethod
    def _connect(self) -> None: ...

    @abstractmethod
    def _disconnect(self) -> None: ...

    def _established(self, now_s: float) -> bool:
        return True

    @abstractmethod
    def _descriptor(self) -> int | None: ...

    @abstractmethod
    def _receive(self) -> bytes:
        """What is there, or b'' if nothing. Raises OSError when the line is gone."""

    @abstractmethod
    def _transmit(self, data: bytes) -> int:
        """How many bytes went out; 0 if none can now. Raises OSError when the line is gone."""


class SerialLine(Line):
    """A serial port, locked to this process."""

    _port: serial.Serial | None = None

    def _connect(self) -> None:
        endpoint = self._endpoint
        self._port = serial.Serial(
            endpoint.path,
            endpoint.baud,
            parity=_PARITIES[endpoint.options.get("parity", "none")],
            stopbits=_STOPBITS[endpoint.options.get("stopbits", "1")],
            timeout=0,
            exclusive=True,
        )

    def _disconnect(self) -> None:
        port, self._port = self._port, None
        if port is not None:
            with contextlib.suppress(*_LINE_ERRORS):
                port.reset_output_buffer()  # or closing waits for a line that is stuck
            port.close()

    def _descriptor(self) -> int | None:
        return None if self._port is None else int(self._port.fileno())

    def _receive(self) -> bytes:
        assert self._port is not None
        return bytes(self._port.read(_CHUNK))

    def _transmit(self, data: bytes) -> int:
        # past pyserial, whose write spins for ever on a full line (EAGAIN) when it has no time-out
        assert self._port is not None
        try:
            return os.write(self._port.fileno(), data)
        except BlockingIOError:
            return 0


class SocketLine(Line):
    """What the four kinds of socket share: one socket that carries the bytes."""

    _socket: socket.socket | None = None

    def _new_socket(self, kind: socket.SocketKind) -> socket.socket:
        family = socket.AF_INET6 if ":" in self._endpoint.host else socket.AF_INET
        made = socket.socket(family, kind)
        made.setblocking(False)
        return made

    def _address(self) -> tuple[str, int]:
        return self._endpoint.host, self._endpoint.port

    def _disconnect(self) -> None:
        carried, self._socket = self._socket, None
        if carried is not None:
            carried.close()

    def _descriptor(self) -> int | None:
        return None if self._socket is None else self._socket.fileno()


class UdpLine(SocketLine):
    """Datagrams, listening (`udpin`) or sending first (`udpout`). Each datagram is one chunk."""

    _peer: tuple[str, int] | None = None

    def _connect(self) -> None:
        self._socket = self._new_socket(socket.SOCK_DGRAM)
        if self._endpoint.scheme == "udpin":
            self._socket.bind(self._address())
        else:
            self._peer = self._address()

    def _receive(self) -> bytes:
        assert self._socket is not None
        try:
            data, peer = self._socket.recvfrom(65535)
        except (BlockingIOError, InterruptedError, ConnectionError):  # the last: nobody hears us there yet
            return b""
        if self._endpoint.scheme == "udpin":
            self._peer = peer
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

    _connected = False
    _give_up_s: float | None = None

    def _connect(self) -> None:
        self._connected = False
        self._give_up_s = None
        self._socket = self._new_socket(socket.SOCK_STREAM)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        result = self._socket.connect_ex(self._address())
        if result not in (0, errno.EINPROGRESS):
            raise OSError(result, os.strerror(result))

    def _established(self, now_s: float) -> bool:
        if self._connected:
            return True
        assert self._socket is not None
        result = self._socket.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
        if result:
            raise OSError(result, os.strerror(result))
        try:
            self._socket.getpeername()
            self._connected = True
        except OSError:
            self._give_up_s = now_s + _CONNECT_TIMEOUT_S if self._give_up_s is None else self._give_up_s
            if now_s >= self._give_up_s:
                raise OSError("no answer") from None
        return self._connected

    def _descriptor(self) -> int | None:
        return super()._descriptor() if self._connected else None

    def fault(self) -> str | None:
        return f"{self._url}: connecting" if self._open and not self._connected else super().fault()


class TcpServerLine(TcpLine):
    """`tcpin`: one peer at a time; a newer connection replaces the older, which may be dead without having said so."""

    _listener: socket.socket | None = None

    def _connect(self) -> None:
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

    def _established(self, now_s: float) -> bool:
        assert self._listener is not None
        with contextlib.suppress(BlockingIOError, InterruptedError, ConnectionError):
            newer, _ = self._listener.accept()
            newer.setblocking(False)
            newer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._hang_up()
            self._socket = newer
        return self._socket is not None

    def _hang_up(self) -> None:
        self._pending = b""
        super()._disconnect()

    def _drop(self, fault: str, now_s: float) -> None:
        self._hang_up()  # and go on listening

    def _descriptor(self) -> int | None:
        if self._socket is not None:
            return super()._descriptor()
        return None if self._listener is None else self._listener.fileno()

    def fault(self) -> str | None:
        return f"{self._url}: waiting for the device to connect" if self._open and self._socket is None else super().fault()


_LINES: dict[str, type[Line]] = {
    "serial": SerialLine,
    "udpin": UdpLine,
    "udpout": UdpLine,
    "tcpin": TcpServerLine,
    "tcpout": TcpClientLine,
}


class TransportOpener:
    """Opens real ports (a `StreamOpener`)."""

    def open(self, name: str, url: str) -> Line:
        """The port of device `name`. A port that is not there now is opened later; TransportError only for a URL that never can be."""
        endpoint = parse_url(url)
        _check_options(url, endpoint)
        if endpoint.scheme == "can":
            from companion.io.can_line import CanLine

            return CanLine(name, url, endpoint)
        if endpoint.scheme != "serial" and endpoint.host == "localhost":
            endpoint = Endpoint(endpoint.scheme, host="127.0.0.1", port=endpoint.port, options=endpoint.options)
        elif endpoint.scheme != "serial" and not _is_address(endpoint.host):
            raise TransportError(f"'{url}': '{endpoint.host}' should be an IP address; looking up a name could hold the vessel up")
        return _LINES[endpoint.scheme](name, url, endpoint)


def _check_options(url: str, endpoint: Endpoint) -> None:
    known = _OPTIONS.get(endpoint.scheme, {})
    for key, value in endpoint.options.items():
        if key not in known:
            raise TransportError(f"'{url}': unknown option '{key}'; known here: {', '.join(known) or 'none'}")
        if value not in known[key]:
            raise TransportError(f"'{url}': {key} should be one of {', '.join(known[key])}")


def _is_address(host: str) -> bool:
    for family in (socket.AF_INET, socket.AF_INET6):
        with contextlib.suppress(OSError):
            socket.inet_pton(family, host)
            return True
    return False
