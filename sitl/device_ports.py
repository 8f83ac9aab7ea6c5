"""Ports of emulated devices, for a companion in another process: each is the other end of one of its URLs.

    serial:/dev/usv-gnss:115200   a pseudo-terminal, linked as usv-gnss in the folder of the ports
    udpin:0.0.0.0:5000            the companion listens there: we send to it and receive its answers
    udpout:127.0.0.1:5000         the companion sends there: we listen and answer the last sender
    tcpin:0.0.0.0:4001            the companion waits there: we connect, and reconnect when it has gone
    tcpout:127.0.0.1:4001         the companion connects there: we wait for it
    can:can0                      UDP multicast on this computer; the folder of the ports gives its group

None of them blocks, or raises for what the companion does. What the companion does not read is lost, as on a wire.
"""

from __future__ import annotations

import contextlib
import os
import select
import socket
import tty
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Protocol

from companion.config.vessel import ConfigError
from companion.core.can_frame import pack, stand_in, unpack

_DEV = "/dev/"
_CHUNK = 65536
_CONNECT_S = 0.02  # time-out of a connection on this machine
_CALLS_BETWEEN = 50  # calls between two attempts to connect
_ANY = {"0.0.0.0": "127.0.0.1", "::": "::1"}


class PortAddress(Protocol):
    """The address of a device, as the companion opens it: `path` for serial ports and CAN, else `host` and `port`."""

    @property
    def scheme(self) -> str:
        """The scheme of the URL."""
        ...

    @property
    def path(self) -> str:
        """The device of a serial port or CAN bus."""
        ...

    @property
    def host(self) -> str:
        """The host of UDP or TCP."""
        ...

    @property
    def port(self) -> int:
        """The port of UDP or TCP."""
        ...


class DevicePort(Protocol):
    """The device's side of a port. `shown` is the port's address as printed for the user."""

    shown: str

    def plug(self) -> None:
        """Open the port. Raises OSError if this machine refuses."""
        ...

    def unplug(self) -> None:
        """Remove the port and lose all bytes in transit."""
        ...

    def take(self) -> bytes:
        """The bytes that the companion has written since the last call."""
        ...

    def give(self, data: bytes) -> None:
        """Send bytes to the companion; they are lost if nothing listens."""
        ...


def device_port(place: PortAddress, folder: Path) -> DevicePort:
    """The port at `place`, not yet plugged in. Raises ConfigError for an address that no simulated device can use."""
    make = PORTS.get(place.scheme)
    if make is None:
        raise ConfigError([f"{place.scheme}: no simulated device can use such a port; there is {', '.join(PORTS)}"])
    return make(place, folder)


class PtyPort:
    """A pseudo-terminal. Each companion that opens it finds a new one, so no settings of the last one remain."""

    def __init__(self, place: PortAddress, folder: Path) -> None:
        if not place.path.startswith(_DEV):
            raise ConfigError([f"serial:{place.path}: a simulated device can only replace a port below /dev"])
        self._link = folder / place.path.removeprefix(_DEV)
        self.shown = str(self._link)
        self._master: int | None = None
        self._poll = select.poll()
        self._heard = False

    def plug(self) -> None:
        """Open a new pseudo-terminal and point the link at it."""
        if self._master is not None:
            return
        master, slave = os.openpty()
        tty.setraw(slave)
        os.set_blocking(master, False)
        self._link.parent.mkdir(parents=True, exist_ok=True)
        beside = self._link.with_name(f".{self._link.name}.new")
        beside.unlink(missing_ok=True)
        beside.symlink_to(os.ttyname(slave))
        beside.replace(self._link)
        os.close(slave)
        self._master, self._heard = master, False
        self._poll = select.poll()
        self._poll.register(master, 0)

    def unplug(self) -> None:
        """Remove the link and close the pseudo-terminal."""
        master, self._master = self._master, None
        if master is not None:
            self._link.unlink(missing_ok=True)
            os.close(master)

    def take(self) -> bytes:
        """Bytes written by the companion; empty if there are none."""
        if self._master is None:
            return b""
        try:
            data = os.read(self._master, _CHUNK)
        except OSError:  # no bytes, or no process has it open
            return b""
        return data

    def give(self, data: bytes) -> None:
        """Send bytes to the companion. After the companion has closed the port, make a new one instead."""
        if self._master is None:
            return
        if self._poll.poll(0):  # no process has it open
            if self._heard:
                self.unplug()
                self.plug()
            return
        self._heard = True
        with contextlib.suppress(OSError):
            os.write(self._master, data)


