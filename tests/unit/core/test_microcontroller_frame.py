"""The frame byte by byte, against a second implementation written from the docstring as firmware would be."""

from __future__ import annotations

import math
import struct
from dataclasses import replace

import pytest

from companion.core.actuation import Deployment, Light
from companion.core.microcontroller_frame import (
    BoardCommand,
    BoardStatus,
    FrameDecoder,
    Ident,
    IdentRequest,
    Radio,
    ThrusterDemand,
    ThrusterState,
    encode,
)
from tests.remembered import remembered


def crc_bitwise(data: bytes) -> int:
    crc = 0xFFFF
    for byte in data:
        crc ^= byte << 8
        for _ in range(8):
            crc = (crc << 1 ^ 0x1021 if crc & 0x8000 else crc << 1) & 0xFFFF
    return crc


def cobs_bytewise(data: bytes) -> bytes:
    """As in the paper's listing: a code byte is filled in when its block ends."""
    out = bytearray([0])
    code_at, code = 0, 1
    for byte in data:
        if byte:
            out.append(byte)
            code += 1
        else:
            out[code_at] = code
            code_at, code = len(out), 1
            out.append(0)
    out[code_at] = code
    return bytes(out)


def on_the_wire(body: bytes) -> bytes:
    return b"\0" + cobs_bytewise(body + struct.pack("<H", crc_bitwise(body))) + b"\0"


STATUS = BoardStatus(
    sequence=7,
    neutral_by_watchdog=False,
    leak_wet=True,
    rc_present=True,
    rc_lost=False,
    voltage_v=12.345,
    current_a=-1.5,
    remaining=1.0,
    rc_us=(1000, 1500, 2000, 0, 0, 0, 0, 0),
    thrusters=(ThrusterState(0.25, -1.0, True), ThrusterState(-1.0, None, False)),
)


def test_crc_check_value() -> None:
    assert crc_bitwise(b"123456789") == 0x29B1


def test_command_bytes() -> None:
    command = BoardCommand(
        sequence=0x102,
        armed=True,
        thrusters=(ThrusterDemand(0.5, math.pi / 2), ThrusterDemand(-1.0, None)),
        lower=True,
        red=Light.STEADY,
        yellow=Light.BLINK,
        green=Light.OFF,
    )
    body = bytes.fromhex("01 01 02 03 09 02") + struct.pack("<hhhh", 5000, 15708, -10000, -32768)
    assert encode(command) == on_the_wire(body)


@pytest.mark.parametrize(("lower", "flags"), [(None, 1), (True, 3), (False, 5)])
def test_retractable_thrusters_in_both_directions(lower: bool | None, flags: int) -> None:
    encoded = on_the_wire(bytes((1, 1, 0, flags, 0, 0)))
    assert encode(BoardCommand(0, True, (), lower)) == encoded
    assert FrameDecoder().feed(encoded) == [BoardCommand(0, True, (), lower)]
    states = (None, Deployment.RETRACTED, Deployment.MOVING, Deployment.LOWERED)
    status = replace(STATUS, thrusters=tuple(ThrusterState(0.0, None, True, state) for state in states))
    body = bytes.fromhex("01 02 07 06") + struct.pack("<HiB8HB", 12345, -1500, 254, 1000, 1500, 2000, 0, 0, 0, 0, 0, 4)
    body += b"".join(struct.pack("<hhB", 0, -32768, state) for state in (1, 3, 5, 7))
    assert encode(status) == on_the_wire(body) and FrameDecoder().feed(on_the_wire(body)) == [status]


def test_status_bytes() -> None:
    body = bytes.fromhex("01 02 07 06") + struct.pack("<HiB8HB", 12345, -1500, 254, 1000, 1500, 2000, 0, 0, 0, 0, 0, 2)
    body += struct.pack("<hhB", 2500, -10000, 1) + struct.pack("<hhB", -10000, -32768, 0)
    assert encode(STATUS) == on_the_wire(body)
    assert FrameDecoder().feed(on_the_wire(body)) == [STATUS]


def test_safe_mode_is_bit_4_radio_bit_5_and_the_bits_above_are_reserved() -> None:
    both = replace(STATUS, safe_mode=True, takes_radio=True)
    for flags, status in ((0x16, replace(STATUS, safe_mode=True)), (0x36, both), (0x46, None)):
        body = bytes((1, 2, 7, flags)) + struct.pack("<HiB8HB", 12345, -1500, 254, 1000, 1500, 2000, 0, 0, 0, 0, 0, 2)
        body += struct.pack("<hhB", 2500, -10000, 1) + struct.pack("<hhB", -10000, -32768, 0)
        assert FrameDecoder().feed(on_the_wire(body)) == ([] if status is None else [status])
    assert FrameDecoder().feed(encode(both)) == [both]


