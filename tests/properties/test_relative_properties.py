"""Relative position: corrections cut into fragments and lost on the way, vectors spoilt by the line, and a filter that
knows what it is worth."""

from __future__ import annotations

import math

from hypothesis import given, settings
from hypothesis import strategies as st

from companion.following.relative_filter import RelativeFilter
from companion.io.mavlink.services.corrections import Assembler
from companion.io.sensors.ubx_relative import RelativeSolutions
from companion.leader_module.moving_base import fragments
from tests.unit.io.sensors.relposned import relposned
from tests.unit.io.test_rtcm import frame

_SIZES = st.lists(st.integers(8, 1029), min_size=1, max_size=12)


def pieces(sizes: list[int]) -> tuple[list[bytes], list[tuple[int, bytes]]]:
    frames = [frame(size, n) for n, size in enumerate(sizes)]
    cut = [one for n, whole in enumerate(frames) for one in fragments(whole, n)]
    return frames, [(one.flags, bytes(one.data[: one.len])) for one in cut]


@settings(deadline=None, derandomize=True, max_examples=100)
@given(_SIZES)
def test_fragments_give_the_frames_back(sizes: list[int]) -> None:
    frames, sent = pieces(sizes)
    assembler = Assembler()
    assert [whole for flags, data in sent for whole in assembler.take(flags, data)] == frames


@settings(deadline=None, derandomize=True, max_examples=100)
@given(_SIZES, st.randoms(use_true_random=False))
def test_with_fragments_lost_only_whole_frames_come_out(sizes: list[int], draws: object) -> None:
    frames, sent = pieces(sizes)
    assembler = Assembler()
    kept = [one for one in sent if draws.random() < 0.7]  # type: ignore[attr-defined]
    found = [whole for flags, data in kept for whole in assembler.take(flags, data)]
    assert all(whole in frames for whole in found)


@settings(deadline=None, derandomize=True, max_examples=150)
@given(st.integers(0, 71), st.integers(0, 255), st.integers(0, 72))
def test_a_spoilt_vector_is_none(at: int, byte: int, cut: int) -> None:
    message = bytearray(relposned())
    same = message[at] == byte
    message[at] = byte
    reader = RelativeSolutions()
    found = reader.feed(bytes(message[:cut])) + reader.feed(bytes(message[cut:]))
    assert len(found) == int(same)
    follower = reader.feed(relposned()) + reader.feed(bytes(80))
    assert len(follower) >= int(same)


_EVENT = st.tuples(
    st.sampled_from(["difference", "base", "none"]),
    st.floats(0.01, 2.0),
    st.floats(-50.0, 50.0),
    st.floats(0.02, 3.0),
)


@settings(deadline=None, derandomize=True, max_examples=100)
@given(st.lists(_EVENT, min_size=1, max_size=40), st.floats(0.0, 5.0))
def test_its_uncertainty_stays_sound(events: list[tuple[str, float, float, float]], slow_m: float) -> None:
    """A measurement never makes it less sure, time never surer, and it is surer than a base that has just come."""
    relative = RelativeFilter()
    relative.suppose(slow_m)
    for kind, dt_s, place_m, sigma_m in events:
        before_m = relative.sigma_m
        relative.advance((0.1, -0.1), dt_s)
        later_m = relative.sigma_m
        assert later_m >= before_m - 1e-9
        if kind == "difference":
            relative.take_difference(place_m, -place_m, sigma_m)
        elif kind == "base":
            relative.take_base(place_m, -place_m, sigma_m)
            assert relative.sigma_m <= sigma_m + 1e-9
        assert 0.0 < relative.sigma_m <= later_m + 1e-9
        assert all(map(math.isfinite, relative.position_m))
