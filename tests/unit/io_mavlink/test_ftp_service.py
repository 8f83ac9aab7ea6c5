"""FTP of a vessel without files: every request is answered at once, and rightly."""

from __future__ import annotations

import random
import struct

import pytest

from companion.io.mavlink.ftp_service import FtpService, answer

HEADER = struct.Struct("<HBBBBBBI")


def request(opcode: int, data: bytes = b"", seq: int = 7, session: int = 3, size: int | None = None, offset: int = 90) -> bytes:
    return (HEADER.pack(seq, session, opcode, len(data) if size is None else size, 0, 0, 0, offset) + data).ljust(251, b"\0")


@pytest.mark.parametrize(
    ("opcode", "data", "error"),
    [
        (0, b"", None),
        (1, b"", None),
        (2, b"", None),
        (3, b"/\0", 6),
        (3, b"/", 6),
        (3, b"", 6),
        (3, b".", 6),
        (3, b"/logs\0", 10),
        (4, b"@PARAM/param.pck?withdefaults=1", 10),
        (4, b"/general.json\0", 10),
        (4, b"", 3),
        (5, b"", 4),
        (6, b"/new", 9),
        (7, b"xx", 4),
        (8, b"/a", 10),
        (9, b"/dir", 9),
        (10, b"/dir", 10),
        (11, b"/a", 10),
        (12, b"/a", 10),
        (13, b"/a\0/b\0", 10),
        (14, b"/a", 10),
        (15, b"", 4),
        (16, b"/", 7),
        (77, b"", 7),
        (255, b"", 7),
    ],
)
def test_each_request_gets_its_answer(opcode: int, data: bytes, error: int | None) -> None:
    reply = answer(request(opcode, data))
    assert reply is not None and len(reply) == 251
    seq, session, ack, size, asked, burst, _, offset = HEADER.unpack_from(reply)
    assert (seq, session, asked, burst, offset) == (8, 3, opcode, 0, 90)
    assert (ack, size) == ((128, 0) if error is None else (129, 1))
    assert error is None or reply[12] == error


def test_more_data_than_fits_is_refused() -> None:
    reply = answer(request(4, b"/a", size=240))
    assert reply is not None and reply[3] == 129 and reply[12] == 3


def test_the_sequence_number_wraps() -> None:
    reply = answer(request(0, seq=0xFFFF))
    assert reply is not None and HEADER.unpack_from(reply)[0] == 0


@pytest.mark.parametrize("opcode", [128, 129])
def test_answers_are_not_answered(opcode: int) -> None:
    assert answer(request(opcode)) is None


def test_any_bytes_are_answered_or_are_an_answer() -> None:
    stream = random.Random(1)
    for _ in range(2000):
        payload = stream.randbytes(251)
        assert (answer(payload) is None) == (payload[3] in (128, 129))


def test_the_answer_goes_to_who_asked(desk) -> None:  # type: ignore[no-untyped-def]
    service = FtpService(desk.hub)
    desk.serve(service)
    desk.tell(desk.messages.MAVLink_file_transfer_protocol_message(0, 1, 1, request(4, b"@PARAM/param.pck")), desk.peer("qgc"))
    (peer, reply), = desk.heard()
    assert peer == desk.peer("qgc")
    assert (reply.target_network, reply.target_system, reply.target_component) == (0, 255, 190)
    assert bytes(reply.payload)[12] == 10
    service.update(0.0)
    assert desk.heard() == []
