"""A serial port as a `Line`: opened beside the control thread, for one process alone."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
import stat
import termios
import threading
import time
from functools import partial
from pathlib import Path

import serial

from companion.io.transport.line import LINE_ERRORS, Line
from companion.io.transport.port_holders import holder_of
from companion.io.transport.threads import begun
from companion.io.transport.urls import PortUrl

PARITIES = {"none": serial.PARITY_NONE, "even": serial.PARITY_EVEN, "odd": serial.PARITY_ODD}
STOPBITS = {"1": serial.STOPBITS_ONE, "2": serial.STOPBITS_TWO}
_CHUNK = 4096
_HUNG_S = 2.0
_DRAIN_S = 0.1  # what the last command may take to go out when the vessel is shut down
_HELD = (errno.EBUSY, errno.EAGAIN)


class PortError(OSError):
    """A port that cannot be opened. Its text is complete."""


class SerialLine(Line):
    """A serial port, locked to this process.

    The first try is made at once. Later ones, with the boat under way, are made by a thread of their own, as is closing
    a port that failed: a driver whose device hangs may take seconds for either.
    """

    _port: serial.Serial | None = None
    _opening: _Opening | None = None
    _opening_since_s: float | None = None
    _before: str | None = None  # what was wrong before the opening under way
    _tried = False

    def _connect(self) -> None:
        first, self._tried = not self._tried, True
        if first:
            self._port = open_port(self._endpoint)
            return
        Path(self._endpoint.path).stat()  # a port that is not there needs no thread
        self._before, self._opening_since_s = self._fault, None
        self._opening = _Opening(self._endpoint)

    def _established(self, now_s: float) -> bool:
        if self._opening is None:
            return True
        if self._opening.ended.is_set():
            opening, self._opening = self._opening, None
            self._port = opening.port()
            return True
        if self._opening_since_s is None:
            self._opening_since_s = now_s
        elif now_s - self._opening_since_s > _HUNG_S:
            self._before = f"{self._url}: the device is there, but opening it hangs; pull its plug and put it in again"
        return False

    def fault(self) -> str | None:
        """See `ByteStream`; while a later try is under way, what was wrong before it."""
        return self._fault if self._opening is None else self._before

    def close(self) -> None:
        """Wait briefly for the last command to go out, then close."""
        port = self._port
        if port is not None and not self._closed:
            _drain(port)
        super().close()

    def _disconnect(self) -> None:
        port, self._port = self._port, None
        opening, self._opening = self._opening, None
        if opening is not None:
            opening.abandon()
        if port is None:
            return
        if self._closed or begun(partial(_close, port), "port-closer") is None:
            _close(port)

    def _descriptor(self) -> int | None:
        return None if self._port is None else int(self._port.fileno())

    def _receive(self) -> bytes:
        assert self._port is not None
        try:
            return bytes(self._port.read(_CHUNK))
        except serial.SerialException as error:
            raise PortError("gone: unplugged, or another program reads it too; waiting for it") from error

    def _transmit(self, data: bytes) -> int:
        # past pyserial, whose write spins for ever on a full line (EAGAIN) when it has no time-out
        assert self._port is not None
        try:
            return os.write(self._port.fileno(), data)
        except BlockingIOError:
            return 0

    def _explain(self, error: BaseException) -> str:
        return f"{self._url}: {error}" if isinstance(error, PortError) else super()._explain(error)


class _Opening:
    """A try to open a port, in a thread of its own. When it has `ended`, `port()` returns the port or raises its
    error. Making one raises PortError where there is no thread for it."""

    def __init__(self, endpoint: PortUrl) -> None:
        self._endpoint = endpoint
        self._lock = threading.Lock()
        self._abandoned = False
        self._port: serial.Serial | None = None
        self._error: Exception | None = None
        self.ended = threading.Event()
        if begun(self._open, "port-opener") is None:
            raise PortError("not opened: this computer has no threads left; trying again")

    def port(self) -> serial.Serial:
        """The open port. Raises the error that opening met."""
        if self._error is not None:
            raise self._error
        return self._port

    def abandon(self) -> None:
        """The port is no longer needed: it is closed as soon as it is open."""
        with self._lock:
            self._abandoned = True
            port, self._port = self._port, None
        if port is not None:
            _close(port)

    def _open(self) -> None:
        port: serial.Serial | None = None
        try:
            port = open_port(self._endpoint)
        except LINE_ERRORS as error:
            self._error = error
        with self._lock:
            if not self._abandoned:
                self._port, port = port, None
            self.ended.set()
        if port is not None:
            _close(port)


def open_port(endpoint: PortUrl) -> serial.Serial:
    """Opens and locks a port. Raises OSError or termios.error; where another program has it, PortError that names the
    program where it can be known."""
    if not stat.S_ISCHR(Path(endpoint.path).stat().st_mode):
        raise PortError("is no serial port but a file or folder; `companion devices` lists the ports")
    try:
        port = serial.Serial(
            endpoint.path,
            endpoint.baud,
            parity=PARITIES[endpoint.options.get("parity", "none")],
            stopbits=STOPBITS[endpoint.options.get("stopbits", "1")],
            timeout=0,
            exclusive=True,
        )
    except serial.SerialException as error:
        if error.errno not in _HELD:
            raise
        raise PortError(f"busy; {_remedy(holder_of(endpoint.path))}") from error
    with contextlib.suppress(OSError):  # the lock keeps out programs that respect it, this the others
        fcntl.ioctl(port.fileno(), termios.TIOCEXCL)
    return port


def _remedy(holder: str | None) -> str:
    if holder is None:
        return "another program has it open, stop that (ModemManager and gpsd do this too)"
    return f"{holder} has it open; stop that, or give this device another port"


def _drain(port: serial.Serial) -> None:
    """Let what was written last go out, if the line takes it at all."""
    until_s = time.monotonic() + _DRAIN_S
    with contextlib.suppress(*LINE_ERRORS):
        while port.out_waiting and time.monotonic() < until_s:
            time.sleep(0.002)


def _close(port: serial.Serial) -> None:
    with contextlib.suppress(*LINE_ERRORS):
        fcntl.ioctl(port.fileno(), termios.TIOCNXCL)
    with contextlib.suppress(*LINE_ERRORS):
        port.reset_output_buffer()  # or closing waits for a line that is stuck
    with contextlib.suppress(*LINE_ERRORS):
        port.close()
