"""RTCM 3 frames found in any stream, checked by pyrtcm's own checksum."""

from __future__ import annotations

import random

import pytest
from pyrtcm import RTCMReader
from pyrtcm.rtcmhelpers import calc_crc24q

from companion.io.rtcm import LONGEST, RtcmFramer, crc24q, message_number
from tests.remembered import remembered

STATION = bytes.fromhex("d300133ed7d30202980edeef34b4bd62ac0941986f33360b98")  # the standard's own example of a 1005


def frame(size: int, seed: int = 0, number: int = 1077) -> bytes:
    """A frame of `size` bytes in all, of a message type with any content."""
    data = bytes((number >> 4, (number & 0xF) << 4)) + random.Random(seed).randbytes(size - 8)
    head = bytes((0xD3, len(data) >> 8, len(data) & 0xFF)) + data
    return head + calc_crc24q(head).to_bytes(3, "big")  # type: ignore[no-any-return]


def test_the_standards_example() -> None:
    assert crc24q(b"123456789") == 0xCDE703
    assert RtcmFramer().feed(STATION) == [STATION] and message_number(STATION) == 1005
    assert RTCMReader.parse(STATION).DF003 == 2003


@pytest.mark.parametrize("size", [8, 179, 180, 181, 360, 720, 800, LONGEST])
def test_every_split_gives_the_frame_unchanged(size: int) -> None:
    whole = b"\xd3\xd3\x01" + frame(size) + b"$GPGGA,\xd3\xff\xd3\x00" + STATION
    for at in range(1, len(whole), max(1, len(whole) // 60)):
        framer = RtcmFramer()
        found = framer.feed(whole[:at]) + framer.feed(whole[at:]) + framer.flush()
        assert found == [frame(size), STATION]


def test_a_spoilt_bit_spoils_one_frame_only() -> None:
    whole = frame(100, 1) + frame(60, 2) + STATION
    for bit in range(8 * 100):
        spoilt = bytearray(whole)
        spoilt[bit // 8] ^= 1 << bit % 8
        framer = RtcmFramer()
        found = framer.feed(bytes(spoilt)) + framer.flush()
        assert found == [frame(60, 2), STATION]


def test_noise_holds_no_frames_and_is_not_kept() -> None:
    generator, framer = random.Random(5), RtcmFramer()
    for _ in range(500):
        assert framer.feed(generator.randbytes(200) + b"\xd3\x03\xff") == [] and remembered(framer) < LONGEST
    framer.flush()
    assert framer.feed(STATION) == [STATION]
