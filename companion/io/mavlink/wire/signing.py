"""MAVLink 2 signatures: made for packets that we send, verified for packets that come in.

Source: MAVLink guide, "Message Signing". A signature is the first 48 bits of SHA-256 over the secret key and the frame,
time stamp included. Time stamps count 10 µs since 2015 and rise with every packet of a stream (system, component,
link). A time stamp is used only after its signature is verified, so a forged packet changes nothing. (pymavlink takes
the time stamp first, so that one forged packet locks a genuine peer out.)

As the guide says, our own time follows the time stamps of peers; a boat without a clock gets the time that way. Where
we know the time, a packet more than a minute ahead of it is refused: one peer with a wrong clock must not make the
time stamps of all others too old. What such a peer did before we knew the time is undone then.
"""

from __future__ import annotations

import hashlib
import hmac
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import Protocol

from fastcrc import crc16

KEY_BYTES = 32
SIGNATURE_BYTES = 13
_STAMP_BYTES, _HASH_BYTES = 6, 6
_MARKER = 0xFD
_SIGNED = 0x01
_EPOCH_UNIX_NS = 1_420_070_400_000_000_000  # 2015-01-01
_TICKS_PER_S = 100_000
_LATE = 60 * _TICKS_PER_S  # the first packet of a new stream may be so far behind our own time
_LEAD = 60 * _TICKS_PER_S  # a packet may be so far ahead of the time that we know
_LAST = 2**48 - 1
_IMPLAUSIBLE = (4_102_444_800 - _EPOCH_UNIX_NS // 10**9) * _TICKS_PER_S  # 2100-01-01; nobody's clock shows that
MOST_STREAMS = 256  # only senders with the key make streams
SAVE_PERIOD_S = 5.0
_PERIOD = round(SAVE_PERIOD_S * _TICKS_PER_S)
_AHEAD = 2 * _PERIOD  # one period for a slow storage medium
_UNDONE = _LEAD + 2 * _AHEAD  # ahead of the time that we know: more than honest peers and stored horizons explain


class Policy(Enum):
    """Which signatures a link needs, by its name in the URL (`?signing=…`)."""

    OFF = "off"  # signatures are neither verified nor made
    ACCEPT = "accept"  # accepts unsigned and genuine packets; signs ours once there is a key
    REQUIRE = "require"  # accepts genuine packets only


class SignatureVerdict(Enum):
    """The result of verifying a packet's signature; the values are the words for people."""

    GENUINE = "genuine"
    FORGED = "forged"  # made with another key, altered, or we have no key to verify it
    STALE = "stale"  # replayed, too old for a new stream, or from the next century
    AHEAD = "ahead of our time"  # by more than a minute, where we know the time
    UNSIGNED = "unsigned"


@dataclass(frozen=True, slots=True)
class SigningState:
    """What is stored over a restart. `horizon`: a new stream's packet stamped at or before it is stale."""

    key: bytes | None
    horizon: int


Stream = tuple[int, int, int]
"""System, component and link of a sender."""


@dataclass(frozen=True, slots=True)
class Recollection:
    """What a process knew that ended without notice: its time, the floor of new streams, the last time stamp of each
    stream."""

    now: int
    floor: int
    streams: Mapping[Stream, int] = field(default_factory=dict)


class StreamMemory(Protocol):
    """Keeps what a process knows of its streams, packet by packet, past the end of that process."""

    def recall(self, state: SigningState) -> Recollection | None:
        """What the process before knew; None where it is lost, or does not belong to this state."""
        ...

    def begin(self, key: bytes | None, known: Recollection) -> None:
        """Keep this, and forget what was before."""
        ...

    def note(self, now: int, stream: Stream | None = None, stamp: int = 0) -> None:
        """Our time is `now`; a stream has reached `stamp`."""
        ...

    def close(self) -> None:
        """The process ends in order: what is stored elsewhere is enough."""
        ...


class _NoMemory:
    """The `StreamMemory` of who has none."""

    def recall(self, state: SigningState) -> Recollection | None:
        return None

    def begin(self, key: bytes | None, known: Recollection) -> None:
        pass

    def note(self, now: int, stream: Stream | None = None, stamp: int = 0) -> None:
        pass

    def close(self) -> None:
        pass


def _unknown() -> int | None:
    return None


class Signing:
    """`sign` and `judge` frames, with one key for all links. Remembers the key, its own time, and the last time stamp
    of each stream."""

    def __init__(
        self,
        time_unix_ns: Callable[[], int],
        state: SigningState,
        save: Callable[[SigningState], None],
        known_unix_ns: Callable[[], int | None] = _unknown,
        memory: StreamMemory | None = None,
    ) -> None:
        """`save`: stores the state. It is called for every new key, and every SAVE_PERIOD_S at most while signed
        packets come and go. `known_unix_ns`: the time where it is known to be right, None where it is not. `memory`:
        keeps the streams over an end without notice."""
        self._time_unix_ns = time_unix_ns
        self._known_unix_ns = known_unix_ns
        self._save = save
        self._memory: StreamMemory = _NoMemory() if memory is None else memory
        horizon = state.horizon if state.horizon < _IMPLAUSIBLE else 0
        before = self._memory.recall(state) or Recollection(horizon, horizon)
        self._key = state.key
        self._floor = before.floor
        self._horizon = horizon
        self._now = max(self._clock(), before.now)
        self._streams: dict[Stream, int] = dict(before.streams)
        self._remember()

    @property
    def has_key(self) -> bool:
        """Whether a key is set."""
        return self._key is not None

    def set_key(self, key: bytes | None, stamp: int = 0) -> None:
        """Use another key from now on, or none; all streams start afresh. `stamp`: the time stamp that came with it.
        Raises ValueError for a key of the wrong length."""
        if key is not None and len(key) != KEY_BYTES:
            raise ValueError(f"a key has {KEY_BYTES} bytes, not {len(key)}")
        if key != self._key:  # the same key again must not admit its old packets again
            self._streams.clear()
            self._floor = 0
        self._key = key
        known = self._known()
        most = _IMPLAUSIBLE if known is None else known + _LEAD
        self._now = max(self._now, self._clock(), stamp if stamp < most else 0)
        self._remember()
        self._keep()

    def sign(self, data: bytes, crc_extra: bytes, link: int) -> bytes:
        """Sign an unsigned MAVLink 2 frame; it is returned unchanged while there is no key. `link`: 0…255."""
        if self._key is None or data[0] != _MARKER:
            return data
        head = bytearray(data[:-2])
        head[2] |= _SIGNED
        head += crc16.mcrf4xx(bytes(head[1:]) + crc_extra).to_bytes(2, "little")
        self._known()
        self._now = max(self._now + 1, self._clock())
        self._memory.note(self._now)
        head += bytes([link & 0xFF]) + min(self._now, _LAST).to_bytes(_STAMP_BYTES, "little")
        self._keep_in_time()
        return bytes(head + self._hash(self._key, bytes(head)))

    def judge(self, data: bytes) -> SignatureVerdict:
        """Verify a whole frame as it came in. Only a genuine one is remembered, and only the first time."""
        if not is_signed(data) or len(data) < 12 + SIGNATURE_BYTES:
            return SignatureVerdict.UNSIGNED
        if self._key is None or not hmac.compare_digest(
            self._hash(self._key, data[:-_HASH_BYTES]), data[-_HASH_BYTES:]
        ):
            return SignatureVerdict.FORGED
        stamp = int.from_bytes(data[-_HASH_BYTES - _STAMP_BYTES : -_HASH_BYTES], "little")
        if stamp >= _IMPLAUSIBLE:  # it would end the time stamps of this stream, and then ours
            return SignatureVerdict.STALE
        known = self._known()
        if known is not None and stamp > known + _LEAD:
            return SignatureVerdict.AHEAD
        stream = (data[5], data[6], data[-SIGNATURE_BYTES])
        if not self._fresh(stream, stamp, known):
            return SignatureVerdict.STALE
        self._streams[stream] = stamp
        self._now = max(self._now, stamp)
        self._memory.note(self._now, stream, stamp)
        self._keep_in_time()
        return SignatureVerdict.GENUINE

    def close(self) -> None:
        """Store the present time stamp."""
        if self._key is not None:
            self._keep(0)
        self._memory.close()

    def _fresh(self, stream: Stream, stamp: int, known: int | None) -> bool:
        """Whether a packet is newer than all that its stream had before; of a new stream, new enough."""
        last = self._streams.get(stream)
        if last is not None:
            return stamp > last
        self._now = max(self._now, self._clock())
        if stamp <= self._floor or stamp < (self._now if known is None else known) - _LATE:
            return False
        if len(self._streams) >= MOST_STREAMS:
            oldest = min(self._streams, key=lambda each: self._streams[each])
            self._floor = max(self._floor, self._streams.pop(oldest))
            self._remember()
        return True

    def _known(self) -> int | None:
        """The time stamp of now, where the time is known. Undoes what peers with wrong clocks did before."""
        time_unix_ns = self._known_unix_ns()
        if time_unix_ns is None:
            return None
        known = max(0, (time_unix_ns - _EPOCH_UNIX_NS) // 10_000)
        if max(self._now, self._floor) > known + _UNDONE:
            self._now = known
            self._floor = known  # what came before counted already, or never will
            self._streams = {stream: last for stream, last in self._streams.items() if last <= known + _LEAD}
            self._remember()
            self._keep()
        return known

    def _remember(self) -> None:
        self._memory.begin(self._key, Recollection(self._now, self._floor, self._streams))

    @staticmethod
    def _hash(key: bytes, data: bytes) -> bytes:
        return hashlib.sha256(key + data).digest()[:_HASH_BYTES]

    def _clock(self) -> int:
        """The time stamp of now by the best clock; 0 for one that shows the next century."""
        time_unix_ns = self._known_unix_ns()
        if time_unix_ns is None:
            time_unix_ns = self._time_unix_ns()
        stamp = max(0, (time_unix_ns - _EPOCH_UNIX_NS) // 10_000)
        return stamp if stamp < _IMPLAUSIBLE else 0

    def _keep_in_time(self) -> None:
        if self._now + _PERIOD > self._horizon:
            self._keep()

    def _keep(self, ahead: int = _AHEAD) -> None:
        """Store a horizon ahead of now: after a power cut, packets accepted until the next save are still behind it."""
        self._horizon = 0 if self._key is None else min(_LAST, self._now + ahead)
        self._save(SigningState(self._key, self._horizon))


def is_signed(data: bytes) -> bool:
    """Whether a whole frame is marked as signed."""
    return data[0] == _MARKER and bool(data[2] & _SIGNED)


def unsigned(data: bytes, crc_extra: int | None) -> bytes:
    """The frame without its signature, as logs store it. Unchanged where it has none, or where its checksum cannot be
    computed (`crc_extra` None)."""
    if not is_signed(data) or crc_extra is None:
        return data
    head = bytearray(data[: -SIGNATURE_BYTES - 2])
    head[2] &= ~_SIGNED & 0xFF
    return bytes(head + crc16.mcrf4xx(bytes(head[1:]) + bytes([crc_extra])).to_bytes(2, "little"))
