"""Runs of repeats, cumulative sums, sizes of noise."""

from __future__ import annotations

import math
import random

import pytest

from companion.nav.integrity.statistics import (
    Median3,
    NoiseSize,
    RepeatRun,
    Resolution,
    ScalarCusum,
    StepNoise,
    VectorCusum,
)


def run_of(values: list[object]) -> RepeatRun:
    run = RepeatRun()
    for k, value in enumerate(values):
        run.update(value, 0.05 * k)
    return run


def test_a_source_that_never_repeats_is_caught_soon() -> None:
    honest: list[object] = list(range(1000))
    needed = next(n for n in range(1, 50) if run_of([*honest, *[999] * n]).doubt >= 1.0)
    assert 8 <= needed <= 20
    assert run_of([*honest, *[999] * 5]).since_s == pytest.approx(0.05 * 999)


def test_a_coarse_source_is_given_its_repeats() -> None:
    """Runs of ten equal values all the time: one of thirty is nothing special, one of hundreds is."""
    honest: list[object] = [k // 10 for k in range(2000)]
    assert run_of([*honest, *[199] * 30]).doubt < 0.5
    assert run_of([*honest, *[199] * 600]).doubt > 1.0


def test_a_fault_teaches_nothing() -> None:
    frozen: list[object] = [*range(500), *[499] * 5000, *range(500, 600), *[599] * 20]
    assert run_of(frozen).doubt >= 1.0


def test_without_a_run_there_is_no_doubt() -> None:
    assert run_of([]).doubt == run_of([1]).doubt == run_of([1, 1, 2]).doubt == 0.0


def test_resolution_is_the_smallest_step() -> None:
    resolution = Resolution()
    for value in (1.0, 1.0, 3.0, 2.5, 2.5):
        resolution.update(value)
    assert resolution.step == 0.5


def test_one_outlier_hardly_changes_the_size_of_noise() -> None:
    rng, noise = random.Random(1), NoiseSize()
    for _ in range(1000):
        noise.update(abs(rng.gauss(0.0, 1.0)))
    before = noise.size
    assert before == pytest.approx(math.sqrt(2.0 / math.pi), rel=0.15)
    noise.update(1e9)
    assert noise.size < 1.03 * before


def test_a_steady_creep_is_no_noise_but_sudden_noise_is() -> None:
    steady = StepNoise()
    for _ in range(500):
        steady.update(0.0, 0.0)
    for _ in range(20):
        steady.update(0.5, 0.0)
    assert steady.size < 0.2
    rng, noisy = random.Random(2), StepNoise()
    for _ in range(500):
        noisy.update(0.0, 0.0)
    for _ in range(20):
        noisy.update(rng.gauss(0.0, 0.5), rng.gauss(0.0, 0.5))
    assert noisy.size > 0.3


def test_a_cumulative_sum_forgets_what_the_slack_explains() -> None:
    cusum = VectorCusum()
    for k in range(100):
        cusum.update(0.1 * k, 0.01, -0.01, 0.02)
    assert cusum.largest == 0.0
    for k in range(100, 120):
        cusum.update(0.1 * k, 0.01, -0.07, 0.02)
    assert cusum.largest == pytest.approx(20 * 0.05)
    assert cusum.onset_s == pytest.approx(9.9)
    cusum.clear(12.0)
    assert (cusum.largest, cusum.onset_s) == (0.0, 12.0)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_scalar_sum_goes_both_ways(sign: float) -> None:
    cusum = ScalarCusum()
    cusum.update(1.0, 0.0, 0.1)
    for k in range(5):
        cusum.update(2.0 + k, sign, 0.1)
    assert cusum.largest == pytest.approx(4.5) and cusum.onset_s == 1.0
    cusum.clear(9.0)
    assert (cusum.largest, cusum.onset_s) == (0.0, 9.0)


def test_the_newest_of_three_is_told_from_their_median() -> None:
    median = Median3()
    assert median.newest_off == 0.0
    for step in (1.0, 0.0, 0.0, 5.0):
        median.step(step)
    assert median.newest_off == 5.0
    median.step(-5.0)
    assert median.newest_off == 0.0