class UdpPort:
    """UDP in either direction, as `place.scheme` says."""

    def __init__(self, place: PortAddress, folder: Path) -> None:
        self._address = (_ANY.get(place.host, place.host), place.port)
        self._listens = place.scheme == "udpout"
        self._peer = None if self._listens else self._address
        self._socket: socket.socket | None = None
        self.shown = f"UDP {'from' if self._listens else 'to'} {place.host}:{place.port}"

    def plug(self) -> None:
        """Open the socket; bind it if the companion sends first."""
        if self._socket is None:
            self._socket = _new_socket(self._address, socket.SOCK_DGRAM)
            if self._listens:
                _bind(self._socket, self._address)

    def unplug(self) -> None:
        """Close the socket."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def take(self) -> bytes:
        """The bytes of all waiting datagrams."""
        taken = b""
        with contextlib.suppress(OSError):
            while self._socket is not None:
                data, peer = self._socket.recvfrom(_CHUNK)
                taken += data
                if self._listens:
                    self._peer = peer
        return taken

    def give(self, data: bytes) -> None:
        """Send one datagram to the companion, if its address is known."""
        if self._socket is not None and self._peer is not None:
            with contextlib.suppress(OSError):
                self._socket.sendto(data, self._peer)


class TcpPort:
    """TCP, as server or client as `place.scheme` says. A new connection replaces the old one."""

    def __init__(self, place: PortAddress, folder: Path) -> None:
        self._address = (_ANY.get(place.host, place.host), place.port)
        self._waits = place.scheme == "tcpout"
        self._listener: socket.socket | None = None
        self._peer: socket.socket | None = None
        self._plugged = False
        self._idle = 0
        self.shown = f"TCP {'at' if self._waits else 'to'} {place.host}:{place.port}"

    def plug(self) -> None:
        """Listen, or allow connection attempts."""
        if self._waits and self._listener is None:
            self._listener = _new_socket(self._address, socket.SOCK_STREAM)
            self._listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            _bind(self._listener, self._address)
            self._listener.listen(1)
        self._plugged = True

    def unplug(self) -> None:
        """Close the connection and stop listening."""
        self._plugged = False
        self._hang_up()
        if self._listener is not None:
            self._listener.close()
            self._listener = None

    def take(self) -> bytes:
        """Accept or connect if needed, then read what has arrived."""
        self._meet()
        if self._peer is None:
            return b""
        try:
            data = self._peer.recv(_CHUNK)
        except (BlockingIOError, InterruptedError):
            return b""
        except OSError:
            data = b""
        if not data:
            self._hang_up()
        return data

    def give(self, data: bytes) -> None:
        """Send bytes on the connection, if there is one."""
        if self._peer is None:
            return
        try:
            self._peer.send(data)
        except (BlockingIOError, InterruptedError):
            pass
        except OSError:
            self._hang_up()

    def _meet(self) -> None:
        """Accept the newest connection, or try to connect."""
        with contextlib.suppress(OSError):
            if self._listener is not None:
                newer, _ = self._listener.accept()
                self._hang_up()
                self._peer = newer
            elif self._plugged and self._peer is None:
                self._peer = self._connect()
            if self._peer is not None:
                self._peer.setblocking(False)
                self._peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def _connect(self) -> socket.socket | None:
        self._idle = (self._idle + 1) % _CALLS_BETWEEN
        if self._idle != 1:
            return None
        peer = _new_socket(self._address, socket.SOCK_STREAM)
        peer.settimeout(_CONNECT_S)
        try:
            peer.connect(self._address)
        except OSError:
            peer.close()
            return None
        return peer

    def _hang_up(self) -> None:
        peer, self._peer = self._peer, None
        if peer is not None:
            peer.close()


class CanPort:
    """A CAN bus in UDP multicast on this computer, with frames as python-can carries them."""

    def __init__(self, place: PortAddress, folder: Path) -> None:
        group, port = stand_in(str(folder), place.path)
        self.shown = f"CAN {place.path}, by UDP multicast {group}:{port}"
        self._group, self._port = group, port
        self._bus: Any = None

    def plug(self) -> None:
        """Join the multicast group."""
        if self._bus is None:
            import can

            self._bus = can.Bus(interface="udp_multicast", channel=self._group, port=self._port)

    def unplug(self) -> None:
        """Leave the multicast group."""
        bus, self._bus = self._bus, None
        if bus is not None:
            bus.shutdown()

    def take(self) -> bytes:
        """The frames that have arrived, packed."""
        taken = b""
        while self._bus is not None and (message := self._bus.recv(timeout=0)) is not None:
            taken += pack(message.arbitration_id, bytes(message.data))
        return taken

    def give(self, data: bytes) -> None:
        """Send the frames packed in `data`."""
        if self._bus is not None:
            import can

            for identifier, content in unpack(data)[0]:
                with contextlib.suppress(can.CanError):
                    self._bus.send(can.Message(arbitration_id=identifier, data=content, is_extended_id=True), timeout=0)


PORTS: Mapping[str, Callable[[PortAddress, Path], DevicePort]] = {
    "serial": PtyPort,
    "udpin": UdpPort,
    "udpout": UdpPort,
    "tcpin": TcpPort,
    "tcpout": TcpPort,
    "can": CanPort,
}


def _new_socket(address: tuple[str, int], kind: socket.SocketKind) -> socket.socket:
    made = socket.socket(socket.AF_INET6 if ":" in address[0] else socket.AF_INET, kind)
    made.setblocking(False)
    return made


def _bind(made: socket.socket, address: tuple[str, int]) -> None:
    try:
        made.bind(address)
    except OSError as error:
        made.close()
        raise OSError(
            error.errno,
            f"{error.strerror}: a simulated device must be at this computer's own address",
            f"{address[0]}:{address[1]}",
        ) from error
