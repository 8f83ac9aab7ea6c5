"""The far ends of a companion's ports: what an emulated device speaks through when the companion is another process.

    serial:/dev/usv-gnss:115200   a pseudo-terminal; a link in a folder of its own bears the name, here usv-gnss
    udpin:0.0.0.0:5000            the companion listens there: we send there and hear its answers
    udpout:127.0.0.1:5000         the companion sends there: we listen, and answer the last sender
    tcpin:0.0.0.0:4001            the companion waits there: we connect, and again when it has gone
    tcpout:127.0.0.1:4001         the companion connects there: we wait for it
    can:can0                      a group of UDP multicast on this computer, which both know by the folder of the ports

None of them blocks or raises for what the companion does; what it does not take is lost, as on a wire.
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

from companion.config import ConfigError
from companion.core.can_frame import pack, stand_in, unpack

_DEV = "/dev/"
_CHUNK = 65536
_KNOCK_S = 0.02  # for a connection to this machine
_CALLS_BETWEEN = 50  # two tries to connect
_ANY = {"0.0.0.0": "127.0.0.1", "::": "::1"}


class Place(Protocol):
    """Where the companion looks for a device, as its URL says: a path for serial ports, else host and port."""

    @property
    def scheme(self) -> str: ...

    @property
    def path(self) -> str: ...

    @property
    def host(self) -> str: ...

    @property
    def port(self) -> int: ...


class FarEnd(Protocol):
    shown: str  # where it is, for people

    def plug(self) -> None:
        """Make the port be there. Raises OSError where that cannot be."""
        ...

    def unplug(self) -> None:
        """Make the port vanish, with what is under way in it."""
        ...

    def take(self) -> bytes:
        """What the companion has written since the last call."""
        ...

    def give(self, data: bytes) -> None:
        """To the companion, if it listens."""
        ...


def far_end(place: Place, folder: Path) -> FarEnd:
    """The end that answers `place`, not yet plugged in. Raises ConfigError for a port that no simulated device can be at."""
    make = ENDS.get(place.scheme)
    if make is None:
        raise ConfigError([f"{place.scheme}: no simulated device can be at such a port; there is {', '.join(ENDS)}"])
    return make(place, folder)


class PtyEnd:
    """A pseudo-terminal. Each companion that opens it finds a fresh one, whatever state the last one left it in."""

    def __init__(self, place: Place, folder: Path) -> None:
        if not place.path.startswith(_DEV):
            raise ConfigError([f"serial:{place.path}: a simulated device can only stand for a port below /dev"])
        self._link = folder / place.path.removeprefix(_DEV)
        self.shown = str(self._link)
        self._master: int | None = None
        self._poll = select.poll()
        self._heard = False

    def plug(self) -> None:
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
        master, self._master = self._master, None
        if master is not None:
            self._link.unlink(missing_ok=True)
            os.close(master)

    def take(self) -> bytes:
        if self._master is None:
            return b""
        try:
            data = os.read(self._master, _CHUNK)
        except OSError:  # nothing there, or nobody has it open
            return b""
        return data

    def give(self, data: bytes) -> None:
        if self._master is None:
            return
        if self._poll.poll(0):  # hung up: nobody has it open
            if self._heard:
                self.unplug()
                self.plug()
            return
        self._heard = True
        with contextlib.suppress(OSError):
            os.write(self._master, data)


class UdpEnd:
    def __init__(self, place: Place, folder: Path) -> None:
        self._address = (_ANY.get(place.host, place.host), place.port)
        self._listens = place.scheme == "udpout"
        self._peer = None if self._listens else self._address
        self._socket: socket.socket | None = None
        self.shown = f"UDP {'from' if self._listens else 'to'} {place.host}:{place.port}"

    def plug(self) -> None:
        if self._socket is None:
            self._socket = _new_socket(self._address, socket.SOCK_DGRAM)
            if self._listens:
                _bind(self._socket, self._address)

    def unplug(self) -> None:
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def take(self) -> bytes:
        taken = b""
        with contextlib.suppress(OSError):
            while self._socket is not None:
                data, peer = self._socket.recvfrom(_CHUNK)
                taken += data
                if self._listens:
                    self._peer = peer
        return taken

    def give(self, data: bytes) -> None:
        if self._socket is not None and self._peer is not None:
            with contextlib.suppress(OSError):
                self._socket.sendto(data, self._peer)


class TcpEnd:
    def __init__(self, place: Place, folder: Path) -> None:
        self._address = (_ANY.get(place.host, place.host), place.port)
        self._waits = place.scheme == "tcpout"
        self._listener: socket.socket | None = None
        self._peer: socket.socket | None = None
        self._plugged = False
        self._idle = 0
        self.shown = f"TCP {'at' if self._waits else 'to'} {place.host}:{place.port}"

    def plug(self) -> None:
        if self._waits and self._listener is None:
            self._listener = _new_socket(self._address, socket.SOCK_STREAM)
            self._listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            _bind(self._listener, self._address)
            self._listener.listen(1)
        self._plugged = True

    def unplug(self) -> None:
        self._plugged = False
        self._hang_up()
        if self._listener is not None:
            self._listener.close()
            self._listener = None

    def take(self) -> bytes:
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
        if self._peer is None:
            return
        try:
            self._peer.send(data)
        except (BlockingIOError, InterruptedError):
            pass
        except OSError:
            self._hang_up()

    def _meet(self) -> None:
        """The newest who connects, or a new try to connect."""
        with contextlib.suppress(OSError):
            if self._listener is not None:
                newer, _ = self._listener.accept()
                self._hang_up()
                self._peer = newer
            elif self._plugged and self._peer is None:
                self._peer = self._knock()
            if self._peer is not None:
                self._peer.setblocking(False)
                self._peer.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def _knock(self) -> socket.socket | None:
        self._idle = (self._idle + 1) % _CALLS_BETWEEN
        if self._idle != 1:
            return None
        peer = _new_socket(self._address, socket.SOCK_STREAM)
        peer.settimeout(_KNOCK_S)
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


class CanEnd:
    """A CAN bus, its frames in UDP multicast on this computer as python-can carries them. Unplugged, nothing of it comes through."""

    def __init__(self, place: Place, folder: Path) -> None:
        group, port = stand_in(str(folder), place.path)
        self.shown = f"CAN {place.path}, by UDP multicast {group}:{port}"
        self._group, self._port = group, port
        self._bus: Any = None

    def plug(self) -> None:
        if self._bus is None:
            import can

            self._bus = can.Bus(interface="udp_multicast", channel=self._group, port=self._port)

    def unplug(self) -> None:
        bus, self._bus = self._bus, None
        if bus is not None:
            bus.shutdown()

    def take(self) -> bytes:
        taken = b""
        while self._bus is not None and (message := self._bus.recv(timeout=0)) is not None:
            taken += pack(message.arbitration_id, bytes(message.data))
        return taken

    def give(self, data: bytes) -> None:
        if self._bus is not None:
            import can

            for identifier, content in unpack(data)[0]:
                with contextlib.suppress(can.CanError):
                    self._bus.send(can.Message(arbitration_id=identifier, data=content, is_extended_id=True), timeout=0)


ENDS: Mapping[str, Callable[[Place, Path], FarEnd]] = {
    "serial": PtyEnd,
    "udpin": UdpEnd,
    "udpout": UdpEnd,
    "tcpin": TcpEnd,
    "tcpout": TcpEnd,
    "can": CanEnd,
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
        raise OSError(error.errno, f"{error.strerror}: a simulated device must be at this computer's own address", f"{address[0]}:{address[1]}") from error
