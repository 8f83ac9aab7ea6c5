"""What serial ports and sockets have in common: a line that never blocks, never raises, and comes back by itself."""

from __future__ import annotations

import contextlib
import errno
import termios
from abc import ABC, abstractmethod
from collections.abc import Sequence

from companion.io.transport.tap import Tap
from companion.io.transport.urls import PortUrl

_RETRY_FIRST_S = 0.5
_RETRY_LAST_S = 5.0
# a flooding peer must not hold the caller; the rest keeps the descriptor readable
_CHUNKS_PER_READ = 16
_BYTES_PER_READ = 16384
LINE_ERRORS = (OSError, ValueError, termios.error)  # all that a port may raise, at any time


class Line(ABC):
    """A ByteStream over one endpoint: what serial ports and sockets have in common.

    Remembers the descriptor, what of a write is still to go out, the last fault, and when to try again: after 0.5 s,
    doubling to 5 s until bytes have come in; every 0.5 s for a device file that is not there, which costs nothing.
    Times are those of the callers.
    """

    def __init__(self, name: str, url: str, endpoint: PortUrl) -> None:
        self.name = name
        self._url = url
        self._endpoint = endpoint
        self._pending = b""
        self._fault: str | None = "not open yet"
        self._open = False
        self._closed = False
        self._retry_s = _RETRY_FIRST_S
        self._next_try_s: float | None = None  # None: at once
        self._absent = False
        self._taps: list[Tap] = []
        self._try()

    def tap(self, name: str) -> Tap:
        """Another reader of what comes in."""
        self._taps.append(Tap(name, self))
        return self._taps[-1]

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
        except LINE_ERRORS as error:
            self._drop(self._explain(error), now_s)
        if chunks:
            self._retry_s = _RETRY_FIRST_S
            for tap in self._taps:
                tap.put(chunks)
        return chunks

    def write(self, data: bytes, now_s: float) -> None:
        """See `ByteStream`: while an earlier message is only half sent, this one is dropped."""
        if not self._ready(now_s):
            return
        try:
            self._flush()
            if not self._pending:
                self._pending = bytes(data)
                self._flush()
        except LINE_ERRORS as error:
            self._drop(self._explain(error), now_s)

    def fault(self) -> str | None:
        """See `ByteStream`."""
        return self._fault

    def fileno(self) -> int | None:
        """See `ByteStream`."""
        return self._descriptor() if self._open else None

    def close(self) -> None:
        """See `ByteStream`. A closed line stays closed."""
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
        except LINE_ERRORS as error:
            self._drop(self._explain(error), now_s)
            return False

    def _try(self) -> None:
        try:
            self._connect()
            self._open = True
            self._absent = False
            self._fault = None
        except LINE_ERRORS as error:
            self._absent = getattr(error, "errno", None) == errno.ENOENT
            self._fault = self._explain(error)
            self._shut()

    def _wait(self, now_s: float) -> None:
        self._next_try_s = now_s + (_RETRY_FIRST_S if self._absent else self._retry_s)
        if not self._absent:
            self._retry_s = min(2.0 * self._retry_s, _RETRY_LAST_S)

    def _drop(self, fault: str, now_s: float) -> None:
        self._shut()
        self._fault = fault
        self._wait(now_s)

    def _shut(self) -> None:
        self._open = False
        self._pending = b""
        with contextlib.suppress(*LINE_ERRORS):
            self._disconnect()

    def _flush(self) -> None:
        if self._pending:
            self._pending = self._pending[self._transmit(self._pending) :]

    def _explain(self, error: BaseException) -> str:
        """What is wrong and what to do, in one line."""
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
