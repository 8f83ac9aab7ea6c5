"""UBX-NAV-RELPOSNED among other bytes of a receiver: the vector from the antenna of its base to its own.

Source: u-blox F9 HPG 1.32 interface description, UBX-22008968, 3.15.13 (version 1, 64 bytes of payload) and 3.4.2 (the
checksum). Other receivers of that maker send version 0 with 40 bytes, where the accuracies and flags stand elsewhere.

There is no sentence of NMEA 0183 for it.
"""

from __future__ import annotations

import math
import struct
from typing import NamedTuple

from companion.core.readings import FixType

_HEAD = b"\xb5\x62\x01\x3c"  # synchronisation, class NAV, id RELPOSNED
_FRAME = 6  # before the payload: _HEAD and its length
_CHECKSUM = 2
_OLD, _NEW = 40, 64  # lengths of the payload
_FLAG_FIX_OK, _FLAG_RELATIVE, _FLAG_NORMALISED = 0x01, 0x04, 0x200  # the last: a direction, without a length
_CARRIER = {1: FixType.RTK_FLOAT, 2: FixType.RTK_FIXED}
_CM_M, _HP_M = 0.01, 0.0001
_DAY_MS = 86_400_000
LEAP_SECONDS = 18
"""GPS time less UTC since 2017 (IERS Bulletin C 52); bulletins since then have announced no other."""


class RelativeSolution(NamedTuple):
    """One solution. `of_day_s`: its UTC in seconds of the day. `fix` NONE: no solution, and the vector is NaN."""

    of_day_s: float
    north_m: float
    east_m: float
    down_m: float
    accuracy_m: float | None  # one sigma on each horizontal axis
    fix: FixType
    base: int


class RelativeSolutions:
    """Bytes as they come in → solutions. Remembers an unfinished message; `bad` counts wrong checksums."""

    def __init__(self) -> None:
        self._rest = b""
        self.bad = 0

    def feed(self, data: bytes) -> list[RelativeSolution]:
        """The solutions that the next bytes complete."""
        if not self._rest and data.find(_HEAD[0]) < 0:
            return []
        buffer, found, at = self._rest + data, [], 0
        while (begin := _begin(buffer, at)) >= 0:
            at = begin
            length = _length(buffer, at)
            if length is None:
                break
            end = at + _FRAME + length + _CHECKSUM
            if length not in (_OLD, _NEW):
                at += 1
                continue
            if len(buffer) < end:
                break
            if _checksum(buffer[at + 2 : end - _CHECKSUM]) == buffer[end - _CHECKSUM : end]:
                found.append(_solution(buffer[at + _FRAME : end - _CHECKSUM]))
                at = end
            else:
                self.bad += 1
                at += 1
        self._rest = buffer[begin:] if begin >= 0 else b""
        return found


def _begin(buffer: bytes, at: int) -> int:
    """Where a message may begin; −1 where none does."""
    found = buffer.find(_HEAD, at)
    if found >= 0:
        return found
    for kept in range(min(len(_HEAD) - 1, len(buffer) - at), 0, -1):
        if buffer.endswith(_HEAD[:kept]):
            return len(buffer) - kept
    return -1


def _length(buffer: bytes, at: int) -> int | None:
    """Length of the payload; None where it is not in yet."""
    return int.from_bytes(buffer[at + 4 : at + 6], "little") if len(buffer) >= at + _FRAME else None


def _checksum(data: bytes) -> bytes:
    """Fletcher's of 8 bits, over class, id, length and payload."""
    a = b = 0
    for byte in data:
        a = (a + byte) & 0xFF
        b = (b + a) & 0xFF
    return bytes((a, b))


def _solution(payload: bytes) -> RelativeSolution:
    base, itow_ms, *vector_cm = struct.unpack_from("<HIiii", payload, 2)
    if len(payload) == _NEW:
        fine, (accuracy_n, accuracy_e) = struct.unpack_from("<bbb", payload, 32), struct.unpack_from("<II", payload, 36)
        (flags,) = struct.unpack_from("<I", payload, 60)
    else:
        fine, (accuracy_n, accuracy_e) = struct.unpack_from("<bbb", payload, 20), struct.unpack_from("<II", payload, 24)
        (flags,) = struct.unpack_from("<I", payload, 36)
    of_day_s = (itow_ms - 1000 * LEAP_SECONDS) % _DAY_MS / 1000.0
    fix = _CARRIER.get(flags >> 3 & 0x03, FixType.NONE)
    usable = flags & _FLAG_FIX_OK and flags & _FLAG_RELATIVE and not flags & _FLAG_NORMALISED
    if not usable or fix is FixType.NONE:
        return RelativeSolution(of_day_s, math.nan, math.nan, math.nan, None, FixType.NONE, base)
    north_m, east_m, down_m = (cm * _CM_M + tenths * _HP_M for cm, tenths in zip(vector_cm, fine, strict=True))
    accuracy_m = _HP_M * math.sqrt(0.5 * (accuracy_n * accuracy_n + accuracy_e * accuracy_e))
    return RelativeSolution(of_day_s, north_m, east_m, down_m, accuracy_m or None, fix, base)
