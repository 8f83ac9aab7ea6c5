"""The gust process against scipy's Riccati equation and against draws of itself."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest
from scipy.linalg import solve_discrete_are

from companion.analysis.disturbance import Array, Disturbance, Noise, Whitener, most_likely

PERIOD_S = 0.1
GUSTY = Disturbance(gust=0.004, gust_s=10.0, slow=0.003, slow_s=0.7, white=0.001)


def drawn(d: Disturbance, count: int, seed: int) -> Array:
    """p + n + w, by the definition."""
    chance = random.Random(seed)
    keep_gust, keep_slow = math.exp(-PERIOD_S / d.gust_s), math.exp(-PERIOD_S / d.slow_s)
    gust, slow, p, rows = chance.gauss(0.0, d.gust), chance.gauss(0.0, d.slow), 0.3, []
    for _ in range(count):
        rows.append(p + slow + chance.gauss(0.0, d.white))
        p += gust * PERIOD_S
        gust = keep_gust * gust + chance.gauss(0.0, d.gust * math.sqrt(1.0 - keep_gust**2))
        slow = keep_slow * slow + chance.gauss(0.0, d.slow * math.sqrt(1.0 - keep_slow**2))
    return np.array(rows)


@pytest.mark.parametrize(
    "d", [GUSTY, Disturbance(2e-4, 30.0, 3e-3, 2.0, 1e-4), Disturbance(0.05, 3.0, 1e-4, 0.2, 3e-4)]
)
def test_the_filter_is_the_kalman_filter_of_the_process(d: Disturbance) -> None:
    gust, slow = math.exp(-PERIOD_S / d.gust_s), math.exp(-PERIOD_S / d.slow_s)
    step = np.array([[1.0, PERIOD_S, 0.0], [0.0, gust, 0.0], [0.0, 0.0, slow]])
    seen, noise = np.array([[1.0, 0.0, 1.0]]), np.array([[d.white**2]])
    drive = np.diag([0.0, d.gust**2 * (1.0 - gust**2), d.slow**2 * (1.0 - slow**2)])
    spread = solve_discrete_are(step.T, seen.T, drive, noise)
    variance = (seen @ spread @ seen.T + noise)[0, 0]
    whitener = Whitener(d, PERIOD_S)
    assert whitener.variance == pytest.approx(variance, rel=1e-6)
    gain = step @ spread @ seen.T / variance

    def innovations(values: Array) -> Array:
        state, rows = np.zeros((3, 1)), []
        for value in values.tolist():
            rows.append(value - (seen @ state)[0, 0])
            state = step @ state + gain * rows[-1]
        return np.array(rows) / math.sqrt(variance)

    measured = drawn(d, 50, 1)
    free, constant = innovations(measured), innovations(np.ones(50))
    expected = free - constant * (constant @ free) / (constant @ constant)
    assert whitener(measured, ((0, 50),)) == pytest.approx(expected, abs=1e-6)


def test_innovations_are_white_and_of_size_one() -> None:
    left = drawn(GUSTY, 6000, 5)
    white = Whitener(GUSTY, PERIOD_S)(left, ((0, 3000), (3000, 6000)))
    assert np.std(white) == pytest.approx(1.0, abs=0.04)
    for lag in (1, 2, 5, 20):
        assert abs(np.mean(white[lag:] * white[:-lag])) < 0.05


def test_the_process_is_found_in_what_it_leaves() -> None:
    found = most_likely(drawn(GUSTY, 6000, 6), ((0, 6000),), PERIOD_S, smallest=2e-3)
    assert found.gust == pytest.approx(GUSTY.gust, rel=0.35)
    assert found.slow == pytest.approx(GUSTY.slow, rel=0.3) and found.white == pytest.approx(GUSTY.white, rel=0.3)


def test_a_constant_velocity_tells_nothing() -> None:
    left = drawn(GUSTY, 500, 7)
    whitener = Whitener(GUSTY, PERIOD_S)
    assert whitener(left + 3.0, ((0, 500),)) == pytest.approx(whitener(left, ((0, 500),)), abs=1e-6)


def test_gusts_that_push_aside_and_turn_at_once_are_counted_once() -> None:
    both = drawn(GUSTY, 4000, 8)
    left = np.stack([drawn(GUSTY, 4000, 9), both, 0.8 * both + 0.6 * drawn(GUSTY, 4000, 10)], axis=1)
    stretches = ((0, 4000),)
    noise = Noise([GUSTY] * 3, PERIOD_S, stretches, left)
    white = noise(left)
    assert white.T @ white / 4000 == pytest.approx(np.eye(3), abs=0.01)
    apart = Noise([GUSTY] * 3, PERIOD_S, stretches)
    assert noise.log_size < apart.log_size - 1000.0  # correlation makes the residuals likelier
    columns = np.stack([left, 2.0 * left], axis=2)
    assert noise(columns)[:, :, 1] == pytest.approx(2.0 * white)
