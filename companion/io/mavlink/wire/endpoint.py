"""One endpoint: the far end of a link, with its sequence numbers, its persona and what waits to be sent to it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from companion.io.mavlink.wire.framer import Framer, Packed, frame
from companion.io.mavlink.wire.guard import Guard
from companion.io.mavlink.wire.personas import Persona
from companion.io.mavlink.wire.proof import Proof
from companion.io.mavlink.wire.radio_flow import RadioFlow
from companion.io.mavlink.wire.reception import Reception, Receptions

DATAGRAM_BYTES = 1200  # several messages share a datagram up to this size, which no network splits
FAST_BYTES_PER_S = 1_000_000.0  # assumed capacity of a network
_BACKLOG_BYTES = 65536
_SLOW_BACKLOG_S = 1.0
FORWARD_SHARE = 0.25  # of the line, at most, for forwarded packets
_FORWARD_S = 1.0  # for which an unused share is saved up
_LEAST_FORWARD = 1200.0
_LEAST_BYTES_PER_S = 250.0  # on a radio that cannot keep up: heartbeats and short answers


@dataclass(slots=True)
class LinkTraffic:
    """Counts since the endpoint was first seen. `received`: admitted messages of known ids. `forwarded`, `held_back`:
    packets of other systems. `dropped`: messages that the line could not take."""

    received: int = 0
    forwarded: int = 0
    held_back: int = 0

    sent: int = 0
    sent_bytes: int = 0
    dropped: int = 0


class Endpoint:
    """The far end of a link, with its own framer, sequence numbers and message intervals.

    `send` and `send_bytes` collect frames; `flush` puts them on the line, as many as it takes. `line_bytes_per_s`:
    capacity of the line; `bytes_per_s`: what is used of it, as much as a radio at its end passes on. `intervals_s`:
    message intervals that the far end asked for (message id → period; negative: never). `first_heard_s`,
    `last_heard_s`, `asked_s`: when it was heard first and last, and when it last sent more than a heartbeat. `trusted`:
    it has sent a genuine signature, or as one of the vessel's `operators`. `proof`: limits what is sent to an address
    that anybody can claim; None: no limit.
    """

    def __init__(
        self,
        name: str,
        persona: Persona,
        transmit: Callable[[bytes, float], int],
        *,
        datagrams: bool = False,
        bytes_per_s: float = FAST_BYTES_PER_S,
        framer: Framer | None = None,
        guard: Guard | None = None,
    ) -> None:
        """`transmit(data, now_s)`: returns how many bytes the line took; for datagrams all or none. `guard`: that of
        the link, with its options."""
        self.name = name
        self.persona = persona
        self.line_bytes_per_s = self.bytes_per_s = bytes_per_s
        self.framer = Framer() if framer is None else framer
        self.guard = Guard() if guard is None else guard
        self.telemetry = self.guard.options.telemetry
        self.receptions = Receptions()
        self.proof: Proof | None = None
        self.leader: Reception | None = None  # of the leader module behind it
        self.traffic = LinkTraffic()
        self.first_heard_s: float | None = None
        self.last_heard_s: float | None = None
        self.asked_s: float | None = None
        self.trusted = False
        self.gone = False
        self.intervals_s: dict[int, float] = {}
        self._transmit = transmit
        self._datagrams = datagrams
        self._sequence = 0xFF  # of the last message
        self._waiting = bytearray()
        self._cuts: list[int] = []  # datagrams: where one ends and the next begins
        self._radio = RadioFlow(_LEAST_BYTES_PER_S / bytes_per_s)
        self._limit = self._backlog_limit()
        self._forward_allowance = self._forward_most = max(_LEAST_FORWARD, _FORWARD_S * FORWARD_SHARE * bytes_per_s)
        self._forwarded_s: float | None = None
        self._allowance = 0.0
        self._allowed_s: float | None = None

    @property
    def backlog(self) -> int:
        """Bytes that wait to be sent."""
        return len(self._waiting)

    @property
    def busy(self) -> bool:
        """Whether half of the backlog is used, or a proof is missing: messages that can wait should."""
        return 2 * len(self._waiting) > self._limit or (self.proof is not None and self.proof.scarce)

    def radio_status(self, free_percent: int, now_s: float) -> None:
        """The radio at this end of a slow line says how much of its buffer is free, in percent."""
        if self.line_bytes_per_s < FAST_BYTES_PER_S:
            self._radio.take(free_percent, now_s)
            self._adapt(now_s)

    def _adapt(self, now_s: float) -> None:
        rate = self.line_bytes_per_s * self._radio.share(now_s)
        if rate != self.bytes_per_s:
            self.bytes_per_s = rate
            self._limit = self._backlog_limit()

    def _backlog_limit(self) -> int:
        if self.bytes_per_s >= FAST_BYTES_PER_S:
            return _BACKLOG_BYTES
        return max(1024, int(self.bytes_per_s * _SLOW_BACKLOG_S))

    def send(self, packed: Packed, system: int, component: int) -> None:
        """Frame a packed message with this endpoint's next sequence number, and collect it."""
        if not packed.again:
            self._sequence = (self._sequence + 1) & 0xFF
        self.send_bytes(self.guard.sign(frame(packed, self._sequence, system, component), packed.crc_extra))

    def send_bytes(self, data: bytes) -> None:
        """Collect one whole frame; it is dropped when too much waits already, or may not be sent without a proof."""
        waiting = self._waiting
        if self.gone or len(waiting) + len(data) > self._limit or not (self.proof is None or self._proves(len(data))):
            self.traffic.dropped += 1
            return
        if (
            self._datagrams
            and waiting
            and len(waiting) - (self._cuts[-1] if self._cuts else 0) + len(data) > DATAGRAM_BYTES
        ):
            self._cuts.append(len(waiting))
        waiting += data
        self.traffic.sent += 1

    def _proves(self, size: int) -> bool:
        assert self.proof is not None
        return self.trusted or self.proof.allows(size)

    def forward(self, data: bytes, urgent: bool, now_s: float) -> None:
        """Collect another system's packet, unchanged, if its share of the line allows. Half of that share is reserved
        for `urgent` packets."""
        if self._forwarded_s is not None:
            saved = max(0.0, now_s - self._forwarded_s) * FORWARD_SHARE * self.bytes_per_s
            self._forward_allowance = min(self._forward_most, self._forward_allowance + saved)
        self._forwarded_s = now_s
        least = 0.0 if urgent else 0.5 * self._forward_most
        if self.busy or self._forward_allowance - len(data) < least:
            self.traffic.held_back += 1
            return
        self._forward_allowance -= len(data)
        self.traffic.forwarded += 1
        self.send_bytes(data)

    def flush(self, now_s: float) -> None:
        """Send as much as the line takes now."""
        if not self._waiting or self.gone:
            return
        if self._datagrams:
            self._flush_datagrams(
                len(self._waiting) if self.bytes_per_s >= FAST_BYTES_PER_S else self._affordable(now_s), now_s
            )
        elif self.bytes_per_s >= FAST_BYTES_PER_S:
            self._drain(len(self._waiting), now_s)
        else:
            self._drain(self._affordable(now_s), now_s)

    def _flush_datagrams(self, most: int, now_s: float) -> None:
        """Send whole datagrams. The last one may exceed `most`; the excess is subtracted from the next allowance."""
        start = 0
        ends = [*self._cuts, len(self._waiting)]
        while ends and start < most:
            end = ends.pop(0)
            taken = self._transmit(bytes(self._waiting[start:end]), now_s)
            if taken:
                self.traffic.sent_bytes += taken
            else:
                self.traffic.dropped += 1
            start = end
        self._allowance -= start
        del self._waiting[:start]
        self._cuts = [end - start for end in ends[:-1]]

    def _drain(self, most: int, now_s: float) -> None:
        """Send up to `most` bytes of a stream."""
        taken = self._transmit(bytes(self._waiting[:most]), now_s) if most > 0 else 0
        del self._waiting[:taken]
        self.traffic.sent_bytes += taken
        self._allowance -= taken

    def _affordable(self, now_s: float) -> int:
        """Bytes that a slow line has had time to carry since the last call; at most a quarter of a second's worth."""
        if self._radio.reports:
            self._adapt(now_s)
        most = max(300.0, 0.25 * self.bytes_per_s)
        elapsed_s = 0.25 if self._allowed_s is None else max(0.0, now_s - self._allowed_s)
        self._allowed_s = now_s
        self._allowance = min(most, self._allowance + elapsed_s * self.bytes_per_s)
        return int(self._allowance)
