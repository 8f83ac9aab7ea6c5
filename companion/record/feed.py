"""The feed: each tick, decimated, for displays on this computer, over a Unix socket in the state folder.

The control thread hands a tick to a thread and goes on; it never waits, and does nothing where nobody reads. What waits
is bounded on both sides: ticks that the thread has not taken yet, and messages that a reader has not taken yet. Of both
the oldest are dropped. So a reader that stalls loses frames, and the loop loses nothing. `feed_schema.py` describes the
messages.
"""

from __future__ import annotations

import contextlib
import math
import os
import selectors
import socket
import threading
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from companion.core.descriptors import NO_DESCRIPTORS
from companion.core.tick import Tick
from companion.record.feed_schema import TickEncoder, event_message, line

SOCKET = "feed.sock"  # in the state folder
_PERIOD_S = 0.1  # of wall time, whatever the speed of a simulation
_LOOK_S = 1.0
_MOST_TICKS = 4  # that wait for the thread
_MOST_FRAMES = 20  # that wait for one reader
_MOST_EVENTS = 200  # that a new reader gets
_MOST_READERS = 8
_LONGEST_ADDRESS = 108
_FULL_S = 0.5  # without a descriptor for a reader that waits
_EARLY = 0.2  # share of the period by which a tick may be early

Snapshot = Mapping[str, Any]


@dataclass(slots=True)
class _Offer:
    """What the control thread hands over."""

    tick: Tick | None
    made_unix_ns: int
    boat: Snapshot | None


@dataclass(slots=True)
class _Reader:
    """One connection. `frames`: messages that wait; `begun`: the rest of the one that is being sent. `boat`: the newest
    message of that kind, while it waits: it is never dropped, only replaced."""

    connection: socket.socket
    frames: deque[bytes] = field(default_factory=lambda: deque(maxlen=_MOST_FRAMES))
    begun: memoryview = field(default_factory=lambda: memoryview(b""))
    boat: bytes = b""

    @property
    def waits(self) -> bool:
        """Whether there is something to send."""
        return bool(self.begun or self.boat or self.frames)

    def send(self) -> bool:
        """Send what the connection takes now; False when it is broken."""
        while self.waits:
            if not self.begun:
                self.begun = memoryview(self.boat or self.frames.popleft())
                self.boat = b""
            try:
                sent = self.connection.send(self.begun)
            except BlockingIOError:
                return True
            except OSError:
                return False
            self.begun = self.begun[sent:]
        return True


