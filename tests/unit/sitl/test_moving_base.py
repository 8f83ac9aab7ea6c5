"""The simulated moving base: what its follower's receiver makes of the bytes that arrive."""

from __future__ import annotations

import math

import pytest

from companion.core.readings import FixType
from companion.io.rtcm import RtcmFramer
from companion.io.sensors.ubx_relative import RelativeSolution, RelativeSolutions
from sitl.moving_base import MovingBase, RelativeReceiver

EPOCH_NS = 1_780_315_200_000_000_000
BASE_M = (40.0, -5.0)


class Boats:
    """A base at rest, whose bytes arrive 0.1 s later, and a receiver aboard a boat that goes east at 5 m/s."""

    def __init__(self, seed: int = 1) -> None:
        self.base, self.receiver = MovingBase(), RelativeReceiver(seed, "gnss")
        self.parser = RelativeSolutions()
        self.tick = 0

    def sail(self, duration_s: float, heard: bool = True) -> list[RelativeSolution]:
        found = []
        for _ in range(round(10 * duration_s)):
            self.tick += 1
            t_s = 0.1 * self.tick
            for data in self.receiver.solutions((0.0, 5.0 * t_s), EPOCH_NS, t_s, True):
                found += self.parser.feed(data)
            frames = self.base.frames(t_s, BASE_M)
            if heard:
                self.receiver.hear([(t_s, data) for data in frames], t_s)
        return found


def test_frames_are_rtcm_once_a_second() -> None:
    base, framer = MovingBase(), RtcmFramer()
    frames = [one for tick in range(30) for one in base.frames(0.1 * tick, BASE_M)]
    assert framer.feed(b"".join(frames)) == frames and len(frames) == 3 * 5
    assert 600 < sum(map(len, frames)) / 3 < 900


def test_float_then_fixed_to_centimetres_at_its_own_time() -> None:
    found = Boats().sail(20.0)
    assert [one.fix for one in found[:8]] == [FixType.RTK_FLOAT] * 8
    fixed = [one for one in found if one.fix is FixType.RTK_FIXED]
    assert len(fixed) >= 10 and found[-len(fixed) :] == fixed
    for one in fixed:
        assert one.north_m == pytest.approx(-40.0, abs=0.05)
        assert one.east_m == pytest.approx(5.0 * (one.of_day_s - EPOCH_NS * 1e-9 % 86400.0) + 5.0, abs=0.05)


def test_without_observations_there_is_no_solution_and_it_is_float_again() -> None:
    boats = Boats()
    boats.sail(20.0)
    assert len(boats.sail(10.0, heard=False)) <= 1
    again = boats.sail(12.0)
    assert again[0].fix is FixType.RTK_FLOAT and again[-1].fix is FixType.RTK_FIXED


def test_without_a_fix_of_its_own_it_has_no_solution() -> None:
    boats = Boats()
    boats.receiver.hear([(0.0, data) for data in boats.base.frames(0.0, BASE_M)], 0.0)
    (data,) = boats.receiver.solutions((0.0, 0.0), EPOCH_NS, 0.0, False)
    (found,) = RelativeSolutions().feed(data)
    assert found.fix is FixType.NONE


def test_the_same_seed_gives_the_same() -> None:
    assert Boats(7).sail(12.0) == Boats(7).sail(12.0)
    assert Boats(7).sail(12.0) != Boats(8).sail(12.0)


def test_it_lies_when_told_to() -> None:
    boats = Boats()
    boats.sail(15.0)
    boats.receiver.off_m = (3.0, 0.0)
    assert boats.sail(3.0)[-1].north_m == pytest.approx(-37.0, abs=0.1)
    boats.receiver.frozen = True
    same = boats.sail(3.0)
    assert len({(one.north_m, one.east_m) for one in same}) == 1 and math.isfinite(same[0].north_m)
