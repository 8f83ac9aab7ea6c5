"""Clocks: wall time, simulated time paced by wall time, simulated time that moves only when told to, and time that
another program moves."""

from __future__ import annotations

import math
import select
import socket
import time
from collections.abc import Sequence

_SAME_S = 1e-9  # times that differ by less are one
_FOREVER_S = 3600.0  # to wait for a grant; then it is waited for again
_SLIP_S = 0.5  # wall time behind which a paced run does not catch up


class WallClock:
    """Seconds since its creation, by the machine's monotonic clock, times `speed` (for a plant that runs as fast)."""

    def __init__(self, speed: float = 1.0) -> None:
        self._speed = speed
        self._start_s = self._released_s = time.monotonic()

    def now_s(self) -> float:
        """The time, in whole microseconds."""
        return math.floor((time.monotonic() - self._start_s) * self._speed * 1e6) / 1e6

    def time_unix_ns(self) -> int:
        """The machine's time since 1970."""
        return time.time_ns()

    def wait(self, until_s: float, filenos: Sequence[int]) -> bool:
        """Wait until `until_s`; True if a descriptor became readable before."""
        remaining_s = (until_s - self.now_s()) / self._speed
        if remaining_s > 0.0 and _readable(filenos, remaining_s):
            return True
        self._released_s = time.monotonic()
        return False

    def busy_s(self) -> float:
        """Time since the last wait ended."""
        return (time.monotonic() - self._released_s) * self._speed


class PacedClock:
    """For SITL with real ground stations: time advances in whole ticks, up to `speed` times as fast as the wall clock.

    A tick always spans its exact period. A slow machine makes a slow boat, not a different one.
    """

    def __init__(self, speed: float, epoch_unix_ns: int) -> None:
        self._speed = speed
        self._epoch_unix_ns = epoch_unix_ns
        self._now_s = 0.0
        self._wall_s = self._released_s = time.monotonic()  # when _now_s was due, and when it was reached

    def now_s(self) -> float:
        """The time of the present tick."""
        return self._now_s

    def time_unix_ns(self) -> int:
        """The same, since 1970."""
        return self._epoch_unix_ns + round(self._now_s * 1e9)

    def wait(self, until_s: float, filenos: Sequence[int]) -> bool:
        """Wait until `until_s` is due; True if a descriptor became readable before."""
        due_s = self._wall_s + (until_s - self._now_s) / self._speed
        wall_s = time.monotonic()
        if due_s > wall_s and _readable(filenos, due_s - wall_s):
            return True
        self._now_s = until_s
        self._released_s = time.monotonic()
        self._wall_s = max(due_s, self._released_s - _SLIP_S)
        return False

    def busy_s(self) -> float:
        """Time since the last wait ended."""
        return (time.monotonic() - self._released_s) * self._speed


class SimulatedClock:
    """For lockstep: waiting takes no time."""

    def __init__(self, epoch_unix_ns: int) -> None:
        self._epoch_unix_ns = epoch_unix_ns
        self._now_s = 0.0

    def set_ahead(self, by_s: float) -> None:
        """Step the time since 1970, as somebody who sets the host's clock does. `now_s` goes on as before."""
        self._epoch_unix_ns += round(by_s * 1e9)

    def now_s(self) -> float:
        """The time that was last waited for."""
        return self._now_s

    def time_unix_ns(self) -> int:
        """The same, since 1970."""
        return self._epoch_unix_ns + round(self._now_s * 1e9)

    def wait(self, until_s: float, filenos: Sequence[int]) -> bool:
        """Jump to `until_s`; always False."""
        self._now_s = until_s
        return False

    def busy_s(self) -> float:
        """Always 0."""
        return 0.0


class DrivenClock:
    """For co-simulation and tests: another program grants the time, over a TCP connection that this clock opens.

    That program writes lines with a time in seconds, up to which the run may go; the same time comes back as a line
    once all work up to it is done. Between two grants the run answers its links and no time passes. When the
    connection closes, time goes on by the wall clock.
    """

    def __init__(self, address: tuple[str, int], epoch_unix_ns: int) -> None:
        """Connect to `address`. Raises OSError where nothing listens there."""
        self._socket = socket.create_connection(address)
        self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self._epoch_unix_ns = epoch_unix_ns
        self._now_s = self._granted_s = 0.0
        self._rest = b""
        self._answered = True
        self._driven = True

    def now_s(self) -> float:
        """Vessel time, s."""
        return self._now_s

    def time_unix_ns(self) -> int:
        """Unix time, ns."""
        return self._epoch_unix_ns + round(self._now_s * 1e9)

    def wait(self, until_s: float, filenos: Sequence[int]) -> bool:
        """Wait until `until_s` is granted. Returns True early if one of `filenos` becomes readable."""
        if filenos and _readable(filenos, 0.0):  # what was sent before a grant is heard before time goes on
            return True
        while self._driven and self._granted_s < until_s - _SAME_S:
            self._answer()
            own = self._socket.fileno()
            if _readable([own, *filenos], _FOREVER_S) and not _readable([own], 0.0):
                return True
            self._hear()
        if not self._driven:
            time.sleep(max(0.0, until_s - self._now_s))
        self._now_s = until_s
        return False

    def busy_s(self) -> float:
        """Always 0."""
        return 0.0

    def close(self) -> None:
        """Close the connection."""
        self._socket.close()

    def _answer(self) -> None:
        """Say once that the time granted is used up."""
        if not self._answered:
            self._answered = True
            self._now_s = max(self._now_s, self._granted_s)
            self._socket.sendall(b"%r\n" % self._granted_s)

    def _hear(self) -> None:
        """Take the newest grant; an end of the connection ends the driving."""
        try:
            data = self._socket.recv(4096)
        except OSError:
            data = b""
        *lines, self._rest = (self._rest + data).split(b"\n")
        if lines:
            self._granted_s, self._answered = float(lines[-1]), False
        self._driven = bool(data)


def _readable(filenos: Sequence[int], timeout_s: float) -> bool:
    """Wait for a descriptor, at most `timeout_s`."""
    if not filenos:
        time.sleep(timeout_s)
        return False
    try:
        return bool(select.select(filenos, (), (), timeout_s)[0])
    except (OSError, ValueError):  # one was closed meanwhile; its link notices that
        time.sleep(min(timeout_s, 0.001))
        return True
