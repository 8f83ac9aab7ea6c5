"""NMEA 0183 sentences as a device prints them."""

from __future__ import annotations

KNOTS_PER_MPS = 3600.0 / 1852.0


def exclusive_or(body: bytes) -> int:
    """The exclusive or of all bytes. It has a second form in C (`sitl.native.operations`)."""
    total = 0
    for byte in body:
        total ^= byte
    return total


def checksum_text(body: str) -> str:
    """The checksum in two hexadecimal digits: exclusive or of the characters between the first one and *."""
    return f"{exclusive_or(body.encode('ascii')):02X}"


def sentence(body: str) -> str:
    """The sentence `body` with start, checksum and line end."""
    return f"${body}*{checksum_text(body)}\r\n"
