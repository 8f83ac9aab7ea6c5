"""CAN frames as bytes on a `ByteStream`: Linux's `struct can_frame` (linux/can.h), 16 bytes each."""

from __future__ import annotations

import struct
import zlib

SIZE = 16
_EXTENDED, _REMOTE, _ERROR = 0x8000_0000, 0x4000_0000, 0x2000_0000
_ID = 0x1FFF_FFFF
_FRAME = struct.Struct("<IB3x8s")
TROUBLE = _FRAME.pack(_ERROR, 8, b"")  # an error frame: stands for one that the CAN controller could not read


def pack(identifier: int, data: bytes) -> bytes:
    """The 16 bytes of a data frame with a 29-bit identifier and up to 8 bytes of data. Raises ValueError for more."""
    if len(data) > 8 or not 0 <= identifier <= _ID:
        raise ValueError(f"not a CAN frame: identifier {identifier:#x}, {len(data)} bytes")
    return _FRAME.pack(identifier | _EXTENDED, len(data), data)


def unpack(chunk: bytes) -> tuple[list[tuple[int, bytes]], int]:
    """The data frames with 29-bit identifiers in a chunk, as (identifier, data), and the number of other frames."""
    frames: list[tuple[int, bytes]] = []
    whole = len(chunk) - len(chunk) % SIZE
    others = int(whole != len(chunk))
    for word, length, data in _FRAME.iter_unpack(chunk[:whole]):
        if word & _EXTENDED and not word & (_REMOTE | _ERROR) and length <= 8:
            frames.append((word & _ID, data[:length]))
        else:
            others += 1
    return frames, others


def stand_in(folder: str, channel: str) -> tuple[str, int]:
    """(multicast group, UDP port) that carry a simulated CAN channel between two processes. Both derive the port from
    the channel and the folder that they share."""
    return "239.74.163.2", 20_000 + zlib.crc32(f"{folder} {channel}".encode()) % 20_000
