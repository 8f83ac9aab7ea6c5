"""NMEA 0183 as a device prints it."""

from __future__ import annotations

from functools import reduce
from operator import xor


def sentence(body: str) -> str:
    """A sentence with its checksum: the exclusive or of all characters between $ and *."""
    return f"${body}*{reduce(xor, body.encode('ascii')):02X}\r\n"
