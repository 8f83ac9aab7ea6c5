"""Listening on serial ports to learn what is plugged in. Nothing is ever written: the ports are opened for reading
alone."""

from __future__ import annotations

import contextlib
import errno
import fcntl
import os
import termios
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from companion.io.recognise import Recogniser
from companion.io.transport.port_holders import holder_of

BAUDS = (115200, 38400, 4800, 9600, 57600, 19200, 460800, 921600, 230400)  # the likely ones first
_TRY_S = 1.3  # at a speed at which bytes make no sense: devices that speak once a second, too
_TRY_BYTES = 600
_LEAST_S = 0.2
_CHUNK = 4096
_POLL_S = 0.02
_PARITIES = {"none": 0, "even": termios.PARENB, "odd": termios.PARENB | termios.PARODD}
_STOPBITS = {"1": 0, "2": termios.CSTOPB}
_BUSY = (errno.EBUSY, errno.EAGAIN)


class PortListener:
    """One port. `update(now_s)` until it is `done`; then `recogniser` holds what came in within `heard_s` at `baud`.

    Where bytes are no messages at one speed, it tries the next. A line without bytes is silent at any speed. The first
    message starts the count anew; where none follows it, that message is what was heard. Remembers the port's settings
    and restores them. `fault`: why the port cannot be listened to, with the remedy; None where it can.
    """

    def __init__(
        self, path: Path, listen_s: float, bauds: Sequence[int] = BAUDS, options: Mapping[str, str] | None = None
    ) -> None:
        """`options`: `parity` and `stopbits`, as behind the ? of a port's URL."""
        self.path = path
        self.done = False
        self.heard_s = 0.0
        self.fault: str | None = None
        self._listen_s = listen_s
        self._bauds = list(bauds)
        self._framing = (
            _PARITIES[(options or {}).get("parity", "none")] | _STOPBITS[(options or {}).get("stopbits", "1")]
        )
        self._descriptor: int | None = None
        self._settings: list[object] | None = None
        self._begun_s: float | None = None
        self._unknown: tuple[int, Recogniser] | None = None  # the first speed at which bytes came
        self.baud = self._bauds.pop(0)
        self.recogniser = Recogniser()
        self._first: tuple[float, Recogniser] | None = None  # when the first message came, and what had come until then
        try:
            self._open()
        except (OSError, termios.error) as error:
            self._give_up(_why_not(error))

    def _give_up(self, why: str) -> None:
        self.fault = self.fault or why
        self.close()

    def update(self, now_s: float) -> None:
        """Take what has come in. Go on, try the next speed, or end."""
        if self.done or self._descriptor is None:
            return
        if self._begun_s is None:
            self._begun_s = now_s
        with contextlib.suppress(OSError):
            self.recogniser.feed(os.read(self._descriptor, _CHUNK))
        self.heard_s = now_s - self._begun_s
        try:
            self._decide()
        except (OSError, termios.error):  # its settings cannot be changed any more
            if self._first is None:
                self._give_up("it was unplugged meanwhile")
            else:
                self._conclude()

    def _decide(self) -> None:
        if self._first is not None or not self.recogniser.bytes:
            if self.heard_s >= self._listen_s:
                self._conclude()
        elif self.recogniser.verdict is not None:
            self._first = self.heard_s, self.recogniser
            self._begin(self.baud)
        elif self.heard_s >= _TRY_S or (self.heard_s >= _LEAST_S and self.recogniser.bytes >= _TRY_BYTES):
            self._next_speed()

    def _conclude(self) -> None:
        if self._first is not None and self.recogniser.verdict is None:
            before_s, self.recogniser = self._first
            self.heard_s += before_s
        self.close()

    def close(self) -> None:
        """Restore the port's settings and close it."""
        self.done = True
        descriptor, self._descriptor = self._descriptor, None
        if descriptor is None:
            return
        with contextlib.suppress(OSError, termios.error):
            if self._settings is not None:
                termios.tcsetattr(descriptor, termios.TCSANOW, self._settings)  # type: ignore[arg-type]
        os.close(descriptor)

    def _open(self) -> None:
        holder = holder_of(self.path)
        if holder is not None:
            self.fault = f"skipped: {holder} has it open"
            self.done = True
            return
        self._descriptor = os.open(self.path, os.O_RDONLY | os.O_NOCTTY | os.O_NONBLOCK)
        fcntl.flock(self._descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        self._settings = termios.tcgetattr(self._descriptor)
        self._begin(self.baud)

    def _begin(self, baud: int) -> None:
        """Start again at that speed."""
        assert self._descriptor is not None
        speed = getattr(termios, f"B{baud}", None)
        if speed is None:
            raise OSError(errno.EINVAL, f"cannot be listened to at {baud} baud")
        raw = termios.tcgetattr(self._descriptor)
        raw[:6] = [0, 0, termios.CS8 | termios.CREAD | termios.CLOCAL | self._framing, 0, speed, speed]
        raw[6][termios.VMIN], raw[6][termios.VTIME] = 0, 0
        termios.tcsetattr(self._descriptor, termios.TCSANOW, raw)
        termios.tcflush(self._descriptor, termios.TCIFLUSH)
        self.baud, self.recogniser, self._begun_s = baud, Recogniser(), None

    def _next_speed(self) -> None:
        if self._unknown is None or (self.recogniser.guess and not self._unknown[1].guess):
            self._unknown = self.baud, self.recogniser
        if self._bauds:
            self._begin(self._bauds.pop(0))
            return
        self.baud, self.recogniser = self._unknown
        self.close()


def listen(paths: Sequence[Path], listen_s: float) -> list[PortListener]:
    """Listen to all ports at once, at the likely speeds. Each ends when it is known, silent for `listen_s`, or unknown
    at all speeds."""
    return hear_out([PortListener(path, listen_s) for path in paths])


def real_time_s() -> float:
    """Wait for the next turn of listening. Returns the clock's time then."""
    time.sleep(_POLL_S)
    return time.monotonic()


def hear_out(listeners: list[PortListener], wait: Callable[[], float] = real_time_s) -> list[PortListener]:
    """Update the listeners until all are done. `wait`: waits for the next turn, and returns the time then, s."""
    try:
        while not all(listener.done for listener in listeners):
            now_s = wait()
            for listener in listeners:
                listener.update(now_s)
    finally:
        for listener in listeners:
            listener.close()
    return listeners


def _why_not(error: OSError | termios.error) -> str:
    number = error.errno if isinstance(error, OSError) else None
    if number in (errno.EACCES, errno.EPERM):
        return "permission denied; `sudo usermod -aG dialout $USER`, then log in again"
    if number in _BUSY:
        return "skipped: another program has it open"
    if number == errno.ENOENT:
        return "no such device"
    if number is None or number == errno.ENOTTY:
        return "no serial port"
    return str(getattr(error, "strerror", None) or error)
