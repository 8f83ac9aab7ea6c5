"""NMEA 0183 as a device prints it."""

from __future__ import annotations

from functools import reduce
from operator import xor


def checksum_text(body: str) -> str:
    """The exclusive or of all characters between the first and *, in two digits."""
    return f"{reduce(xor, body.encode('ascii')):02X}"


def sentence(body: str) -> str:
    """A sentence with its checksum."""
    return f"${body}*{checksum_text(body)}\r\n"
