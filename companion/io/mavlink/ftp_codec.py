"""The 251 bytes of a FILE_TRANSFER_PROTOCOL message. Source: MAVLink guide, "File Transfer Protocol"."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from enum import IntEnum

_HEADER = struct.Struct("<HBBBBBBI")  # seq, session, opcode, size, request opcode, burst complete, padding, offset
PAYLOAD_SIZE = 251
LARGEST_DATA = PAYLOAD_SIZE - _HEADER.size
_ACK, _NAK = 128, 129


class Opcode(IntEnum):
    """Those of MAVLink FTP."""

    NONE = 0
    TERMINATE_SESSION = 1
    RESET_SESSIONS = 2
    LIST_DIRECTORY = 3
    OPEN_FILE_RO = 4
    READ_FILE = 5
    CREATE_FILE = 6
    WRITE_FILE = 7
    REMOVE_FILE = 8
    CREATE_DIRECTORY = 9
    REMOVE_DIRECTORY = 10
    OPEN_FILE_WO = 11
    TRUNCATE_FILE = 12
    RENAME = 13
    CALC_FILE_CRC32 = 14
    BURST_READ_FILE = 15


class FtpError(IntEnum):
    """Those of MAVLink FTP that a read-only tree can meet."""

    FAIL = 1
    INVALID_DATA_SIZE = 3
    INVALID_SESSION = 4
    NO_SESSIONS_AVAILABLE = 5
    EOF = 6
    UNKNOWN_COMMAND = 7
    FILE_PROTECTED = 9
    FILE_NOT_FOUND = 10


@dataclass(frozen=True, slots=True)
class FtpRequest:
    """What a client asks. `size` of a read is how much it wants; of anything else how much of `data` counts."""

    seq: int
    session: int
    opcode: int
    size: int
    offset: int
    data: bytes

    @property
    def path(self) -> str | None:
        """None where it is no text."""
        try:
            return self.data.rstrip(b"\0").decode()
        except UnicodeDecodeError:
            return None


def parse(payload: bytes) -> FtpRequest | None:
    """None for what is itself an answer."""
    seq, session, opcode, size, _, _, _, offset = _HEADER.unpack_from(payload)
    if opcode in (_ACK, _NAK):
        return None
    return FtpRequest(seq, session, opcode, size, offset, payload[_HEADER.size :][:size])


def ack(request: FtpRequest, data: bytes = b"", *, seq: int | None = None, offset: int | None = None, burst_complete: bool = False) -> bytes:
    """`seq`: where more than one answer goes to a request, else the one after it."""
    seq = request.seq + 1 if seq is None else seq
    offset = request.offset if offset is None else offset
    header = _HEADER.pack(seq & 0xFFFF, request.session, _ACK, len(data), request.opcode, burst_complete, 0, offset)
    return (header + data).ljust(PAYLOAD_SIZE, b"\0")


def nak(request: FtpRequest, error: FtpError, *, seq: int | None = None, offset: int | None = None) -> bytes:
    seq = request.seq + 1 if seq is None else seq
    header = _HEADER.pack(seq & 0xFFFF, request.session, _NAK, 1, request.opcode, 0, 0, request.offset if offset is None else offset)
    return (header + bytes([error])).ljust(PAYLOAD_SIZE, b"\0")
