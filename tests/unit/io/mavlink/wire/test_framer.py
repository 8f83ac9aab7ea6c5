from __future__ import annotations

import io
import random
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common

from companion.io.mavlink.wire import framer as framer_module
from companion.io.mavlink.wire import messages as mavlink
from companion.io.mavlink.wire.framer import Framer, UnknownMessage, frame, pack
from tests.remembered import remembered

SAMPLES: list[Any] = [
    mavlink.MAVLink_heartbeat_message(11, 12, 81, 0x03040000, 3, 3),
    mavlink.MAVLink_attitude_message(1234, 0.1, -0.2, 3.0, 0.0, 0.0, 0.0),
    mavlink.MAVLink_command_long_message(1, 1, 400, 0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
    mavlink.MAVLink_statustext_message(6, b"a text with \xfd and \xfe in it", 0, 0),
    mavlink.MAVLink_param_set_message(1, 1, b"DP_BW_SURGE", 0.35, 9),
    mavlink.MAVLink_file_transfer_protocol_message(0, 1, 1, [0xFD, 0, 0xFE, *range(248)]),
    mavlink.MAVLink_mission_item_int_message(
        1, 1, 0, 3, 16, 1, 1, 0.0, float("nan"), 0.0, 0.0, 634400000, 104000000, 0.0, 0
    ),
    mavlink.MAVLink_battery_status_message(0, 0, 0, 0x7FFF, [65535] * 10, -1, -1, -1, 50),
    mavlink.MAVLink_available_modes_message(9, 1, 6, 0x04040000, 4, b"Mission"),
]


def bytes_of(message: Any, sequence: int = 0) -> bytes:
    return frame(pack(message), sequence, 255, 190)


def unknown_frame(payload: bytes, number: int = 0xABCDE) -> bytes:
    return (
        bytes((0xFD, len(payload), 0, 0, 5, 9, 8, number & 0xFF, number >> 8 & 0xFF, number >> 16))
        + payload
        + b"\x12\x34"
    )


def kinds(messages: list[Any]) -> list[str]:
    return [message.get_type() for message in messages]


@pytest.mark.parametrize(
    "message", [m for m in SAMPLES if type(m) is common.mavlink_map.get(type(m).id)], ids=lambda m: m.get_type()
)
def test_encodes_as_pymavlink_does_byte_for_byte(message: Any) -> None:
    theirs = common.MAVLink(io.BytesIO(), srcSystem=1, srcComponent=1)
    theirs.seq = 77
    assert frame(pack(message), 77, 1, 1) == message.pack(theirs)


def test_encodes_every_message_of_the_wheel_as_it_does() -> None:
    """Random payloads of every class, read by its own decoder and packed by both."""
    rng = random.Random(3)
    theirs = common.MAVLink(io.BytesIO(), srcSystem=7, srcComponent=9)
    compared = 0
    for cls in common.mavlink_map.values():
        if mavlink.MESSAGES[cls.id] is not cls:
            continue
        raw = bytes(rng.randrange(0, 127) for _ in range(cls.unpacker.size))
        head = bytes((0xFD, len(raw), 0, 0, 0, 7, 9, cls.id & 0xFF, cls.id >> 8 & 0xFF, cls.id >> 16))
        crc = common.x25crc((head + raw)[1:] + bytes((cls.crc_extra,))).crc
        whole = head + raw + bytes((crc & 0xFF, crc >> 8))
        (ours,) = Framer().feed(whole)
        reference = theirs.decode(bytearray(whole))
        assert ours.to_dict() == reference.to_dict()
        assert frame(pack(ours), 0, 7, 9) == reference.pack(theirs)
        compared += 1
    assert compared > 180


def test_header_fields_and_raw_bytes_are_kept() -> None:
    data = frame(pack(SAMPLES[0]), 200, 42, 17)
    (message,) = Framer().feed(data)
    assert (message.get_srcSystem(), message.get_srcComponent(), message.get_seq()) == (42, 17, 200)
    assert bytes(message.get_msgbuf()) == data


def test_version_1_frames_are_read() -> None:
    theirs = common.MAVLink(io.BytesIO(), srcSystem=255, srcComponent=190)
    data = common.MAVLink_heartbeat_message(6, 8, 0, 99, 4, 3).pack(theirs, force_mavlink1=True)
    assert data[0] == 0xFE
    (message,) = Framer().feed(data)
    assert (message.custom_mode, message.get_srcSystem()) == (99, 255)
    # version 1 has no extensions: mission_type is then 0
    data = common.MAVLink_mission_count_message(1, 1, 5).pack(theirs, force_mavlink1=True)
    (message,) = Framer().feed(data)
    assert (message.count, message.mission_type, message.opaque_id) == (5, 0, 0)


def test_every_version_1_message_is_read() -> None:
    theirs = common.MAVLink(io.BytesIO(), srcSystem=255, srcComponent=190)
    heard = 0
    for cls in common.mavlink_map.values():
        if cls.id > 255 or mavlink.MESSAGES[cls.id] is not cls:
            continue
        message = theirs.decode(bytearray(_whole(cls)))
        (read,) = Framer().feed(message.pack(theirs, force_mavlink1=True))
        assert read.to_dict() == message.to_dict()
        heard += 1
    assert heard > 100


def _whole(cls: Any) -> bytes:
    return frame(pack(mavlink.MESSAGES[cls.id](*_values(cls))), 0, 7, 9)


def _values(cls: Any) -> list[Any]:
    values: list[Any] = []
    for field, kind in zip(cls.fieldnames, cls.fieldtypes, strict=True):
        length = cls.array_lengths[cls.ordered_fieldnames.index(field)]
        values.append(b"x" if kind == "char" else [1] * length if length else 1)
    return values


@pytest.mark.parametrize(
    ("flood", "looks_per_byte", "summed_per_byte"),
    [
        (b"\xfe", 0.01, 0.01),
        (b"\xfd\xff", 0.01, 0.01),
        (b"\xfd\xff\x00", 0.05, 0.01),
        (b"\xfe\x09\x00\x00\x00\x00", 0.2, 4.0),
        (b"\xfe\x3f", 0.6, 36.0),
        (b"\xfd\xff" + bytes(8), 0.2, 30.0),
        (b"\xfd\xff\x00" * 80 + bytes_of(SAMPLES[0]), 0.7, 2.0),
    ],
    ids=["FE", "FD FF", "FD FF 00", "heartbeats 1", "FE 3F", "heartbeats 2", "false starts before a frame"],
)
def test_a_flood_costs_little(
    flood: bytes, looks_per_byte: float, summed_per_byte: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    looks = summed = 0
    look, checksum = framer_module._frame_at, framer_module._mcrf4xx

    def counted_look(buffer: bytes, start: int) -> Any:
        nonlocal looks
        looks += 1
        return look(buffer, start)

    def counted_sum(data: bytes) -> int:
        nonlocal summed
        summed += len(data)
        return int(checksum(data))

    monkeypatch.setattr(framer_module, "_frame_at", counted_look)
    monkeypatch.setattr(framer_module, "_mcrf4xx", counted_sum)
    data = flood * (65536 // len(flood))
    framer = Framer()
    for start in range(0, len(data), 4096):
        framer.feed(data[start : start + 4096])
    assert looks < looks_per_byte * len(data)
    assert summed < summed_per_byte * len(data)


def test_signed_frames_are_read_past_their_signature() -> None:
    theirs = common.MAVLink(io.BytesIO(), srcSystem=255, srcComponent=190)
    theirs.signing.secret_key = b"k" * 32
    theirs.signing.sign_outgoing = True
    data = common.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3).pack(theirs)
    assert len(data) == 9 + 12 + 13
    assert kinds(Framer().feed(data + bytes_of(SAMPLES[1]))) == ["HEARTBEAT", "ATTITUDE"]


def test_bytes_one_by_one() -> None:
    framer, heard = Framer(), []
    for byte in b"".join(map(bytes_of, SAMPLES)):
        heard += framer.feed(bytes((byte,)))
    assert kinds(heard) == kinds(SAMPLES)
    assert (framer.garbage, framer.received) == (0, len(SAMPLES))


@pytest.mark.parametrize(
    "stray", [b"\xfd", b"\xfe", b"\xfd\xff", b"\xfd\x1c\x00", b"\xfd\xff\x00\x00\x00\x01\x01\x1e\x00\x00"]
)
def test_a_stray_start_costs_nothing_but_itself(stray: bytes) -> None:
    framer = Framer()
    clean = b"".join(map(bytes_of, SAMPLES))
    heard = framer.feed(stray + clean) + framer.flush()
    assert kinds(heard) == kinds(SAMPLES)
    assert framer.garbage == len(stray)


def test_a_broken_frame_costs_only_itself() -> None:
    frames = [bytes_of(message) for message in SAMPLES]
    broken = bytearray(frames[2])
    broken[12] ^= 0x40
    framer = Framer()
    heard = framer.feed(b"".join([*frames[:2], bytes(broken), *frames[3:]])) + framer.flush()
    assert kinds(heard) == kinds([*SAMPLES[:2], *SAMPLES[3:]])


def test_a_truncated_frame_costs_only_itself() -> None:
    framer = Framer()
    heard = framer.feed(bytes_of(SAMPLES[1])[:-5] + bytes_of(SAMPLES[0]) + bytes_of(SAMPLES[2]))
    assert kinds(heard + framer.flush()) == ["HEARTBEAT", "COMMAND_LONG"]


def test_unknown_ids_are_skipped_by_their_length_and_counted() -> None:
    framer = Framer()
    heard = framer.feed(bytes_of(SAMPLES[0]) + unknown_frame(bytes(range(60))) + bytes_of(SAMPLES[1]))
    assert kinds(heard) == ["HEARTBEAT", f"UNKNOWN_{0xABCDE}", "ATTITUDE"]
    assert isinstance(heard[1], UnknownMessage)
    assert (heard[1].get_srcSystem(), heard[1].get_srcComponent()) == (9, 8)
    assert (framer.unknown, framer.received, framer.garbage) == (1, 2, 0)


def test_frames_with_unknown_incompatible_flags_are_refused() -> None:
    data = bytearray(bytes_of(SAMPLES[0]))
    data[2] = 0x02
    framer = Framer()
    assert framer.feed(bytes(data)) + framer.flush() == []


def test_random_bytes_neither_raise_nor_pile_up() -> None:
    rng = random.Random(1)
    framer = Framer()
    for _ in range(100):
        framer.feed(rng.randbytes(1000))
        assert remembered(framer) < 300
    framer.flush()
    assert not framer.pending
    assert kinds(framer.feed(bytes_of(SAMPLES[0]))) == ["HEARTBEAT"]


@settings(deadline=None, derandomize=True, max_examples=100)
@given(
    garbage=st.lists(
        st.one_of(
            st.binary(max_size=40), st.lists(st.sampled_from([0xFD, 0xFE, 0, 1, 9, 255]), max_size=40).map(bytes)
        ),
        min_size=10,
        max_size=10,
    ),
    cuts=st.lists(st.integers(1, 60), min_size=1, max_size=20),
)
def test_garbage_between_frames_loses_none_of_them(garbage: list[bytes], cuts: list[int]) -> None:
    data = b"".join(noise + bytes_of(message) for noise, message in zip(garbage, SAMPLES, strict=False)) + garbage[-1]
    framer, heard, position, i = Framer(), [], 0, 0
    while position < len(data):
        step = cuts[i % len(cuts)]
        heard += framer.feed(data[position : position + step])
        position, i = position + step, i + 1
    heard += framer.flush()
    assert kinds([message for message in heard if not isinstance(message, UnknownMessage)]) == kinds(SAMPLES)


@settings(deadline=None, derandomize=True, max_examples=100)
@given(hits=st.sets(st.integers(0, len(SAMPLES) - 1)), where=st.integers(0, 1000), flip=st.integers(1, 255))
def test_hits_lose_the_frames_hit(hits: set[int], where: int, flip: int) -> None:
    parts = []
    for i, message in enumerate(SAMPLES):
        data = bytearray(bytes_of(message))
        if i in hits:
            data[where % len(data)] ^= flip
        parts.append(bytes(data))
    framer = Framer()
    heard = framer.feed(b"".join(parts)) + framer.flush()
    expected = [message.get_type() for i, message in enumerate(SAMPLES) if i not in hits]
    survivors = kinds([message for message in heard if not isinstance(message, UnknownMessage)])
    remaining = iter(survivors)
    assert all(kind in remaining for kind in expected), (expected, survivors)
