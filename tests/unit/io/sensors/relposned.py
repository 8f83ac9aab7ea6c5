"""UBX-NAV-RELPOSNED written by hand, field by field, from the maker's table."""

from __future__ import annotations

import struct

FIXED, FLOAT = 0x137, 0x12F  # flags: fix ok, differential, valid, fixed or float, moving, heading valid
ITOW_MS = 345_618_400  # Wednesday 24:00 UTC and 0.4 s, by GPS time: 18 s of leap


def framed(payload: bytes, kind: bytes = b"\x01\x3c") -> bytes:
    body = kind + struct.pack("<H", len(payload)) + payload
    a = b = 0
    for byte in body:
        a = (a + byte) & 255
        b = (b + a) & 255
    return b"\xb5\x62" + body + bytes((a, b))


def relposned(
    north: tuple[int, int] = (1234, 56),
    east: tuple[int, int] = (-700, -12),
    down: tuple[int, int] = (15, 0),
    *,
    itow_ms: int = ITOW_MS,
    accuracy: tuple[int, int] = (80, 60),
    flags: int = FIXED,
    base: int = 4,
) -> bytes:
    """Version 1. Each component in cm and tenths of a millimetre, accuracies in tenths of a millimetre."""
    payload = struct.pack("<BBHI", 1, 0, base, itow_ms)
    payload += struct.pack("<iiiii4x", north[0], east[0], down[0], 1419, 33_000_000)
    payload += struct.pack("<bbbb", north[1], east[1], down[1], 3)
    payload += struct.pack("<IIIII4xI", *accuracy, 150, 90, 120_000, flags)
    assert len(payload) == 64
    return framed(payload)


def old_relposned(flags: int = FIXED) -> bytes:
    """Version 0, of the receivers of the eighth generation."""
    payload = struct.pack("<BBHIiiibbbxIIII", 0, 0, 4, ITOW_MS, 1234, -700, 15, 56, -12, 0, 80, 60, 150, flags)
    assert len(payload) == 40
    return framed(payload)
