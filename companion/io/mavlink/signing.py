"""MAVLink 2 signatures: made for what we send, judged for what comes in. Source: MAVLink guide, "Message Signing".

A signature is the first 48 bits of SHA-256 over the secret key and the frame up to and with the time stamp. Time stamps count 10 µs since 2015, rise with
every packet of a stream (system, component, link), and say nothing until the signature has been found genuine: a forged packet changes nothing here.
(pymavlink notes the time before it looks at the signature, so that one forged packet locks a genuine peer out.)
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
_LATE = 60 * _TICKS_PER_S  # behind our own time, at most, for a stream that is not known yet
_LAST = 2**48 - 1
_MOST_STREAMS = 256  # only who has the key makes one
SAVE_PERIOD_S = 5.0
_PERIOD = round(SAVE_PERIOD_S * _TICKS_PER_S)
_AHEAD = 2 * _PERIOD  # one for the medium to take its time


class Policy(Enum):
    """What a link asks of packets, by the name in its URL (`?signing=…`)."""

    OFF = "off"  # signatures are neither looked at nor given
    ACCEPT = "accept"  # unsigned packets count; signed ones only if genuine; ours are signed once there is a key
    REQUIRE = "require"  # only genuine ones count


class Verdict(Enum):
    GENUINE = "genuine"
    FORGED = "forged"  # another key, another content, or none of ours to judge by
    STALE = "stale"  # genuine once: seen before, or too old for a new stream
    UNSIGNED = "unsigned"


@dataclass(frozen=True, slots=True)
class SigningState:
    """What is kept over a restart. `horizon`: no packet stamped at or before it is taken from a stream that is not known yet."""

    key: bytes | None
    horizon: int


class Signing:
    """`sign` and `judge` frames with one key for all links. Remembers the key, its own time, and the last stamp of each stream."""

    def __init__(self, time_unix_ns: Callable[[], int], state: SigningState, save: Callable[[SigningState], None]) -> None:
        """`save`: keeps the state; called with every new key, and at most every SAVE_PERIOD_S while signed packets come and go."""
        self._time_unix_ns = time_unix_ns
        self._save = save
        self._key = state.key
        self._floor = state.horizon
        self._horizon = state.horizon
        self._now = max(self._clock(), state.horizon)
        self._streams: dict[tuple[int, int, int], int] = {}

    @property
    def has_key(self) -> bool:
        return self._key is not None

    def set_key(self, key: bytes | None, stamp: int = 0) -> None:
        """Another key, or none, from now on, with which streams begin anew. `stamp`: the time that came with it. Raises ValueError for a key of another length."""
        if key is not None and len(key) != KEY_BYTES:
            raise ValueError(f"a key has {KEY_BYTES} bytes, not {len(key)}")
        if key != self._key:  # the same one again must not let its old packets count again
            self._streams.clear()
            self._floor = 0
        self._key = key
        self._now = max(self._now, self._clock(), min(stamp, _LAST))
        self._keep()

    def sign(self, data: bytes, crc_extra: bytes, link: int) -> bytes:
        """An unsigned MAVLink 2 frame with its signature; as it is while there is no key. `link`: 0…255."""
        if self._key is None or data[0] != _MARKER:
            return data
        head = bytearray(data[:-2])
        head[2] |= _SIGNED
        head += crc16.mcrf4xx(bytes(head[1:]) + crc_extra).to_bytes(2, "little")
        self._now = max(self._now + 1, self._clock())
        head += bytes([link & 0xFF]) + min(self._now, _LAST).to_bytes(_STAMP_BYTES, "little")
        self._keep_in_time()
        return bytes(head + self._hash(self._key, bytes(head)))

    def judge(self, data: bytes) -> Verdict:
        """Of a whole frame as it came. Only a genuine one is remembered."""
        if not is_signed(data) or len(data) < 12 + SIGNATURE_BYTES:
            return Verdict.UNSIGNED
        if self._key is None or not hmac.compare_digest(self._hash(self._key, data[:-_HASH_BYTES]), data[-_HASH_BYTES:]):
            return Verdict.FORGED
        stamp = int.from_bytes(data[-_HASH_BYTES - _STAMP_BYTES : -_HASH_BYTES], "little")
        stream = (data[5], data[6], data[-SIGNATURE_BYTES])
        last = self._streams.get(stream)
        if last is None:
            self._now = max(self._now, self._clock())
            if stamp <= self._floor or stamp < self._now - _LATE:
                return Verdict.STALE
            if len(self._streams) >= _MOST_STREAMS:
                oldest = min(self._streams, key=lambda known: self._streams[known])
                self._floor = max(self._floor, self._streams.pop(oldest))
        elif stamp <= last:
            return Verdict.STALE
        self._streams[stream] = stamp
        self._now = max(self._now, stamp)
        self._keep_in_time()
        return Verdict.GENUINE

    def close(self) -> None:
        """Keep what the time has come to."""
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
        """A horizon somewhat ahead, so that what is accepted until the next time is behind it after a power cut too."""
        self._horizon = 0 if self._key is None else min(_LAST, self._now + ahead)
        self._save(SigningState(self._key, self._horizon))


def is_signed(data: bytes) -> bool:
    """Whether a whole frame says that it bears a signature."""
    return data[0] == _MARKER and bool(data[2] & _SIGNED)


def unsigned(data: bytes, crc_extra: int | None) -> bytes:
    """The frame without its signature, as logs keep it; unchanged where it has none, or its checksum cannot be made anew (`crc_extra` None)."""
    if not is_signed(data) or crc_extra is None:
        return data
    head = bytearray(data[: -SIGNATURE_BYTES - 2])
    head[2] &= ~_SIGNED & 0xFF
    return bytes(head + crc16.mcrf4xx(bytes(head[1:]) + bytes([crc_extra])).to_bytes(2, "little"))
