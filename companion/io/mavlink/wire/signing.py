"""MAVLink 2 signatures: made for packets that we send, verified for packets that come in.

Source: MAVLink guide, "Message Signing". A signature is the first 48 bits of SHA-256 over the secret key and the frame,
time stamp included. Time stamps count 10 µs since 2015 and rise with every packet of a stream (system, component,
link). A time stamp is used only after its signature is verified, so a forged packet changes nothing. (pymavlink takes
the time stamp first, so that one forged packet locks a genuine peer out.)
"""

from __future__ import annotations

import hashlib
import hmac
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum

from fastcrc import crc16

KEY_BYTES = 32
SIGNATURE_BYTES = 13
_STAMP_BYTES, _HASH_BYTES = 6, 6
_MARKER = 0xFD
_SIGNED = 0x01
_EPOCH_UNIX_NS = 1_420_070_400_000_000_000  # 2015-01-01
_TICKS_PER_S = 100_000
_LATE = 60 * _TICKS_PER_S  # the first packet of a new stream may be so far behind our own time
_LAST = 2**48 - 1
_IMPLAUSIBLE = (4_102_444_800 - _EPOCH_UNIX_NS // 10**9) * _TICKS_PER_S  # 2100-01-01; nobody's clock shows that
_MOST_STREAMS = 256  # only senders with the key make streams
SAVE_PERIOD_S = 5.0
_PERIOD = round(SAVE_PERIOD_S * _TICKS_PER_S)
_AHEAD = 2 * _PERIOD  # one period for a slow storage medium


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
    UNSIGNED = "unsigned"


@dataclass(frozen=True, slots=True)
class SigningState:
    """What is stored over a restart. `horizon`: a new stream's packet stamped at or before it is stale."""

    key: bytes | None
    horizon: int


class Signing:
    """`sign` and `judge` frames, with one key for all links. Remembers the key, its own time, and the last time stamp
    of each stream."""

    def __init__(
        self, time_unix_ns: Callable[[], int], state: SigningState, save: Callable[[SigningState], None]
    ) -> None:
        """`save`: stores the state. It is called for every new key, and every SAVE_PERIOD_S at most while signed
        packets come and go."""
        self._time_unix_ns = time_unix_ns
        self._save = save
        horizon = state.horizon if state.horizon < _IMPLAUSIBLE else 0
        self._key = state.key
        self._floor = horizon
        self._horizon = horizon
        self._now = max(self._clock(), horizon)
        self._streams: dict[tuple[int, int, int], int] = {}

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
        self._now = max(self._now, self._clock(), stamp if stamp < _IMPLAUSIBLE else 0)
        self._keep()

    def sign(self, data: bytes, crc_extra: bytes, link: int) -> bytes:
        """Sign an unsigned MAVLink 2 frame; it is returned unchanged while there is no key. `link`: 0…255."""
        if self._key is None or data[0] != _MARKER:
            return data
        head = bytearray(data[:-2])
        head[2] |= _SIGNED
        head += crc16.mcrf4xx(bytes(head[1:]) + crc_extra).to_bytes(2, "little")
        self._now = max(self._now + 1, self._clock())
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
        stream = (data[5], data[6], data[-SIGNATURE_BYTES])
        last = self._streams.get(stream)
        if last is None:
            self._now = max(self._now, self._clock())
            if stamp <= self._floor or stamp < self._now - _LATE:
                return SignatureVerdict.STALE
            if len(self._streams) >= _MOST_STREAMS:
                oldest = min(self._streams, key=lambda known: self._streams[known])
                self._floor = max(self._floor, self._streams.pop(oldest))
        elif stamp <= last:
            return SignatureVerdict.STALE
        self._streams[stream] = stamp
        self._now = max(self._now, stamp)
        self._keep_in_time()
        return SignatureVerdict.GENUINE

    def close(self) -> None:
        """Store the present time stamp."""
        if self._key is not None:
            self._keep(0)

    @staticmethod
    def _hash(key: bytes, data: bytes) -> bytes:
        return hashlib.sha256(key + data).digest()[:_HASH_BYTES]

    def _clock(self) -> int:
        return max(0, (self._time_unix_ns() - _EPOCH_UNIX_NS) // 10_000)

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
