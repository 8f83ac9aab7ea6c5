"""A serial RC receiver on the board: the compiled C, held against what transmitters send and against the drivers."""

from __future__ import annotations

import random

import pytest

from companion.core.microcontroller_frame import Radio
from companion.io.crsf_telemetry import framed
from companion.io.sensors.rc_stream import pulses_us
from tests.unit.io.actuators.firmware.host import Board, DriveConfig, RcReceiver
from tests.unit.io.sensors.rc_line import CENTRE, HIGH, LOW, packed

SBUS, CRSF = 2, 3
BOTH = pytest.mark.parametrize("protocol", [SBUS, CRSF], ids=["sbus", "crsf"])
PROVEN = {SBUS: 10, CRSF: 3}  # frames in a row, before they count
PERIOD_MS = 7
JUMP_US = 62
STICKS = (LOW, HIGH, 1192, CENTRE, 172, 1811, 700, 1500, 300)
PULSES = (1000, 2000, 1625, 1500, 988, 2012, 1318, 1818)
GONE = (0,) * 8


def sent(protocol: int, values: tuple[int, ...] = STICKS, flags: int = 0) -> bytes:
    if protocol == CRSF:
        return framed(0x16, packed(values))
    return b"\x0f" + packed(values) + bytes((flags, 0))


def link(quality: int) -> bytes:
    return framed(0x14, bytes((60, 60, quality, 10, 0, 4, 3, 60, quality, 10)))


class Line:
    """A receiver and its wire, a frame every 7 ms."""

    def __init__(self, protocol: int, now_ms: int = 5000) -> None:
        self.protocol, self.now_ms = protocol, now_ms
        self._receiver = RcReceiver(protocol)

    def hear(self, *frames: bytes) -> list[tuple[int, ...]]:
        found: list[tuple[int, ...]] = []
        for frame in frames:
            self.now_ms += PERIOD_MS
            found += self._receiver.hear(frame, self.now_ms)
        return found


@BOTH
@pytest.mark.parametrize("now_ms", [5000, 2**32 - 30], ids=["", "the clock wraps"])
def test_eight_channels_count_once_the_line_is_proven(protocol: int, now_ms: int) -> None:
    found = Line(protocol, now_ms).hear(*[sent(protocol)] * 20)
    assert len(found) == 20 - PROVEN[protocol] + 1
    assert set(found) == {PULSES}


@BOTH
def test_every_value_is_the_pulse_of_the_drivers(protocol: int) -> None:
    """Halves may be rounded either way."""
    line = Line(protocol)
    line.hear(*[sent(protocol, (0,) * 8)] * 12)
    for first in range(0, 2048, 8):
        values = tuple(range(first, first + 8))
        heard = line.hear(*[sent(protocol, values)] * 3)[-1]
        assert all(abs(a - b) <= 1 for a, b in zip(heard, pulses_us(values), strict=True))


@BOTH
def test_a_bad_wire_moves_no_stick(protocol: int) -> None:
    """One byte in two hundred is spoilt, in two percent of the frames one is lost or added. A channel of SBUS, which has
    no checksum, may be off by less than a jump."""
    rng, line = random.Random(31), Line(protocol)
    heard: list[tuple[int, ...]] = []
    for _ in range(20_000):
        data = bytearray(sent(protocol))
        for at in range(len(data)):
            if rng.random() < 0.005:
                data[at] ^= 1 << rng.randrange(8)
        if rng.random() < 0.02:
            del data[rng.randrange(len(data))]
        elif rng.random() < 0.02:
            data.insert(rng.randrange(len(data)), rng.randrange(256))
        heard += line.hear(bytes(data))
    assert len(heard) > 1000
    off_us = max(abs(a - b) for pulses in heard for a, b in zip(pulses, PULSES, strict=True))
    assert off_us <= (JUMP_US if protocol == SBUS else 0)


@BOTH
def test_noise_is_no_transmitter(protocol: int) -> None:
    rng = random.Random(32)
    assert Line(protocol).hear(*[rng.randbytes(rng.randrange(1, 60)) for _ in range(20_000)]) == []


@BOTH
def test_after_noise_the_line_is_proven_anew(protocol: int) -> None:
    line = Line(protocol)
    line.hear(*[sent(protocol)] * 20)
    assert line.hear(b"\x0f\xc8\xff\x03" * 10) == []
    assert line.hear(*[sent(protocol)] * (PROVEN[protocol] + 1))[-1] == PULSES


@BOTH
def test_a_loop_that_is_late_now_and_then_loses_no_frame(protocol: int) -> None:
    """The bytes of a frame are read in two turns, or those of two frames in one."""
    line = Line(protocol)
    line.hear(*[sent(protocol)] * 20)
    whole = sent(protocol)
    heard = line.hear(whole[:9], whole[9:], whole + whole, whole + whole[:5], whole[5:])
    assert heard == [PULSES] * 5


def test_a_jump_of_one_frame_moves_no_stick() -> None:
    line = Line(SBUS)
    line.hear(*[sent(SBUS)] * 20)
    jumped = sent(SBUS, (HIGH, *STICKS[1:]))
    heard = line.hear(jumped, *[sent(SBUS)] * 20)
    assert set(heard) == {PULSES}
    assert line.hear(*[jumped] * 3)[-1][0] == 2000


def test_failsafe_is_a_lost_transmitter_and_a_lost_frame_is_silence() -> None:
    line = Line(SBUS)
    line.hear(*[sent(SBUS)] * 20)
    assert line.hear(*[sent(SBUS, flags=0x04)] * 5)[1:] == []
    assert line.hear(*[sent(SBUS, flags=0x0C)] * 5)[-1] == GONE
    assert line.hear(*[sent(SBUS)] * 5)[-1] == PULSES


def test_a_link_without_quality_is_a_lost_transmitter() -> None:
    line = Line(CRSF)
    line.hear(*[sent(CRSF)] * 5)
    assert line.hear(link(100)) == []
    assert line.hear(link(0), sent(CRSF)) == [GONE, GONE]
    assert line.hear(link(80), sent(CRSF)) == [PULSES]
    line.hear(link(0))
    line.now_ms += 1000
    assert line.hear(sent(CRSF)) == [PULSES]


# --- the way back --------------------------------------------------------------------------------------------------


def test_the_board_holds_the_newest_frame_for_the_receiver() -> None:
    board = Board([DriveConfig(trim_us=1500, ahead_us=1900, astern_us=1100)])
    board.step()
    assert not board.status().takes_radio
    board.inputs.takes_radio = True
    board.step(60)
    assert board.status().takes_radio
    board.hear(Radio(b"old"), Radio(b"newest"))
    radio = board.outputs.radio
    assert bytes(radio.data[: radio.length]) == b"newest"
