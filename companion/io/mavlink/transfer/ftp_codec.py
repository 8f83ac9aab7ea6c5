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
    """The opcodes of MAVLink FTP."""

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
    """The errors of MAVLink FTP that occur here, where all files are read-only."""

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
    """A client's request. `size`: for a read, how many bytes it wants; otherwise the length of `data`."""

    seq: int
    session: int
    opcode: int
    size: int
    offset: int
    data: bytes

    @property
    def path(self) -> str | None:
        """The data as a path; None where it is not UTF-8."""
        try:
            return self.data.rstrip(b"\0").decode()
        except UnicodeDecodeError:
            return None


def parse(payload: bytes) -> FtpRequest | None:
    """The request in a payload of PAYLOAD_SIZE bytes; None for a payload that is an answer."""
    seq, session, opcode, size, _, _, _, offset = _HEADER.unpack_from(payload)
    if opcode in (_ACK, _NAK):
        return None
    return FtpRequest(seq, session, opcode, size, offset, payload[_HEADER.size :][:size])


def ack(
    request: FtpRequest,
    data: bytes = b"",
    *,
    seq: int | None = None,
    offset: int | None = None,
    burst_complete: bool = False,
) -> bytes:
    """The payload of a positive answer. `seq`: of this answer; None: the request's number plus 1. `offset` None: that
    of the request."""
    seq = request.seq + 1 if seq is None else seq
    offset = request.offset if offset is None else offset
    header = _HEADER.pack(seq & 0xFFFF, request.session, _ACK, len(data), request.opcode, burst_complete, 0, offset)
    return (header + data).ljust(PAYLOAD_SIZE, b"\0")


def nak(request: FtpRequest, error: FtpError, *, seq: int | None = None, offset: int | None = None) -> bytes:
    """The payload of a negative answer; `seq`, `offset` as for `ack`."""
    seq = request.seq + 1 if seq is None else seq
    header = _HEADER.pack(
        seq & 0xFFFF, request.session, _NAK, 1, request.opcode, 0, 0, request.offset if offset is None else offset
    )
    return (header + bytes([error])).ljust(PAYLOAD_SIZE, b"\0")
