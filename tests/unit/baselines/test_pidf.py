"""Tustin's PIDf against scipy's bilinear transform and its difference equation."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal

from companion.baselines.pidf import Gains, Pidf, coefficients

GAINS = [Gains(1.2, 0.0, 1.5, 0.26), Gains(1.0, 0.0, 1.2, 0.26), Gains(0.15, 0.5, 0.0, 0.26), Gains(0.7, 0.3, 0.9, 0.1)]


@pytest.mark.parametrize("gains", GAINS)
@pytest.mark.parametrize("h_s", [0.05, 0.02])
def test_coefficients_are_those_of_the_bilinear_transform(gains: Gains, h_s: float) -> None:
    kp, ki, kd, tf = gains.kp, gains.ki, gains.kd, gains.tf_s
    numerator = [kp * tf + kd, kp + ki * tf, ki]
    denominator = [tf, 1.0, 0.0]
    b, a = signal.bilinear(numerator, denominator, 1.0 / h_s)
    ours_b, ours_a = coefficients(gains, h_s)
    np.testing.assert_allclose(np.array(ours_b) / ours_a[0], b, rtol=0.0, atol=1e-12 * max(1.0, float(np.abs(b).max())))
    np.testing.assert_allclose(np.array(ours_a) / ours_a[0], a, rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("gains", GAINS)
def test_output_is_that_of_the_difference_equation(gains: Gains) -> None:
    errors = np.random.default_rng(1).normal(size=400)
    errors[0] = 0.0
    b, a = coefficients(gains, 0.05)
    expected = signal.lfilter(b, a, errors)
    block = Pidf()
    found = [block.update(float(error), gains, 0.05) for error in errors]
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_a_gain_changed_under_way_leaves_nothing_behind() -> None:
    block = Pidf()
    for _ in range(100):
        block.update(1.0, Gains(1.2, 0.0, 1.5, 0.26), 0.05)
    for _ in range(100):
        found = block.update(0.0, Gains(0.8, 0.0, 1.5, 0.26), 0.05)
    assert found == pytest.approx(0.0, abs=1e-6)


def test_the_integral_is_held_within_what_there_is() -> None:
    block = Pidf(0.0, 1.0)
    for _ in range(1000):
        block.update(5.0, Gains(0.15, 0.5, 0.0, 0.26), 0.05)
    assert block.update(-1.0, Gains(0.0, 0.5, 0.0, 0.26), 0.05) <= 1.0