class Feed:
    """A `core.ports.Recorder` that offers ticks to readers of its socket.

    Remembers the newest events, and when a frame and a look at the boat are due next.
    """

    def __init__(
        self,
        path: Path,
        hello: Snapshot,
        thrusters: Sequence[str],
        devices: Sequence[str],
        look: Callable[[float], Snapshot],
        period_s: float = _PERIOD_S,
    ) -> None:
        """`hello`: what is known of the boat from the start. `look(now_s)`: what changes seldom, as plain values; the
        control thread calls it once a second while somebody reads. `period_s`: between two frames, of wall time. Raises
        OSError where the socket cannot be made."""
        self._period_s = period_s
        self._encoder = TickEncoder(thrusters, devices)
        self._hello = line({**hello, "kind": "hello", "columns": self._encoder.columns})
        self._look = look
        self._due_s = self._look_due_s = 0.0
        self._events: deque[bytes] = deque(maxlen=_MOST_EVENTS)
        self._fresh: deque[bytes] = deque(maxlen=_MOST_EVENTS)
        self._offers: deque[_Offer] = deque(maxlen=_MOST_TICKS)
        self._boat = b""
        self._sequence = 0
        self._readers: dict[int, _Reader] = {}
        self._read = False  # whether anybody reads; the thread writes it
        self._ended = False
        self._path = path
        self._listener = _listener(path)
        self._bell = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        self._selector = selectors.DefaultSelector()
        self.listens = False
        """Whether a new reader is let in; not for a moment without a descriptor for it."""
        self._listens_s = -math.inf  # again from then on
        self._listen(True)
        self._selector.register(self._bell, selectors.EVENT_READ)
        self._thread = threading.Thread(target=self._run, name="feed", daemon=True)
        self._thread.start()

    @property
    def readers(self) -> int:
        """How many read now."""
        return len(self._readers)

    def record(self, tick: Tick) -> None:
        """See `Recorder`. Offers the tick, if one is due and anybody reads."""
        for event in tick.events:
            self._fresh.append(line(event_message(event, tick.time_unix_ns)))
        now_s = time.monotonic()
        if not self._read or now_s < self._due_s - _EARLY * self._period_s:
            return
        self._due_s = max(self._due_s + self._period_s, now_s)
        boat = None
        if now_s >= self._look_due_s:
            self._look_due_s = now_s + _LOOK_S
            boat = self._look_at_boat(tick.t_s)
        self._offers.append(_Offer(tick, time.time_ns(), boat))
        os.eventfd_write(self._bell, 1)

    def _look_at_boat(self, now_s: float) -> Snapshot:
        try:
            return self._look(now_s)
        except Exception as error:  # noqa: BLE001  a display must not stop the boat
            return {"fault": f"{type(error).__name__}: {error}"}

    def close(self) -> None:
        """End the thread, and remove the socket."""
        self._ended = True
        os.eventfd_write(self._bell, 1)
        self._thread.join()
        for reader in self._readers.values():
            reader.connection.close()
        self._listener.close()
        self._selector.close()
        os.close(self._bell)
        self._path.unlink(missing_ok=True)

    # --- the thread ------------------------------------------------------------------------------------------------

    def _run(self) -> None:
        while not self._ended:
            ready = self._selector.select(None if self.listens else _FULL_S)
            if time.monotonic() >= self._listens_s:
                self._listen(True)
            for key, events in ready:
                if key.fileobj is self._listener:
                    self._accept()
                elif key.fileobj == self._bell:
                    self._take()
                elif (reader := self._readers.get(key.fd)) is not None:
                    self._mind(reader, events)

    def _listen(self, on: bool) -> None:
        if on and not self.listens:
            self._selector.register(self._listener, selectors.EVENT_READ)
        elif self.listens and not on:
            self._selector.unregister(self._listener)
        self.listens = on

    def _accept(self) -> None:
        try:
            connection, _ = self._listener.accept()
        except OSError as error:
            if error.errno in NO_DESCRIPTORS:  # it would be ready without end
                self._listen(False)
                self._listens_s = time.monotonic() + _FULL_S
            return
        with contextlib.suppress(OSError):
            if len(self._readers) >= _MOST_READERS:
                connection.close()
                return
            connection.setblocking(False)
            reader = _Reader(connection)
            self._merge_events()
            first = [self._hello, *self._events]
            reader.begun = memoryview(b"".join(first) + self._boat)
            self._readers[connection.fileno()] = reader
            self._selector.register(connection, selectors.EVENT_READ)
            self._look_due_s = 0.0  # a new reader need not wait for what changes seldom
            self._read = True
            self._flush(reader)

    def _merge_events(self) -> list[bytes]:
        """The events since the last call, which now belong to the past."""
        fresh: list[bytes] = []
        with contextlib.suppress(IndexError):
            while True:
                fresh.append(self._fresh.popleft())
        self._events.extend(fresh)
        return fresh

    def _take(self) -> None:
        """Encode what the control thread has offered, and pass it to all readers."""
        with contextlib.suppress(BlockingIOError):
            os.eventfd_read(self._bell)
        frames: list[bytes] = self._merge_events() if self._offers else []
        while self._offers:
            offer = self._offers.popleft()
            if offer.boat is not None:
                self._boat = line({**offer.boat, "kind": "boat"})
                for reader in self._readers.values():
                    reader.boat = self._boat
            if offer.tick is not None:
                self._sequence += 1
                frames.append(line(self._encoder.message(offer.tick, self._sequence, offer.made_unix_ns)))
        for reader in list(self._readers.values()):
            reader.frames.extend(frames)
            self._flush(reader)

    def _mind(self, reader: _Reader, events: int) -> None:
        """A reader has closed, has said something (nobody listens), or takes more."""
        if events & selectors.EVENT_READ:
            try:
                gone = not reader.connection.recv(4096)
            except BlockingIOError:
                gone = False
            except OSError:
                gone = True
            if gone:
                self._drop(reader)
                return
        self._flush(reader)

    def _flush(self, reader: _Reader) -> None:
        if not reader.send():
            self._drop(reader)
            return
        wanted = selectors.EVENT_READ | (selectors.EVENT_WRITE if reader.waits else 0)
        self._selector.modify(reader.connection, wanted)

    def _drop(self, reader: _Reader) -> None:
        self._selector.unregister(reader.connection)
        self._readers.pop(reader.connection.fileno(), None)
        reader.connection.close()
        self._read = bool(self._readers)


@contextlib.contextmanager
def address_of(path: Path) -> Iterator[str]:
    """The address of the socket at `path`. One that is too long for a socket's address (108 bytes) goes by a descriptor
    of its folder. Raises OSError for a folder that cannot be opened."""
    if len(os.fsencode(path)) < _LONGEST_ADDRESS:
        yield str(path)
        return
    folder = os.open(path.parent, os.O_PATH | os.O_DIRECTORY | os.O_CLOEXEC)
    try:
        yield f"/proc/self/fd/{folder}/{path.name}"
    finally:
        os.close(folder)


def _listener(path: Path) -> socket.socket:
    """A socket that listens at `path`, for the owner of the process alone. What an earlier run left there goes."""
    path.unlink(missing_ok=True)
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM | socket.SOCK_CLOEXEC)
    try:
        before = os.umask(0o177)
        try:
            with address_of(path) as address:
                listener.bind(address)
        finally:
            os.umask(before)
        listener.listen(_MOST_READERS)
        listener.setblocking(False)
    except OSError as error:
        listener.close()
        raise OSError(error.errno, f"no feed for displays: {error.strerror or error}", str(path)) from error
    return listener
