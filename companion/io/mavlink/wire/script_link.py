"""The private link of one script: one end of a pair of sockets, the other belongs to the script's process.

Nobody else reaches it. Only packets with the script's own address are taken, only those that its `may` grants are
obeyed, and its heartbeats never count as those of a ground station. Nothing is forwarded from or to it.
"""

from __future__ import annotations

import contextlib
import socket
from collections.abc import Iterable, Mapping, Sequence

from companion.core.tick import DeviceHealth
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.endpoint import Endpoint
from companion.io.mavlink.wire.guard import Guard
from companion.io.mavlink.wire.link_base import MOST_BYTES, Received, link_health, take_in
from companion.io.mavlink.wire.link_options import LEADER, LinkOptions, Route
from companion.io.mavlink.wire.personas import DEFAULT_PERSONA
from companion.supervisor.authority import RequestedAction

COMPONENT = 191  # MAV_COMP_ID_ONBOARD_COMPUTER
GRANTS: Mapping[str, frozenset[RequestedAction]] = {
    "command": frozenset({RequestedAction.COMMAND, RequestedAction.DISARM}),
    "setpoint": frozenset({RequestedAction.SETPOINT}),
    "upload": frozenset({RequestedAction.UPLOAD}),
    "parameter": frozenset({RequestedAction.PARAMETER}),
}
"""What each word of `may` grants."""


class ScriptLink:
    """A `Link`. `fault`: why the script does not run now, None while it does; its keeper writes it. `theirs`: the
    script's end of the pair."""

    def __init__(self, name: str, system: int, may: Iterable[str]) -> None:
        """`name`: of the script. `system`: its MAVLink system id. `may`: words of GRANTS."""
        self.name = f"script:{name}"
        self.guard = Guard(LinkOptions(telemetry=LEADER, route=Route.NO))
        self.guard.granted = frozenset(action for word in may for action in GRANTS[word])
        self.fault: str | None = "not started yet"
        self._system = system
        self._ours, self.theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_STREAM)
        self._ours.setblocking(False)
        self._waiting = b""
        self._closed = False
        self._endpoint = Endpoint(self.name, DEFAULT_PERSONA, self._transmit, guard=self.guard)

    @property
    def endpoints(self) -> Sequence[Endpoint]:
        """As `Link.endpoints`: none while the script does not run."""
        return () if self._closed or self.fault is not None else (self._endpoint,)

    def receive(self, now_s: float) -> Received:
        """As `Link.receive`. What does not come from the script's own address is left out."""
        heard: Received = []
        with contextlib.suppress(OSError):
            take_in(self._endpoint, self._endpoint.framer.feed(self._ours.recv(MOST_BYTES)), now_s, heard)
        return [(endpoint, message) for endpoint, message in heard if self._is_its_own(message)]

    def _is_its_own(self, message: object) -> bool:
        sender = message.get_srcSystem(), message.get_srcComponent()  # type: ignore[attr-defined]
        if sender != (self._system, COMPONENT):
            return False
        number = message.get_msgId()  # type: ignore[attr-defined]
        is_station = number == mavlink.MAVLINK_MSG_ID_HEARTBEAT and message.type == mavlink.MAV_TYPE_GCS  # type: ignore[attr-defined]
        return not is_station

    def filenos(self) -> Sequence[int]:
        """As `Link.filenos`."""
        return () if self._closed else (self._ours.fileno(),)

    def health(self, now_s: float) -> DeviceHealth:
        """As `Link.health`."""
        return link_health(self.name, (self._endpoint,), self.fault, now_s, self.guard)

    def news(self) -> Sequence[str]:
        """As `Link.news`."""
        return ()

    def close(self) -> None:
        """As `Link.close`."""
        self._closed = self._endpoint.gone = True
        self._ours.close()
        self.theirs.close()

    def _transmit(self, data: bytes, now_s: float) -> int:
        """All of it, or nothing while the script does not read."""
        try:
            if self._waiting:
                self._waiting = self._waiting[self._ours.send(self._waiting) :]
            if self._waiting:
                return len(data)
            self._waiting = data[self._ours.send(data) :]
        except OSError:
            pass
        return len(data)
