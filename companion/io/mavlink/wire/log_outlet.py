"""The log as an endpoint: it gets every packet."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from companion.io.mavlink.wire.endpoint import Endpoint
from companion.io.mavlink.wire.personas import DEFAULT_PERSONA

Tap = Callable[[Sequence[bytes]], None]


class LogOutlet(Endpoint):
    """The log, as an endpoint that never answers. Each flush gives the packets since the last one to the tap."""

    def __init__(self, tap: Tap) -> None:
        super().__init__("log", DEFAULT_PERSONA, lambda data, now_s: len(data))
        self._tap = tap
        self._packets: list[bytes] = []

    def send_bytes(self, data: bytes) -> None:
        """Keep a packet for the next flush."""
        self._packets.append(data)

    def flush(self, now_s: float) -> None:
        """Give the kept packets to the tap."""
        if self._packets:
            packets, self._packets = self._packets, []
            self._tap(packets)