def test_radio_bytes() -> None:
    assert encode(Radio(b"\xc8\x00\x01")) == on_the_wire(b"\x01\x07\xc8\x00\x01")
    assert FrameDecoder().feed(on_the_wire(b"\x01\x07" + bytes(64))) == [Radio(bytes(64))]
    assert FrameDecoder().feed(on_the_wire(b"\x01\x07" + bytes(65))) == []


@pytest.mark.parametrize("length", [0, 65])
def test_radio_holds_1_to_64_bytes(length: int) -> None:
    with pytest.raises(ValueError, match=f"{length} bytes for the RC receiver; a frame holds 1 to 64"):
        encode(Radio(bytes(length)))


def test_ident_bytes() -> None:
    assert encode(IdentRequest()) == on_the_wire(bytes.fromhex("01 03"))
    assert encode(Ident((1, 2, 0), 3, "revolt")) == on_the_wire(bytes.fromhex("01 04 01 02 00 03 06") + b"revolt")
    assert FrameDecoder().feed(encode(Ident((1, 2, 0), 3, "revolt"))) == [Ident((1, 2, 0), 3, "revolt")]


def test_a_frame_holds_no_zero_inside() -> None:
    assert 0 not in encode(BoardCommand(0, False, (ThrusterDemand(0.0, 0.0),) * 16))[1:-1]


def test_values_out_of_range_are_limited_and_nan_is_neutral() -> None:
    demands = (
        ThrusterDemand(9.0, 0.0),
        ThrusterDemand(-9.0, 0.0),
        ThrusterDemand(math.nan, math.nan),
        ThrusterDemand(math.inf, math.inf),
    )
    (decoded,) = FrameDecoder().feed(encode(BoardCommand(1, True, demands)))
    assert isinstance(decoded, BoardCommand)
    assert [(demand.throttle, demand.azimuth_rad) for demand in decoded.thrusters] == [
        (1.0, 0.0),
        (-1.0, 0.0),
        (0.0, None),
        (1.0, None),
    ]


def test_unknown_values_survive() -> None:
    unknown = BoardStatus(0, True, False, False, False, None, None, None, (0,) * 8, ())
    assert FrameDecoder().feed(encode(unknown)) == [unknown]


def test_too_many_thrusters_are_refused() -> None:
    with pytest.raises(ValueError, match="17 thrusters"):
        encode(BoardCommand(0, False, (ThrusterDemand(0.0),) * 17))


@pytest.mark.parametrize(
    "body",
    [
        bytes.fromhex("02 01 00 01 00 00"),  # another version
        bytes.fromhex("01 09 00 00"),  # unknown type
        bytes.fromhex("01 01 00 01 00 01"),  # says one thruster, has none
        bytes.fromhex("01 01 00 01 00"),  # short
        bytes.fromhex("01 01 00 08 00 00"),  # unknown flag
        bytes.fromhex("01 01 00 06 00 00"),  # down and up at once
        bytes.fromhex("01 01 00 01 03 00"),  # a lamp that is neither
        bytes.fromhex("01 01 00 01 40 00"),  # reserved bits of the lamps
        bytes.fromhex("01 01 00 01 00 01") + struct.pack("<hh", 10001, 0),  # throttle above 1
        bytes.fromhex("01 01 00 01 00 01") + struct.pack("<hh", 0, 31417),  # azimuth above π
        bytes.fromhex("01 02 00 00"),
        bytes.fromhex("01 03 00"),
        bytes.fromhex("01 04 01 00 00 03 02 41"),  # name shorter than said
        b"",
    ],
)
def test_an_invalid_message_in_a_valid_frame_is_an_error(body: bytes) -> None:
    decoder = FrameDecoder()
    assert decoder.feed(on_the_wire(body)) == []
    assert decoder.errors == 1


def test_an_endless_stream_without_delimiters_is_bounded_and_recovered_from() -> None:
    decoder = FrameDecoder()
    for _ in range(100):
        assert decoder.feed(b"\x55" * 1000) == []
    assert remembered(decoder) <= 254
    assert decoder.feed(encode(STATUS)) == [STATUS]
    assert decoder.errors == 1
