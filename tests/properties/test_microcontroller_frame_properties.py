"""Whatever the line does to a frame, the decoder gives what was sent or nothing."""

from __future__ import annotations

import math

from hypothesis import given, settings
from hypothesis import strategies as st

from companion.core.actuation import Deployment, Light
from companion.core.microcontroller_auxiliary import AuxiliaryDemand, AuxiliaryState
from companion.core.microcontroller_frame import (
    BoardCommand,
    BoardStatus,
    FrameDecoder,
    Ident,
    IdentRequest,
    Message,
    ThrusterDemand,
    ThrusterState,
    encode,
)
from tests.remembered import remembered

steady = settings(deadline=None, derandomize=True, max_examples=100)

throttles = st.integers(-10000, 10000).map(lambda n: n / 10000)
azimuths = st.none() | st.integers(-31415, 31415).map(lambda n: n / 1e4)
bytes_u8 = st.integers(0, 255)
lights = st.sampled_from(Light)
commands = st.builds(
    BoardCommand,
    sequence=bytes_u8,
    armed=st.booleans(),
    thrusters=st.lists(st.builds(ThrusterDemand, throttles, azimuths), max_size=16).map(tuple),
    lower=st.none() | st.booleans(),
    red=lights,
    yellow=lights,
    green=lights,
)
statuses = st.builds(
    BoardStatus,
    sequence=bytes_u8,
    neutral_by_watchdog=st.booleans(),
    leak_wet=st.booleans(),
    rc_present=st.booleans(),
    rc_lost=st.booleans(),
    voltage_v=st.none() | st.integers(0, 65534).map(lambda n: n / 1e3),
    current_a=st.none() | st.integers(-(2**31) + 1, 2**31 - 1).map(lambda n: n / 1e3),
    remaining=st.none() | st.integers(0, 254).map(lambda n: n / 254.0),
    rc_us=st.tuples(*[st.integers(0, 65535)] * 8),
    thrusters=st.lists(
        st.builds(ThrusterState, throttles, azimuths, st.booleans(), st.none() | st.sampled_from(Deployment)),
        max_size=16,
    ).map(tuple),
    safe_mode=st.booleans(),
)
names = st.text(st.characters(max_codepoint=127), max_size=32)
idents = st.builds(Ident, st.tuples(bytes_u8, bytes_u8, bytes_u8), bytes_u8, names)
pulses = st.lists(st.none() | st.integers(500, 2500).map(float), max_size=16).map(tuple)
relays = st.lists(st.booleans(), max_size=16).map(tuple)
outputs = st.builds(AuxiliaryDemand, bytes_u8, pulses, relays) | st.builds(AuxiliaryState, bytes_u8, pulses, relays)
messages = commands | statuses | idents | outputs | st.just(IdentRequest())

GOOD = BoardCommand(9, True, (ThrusterDemand(0.5, 1.0), ThrusterDemand(0.0, None)))


@steady
@given(st.lists(messages, max_size=6), st.integers(1, 40))
def test_round_trip_however_the_bytes_are_cut(sent: list[Message], chunk: int) -> None:
    wire = b"".join(encode(message) for message in sent)
    decoder = FrameDecoder()
    received = [message for at in range(0, len(wire), chunk) for message in decoder.feed(wire[at : at + chunk])]
    assert received == sent
    assert decoder.errors == 0


@steady
@given(messages, st.data())
def test_a_flipped_bit_costs_that_frame_alone(sent: Message, data: st.DataObject) -> None:
    wire = bytearray(encode(sent))
    bit = data.draw(st.integers(0, 8 * len(wire) - 1))
    wire[bit // 8] ^= 1 << bit % 8
    assert FrameDecoder().feed(encode(GOOD) + bytes(wire) + encode(GOOD)) == [GOOD, GOOD]


@steady
@given(messages, st.integers(0, 1000), st.integers(1, 8))
def test_lost_bytes_cost_that_frame_alone(sent: Message, at: int, count: int) -> None:
    wire = encode(sent)
    at = 1 + at % (len(wire) - 2)  # not the delimiters
    damaged = wire[:at] + wire[min(at + count, len(wire) - 1) :]
    assert FrameDecoder().feed(damaged + encode(GOOD)) == [GOOD]


@steady
@given(st.binary(max_size=600))
def test_garbage_gives_nothing_and_the_next_frame_comes_through(garbage: bytes) -> None:
    decoder = FrameDecoder()
    assert decoder.feed(garbage + encode(GOOD)) == [GOOD]
    assert remembered(decoder) == 0


@steady
@given(st.floats(-20.0, 20.0), st.floats(-1.5, 1.5))
def test_any_azimuth_arrives_as_the_same_direction(azimuth_rad: float, throttle: float) -> None:
    (received,) = FrameDecoder().feed(encode(BoardCommand(0, True, (ThrusterDemand(throttle, azimuth_rad),))))
    assert isinstance(received, BoardCommand)
    (thruster,) = received.thrusters
    assert thruster.azimuth_rad is not None
    assert abs(math.remainder(thruster.azimuth_rad - azimuth_rad, 2.0 * math.pi)) < 6e-5
    assert abs(thruster.throttle - min(max(throttle, -1.0), 1.0)) <= 0.5e-4 + 1e-12
