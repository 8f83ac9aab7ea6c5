"""RTCM 3 corrections from ground stations: GPS_RTCM_DATA, and the older GPS_INJECT_DATA.

Source: MAVLink common.xml. `flags`: bit 0 marks a fragment, bits 1 and 2 are its number, bits 3 to 7 are a sequence
number that the fragments of one message share.

Senders differ in the rest. QGroundControl lets the fragment number overflow into the sequence number beyond 720 bytes.
Neither it nor MAVSDK ends a message of n·180 bytes with an empty fragment. So fragments only give the order of the
bytes; RTCM's own length and checksum tell where a message ends.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from companion.io.corrections import CorrectionsRelay
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.hub import Handler, Peer
from companion.io.rtcm import RtcmFramer

_FRAGMENTED = 0x01
_FRAGMENTS = 4
_MOST_SENDERS = 8
_MOST_DATA, _MOST_INJECTED = 180, 110


class Assembler:
    """Fragments of one sender, which the network may swap or duplicate → RTCM frames.

    Remembers the present sequence with its first fragment, the next fragment number, fragments that came too early, and
    an unfinished frame.
    """

    def __init__(self) -> None:
        self._framer = RtcmFramer()
        self._sequence = -1
        self._next = 0
        self._first = b""
        self._early: dict[int, bytes] = {}

    def append(self, data: bytes) -> list[bytes]:
        """Unnumbered bytes → the frames that are now complete."""
        return self._framer.feed(data)

    def take(self, flags: int, data: bytes) -> list[bytes]:
        """The data of one GPS_RTCM_DATA → the frames that are now complete."""
        if not flags & _FRAGMENTED:
            self._early.clear()
            self._next = 0
            return self._begin(data)
        number, sequence = flags >> 1 & 0x03, flags >> 3
        runs_on = number == 0 and self._next == _FRAGMENTS  # the fifth fragment of QGroundControl
        # from a sender that does not count its sequence numbers
        again = number == 0 and 0 < self._next < _FRAGMENTS and data != self._first
        if sequence != self._sequence or again:
            self._sequence = sequence
            self._early.clear()
            self._next = _FRAGMENTS if runs_on else 0
        if number == 0 and self._next in (0, _FRAGMENTS):
            frames = self._framer.feed(data) if runs_on else self._begin(data)
            self._next, self._first = 1, data
        elif number == self._next:
            frames = self._framer.feed(data)
            self._next += 1
        else:
            if number > self._next:
                self._early[number] = data
            return []
        while self._next in self._early:
            frames += self._framer.feed(self._early.pop(self._next))
            self._next += 1
        return frames

    def _begin(self, data: bytes) -> list[bytes]:
        """The first bytes of a message; an unfinished frame before it has lost its end."""
        frames = self._framer.flush() if len(data) > 1 and data[0] == 0xD3 and data[1] <= 0x03 else []
        return frames + self._framer.feed(data)


class RtcmService:
    """Passes GPS_RTCM_DATA and GPS_INJECT_DATA of any system as whole RTCM frames to the relay, which sends them to the
    GNSS receivers. What a leader module sends comes from a base that moves: it goes to the receivers for that alone."""

    def __init__(self, relay: CorrectionsRelay, module: Callable[[], int | None] = lambda: None) -> None:
        """`module()`: the system of the leader module that leads; None without one."""
        self._relay = relay
        self._module = module
        self._assemblers: dict[tuple[int, int, Any], Assembler] = {}
        self.handles: Mapping[int, Handler] = {
            mavlink.MAVLINK_MSG_ID_GPS_RTCM_DATA: self._on_rtcm,
            mavlink.MAVLINK_MSG_ID_GPS_INJECT_DATA: self._on_inject,
        }

    def update(self, now_s: float) -> None:
        """Nothing to do: the service only answers messages."""

    def _on_rtcm(self, message: Any, peer: Peer, now_s: float) -> None:
        frames = self._assembler(peer).take(message.flags, bytes(message.data[: min(message.len, _MOST_DATA)]))
        self._hand_over(frames, peer, now_s)

    def _on_inject(self, message: Any, peer: Peer, now_s: float) -> None:
        frames = self._assembler(peer).append(bytes(message.data[: min(message.len, _MOST_INJECTED)]))
        self._hand_over(frames, peer, now_s)

    def _assembler(self, peer: Peer) -> Assembler:
        key = (peer.system, peer.component, peer.endpoint)
        found = self._assemblers.pop(key, None) or Assembler()
        self._assemblers[key] = found
        if len(self._assemblers) > _MOST_SENDERS:
            del self._assemblers[next(iter(self._assemblers))]
        return found

    def _hand_over(self, frames: list[bytes], peer: Peer, now_s: float) -> None:
        if frames and (peer.system, peer.component) == (self._module(), mavlink.MAV_COMP_ID_ONBOARD_COMPUTER):
            self._relay.take_moving(frames, now_s)
        elif frames:
            self._relay.heard(now_s)
            self._relay.take(f"mavlink:{peer.system}", frames, now_s, way=f"{peer.endpoint.name} {peer.component}")
