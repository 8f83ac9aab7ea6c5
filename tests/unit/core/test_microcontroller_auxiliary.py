"""AUXILIARY and AUXILIARY_STATUS byte by byte, against the framing that the test of the frame writes by hand."""

from __future__ import annotations

import math
import struct

import pytest

from companion.core.microcontroller_auxiliary import AuxiliaryDemand, AuxiliaryState
from companion.core.microcontroller_frame import FrameDecoder, encode
from tests.unit.core.test_microcontroller_frame import on_the_wire


def test_the_bytes() -> None:
    demand = AuxiliaryDemand(0x103, (1500.0, None, 2500.0), (True, False, False, True))
    body = bytes.fromhex("01 05 03 09 00 04 03") + struct.pack("<HHH", 1500, 0, 2500)
    assert encode(demand) == on_the_wire(body)
    state = AuxiliaryState(3, demand.servos_us, demand.relays)
    assert encode(state) == on_the_wire(b"\x01\x06" + body[2:])
    assert FrameDecoder().feed(encode(state)) == [state]


def test_pulses_out_of_range_are_limited_and_nan_is_no_pulses() -> None:
    (decoded,) = FrameDecoder().feed(encode(AuxiliaryDemand(0, (9999.0, -1.0, math.nan, math.inf), ())))
    assert decoded == AuxiliaryDemand(0, (2500.0, 500.0, None, 2500.0), ())


def test_too_many_are_refused() -> None:
    with pytest.raises(ValueError, match="17 servos and 0 relays"):
        encode(AuxiliaryDemand(0, (1500.0,) * 17, ()))


@pytest.mark.parametrize(
    "body",
    [
        bytes.fromhex("01 05 00 00 00 00"),  # short
        bytes.fromhex("01 05 00 02 00 01 00"),  # a relay on that is not counted
        bytes.fromhex("01 05 00 00 00 11 00"),  # 17 relays
        bytes.fromhex("01 05 00 00 00 00 01"),  # says one servo, has none
        bytes.fromhex("01 05 00 00 00 00 01") + struct.pack("<H", 499),
        bytes.fromhex("01 06 00 00 00 00 01") + struct.pack("<H", 2501),
    ],
)
def test_an_invalid_body_is_an_error(body: bytes) -> None:
    decoder = FrameDecoder()
    assert decoder.feed(on_the_wire(body)) == [] and decoder.errors == 1
