"""What a script's interface stands on: packets to and from the boat, lines of the feed, time, and its keeper."""

from __future__ import annotations

import contextlib
import json
import os
import select
import socket
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from companion.record.feed import address_of

_CHUNK = 65536
_LONGEST_LINE = 1 << 20
_AGAIN_S = 0.5


@dataclass(frozen=True, slots=True)
class Arrived:
    """What came in: bytes of MAVLink, and messages of the feed."""

    packets: bytes = b""
    lines: Sequence[Mapping[str, Any]] = ()


class Door(Protocol):
    """The way between a script and its boat."""

    def now_s(self) -> float:
        """Time, by which waits are counted."""
        ...

    def send(self, packet: bytes) -> None:
        """Send a packet to the boat. Nothing is raised where it cannot be taken."""
        ...

    def wait(self, timeout_s: float) -> Arrived:
        """What comes in within `timeout_s`; returns with the first of it. Tells the keeper that the script lives."""
        ...

    def tell(self, kind: str, text: str) -> None:
        """Tell the keeper: `say` a text to people, or `failed` with the reason."""
        ...


class SocketDoor:
    """The door of a script's process. `link`: a connected stream socket to the boat. `feed`: path of the feed's socket.
    `status`: descriptor of the keeper's pipe, None for none."""

    def __init__(self, link: socket.socket, feed: Path, status: int | None) -> None:
        self._link, self._feed_path, self._status = link, feed, status
        self._link.setblocking(False)
        self._feed: socket.socket | None = None
        self._rest = b""
        self._out = bytearray()
        self._next_try_s = 0.0
        with contextlib.suppress(OSError):  # what an earlier script has left unread
            while self._link.recv(_CHUNK):
                pass

    def now_s(self) -> float:
        """As `Door.now_s`: the clock of the computer, which no step changes."""
        return time.monotonic()

    def send(self, packet: bytes) -> None:
        """As `Door.send`."""
        if len(self._out) < _CHUNK:
            self._out += packet
        self._flush()

    def wait(self, timeout_s: float) -> Arrived:
        """As `Door.wait`."""
        self._beat()
        self._connect()
        readers = [one for one in (self._link, self._feed) if one is not None]
        writers = [self._link] if self._out else []
        ready, free, _ = select.select(readers, writers, [], min(max(0.0, timeout_s), _AGAIN_S))
        if free:
            self._flush()
        packets = self._packets() if self._link in ready else b""
        lines = self._lines() if self._feed is not None and self._feed in ready else []
        return Arrived(packets, lines)

    def tell(self, kind: str, text: str) -> None:
        """As `Door.tell`."""
        if self._status is not None:
            with contextlib.suppress(OSError):
                os.write(self._status, json.dumps({kind: text[:2000]}).encode() + b"\n")

    def _beat(self) -> None:
        if self._status is not None:
            with contextlib.suppress(OSError):  # the pipe is full of beats
                os.write(self._status, b"\n")

    def _flush(self) -> None:
        try:
            sent = self._link.send(self._out) if self._out else 0
        except BlockingIOError:
            return
        except OSError as error:
            raise ConnectionError(f"the boat's end of the link is gone: {error.strerror}") from error
        del self._out[:sent]

    def _packets(self) -> bytes:
        data = self._link.recv(_CHUNK)
        if not data:
            raise ConnectionError("the companion has ended")
        return data

    def _connect(self) -> None:
        """Connect to the feed, where that is not so yet; again after a pause where nobody offers it."""
        if self._feed is not None or self.now_s() < self._next_try_s:
            return
        self._next_try_s = self.now_s() + _AGAIN_S
        made = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        try:
            with address_of(self._feed_path) as address:
                made.connect(address)
        except OSError:
            made.close()
            return
        made.setblocking(False)
        self._feed, self._rest = made, b""

    def _lines(self) -> list[Mapping[str, Any]]:
        assert self._feed is not None
        try:
            data = self._feed.recv(4 * _CHUNK)
        except BlockingIOError:
            return []
        except OSError:
            data = b""
        if not data or len(self._rest) > _LONGEST_LINE:
            self._feed.close()
            self._feed = None
            return []
        *whole, self._rest = (self._rest + data).split(b"\n")
        return [json.loads(text) for text in whole if text]
