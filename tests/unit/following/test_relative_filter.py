"""The filter of relative position, against processes whose errors are drawn as it supposes them."""

from __future__ import annotations

import math
import random

import pytest

from companion.following.relative_filter import RelativeFilter
from sitl.noise import GaussMarkov, Normals

DT_S = 0.1
SLOW_M, NOISE_M = 0.9, 0.25


class Two:
    """Two boats: the truth moves in steps of `DT_S`, and the filter hears of it."""

    def __init__(self, seed: int, slow_m: float = SLOW_M) -> None:
        self.rng = Normals(random.Random(seed))
        self.filter = RelativeFilter()
        self.filter.suppose(slow_m)
        self.place = [20.0, -3.0]
        self.slow = [GaussMarkov(self.rng, slow_m, 60.0) for _ in range(2)]
        self.drift = [GaussMarkov(self.rng, 0.01, 5.0) for _ in range(2)]
        self.time = 0

    def step(self, differences: bool = True, base_m: float | None = None) -> None:
        self.time += 1
        speed = [0.6 * math.sin(0.05 * self.time), -0.4 * math.cos(0.03 * self.time)]
        for axis in range(2):
            error = self.drift[axis].update(DT_S)
            self.place[axis] += (speed[axis] + error) * DT_S + self.rng.gauss(0.0, 0.02 * math.sqrt(DT_S))
        self.filter.advance((speed[0] * DT_S, speed[1] * DT_S), DT_S)
        slow = [process.update(DT_S) for process in self.slow]
        if differences:
            seen = [here + error + self.rng.gauss(0.0, NOISE_M) for here, error in zip(self.place, slow, strict=True)]
            self.filter.take_difference(seen[0], seen[1], NOISE_M)
        if base_m is not None:
            seen = [here + self.rng.gauss(0.0, base_m) for here in self.place]
            self.filter.take_base(seen[0], seen[1], base_m)

    @property
    def error_m(self) -> tuple[float, float]:
        north_m, east_m = self.filter.position_m
        return north_m - self.place[0], east_m - self.place[1]


def test_its_sigma_is_what_it_errs_by() -> None:
    """Mean square of the error over its variance, of both axes of 60 runs: 1 ± 0.2 (three sigma of that mean)."""
    squares = []
    for seed in range(100, 160):
        two = Two(seed)
        for _ in range(900):
            two.step()
        squares += [(error / two.filter.sigma_m) ** 2 for error in two.error_m]
    assert sum(squares) / len(squares) == pytest.approx(1.0, abs=0.4)


def test_velocities_smooth_what_multipath_moves() -> None:
    """After minutes the position is better than the difference itself."""
    two = Two(1)
    for _ in range(3000):
        two.step()
    assert two.filter.sigma_m < 0.75 * SLOW_M


def test_a_moving_base_gives_centimetres_and_carries_on_after_it() -> None:
    two = Two(2)
    for tick in range(600):
        two.step(base_m=0.02 if tick % 10 == 0 else None)
    assert two.filter.sigma_m < 0.06 and math.hypot(*two.error_m) < 0.15
    for _ in range(100):
        two.step()
    assert 0.1 < two.filter.sigma_m < 0.5 and math.hypot(*two.error_m) < 1.0


def test_the_difference_stays_the_guide_where_its_error_is_small() -> None:
    two = Two(3, slow_m=0.02)
    for _ in range(100):
        two.step()
    assert two.filter.sigma_m < 0.12 and math.hypot(*two.error_m) < 0.4


def test_forgetting_begins_anew() -> None:
    two = Two(4)
    two.step()
    two.filter.forget()
    assert two.filter.sigma_m == pytest.approx(1000.0)
    two.step(base_m=0.02)
    assert math.hypot(*two.error_m) < 0.1
