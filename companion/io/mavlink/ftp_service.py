"""MAVLink FTP of a vessel that serves no files: every request gets its right refusal at once.

Silence costs a client seconds of retries before it goes on (MAVProxy 11 s before it asks for parameters one by one); a refusal costs
one round trip. Source: MAVLink guide, "File Transfer Protocol".
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from enum import IntEnum
from typing import Any

from companion.io.mavlink import messages as mavlink
from companion.io.mavlink.hub import Handler, Hub, Peer

_HEADER = struct.Struct("<HBBBBBBI")  # seq, session, opcode, size, request opcode, burst complete, padding, offset
_PAYLOAD_SIZE = 251
_LARGEST_DATA = _PAYLOAD_SIZE - _HEADER.size
_ACK = 128
_NAK = 129


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
    """Those of MAVLink FTP, as far as a vessel without files can meet them."""

    INVALID_DATA_SIZE = 3
    INVALID_SESSION = 4
    EOF = 6
    UNKNOWN_COMMAND = 7
    FILE_PROTECTED = 9
    FILE_NOT_FOUND = 10


_KNOWN = frozenset(Opcode)
_ACCEPTED = frozenset({Opcode.NONE, Opcode.TERMINATE_SESSION, Opcode.RESET_SESSIONS})
_OF_A_SESSION = frozenset({Opcode.READ_FILE, Opcode.WRITE_FILE, Opcode.BURST_READ_FILE})
_THAT_CREATE = frozenset({Opcode.CREATE_FILE, Opcode.CREATE_DIRECTORY})


class FtpService:
    """In: FILE_TRANSFER_PROTOCOL requests. Out: one reply to each, to who asked. Remembers nothing."""

    def __init__(self, hub: Hub) -> None:
        self._hub = hub
        self.handles: Mapping[int, Handler] = {mavlink.MAVLINK_MSG_ID_FILE_TRANSFER_PROTOCOL: self._on_request}

    def update(self, now_s: float) -> None:
        """Nothing is ever under way."""

    def _on_request(self, message: Any, peer: Peer, now_s: float) -> None:
        reply = answer(bytes(message.payload))
        if reply is not None:
            self._hub.send(peer, mavlink.MAVLink_file_transfer_protocol_message(0, peer.system, peer.component, reply))


def answer(payload: bytes) -> bytes | None:
    """The 251 bytes that answer a request's 251 bytes; None for what is itself an answer."""
    seq, session, opcode, size, _, _, _, offset = _HEADER.unpack_from(payload)
    if opcode in (_ACK, _NAK):
        return None
    error = refusal(opcode, size, payload[_HEADER.size : _HEADER.size + size])
    data = b"" if error is None else bytes([error])
    header = _HEADER.pack((seq + 1) & 0xFFFF, session, _ACK if error is None else _NAK, len(data), opcode, 0, 0, offset)
    return (header + data).ljust(_PAYLOAD_SIZE, b"\0")


def refusal(opcode: int, size: int, data: bytes) -> FtpError | None:
    """Why a request fails on a vessel without files; None for those that succeed."""
    if opcode not in _KNOWN:
        return FtpError.UNKNOWN_COMMAND
    if size > _LARGEST_DATA:
        return FtpError.INVALID_DATA_SIZE
    if opcode in _ACCEPTED:
        return None
    if opcode in _OF_A_SESSION:
        return FtpError.INVALID_SESSION
    path = data.strip(b"\0/")
    if opcode == Opcode.LIST_DIRECTORY:
        return FtpError.EOF if path in (b"", b".") else FtpError.FILE_NOT_FOUND
    if not path:
        return FtpError.INVALID_DATA_SIZE
    return FtpError.FILE_PROTECTED if opcode in _THAT_CREATE else FtpError.FILE_NOT_FOUND
