"""Reports to systemd: ready, alive, status, stopping. Source: sd_notify(3), systemd.service(5)."""

from __future__ import annotations

import contextlib
import os
import socket
from collections.abc import Mapping

from companion.core.tick import Tick

_KICKS = 4.0  # in the time that the watchdog waits
_STATUS_S = 5.0


class ServiceManager:
    """A `core.ports.Recorder` for systemd: each tick is a sign of life, so that a loop that hangs is restarted. The
    first tick reports READY.

    Never blocks and never raises: a service manager that does not listen is no reason to stop. Remembers when it last
    sent what.
    """

    def __init__(self, address: str, watchdog_s: float | None = None) -> None:
        """`address`: of the datagram socket, `@name` for an abstract one. `watchdog_s`: silence after which systemd
        restarts the service; None: no watchdog."""
        self._address = "\0" + address[1:] if address.startswith("@") else address
        self._kick_s = None if watchdog_s is None else watchdog_s / _KICKS
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC)
        self._socket.setblocking(False)
        self._kick_due_s = self._status_due_s = 0.0
        self._ready = False

    def record(self, tick: Tick) -> None:
        """See `Recorder`."""
        self.alive(tick.t_s, _status(tick))

    def alive(self, t_s: float, status: str) -> None:
        """Send the signs of life and the status that are due. `status`: one line."""
        lines = []
        if not self._ready:
            self._ready = True
            lines.append("READY=1")
        if self._kick_s is not None and t_s >= self._kick_due_s:
            self._kick_due_s = t_s + self._kick_s
            lines.append("WATCHDOG=1")
        if t_s >= self._status_due_s:
            self._status_due_s = t_s + _STATUS_S
            lines.append(f"STATUS={status}")
        if lines:
            self._say(*lines)

    def close(self) -> None:
        """Announce the end."""
        self._say("STOPPING=1")
        self._socket.close()

    def _say(self, *lines: str) -> None:
        with contextlib.suppress(OSError):
            self._socket.sendto("\n".join(lines).encode(), self._address)


def service_manager(environment: Mapping[str, str], process: int | None = None) -> ServiceManager | None:
    """The service manager that `environment` names, or None. `process`: our own number, since the watchdog may be meant
    for another process."""
    address = environment.get("NOTIFY_SOCKET", "")
    if not address.startswith(("/", "@")):
        return None
    meant = environment.get("WATCHDOG_PID", "")
    micros = environment.get("WATCHDOG_USEC", "")
    ours = not meant or meant == str(os.getpid() if process is None else process)
    return ServiceManager(address, int(micros) * 1e-6 if ours and micros.isdecimal() and int(micros) > 0 else None)


def _status(tick: Tick) -> str:
    armed = "armed" if tick.status.armed else "disarmed"
    ill = [device.name for device in tick.health if not device.ok]
    return f"{tick.status.mode.value}, {armed}, {tick.nav.fix.name}" + (f"; not well: {', '.join(ill)}" if ill else "")
