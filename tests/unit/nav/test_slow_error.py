"""Whether innovations show that what measurements are off by moves faster than is said."""

from __future__ import annotations

import math

import numpy as np
import pytest

from companion.nav.error_state import Innovation
from companion.nav.measured_off import Wander
from companion.nav.slow_error import Limits, SlowError, has_jumped

SAID = Wander(0.01, 100.0)


def innovation(y1: float, y2: float | None, variance: float) -> Innovation:
    made = Innovation(1 if y2 is None else 2)
    made.y1, made.y2 = y1, y2 or 0.0
    made.s11 = made.s22 = variance
    made.normalised_square = (made.y1**2 + made.y2**2) / variance
    return made


def taken(noise: float, drift: float, size: int = 2, most: float = 50.0, dt_s: float = 0.05) -> SlowError:
    """After a minute of innovations with noise and a part that lasts for a second."""
    draw = np.random.default_rng(1)
    watch, lasting = SlowError(Limits(most, 2000.0, 40.0, 0.15)), np.zeros(size)
    kept = math.exp(-dt_s)
    for k in range(round(60.0 / dt_s)):
        lasting = kept * lasting + drift * math.sqrt(1.0 - kept * kept) * draw.standard_normal(size)
        y = (lasting + noise * draw.standard_normal(size)).tolist()
        found = innovation(y[0], y[1] if size == 2 else None, 1.0)
        watch.take(k * dt_s, found, SAID.sigma)
    return watch


@pytest.mark.parametrize("size", [1, 2])
@pytest.mark.parametrize("noise", [0.3, 1.0, 5.0])
def test_noise_is_no_drift_however_much_there_is(size: int, noise: float) -> None:
    watch = taken(noise, 0.0, size=size)
    assert watch.expected(SAID, 60.0) == SAID and watch.doubt == 0.0


@pytest.mark.parametrize("size", [1, 2])
@pytest.mark.parametrize(("noise", "drift"), [(1.0, 3.0), (0.3, 0.9)])
def test_innovations_that_are_alike_add_to_the_slow_error(size: int, noise: float, drift: float) -> None:
    """Where the claimed noise is too large, too."""
    watch = taken(noise, drift, size=size)
    assert watch.expected(SAID, 60.0).sigma > 0.5 * drift and watch.doubt > 0.5 * drift


def test_what_is_small_beside_the_claims_does_no_harm() -> None:
    watch = taken(0.05, 0.2)
    assert watch.expected(SAID, 60.0) == SAID


def test_what_was_added_goes_back_and_has_a_limit() -> None:
    watch = taken(1.0, 300.0, most=5.0)
    assert watch.expected(SAID, 60.0).sigma == pytest.approx(5.0, rel=0.1)
    for k in range(1200, 1200 + 20 * 200):
        watch.take(k * 0.05, innovation(0.0, 0.0, 1.0), SAID.sigma)
    assert watch.expected(SAID, 260.0).sigma == pytest.approx(5.0 * math.exp(-200.0 / 60.0), rel=0.2)
    watch.begin()
    assert watch.expected(SAID, 260.0) == SAID


def test_neither_a_pause_nor_an_estimate_that_is_lost_tells_anything() -> None:
    watch = SlowError(Limits(1.0, 10.0, 1.0, 0.15))
    for k in range(100):
        watch.take(3.0 * k, innovation(5.0, 5.0, 1.0), SAID.sigma)
    for k in range(100):
        watch.take(300.0 + 0.1 * k, innovation(8.0, 8.0, 1.0), SAID.sigma)
    assert watch.expected(SAID, 310.0) == SAID and watch.doubt == 0.0


def test_a_jump_lasts_for_minutes() -> None:
    assert has_jumped(innovation(5.0, 5.0, 1.0)) and not has_jumped(innovation(3.0, 3.0, 1.0))
    watch = SlowError(Limits(1.0, 10.0, 1.0, 0.15))
    watch.jumped(10.0, 0.2)
    assert watch.expected(SAID, 20.0) == Wander(SAID.sigma, 300.0) and watch.doubt == pytest.approx(0.14)
    for k in range(1000):
        watch.take(20.0 + 0.1 * k, innovation(0.0, 0.0, 1.0), SAID.sigma)
    assert watch.doubt == pytest.approx(0.14 * math.exp(-1.0 / 3.0), rel=0.01)
    assert watch.expected(SAID, 2000.0) == SAID
    watch.jumped(130.0, 0.0)
    assert watch.expected(SAID, 131.0) == SAID and watch.doubt == 0.0
