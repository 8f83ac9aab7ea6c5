"""SBUS frames, built by hand from the bit layout, through the driver."""

from __future__ import annotations

import pytest
from hypothesis import given, settings

from tests.unit.io.sensors import rc_line
from tests.unit.io.sensors.rc_line import ANY_STREAM, HIGH, LOW, PERIOD_S, cut, in_shares, packed

PROVEN = 10  # frames, before they count
# all channels at the centre: 992 is 0b01111100000, the lowest bit first
CENTRED = bytes.fromhex("0f e0031ff8c0073ef0810f7c e0031ff8c0073ef0810f7c 00 00")


def frame(*values: int, flags: int = 0x00, end: int = 0x00) -> bytes:
    """`values`: of the first channels; the others are at the centre."""
    return b"\x0f" + packed(values) + bytes((flags, end))


class Line(rc_line.Line):
    """The line of an SBUS receiver."""

    def proven(self) -> Line:
        """It has sent ten frames, all channels at the centre."""
        self.hear(*[frame()] * PROVEN)
        return self


def test_a_frame_by_hand() -> None:
    assert frame() == CENTRED
    found = Line().hear(*[CENTRED] * PROVEN)
    assert [rc.channels for rc in found] == [(0.0,) * 16] and not found[0].lost
    assert found[0].t_s == pytest.approx(PROVEN * PERIOD_S) and found[0].source == "rc"


def test_the_ends_of_the_sticks() -> None:
    (rc,) = Line().hear(*[frame(LOW, HIGH, 172, 1811, 0, 2047)] * PROVEN)
    assert rc.channels[:4] == pytest.approx((-1.0, 1.0, -1.024, 1.024), abs=2e-3)
    assert rc.channels[4:6] == pytest.approx((-1.24, 1.318), abs=2e-3)


def test_frames_count_from_the_tenth_in_a_row_whatever_the_chunks() -> None:
    stream = frame(LOW) * (PROVEN + 1)
    for size in (1, 7, 25, 26, 100):
        line = Line()
        found = line.hear(*(stream[at : at + size] for at in range(0, len(stream), size)))
        assert found and all(rc.channels[0] == -1.0 for rc in found), size
        assert line.sensor.counts == (2, 0)


def test_one_frame_moves_no_stick_and_throws_no_switch() -> None:
    line = Line().proven()
    line.hear(*[frame(LOW)] * 3)
    found = line.hear(frame(HIGH), *[frame(LOW)] * (PROVEN + 2), every_s=0.02)
    assert [rc.channels[0] for rc in found] == [-1.0] * 3, "ten frames after it the line is trusted again"
    found = line.hear(frame(HIGH), frame(HIGH), every_s=0.02)
    assert [rc.channels[0] for rc in found] == [-1.0, 1.0], "the second one does"


def test_failsafe_and_lost_frames() -> None:
    line = Line().proven()
    line.hear(*[frame(HIGH)] * 3)
    assert not line.hear(*[frame(HIGH, flags=0x04)] * 4, every_s=0.05)[1:], "old channels are no news"
    lost = line.hear(*[frame(HIGH, flags=0x0C)] * 3, every_s=0.05)
    assert [rc.lost for rc in lost][-2:] == [True, True]
    back = line.hear(*[frame(HIGH)] * 3, every_s=0.05)
    assert not back[-1].lost
    assert line.sensor.health(line.now_s).ok, "the receiver is well all the time"


def test_silence_is_a_lost_transmitter_and_a_fault_of_the_wire() -> None:
    line = Line(timeout_s=1.0)
    (rc,) = line.hear(*[frame()] * PROVEN)
    (gone,) = line.sensor.read(line.now_s + 1.5)
    assert gone.lost and gone.t_s == pytest.approx(rc.t_s + 1.0)
    assert line.sensor.read(line.now_s + 1.6) == [], "it is said once"
    health = line.sensor.health(line.now_s + 1.5)
    assert not health.ok and health.text.startswith("silent for 1.5 s")
    assert not line.hear(*[frame()] * 4, every_s=0.02)[-1].lost


def test_at_most_fifty_readings_a_second() -> None:
    line = Line()
    assert len(line.hear(*[frame()] * (200 + PROVEN), every_s=0.007)) == pytest.approx(1.4 / 0.021, abs=3)
    line.wire.chunks = [(line.now_s + 0.1, frame() * 20)]
    assert len(line.sensor.read(line.now_s + 0.1)) == 1


@pytest.mark.parametrize("end", [0x04, 0x14, 0x24, 0x34])
def test_sbus2_ends(end: int) -> None:
    assert Line().hear(*[frame(end=end)] * PROVEN)


def test_an_inverted_line_is_explained() -> None:
    line = Line()
    line.hear(*[bytes(255 - byte for byte in CENTRED)] * 30)
    text = line.sensor.health(line.now_s).text
    assert "SBUS is inverted" in text and "parity=even" in text


@settings(deadline=None, derandomize=True, max_examples=60)
@given(**ANY_STREAM)
def test_any_channels_come_through_after_any_noise(values: list[int], noise: bytes, sizes: list[int]) -> None:
    """Noise before the frames may hide the first of them, no more than its length allows."""
    found = Line().hear(*cut(noise + frame(*values) * (PROVEN + 4), sizes), every_s=0.02)
    assert found and found[-1].channels == pytest.approx(in_shares(values))
